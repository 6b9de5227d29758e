//! Error against run time: every method, step or tolerance, precision and math backend on one scene, against the independent reference.
//!
//! A kind of scene supplies the rows to run, the errors that count and the columns of its table ([`Kind`]); running,
//! timing and printing are the same for all.

mod bump_stop;
#[cfg(feature = "peers")]
pub(crate) mod peers;
pub(crate) mod table;
pub(crate) mod triboelectric;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::method::{Failure, Math, Method, Options, Precision};
use crate::outcome::{Outcome, name};
use crate::rows::Column;
use crate::run::{run_scene, try_run_scene};
use crate::scene_file::Scene;
pub(crate) use table::{Control, Extent, Variant};

/// Relative difference of two errors below which they count as equal.
const SAME: f64 = 0.1;

/// What a kind of scene supplies to its table.
pub(crate) struct Kind {
    variants: fn(&Scene, &Extent) -> Vec<Variant>,
    /// The errors of an outcome against the reference.
    errors: fn(&Outcome, &Outcome) -> Errors,
    /// Name and bound of the error that a row must reach to be compared by its run time.
    target: (&'static str, f64),
    /// Whether the reference has a row of its own.
    lists_reference: bool,
    pub(crate) columns: &'static [Column<'static>],
    /// The columns of CSV, with commas between them.
    csv: &'static str,
    /// Cells of a row beside its own numbers, or in place of them.
    cells: fn(&Comparison, &Row) -> Vec<(&'static str, Value)>,
    /// Columns at the left that hold words.
    pub(crate) words: usize,
    /// What is above the table.
    title: fn(&Comparison) -> String,
    /// What is below the table.
    notes: fn(&Comparison) -> Vec<String>,
    /// Which row it is, for the note on its failure.
    label: fn(&Variant) -> String,
    /// Names and values that stand before the rows in JSON.
    summary: fn(&Comparison) -> Vec<(&'static str, Value)>,
}

fn kind(scene: &Scene) -> &'static Kind {
    if scene.bump_stop().is_ok() { &bump_stop::KIND } else { &triboelectric::KIND }
}

/// Relative errors against the reference by name; `None` where the reference has no such number or the number is 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Errors(Vec<(&'static str, Option<f64>)>);

impl Errors {
    fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(other, _)| *other == name).and_then(|(_, error)| *error)
    }

    fn same(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|((_, one), (_, other))| match (one, other) {
            (Some(one), Some(other)) => (one - other).abs() <= SAME * one.max(*other),
            (one, other) => one.is_none() && other.is_none(),
        })
    }
}

impl Serialize for Errors {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

/// `|ours − theirs| / |theirs|`.
fn relative(ours: Option<f64>, theirs: Option<f64>) -> Option<f64> {
    match (ours, theirs) {
        (Some(ours), Some(theirs)) if theirs != 0.0 => Some(((ours - theirs) / theirs).abs()),
        _ => None,
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Measured {
    /// Errors against the reference.
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Contacts in the measuring window of a bump-stop scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    contacts: Option<u64>,
    /// Steps, kept and rejected, per simulated second.
    pub(crate) steps_per_s: f64,
    /// Processor time of the host in ns per simulated second, the least of the runs.
    pub(crate) ns_per_s: f64,
    /// The largest of them over the least, less 1.
    pub(crate) time_spread: Option<f64>,
    /// Host time over that of the fastest row that reaches the target; `None` if there is no such row.
    time_ratio: Option<f64>,
    /// Residual of the energy ledger, as in [`Outcome::energy_residual`].
    energy_residual: Option<f64>,
    /// Number of runs that were timed.
    runs: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Row {
    #[serde(flatten)]
    pub(crate) variant: Variant,
    /// What it found; `None` if it failed.
    #[serde(flatten)]
    pub(crate) found: Option<Measured>,
    pub(crate) failure: Option<String>,
}

impl Row {
    /// The error of this name; `None` too if the row failed.
    fn error(&self, name: &str) -> Option<f64> {
        self.found.as_ref()?.errors.get(name)
    }
}

/// Rows left out because their errors are those of the polynomial row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Omitted {
    precision: Precision,
    math: Math,
    /// Number of rows left out.
    rows: usize,
    /// Number of rows tried.
    of: usize,
    /// Median of their run times over those of the polynomial rows.
    time_ratio: f64,
}

pub(crate) struct Comparison {
    pub(crate) kind: &'static Kind,
    pub(crate) scene: Scene,
    reference: Outcome,
    pub(crate) rows: Vec<Row>,
    omitted: Vec<Omitted>,
}

impl Serialize for Comparison {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, value) in (self.kind.summary)(self) {
            map.serialize_entry(name, &value)?;
        }
        map.serialize_entry("rows", &self.rows)?;
        map.serialize_entry("omitted", &self.omitted)?;
        map.end()
    }
}

impl Comparison {
    pub(crate) fn file(&self) -> String {
        self.scene.file.display().to_string()
    }

