//! Error against run time: every method, step or tolerance, precision and math backend on one scene,
//! against the independent reference.

pub mod bump_stop;
mod plan;
pub mod table;

use serde::Serialize;

use crate::method::{Failure, Math, Method, Options, Precision, run_scene};
use crate::outcome::Outcome;
use crate::scene_file::Scene;

pub use self::plan::{Control, Extent, Variant, variants};

/// The error in mean power that a row must reach to be compared by its run time.
pub const TARGET_ERROR: f64 = 1e-3;

/// Relative difference of an error below which two rows are the same.
const SAME: f64 = 0.1;

/// Relative errors against the reference; `None` where the reference has no such number or it is 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Of the mean power.
    pub mean_power_error: Option<f64>,
    /// Of the root mean square of the voltage.
    pub rms_voltage_error: Option<f64>,
    /// Of the time of the first impact.
    pub first_impact_error: Option<f64>,
    /// Of the amplitude of a slider.
    pub amplitude_error: Option<f64>,
}

impl Errors {
    fn of(outcome: &Outcome, reference: &Outcome) -> Self {
        let relative = |ours: Option<f64>, theirs: Option<f64>| match (ours, theirs) {
            (Some(ours), Some(theirs)) if theirs != 0.0 => Some(((ours - theirs) / theirs).abs()),
            _ => None,
        };
        Self {
            mean_power_error: relative(outcome.mean_power_w, reference.mean_power_w),
            rms_voltage_error: relative(outcome.rms_voltage_v, reference.rms_voltage_v),
            first_impact_error: relative(first_impact(outcome), first_impact(reference)),
            amplitude_error: relative(amplitude(outcome), amplitude(reference)),
        }
    }

    fn same(&self, other: &Self) -> bool {
        let pairs = [
            (self.mean_power_error, other.mean_power_error),
            (self.rms_voltage_error, other.rms_voltage_error),
            (self.first_impact_error, other.first_impact_error),
            (self.amplitude_error, other.amplitude_error),
        ];
        pairs.iter().all(|pair| match pair {
            (Some(one), Some(two)) => (one - two).abs() <= SAME * one.max(*two),
            (one, two) => one.is_none() && two.is_none(),
        })
    }
}

fn first_impact(outcome: &Outcome) -> Option<f64> {
    outcome.contact_separation()?.first_impact_s
}

fn amplitude(outcome: &Outcome) -> Option<f64> {
    outcome.sliding()?.amplitude_m
}

/// What a row found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Found {
    /// Errors against the reference.
    #[serde(flatten)]
    pub errors: Errors,
    /// Steps, kept and rejected, per simulated second.
    pub steps_per_s: f64,
    /// Host time in ns per simulated second: the median of the runs.
    pub ns_per_s: f64,
    /// Host time over that of the fastest row of the scene within [`TARGET_ERROR`]; `None` if there
    /// is no such row.
    pub time_ratio: Option<f64>,
    /// Residual of the energy ledger, as in [`Outcome::energy_residual`].
    pub energy_residual: Option<f64>,
    /// Number of runs that were timed.
    pub runs: usize,
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

/// Rows left out because their errors are those of the polynomial row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Omitted {
    /// Precision of the rows.
    pub precision: Precision,
    /// The backend.
    pub math: Math,
    /// Number of rows left out.
    pub rows: usize,
    /// Number of rows tried.
    pub of: usize,
    /// Median of their run times over those of the polynomial rows.
    pub time_ratio: f64,
}

/// The table of one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The scene file.
    pub file: String,
    /// Load resistance in Ω.
    pub resistance_ohm: f64,
    /// Simulated time in s.
    pub duration_s: f64,
    /// Mean power in W by the reference.
    pub mean_power_w: Option<f64>,
    /// RMS voltage in V by the reference.
    pub rms_voltage_v: Option<f64>,
    /// First impact in s by the reference.
    pub first_impact_s: Option<f64>,
    /// Amplitude of a slider in m by the reference; `None` for another scene.
    pub amplitude_m: Option<f64>,
    /// The rows.
    pub rows: Vec<Row>,
    /// What was left out.
    pub omitted: Vec<Omitted>,
}

/// A variant with the times of its runs.
struct Timed {
    variant: Variant,
    outcome: Result<Outcome, String>,
    times: Vec<f64>,
}

impl Timed {
    fn wants_more(&self, extent: &Extent) -> bool {
        self.outcome.is_ok()
            && self.times.len() < extent.runs
            && self.times.iter().sum::<f64>() < extent.seconds_per_row
    }

    fn run(scene: &Scene, variant: Variant) -> Result<Self, Failure> {
        let (outcome, times) = match run_scene(scene, &variant.options()) {
            Ok(outcome) => {
                let time = outcome.wall_s;
                (Ok(outcome), vec![time])
            }
            Err(Failure::Step(error) | Failure::StepLimitExceeded(error)) => (Err(error), Vec::new()),
            Err(error @ Failure::Input(_)) => return Err(error),
        };
        Ok(Self { variant, outcome, times })
    }

