//! Error against run time on a bump-stop scene: the core's method at one rate and at two, in both
//! precisions, beside general methods on the host.

pub mod table;

use serde::Serialize;

use super::Extent;
use crate::method::{Failure, Method, Options, Precision, run_scene};
use crate::outcome::{BumpStopOutcome, Outcome, Particular};
use crate::scene_file::{BumpStop, Model, Scene};

/// The error in RMS voltage that a row must reach to be compared by its run time.
pub const TARGET_ERROR: f64 = 1e-2;

/// Steps near contact in s that are tried.
const STEPS: [f64; 9] = [2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7, 2.5e-7, 1e-7, 5e-8];
/// Those of the short table.
const FEW_STEPS: [f64; 4] = [5e-6, 1e-6, 2.5e-7, 5e-8];
/// Step in free flight of the rows with two rates, in s.
const LONG_STEP: f64 = 2e-5;
/// Fewest and most steps of a run: fewer would not resolve it, more take too long.
const STEP_COUNT: std::ops::RangeInclusive<f64> = 1e3..=3e6;

/// One row to run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Variant {
    /// Method.
    pub method: Method,
    /// Precision.
    pub precision: Precision,
    /// Step in s; of two rates, that near contact.
    pub step_s: f64,
    /// Step in s in free flight, of two rates.
    pub long_step_s: Option<f64>,
}

impl Variant {
    fn options(&self) -> Options {
        Options {
            method: self.method,
            precision: Some(self.precision),
            step_s: Some(self.step_s),
            long_step_s: self.long_step_s,
            ..Options::default()
        }
    }

    fn is_of_core(&self) -> bool {
        self.method == Method::DiscreteGradient
    }
}

/// What a row found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Found {
    /// Error of the state at the end of the run in the energy norm, over the state's own norm.
    pub end_error: f64,
    /// Relative error of the time of the first contact; `None` if there is none.
    pub first_contact_error: Option<f64>,
    /// Relative error of the RMS voltage of the window.
    pub rms_voltage_error: Option<f64>,
    /// Relative error of the mean contact force of the window.
    pub mean_force_error: Option<f64>,
    /// Contacts in the window.
    pub contacts: u64,
    /// Steps, kept and rejected, per simulated second.
    pub steps_per_s: f64,
    /// Host time in ns per simulated second: the least of the runs, which are short, so that a busy machine
    /// shows in a median.
    pub ns_per_s: f64,
    /// Host time over that of the fastest row within [`TARGET_ERROR`]; `None` if there is none.
    pub time_ratio: Option<f64>,
    /// Residual of the energy ledger; `None` where none is kept.
    pub energy_residual: Option<f64>,
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What was run.
    #[serde(flatten)]
    pub variant: Variant,
    /// What it found; `None` if it failed.
    #[serde(flatten)]
    pub found: Option<Found>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// The table of one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BumpStopComparison {
    /// The scene file.
    pub file: String,
    /// Modes of the beam and of the rod.
    pub modes: [usize; 2],
    /// Place in m of the stop from the clamp and gap in m; `None` without a stop.
    pub stop_m: Option<[f64; 2]>,
    /// Simulated time in s.
    pub duration_s: f64,
    /// Start of the window in s.
    pub settle_s: f64,
    /// RMS voltage in V by the reference.
    pub rms_voltage_v: Option<f64>,
    /// Contacts in the window by the reference.
    pub contacts: u64,
    /// First contact in s by the reference.
    pub first_contact_s: Option<f64>,
    /// Host time in ns per simulated second of the reference, one run.
    pub reference_ns_per_s: f64,
    /// The rows.
    pub rows: Vec<Row>,
}

/// The rows of a table for a scene of this length.
#[must_use]
pub fn variants(duration_s: f64, extent: &Extent) -> Vec<Variant> {
    let steps = if extent.whole { &STEPS[..] } else { &FEW_STEPS[..] };
    let steps: Vec<f64> =
        steps.iter().copied().filter(|step| STEP_COUNT.contains(&(duration_s / step))).collect();
    let mut variants = Vec::new();
    for (precision, long_step_s) in [
        (Precision::F64, None),
        (Precision::F64, Some(LONG_STEP)),
        (Precision::F32, None),
        (Precision::F32, Some(LONG_STEP)),
    ] {
        let method = Method::DiscreteGradient;
        // Two rates that are one are in the table already.
        let steps = steps.iter().filter(|step| long_step_s.is_none_or(|long| **step < long));
        variants.extend(steps.map(|&step_s| Variant { method, precision, step_s, long_step_s }));
    }
    for method in [Method::TrBdf2, Method::Newmark, Method::Rk4] {
        let (precision, long_step_s) = (Precision::F64, None);
        variants.extend(steps.iter().map(|&step_s| Variant { method, precision, step_s, long_step_s }));
    }
    variants
}

/// Number of steps of the progress that [`compare`] reports.
#[must_use]
pub fn length(scene: &Scene, extent: &Extent) -> usize {
    1 + variants(scene.run.duration_s, extent).len()
}