    /// Largest error with which a row reaches the target.
    pub(crate) fn target_error(&self) -> f64 {
        self.kind.target.1
    }

    pub(crate) fn error(&self, row: &Row) -> Option<f64> {
        row.error(self.kind.target.0)
    }

    /// The same with as many digits, from two on, as show on which side of the target it is.
    pub(crate) fn shown_error(&self, row: &Row) -> Option<String> {
        let (error, target) = (self.error(row)?, self.target_error());
        let reaches = |shown: f64| shown <= target;
        let shown = |digits: usize| format!("{error:.digits$e}");
        (1..17).map(shown).find(|text| text.parse().is_ok_and(|shown| reaches(shown) == reaches(error)))
    }

    /// Whether a row is accurate enough to be compared by its run time.
    pub(crate) fn reaches_target(&self, row: &Row) -> bool {
        self.error(row).is_some_and(|error| error <= self.target_error())
    }

    /// The fastest row that reaches the target, of those of some variants.
    fn fastest(&self, of: impl Fn(&Variant) -> bool) -> Option<(&Row, &Measured)> {
        let rows = self.rows.iter().filter(|row| of(&row.variant) && self.reaches_target(row));
        let found = rows.filter_map(|row| Some((row, row.found.as_ref()?)));
        found.min_by(|(_, one), (_, other)| one.ns_per_s.total_cmp(&other.ns_per_s))
    }

    /// The fastest row of each of some methods that reaches the target, with its setting.
    pub(crate) fn fastest_note(&self, methods: [Method; 4], setting: impl Fn(&Row) -> String) -> String {
        let parts = methods.map(|method| match self.fastest(|variant| variant.method == method) {
            Some((row, found)) => {
                let (precision, time_us) = (row.variant.precision.name(), found.ns_per_s / 1e3);
                format!("{} {time_us:.0} µs ({precision}, {})", name(&method), setting(row))
            }
            None => format!("{} none", name(&method)),
        });
        let (error, parts) = (self.target_error(), parts.join("; "));
        format!("Host time per simulated second of the fastest rows within an error of {error:.0e}: {parts}.")
    }
}

/// A variant with the times of its runs in s.
struct Timed {
    variant: Variant,
    outcome: Result<Outcome, String>,
    /// Those of the runs without energy ledger, after one with it.
    times: Vec<f64>,
}

impl Timed {
    fn run(scene: &Scene, variant: Variant) -> Result<Self, Failure> {
        let outcome = try_run_scene(scene, &variant.options())?;
        Ok(Self { variant, outcome, times: Vec::new() })
    }

    fn wants_more(&self, extent: &Extent) -> bool {
        let enough = self.times.len() > 1 && self.times.iter().sum::<f64>() >= extent.seconds_per_row;
        self.outcome.is_ok() && self.times.len() < extent.runs && !enough
    }

    /// Runs the variant once more, for its run time.
    fn repeat(&mut self, scene: &Scene) -> Result<(), Failure> {
        self.times.push(run_scene(scene, &Options { bare: true, ..self.variant.options() })?.processor_s);
        Ok(())
    }

