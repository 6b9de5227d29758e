//! Runs of shipped scenes with changes, and the sampled motion and the contacts of a bump-stop run.

use crate::embedded::{ContactInterval, contact_intervals, natural_frequency_hz};
use crate::method::{Failure, Options};
use crate::outcome::{BumpStopOutcome, Outcome};
use crate::run::{run_scene, try_each};
use crate::scene_file::{self, Excitation, Scene, StopParameters};

/// The scenes of the second paper far below the resonance: the stop at the tip, at mid-span, and none.
pub(super) const OFF_RESONANCE: [&str; 3] =
    ["bump-stop-below-resonance", "bump-stop-below-resonance-mid-span", "bump-stop-below-resonance-none"];
/// Those near the resonance, 220 Hz into 1 MΩ.
pub(super) const NEAR_RESONANCE: [&str; 3] = ["bump-stop-tip", "bump-stop-mid-span", "bump-stop-none"];

pub(super) type Changes<'a> = &'a [(&'a str, &'a str)];

/// From where the experiments have their scenes: as shipped, or with each number times the factor of its key.
#[derive(Clone, Copy)]
pub(super) struct Loader<'a>(pub(super) Option<&'a (dyn Fn(&str) -> f64 + Sync)>);

impl Loader<'_> {
    /// A shipped scene with these keys changed.
    pub(super) fn scene(self, name: &str, changes: Changes<'_>) -> Result<Scene, Failure> {
        self.scaled(name, changes).map(|(scene, _)| scene)
    }

    /// The same, and its first natural frequency over that of the shipped numbers. The frequency of the excitation
    /// and the times of the run keep their ratios to it: what experiments say of frequencies is at the shipped ones.
    pub(super) fn scaled(self, name: &str, changes: Changes<'_>) -> Result<(Scene, f64), Failure> {
        let shipped = scene_file::read_shipped(name, changes)?;
        let Some(factor) = self.0 else { return Ok((shipped, 1.0)) };
        let mut scene = scene_file::read_scaled(name, changes, &factor)?;
        let ratio = natural_frequency_hz(&scene)? / natural_frequency_hz(&shipped)?;
        if let Excitation::Sine(tone) = &mut scene.excitation {
            tone.frequency_hz *= ratio;
        }
        scene.run.duration_s = shipped.run.duration_s / ratio;
        scene.run.settle_s = shipped.run.settle_s / ratio;
        Ok((scene, ratio))
    }

    /// Runs a shipped scene with these keys changed, by the default method.
    pub(super) fn run(self, name: &str, changes: Changes<'_>) -> Result<Outcome, Failure> {
        run_scene(&self.scene(name, changes)?, &Options::default())
    }
}

/// The result for each of some cases, in their order, on all cores.
pub(super) fn each_of<C: Sync, R: Send, const N: usize>(
    cases: [C; N],
    work: impl Fn(&C) -> Result<R, Failure> + Sync,
) -> Result<[R; N], Failure> {
    let count = |found: Vec<R>| Failure::Input(format!("{} results of {N} cases", found.len()));
    try_each(&cases, work)?.try_into().map_err(count)
}

pub(super) fn bump_stop(outcome: &Outcome) -> Result<&BumpStopOutcome, Failure> {
    outcome.bump_stop().ok_or_else(|| Failure::Input("a bump-stop scene must be run".to_owned()))
}

/// The number, or not-a-number, which meets no assertion.
pub(super) fn value(number: Option<f64>) -> f64 {
    number.unwrap_or(f64::NAN)
}

/// Distance of the samples in s.
pub(super) const EVERY_S: f64 = 1e-5;

#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) time_s: f64,
    /// Displacement in m of the beam at the stop, and of the rod's face.
    pub(super) stop_point_m: f64,
    pub(super) rod_m: f64,
    pub(super) voltage_v: f64,
    pub(super) force_n: f64,
}

/// A run of a scene with its samples in the measuring window.
pub(super) struct History {
    pub(super) scene: Scene,
    pub(super) outcome: Outcome,
    pub(super) samples: Vec<Sample>,
    /// Contacts that begin in the window.
    pub(super) contacts: Vec<ContactInterval>,
}

impl History {
    /// Runs the scene by the default method.
    pub(super) fn of(scene: Scene) -> Result<Self, Failure> {
        let options = Options::default();
        let contacts = match stop(&scene) {
            Some(_) => contact_intervals(&scene, &options)?,
            None => Vec::new(),
        };
        let mut outcome = run_scene(&scene, &Options { trace_every_s: Some(EVERY_S), ..options })?;
        let rows = outcome.trace.take().map(|trace| trace.rows).unwrap_or_default();
        let sample = |row: &Vec<f64>| match row[..] {
            [time_s, _, stop_point_m, rod_m, voltage_v, force_n, ..] => {
                Some(Sample { time_s, stop_point_m, rod_m, voltage_v, force_n })
            }
            _ => None,
        };
        // Whole periods: the window without its last instant.
        let (from, to) = (scene.run.settle_s - 0.5 * EVERY_S, scene.run.duration_s - 0.5 * EVERY_S);
        let samples =
            rows.iter().filter_map(sample).filter(|sample| (from..to).contains(&sample.time_s)).collect();
        Ok(Self { scene, outcome, samples, contacts })
    }

    /// Gap at rest in m; not-a-number without a stop.
    pub(super) fn gap_m(&self) -> f64 {
        stop(&self.scene).map_or(f64::NAN, |stop| stop.gap_m)
    }

    pub(super) fn peak_voltage_v(&self) -> f64 {
        value(self.outcome.peak_voltage_v)
    }

    pub(super) fn rms_voltage_v(&self) -> f64 {
        value(self.outcome.rms_voltage_v)
    }

    pub(super) fn mean_power_w(&self) -> f64 {
        value(self.outcome.mean_power_w)
    }

    pub(super) fn mean_force_n(&self) -> Result<f64, Failure> {
        Ok(value(bump_stop(&self.outcome)?.mean_force_n))
    }
}

pub(super) fn stop(scene: &Scene) -> Option<&StopParameters> {
    scene.bump_stop().ok()?.stop.as_ref()
}