/// The numbers of a run that rows are compared by.
struct Numbers {
    outcome: Outcome,
    particular: BumpStopOutcome,
}

impl Numbers {
    fn of(scene: &Scene, options: Options) -> Result<Self, Failure> {
        let outcome = run_scene(scene, &options)?;
        let Particular::BumpStop(particular) = outcome.particular.clone() else {
            return Err(Failure::Input(format!("{}: scene: must be \"bump-stop\"", scene.file.display())));
        };
        Ok(Self { outcome, particular })
    }

    fn found(&self, exact: &Self, ns_per_s: f64) -> Found {
        let relative = |ours: Option<f64>, theirs: Option<f64>| match (ours, theirs) {
            (Some(ours), Some(theirs)) if theirs != 0.0 => Some(((ours - theirs) / theirs).abs()),
            _ => None,
        };
        let ends = self.particular.end_state.iter().zip(&exact.particular.end_state);
        let error: f64 = ends.map(|(ours, theirs)| (ours - theirs).powi(2)).sum();
        let whole: f64 = exact.particular.end_state.iter().map(|entry| entry * entry).sum();
        let outcome = &self.outcome;
        Found {
            end_error: if whole > 0.0 { (error / whole).sqrt() } else { 0.0 },
            first_contact_error: relative(self.particular.first_contact_s, exact.particular.first_contact_s),
            rms_voltage_error: relative(outcome.rms_voltage_v, exact.outcome.rms_voltage_v),
            mean_force_error: relative(self.particular.mean_force_n, exact.particular.mean_force_n),
            contacts: self.particular.contacts,
            steps_per_s: (outcome.steps + outcome.rejected_steps) as f64 / outcome.duration_s,
            ns_per_s,
            time_ratio: None,
            energy_residual: outcome.energy_residual,
        }
    }
}

/// Runs all variants on a bump-stop scene, on the calling thread, one after another; `advance` is told how
/// many steps of [`length`] are done.
///
/// # Errors
/// [`Failure::Input`] if the scene is refused by the reference or by a method, [`Failure::Step`] if the
/// reference fails. A variant that fails in a step is a row that says so.
pub fn compare(
    scene: &Scene,
    extent: &Extent,
    mut advance: impl FnMut(u64),
) -> Result<BumpStopComparison, Failure> {
    let Model::BumpStop(BumpStop { parameters, stop, .. }) = &scene.model else {
        return Err(Failure::Input(format!("{}: scene: must be \"bump-stop\"", scene.file.display())));
    };
    let exact = Numbers::of(scene, Options { method: Method::Reference, ..Options::default() })?;
    advance(1);
    let mut rows = Vec::new();
    for variant in variants(scene.run.duration_s, extent) {
        rows.push(row(scene, variant, extent, &exact)?);
        advance(1);
    }
    let reached = |found: &Found| {
        found.rms_voltage_error.is_some_and(|error| error <= TARGET_ERROR).then_some(found.ns_per_s)
    };
    let fastest = rows.iter().filter_map(|row| reached(row.found.as_ref()?)).fold(f64::INFINITY, f64::min);
    for found in rows.iter_mut().filter_map(|row| row.found.as_mut()) {
        found.time_ratio = fastest.is_finite().then(|| found.ns_per_s / fastest);
    }
    Ok(BumpStopComparison {
        file: scene.file.display().to_string(),
        modes: [parameters.beam_modes, stop.map_or(0, |stop| stop.rod_modes)],
        stop_m: stop.map(|stop| [stop.position_m, stop.gap_m]),
        duration_s: scene.run.duration_s,
        settle_s: scene.run.settle_s,
        rms_voltage_v: exact.outcome.rms_voltage_v,
        contacts: exact.particular.contacts,
        first_contact_s: exact.particular.first_contact_s,
        reference_ns_per_s: 1e9 * exact.outcome.wall_s / scene.run.duration_s,
        rows,
    })
}

/// Runs a variant: once with its ledger, for its errors, and then bare, for its run time.
fn row(scene: &Scene, variant: Variant, extent: &Extent, exact: &Numbers) -> Result<Row, Failure> {
    let numbers = match Numbers::of(scene, variant.options()) {
        Ok(numbers) => numbers,
        Err(Failure::Step(error) | Failure::StepLimitExceeded(error)) => {
            return Ok(Row { variant, found: None, failure: Some(error) });
        }
        Err(error @ Failure::Input(_)) => return Err(error),
    };
    let bare = Options { bare: true, ..variant.options() };
    let (mut shortest, mut spent) = (f64::INFINITY, 0.0);
    for _ in 0..extent.runs {
        let wall_s = run_scene(scene, &bare)?.wall_s;
        shortest = shortest.min(wall_s);
        spent += wall_s;
        if spent >= extent.seconds_per_row {
            break;
        }
    }
    let found = numbers.found(exact, 1e9 * shortest / scene.run.duration_s);
    Ok(Row { variant, found: Some(found), failure: None })
}

#[cfg(test)]
mod tests;