    fn row(self, scene: &Scene, reference: &Outcome) -> Row {
        let duration = scene.run.duration_s;
        let (seconds, time_spread) = least(&self.times);
        let found = self.outcome.as_ref().ok().map(|outcome| Measured {
            errors: (kind(scene).errors)(outcome, reference),
            contacts: outcome.bump_stop().map(|found| found.contacts),
            steps_per_s: (outcome.steps + outcome.rejected_steps) as f64 / duration,
            ns_per_s: 1e9 * seconds / duration,
            time_spread,
            time_ratio: None,
            energy_residual: outcome.energy_residual,
            runs: self.times.len(),
        });
        Row { variant: self.variant, found, failure: self.outcome.err() }
    }
}

/// The least of some times, and by how much of it the largest is larger: `None` of a single one.
pub(crate) fn least(times: &[f64]) -> (f64, Option<f64>) {
    let extreme = |pick: fn(f64, f64) -> f64| times.iter().copied().reduce(pick).unwrap_or(f64::NAN);
    let least = extreme(f64::min);
    (least, (times.len() > 1).then(|| extreme(f64::max) / least - 1.0))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match (values.get(values.len() / 2), values.get((values.len().max(1) - 1) / 2)) {
        (Some(upper), Some(lower)) => 0.5 * (upper + lower),
        _ => f64::NAN,
    }
}

/// Steps of a row's run, by which its time is foreseen: of a method that chooses its steps some 500 in a period.
fn steps(variant: &Variant, scene: &Scene) -> u64 {
    let step_s = match variant.control {
        Control::PerPeriod { steps, period_s } => period_s / f64::from(steps),
        Control::Step { step_s, long_step_s } => (step_s * long_step_s.unwrap_or(step_s)).sqrt(),
        Control::Tolerance(_) | Control::Default => triboelectric::period(scene) / 500.0,
    };
    (scene.run.duration_s / step_s) as u64
}

/// Most repeats of a row of which [`compare`] tells: a row that takes long is timed twice.
const LONG: usize = 2;

/// The work of which [`compare`] tells, in steps.
pub(crate) fn work(scene: &Scene, extent: &Extent) -> u64 {
    let rows = (kind(scene).variants)(scene, extent);
    (1 + extent.runs.min(LONG) as u64) * rows.iter().map(|row| steps(row, scene)).sum::<u64>()
}

/// Runs all variants on a scene, on the calling thread, one after another; calls `done` with the work of each run.
///
/// A round of repeats goes through all variants, so that a machine that is busy for a while slows all rows alike. A
/// variant that fails is a row that says so.
pub(crate) fn compare(scene: &Scene, extent: &Extent, done: impl Fn(u64)) -> Result<Comparison, Failure> {
    let kind = kind(scene);
    let reference = run_scene(scene, &Options { method: Method::Reference, ..Options::default() })?;
    let mut all = Vec::new();
    for variant in (kind.variants)(scene, extent) {
        all.push(Timed::run(scene, variant)?);
        done(steps(&variant, scene));
    }
    for round in 0..extent.runs {
        for timed in &mut all {
            if timed.wants_more(extent) {
                timed.repeat(scene)?;
            }
            done(if round < LONG { steps(&timed.variant, scene) } else { 0 });
        }
    }
    let mut rows: Vec<Row> = all.into_iter().map(|timed| timed.row(scene, &reference)).collect();
    if kind.lists_reference {
        rows.push(reference_row(scene, &reference));
    }
    let omitted = omit(&mut rows);
    let mut comparison = Comparison { kind, scene: scene.clone(), reference, rows, omitted };
    let fastest = comparison.fastest(|_| true).map(|(_, found)| found.ns_per_s);
    for found in comparison.rows.iter_mut().filter_map(|row| row.found.as_mut()) {
        found.time_ratio = fastest.map(|fastest| found.ns_per_s / fastest);
    }
    Ok(comparison)
}

/// The row of the reference itself, which has no errors.
fn reference_row(scene: &Scene, reference: &Outcome) -> Row {
    let timed = Timed {
        variant: Variant::reference(Control::Default),
        outcome: Ok(reference.clone()),
        times: vec![reference.processor_s],
    };
    let mut row = timed.row(scene, reference);
    if let Some(found) = &mut row.found {
        found.errors.0.iter_mut().for_each(|(_, error)| *error = None);
    }
    row
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
