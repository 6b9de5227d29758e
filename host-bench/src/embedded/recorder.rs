//! Rows of a trace at equal distances in time, from the dense output: recording changes no bit of
//! the run.

use model_core::clock::Instant;
use model_core::excitation::Excitation;
use model_core::hybrid::{Observer, Span};
use model_core::integrate::cubic::Cubic;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::{Harvester, account};

use super::excitation::HostExcitation;
use super::hybrid_run::{HostedScene, ModeOf, WHOLE};

/// Collects the rows of a run: the columns of [`HostedScene::columns`].
pub(super) struct Recorder<'a, S: Scalar, H, M> {
    pub(super) hosted: &'a H,
    pub(super) excitation: &'a HostExcitation<'a, S, M>,
    pub(super) every: f64,
    pub(super) rows: Vec<Vec<f64>>,
}

impl<S, H, M, const N: usize> Observer<S, ModeOf<S, H, N>, N, WHOLE> for Recorder<'_, S, H, M>
where
    S: Scalar,
    H: HostedScene<S, N>,
    M: Mathematics<S>,
{
    fn step(&mut self, span: &Span<'_, S, ModeOf<S, H, N>, N, WHOLE>) {
        let harvester = self.hosted.core();
        let from = span.from.seconds::<f64>();
        let end = span.from.after(span.ticks).seconds::<f64>();
        loop {
            let time = self.rows.len() as f64 * self.every;
            // Compared in ticks: the last row may stand at the end of the last step.
            if Instant::from_seconds(time).is_none_or(|row| row > span.from.after(span.ticks)) {
                return;
            }
            let fraction = ((time - from) / (end - from)).clamp(0.0, 1.0);
            let theta = S::from_f64(fraction);
            let dense: [S; N] = std::array::from_fn(|index| {
                let [start, end] =
                    [span.start, span.end].map(|point| (point.state[index], point.derivative[index]));
                Cubic::new(start.0, start.1, end.0, end.1, span.step).value(theta)
            });
            let voltages = [span.start, span.end].map(|point| harvester.voltage(span.mode, point));
            let mean = span.energies[account::VOLTAGE] / span.step;
            let voltage = Cubic::with_mean(voltages[0], voltages[1], mean).value(theta);
            let at = span.from.after((fraction * f64::from(span.ticks)) as u32);
            let [position, velocity] = [dense[0], dense[1]];
            let charge = self.hosted.coulombs(position, self.hosted.charge(span.mode, &dense));
            let row: [S; 5] = [position, velocity, charge, voltage, self.excitation.acceleration(at)];
            let held = f64::from(u8::from(harvester.is_stick(span.mode)));
            let store = self.hosted.store(span.mode, &dense).map(|store| store.voltage.to_f64());
            let row = std::iter::once(time).chain(row.map(S::to_f64)).chain([held]).chain(store);
            self.rows.push(row.collect());
        }
    }
}
