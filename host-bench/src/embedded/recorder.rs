//! Rows of a trace at equal distances in time, from the dense output: recording changes no bit of
//! the run.

use model_core::clock::Instant;
use model_core::excitation::Excitation;
use model_core::hybrid::{Observer, Span};
use model_core::integrate::cubic::Cubic;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::contact_separation::{CHARGE, ContactSeparation, GAP, Mode, Parts, STATES, VELOCITY};
use model_core::scene::{Harvester, account};

use super::excitation::HostExcitation;

/// Collects the rows of a contact-separation run: the columns of
/// [`crate::outcome::CONTACT_SEPARATION_COLUMNS`].
pub(super) struct Recorder<'a, S: Scalar, P: Parts<S>, M> {
    pub(super) harvester: &'a ContactSeparation<S, P>,
    pub(super) excitation: &'a HostExcitation<'a, S, M>,
    pub(super) every: f64,
    pub(super) rows: Vec<Vec<f64>>,
}

impl<S: Scalar, P: Parts<S>, M: Mathematics<S>> Observer<S, Mode, STATES, { account::WHOLE }>
    for Recorder<'_, S, P, M>
{
    fn step(&mut self, span: &Span<'_, S, Mode, STATES, { account::WHOLE }>) {
        let from = span.from.seconds::<f64>();
        let end = span.from.after(span.ticks).seconds::<f64>();
        loop {
            let time = self.rows.len() as f64 * self.every;
            // Compared in ticks: the last row may stand at the end of the last step.
            if Instant::from_seconds(time).is_none_or(|row| row > span.from.after(span.ticks)) {
                return;
            }
            let fraction = ((time - from) / (end - from)).clamp(0.0, 1.0);
            let theta = S::literal(fraction);
            let dense = |index: usize| {
                let [start, end] =
                    [span.start, span.end].map(|point| (point.state[index], point.derivative[index]));
                Cubic::new(start.0, start.1, end.0, end.1, span.step).value(theta)
            };
            let voltages = [span.start, span.end].map(|point| self.harvester.voltage(span.mode, point));
            let mean = span.energies[account::VOLTAGE] / span.step;
            let voltage = Cubic::with_mean(voltages[0], voltages[1], mean).value(theta);
            let charge = self.harvester.transferred_charge(dense(GAP), dense(CHARGE));
            let at = span.from.after((fraction * f64::from(span.ticks)) as u32);
            let row: [S; 5] =
                [dense(GAP), dense(VELOCITY), charge, voltage, self.excitation.acceleration(at)];
            let stuck = f64::from(u8::from(span.mode == Mode::Stuck));
            let row = std::iter::once(time).chain(row.map(S::to_f64)).chain([stuck]);
            self.rows.push(row.collect());
        }
    }
}
