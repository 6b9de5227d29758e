//! What the report of a run takes from the scene, and the rows of a trace at equal distances in time, from the dense output:
//! recording changes no bit of the run.

use std::marker::PhantomData;

use model_core::clock::Instant;
use model_core::energy::{Residual, RunMeter};
use model_core::integrate::Cubic;
use model_core::observer::{AcceptedStep, Event, Motion, Observer, Outputs};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;

use super::bump_stop::Clamp;
use super::excitation::{HostExcitation, Setting};
use super::limits::Gauge;
use harvester_scene::outcome::Particular;

/// What the report of one kind of scene adds to the numbers that every run has.
pub(super) trait Report<S: Scalar, H: Harvester<S>> {
    /// Columns of a trace: time first, the voltage of a storage last.
    fn columns(&self, with_storage: bool) -> &'static [&'static str];

    /// The columns between these two at a fraction of a step, under a base acceleration in m/s².
    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6];

    /// The relative residual of the energy ledger that holds for this scene.
    fn residual(&self, residual: &Residual<S>) -> Option<S>;

    /// Energy in J that an inferred force law created in the window; `None` for a bump-stop scene, and for a
    /// run that does not integrate all powers.
    fn created_energy(&self, _window: &RunMeter<S>) -> Option<S> {
        None
    }

    /// What meters the bending at the clamp over the window; `None` for a scene without a clamped beam's stress.
    fn clamp<'a>(&self, _excitation: HostExcitation<'a, S>) -> Option<Clamp<'a, S>> {
        None
    }

    /// What compares the steps of a run with the limits of the model.
    fn gauge<'a>(&'a self, setting: Setting<'a, S>) -> Gauge<'a, S>;

    /// The numbers that only this kind of scene has.
    fn particular(&self, harvester: &H, found: &Found<'_, S>, end: &H::State) -> Particular;

    fn describe(&self, outputs: &Outputs<'_, S>) -> String;
}

/// What a run found, for the scene to make its own numbers of.
pub(super) struct Found<'a, S: Scalar> {
    /// The measuring window.
    pub(super) window: &'a RunMeter<S>,
    /// Time of the first contact or impact of the whole run.
    pub(super) first_contact: Option<Instant>,
    /// Periods of the base in the window, where it moves in one sine.
    pub(super) periods: Option<f64>,
    /// The bending at the clamp in the window.
    pub(super) clamp: Option<&'a Clamp<'a, S>>,
}

/// Collects the rows of a run: the columns of [`Report::columns`].
pub(super) struct Recorder<'a, S: Scalar, H, R> {
    report: &'a R,
    excitation: HostExcitation<'a, S>,
    every: f64,
    rows: Vec<Vec<f64>>,
    impacts_s: Vec<f64>,
    harvester: PhantomData<H>,
}

impl<'a, S: Scalar, H, R> Recorder<'a, S, H, R> {
    /// A row for each `every` seconds.
    pub(super) fn new(report: &'a R, excitation: HostExcitation<'a, S>, every: f64) -> Self {
        Self { report, excitation, every, rows: Vec::new(), impacts_s: Vec::new(), harvester: PhantomData }
    }

    /// The rows, and the instants of impacts in s.
    pub(super) fn into_parts(self) -> (Vec<Vec<f64>>, Vec<f64>) {
        (self.rows, self.impacts_s)
    }
}

impl<S, H, R> Observer<S> for Recorder<'_, S, H, R>
where
    S: Scalar,
    H: Harvester<S>,
    R: Report<S, H>,
{
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        let (from, until) = (step.from.seconds::<f64>(), step.until().seconds::<f64>());
        loop {
            let time = self.rows.len() as f64 * self.every;
            // Compared in ticks: the last row may stand at the end of the last step.
            if Instant::from_seconds(time).is_none_or(|row| row > step.until()) {
                return;
            }
            let fraction = ((time - from) / (until - from)).clamp(0.0, 1.0);
            let theta = S::from_f64(fraction);
            let at = step.from.after((fraction * f64::from(step.ticks)) as u32);
            let row = self.report.row(step, theta, self.excitation.acceleration(at)).map(S::to_f64);
            let storage = step.start.storage.zip(step.end.storage).map(|(start, end)| {
                let rise = (end.voltage - start.voltage).to_f64();
                start.voltage.to_f64() + rise * fraction
            });
            self.rows.push(std::iter::once(time).chain(row).chain(storage).collect());
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        if event.impact_speed.is_some() {
            self.impacts_s.push(event.at.seconds());
        }
    }
}

/// A coordinate at a fraction of a step, by a cubic.
pub(super) fn dense<S: Scalar>(start: Motion<S>, end: Motion<S>, step: S, fraction: S) -> S {
    Cubic::new(start.value, start.rate, end.value, end.rate, step).value(fraction)
}

/// The terminal voltage at a fraction of a step, by a parabola of its mean.
pub(super) fn dense_voltage<S: Scalar>(step: &AcceptedStep<'_, S>, fraction: S) -> S {
    Cubic::with_mean(step.start.voltage, step.end.voltage, step.mean_voltage).value(fraction)
}