    fn median(&self) -> f64 {
        median(self.times.clone())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match (values.get(values.len() / 2), values.get((values.len().max(1) - 1) / 2)) {
        (Some(upper), Some(lower)) => 0.5 * (upper + lower),
        _ => f64::NAN,
    }
}

/// Number of steps of the progress that [`compare`] reports.
#[must_use]
pub fn length(scene: &Scene, extent: &Extent) -> usize {
    1 + variants(scene, extent).len() * extent.runs
}

/// Runs all variants on a scene, on the calling thread, one after another; `advance` is told how many
/// steps of [`length`] are done.
///
/// Repeats go round all variants rather than one after the other, so that a machine that is busy for
/// a while slows all rows alike.
///
/// # Errors
/// [`Failure::Input`] if the scene is refused, [`Failure::Step`] if the reference fails. A variant
/// that fails is a row that says so.
pub fn compare(scene: &Scene, extent: &Extent, mut advance: impl FnMut(u64)) -> Result<Comparison, Failure> {
    let reference = run_scene(scene, &Options { method: Method::Reference, ..Options::default() })?;
    advance(1);
    let mut all = Vec::new();
    for variant in variants(scene, extent) {
        all.push(Timed::run(scene, variant)?);
        advance(1);
    }
    for _ in 1..extent.runs {
        for timed in &mut all {
            if timed.wants_more(extent) {
                timed.times.push(run_scene(scene, &timed.variant.options())?.wall_s);
            }
            advance(1);
        }
    }
    let reference_row = Timed {
        variant: Variant::reference(),
        times: vec![reference.wall_s],
        outcome: Ok(reference.clone()),
    };
    all.push(reference_row);
    Ok(tabulate(scene, &reference, &all))
}

fn tabulate(scene: &Scene, reference: &Outcome, all: &[Timed]) -> Comparison {
    let duration = scene.run.duration_s;
    let mut rows: Vec<Row> = all
        .iter()
        .map(|timed| Row {
            variant: timed.variant,
            found: timed.outcome.as_ref().ok().map(|outcome| Found {
                errors: Errors::of(outcome, reference),
                steps_per_s: (outcome.steps + outcome.rejected_steps) as f64 / duration,
                ns_per_s: 1e9 * timed.median() / duration,
                time_ratio: None,
                energy_residual: outcome.energy_residual,
                runs: timed.times.len(),
            }),
            failure: timed.outcome.as_ref().err().cloned(),
        })
        .collect();
    // The reference's own row has no error to show.
    if let Some(Found { errors, .. }) = rows.last_mut().and_then(|row| row.found.as_mut()) {
        *errors = Errors {
            mean_power_error: None,
            rms_voltage_error: None,
            first_impact_error: None,
            amplitude_error: None,
        };
    }
    let omitted = omit(&mut rows);
    let reached = |found: &Found| found.errors.mean_power_error.is_some_and(|error| error <= TARGET_ERROR);
    let fastest = rows
        .iter()
        .filter_map(|row| row.found.filter(reached).map(|found| found.ns_per_s))
        .fold(f64::INFINITY, f64::min);
    for found in rows.iter_mut().filter_map(|row| row.found.as_mut()) {
        found.time_ratio = fastest.is_finite().then(|| found.ns_per_s / fastest);
    }
    let resistance_ohm = scene.load.resistance_ohm();
    Comparison {
        file: scene.file.display().to_string(),
        resistance_ohm,
        duration_s: duration,
        mean_power_w: reference.mean_power_w,
        rms_voltage_v: reference.rms_voltage_v,
        first_impact_s: first_impact(reference),
        amplitude_m: amplitude(reference),
        rows,
        omitted,
    }
}

/// Takes out the rows whose errors are those of the same row with the polynomial backend.
fn omit(rows: &mut Vec<Row>) -> Vec<Omitted> {
    let polynomial: Vec<Row> =
        rows.iter().filter(|row| row.variant.math == Some(Math::Polynomial)).cloned().collect();
    let mut omitted: Vec<Omitted> = Vec::new();
    let mut ratios: Vec<Vec<f64>> = Vec::new();
    rows.retain(|row| {
        let Variant { precision, math: Some(math), .. } = row.variant else { return true };
        if math == Math::Polynomial {
            return true;
        }
        let place = omitted.iter().position(|entry| (entry.precision, entry.math) == (precision, math));
        let place = place.unwrap_or_else(|| {
            omitted.push(Omitted { precision, math, rows: 0, of: 0, time_ratio: f64::NAN });
            ratios.push(Vec::new());
            omitted.len() - 1
        });
        omitted[place].of += 1;
        let twin = Variant { math: Some(Math::Polynomial), ..row.variant };
        let Some(other) = polynomial.iter().find(|other| other.variant == twin) else { return true };
        let same = match (&row.found, &other.found) {
            (Some(one), Some(two)) => {
                ratios[place].push(one.ns_per_s / two.ns_per_s);
                one.errors.same(&two.errors)
            }
            (one, two) => one.is_none() && two.is_none(),
        };
        omitted[place].rows += usize::from(same);
        !same
    });
    for (entry, ratios) in omitted.iter_mut().zip(ratios) {
        entry.time_ratio = median(ratios);
    }
    omitted
}

#[cfg(test)]
mod tests;
