//! The values of a few keys at which a number of the result is largest or smallest: a grid, then a search without derivatives.

mod grid;
mod picture;
mod search;

use std::path::Path;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Map, Value, json};

pub(crate) use self::picture::picture;
use self::search::FLAT;
pub(crate) use self::search::{most_runs, optimise};
use crate::budget::day_numbers;
use crate::method::{Failure, Options};
use crate::outcome::{Branch, Fields, Outcome, fields, flattened, number};
use crate::report::setting::number_and_unit;
use crate::resolution::resonances;
use crate::run::run_scene;
use crate::scene_file::{self, Override, Scene, finite_number_in, finite_number_of, nearest};

/// A key and the range in which its best value is sought: `KEY=LOW:HIGH` or `KEY=LOW:HIGH:log`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Range {
    pub(crate) key: String,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) is_logarithmic: bool,
}

impl Range {
    /// The value at a part of the way from the low to the high end, in logarithms where it is asked for.
    pub(crate) fn value(&self, part: f64) -> f64 {
        match part {
            part if part <= 0.0 => self.low,
            part if part >= 1.0 => self.high,
            part if self.is_logarithmic => self.low * (self.high / self.low).powf(part),
            part => self.low + part * (self.high - self.low),
        }
    }
}

/// A key, both ends of a range, what follows them, and whether `log` ends all.
type Ends<'a> = (&'a str, [f64; 2], Vec<&'a str>, bool);

/// Those of `KEY=LOW:HIGH…`, where the ends have these names.
pub(crate) fn ends<'a>(text: &'a str, form: &str, [low, high]: [&str; 2]) -> Result<Ends<'a>, String> {
    let (key, range) = text.split_once('=').ok_or(form)?;
    let (key, mut parts) = (key.trim(), range.split(':').map(str::trim).collect::<Vec<_>>());
    let is_logarithmic = parts.pop_if(|last| *last == "log").is_some();
    if key.is_empty() || parts.len() < 2 {
        return Err(form.to_owned());
    }
    let rest = parts.split_off(2);
    let ends = [finite_number_of(key, low, parts[0])?, finite_number_of(key, high, parts[1])?];
    match is_logarithmic && !ends.iter().all(|end| *end > 0.0) {
        true => Err(format!("{low} and {high} must be above 0 with log")),
        false => Ok((key, ends, rest, is_logarithmic)),
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "must be KEY=LOW:HIGH or KEY=LOW:HIGH:log";
        let (key, [low, high], rest, is_logarithmic) = ends(text, FORM, ["LOW", "HIGH"])?;
        match rest[..] {
            [] if low < high => Ok(Self { key: key.to_owned(), low, high, is_logarithmic }),
            [] => Err(format!("LOW = {low} must be below HIGH = {high}")),
            _ => Err(FORM.to_owned()),
        }
    }
}

/// A bound of a number of the result: `QUANTITY<=VALUE` or `QUANTITY>=VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Constraint {
    pub(crate) quantity: String,
    /// Whether the number must be at least the bound; at most otherwise.
    pub(crate) is_least: bool,
    pub(crate) bound: f64,
}

impl Constraint {
    /// By how much a value keeps the bound, relative to it; negative where it does not.
    pub(crate) fn margin(&self, value: f64) -> f64 {
        let margin = if self.is_least { value - self.bound } else { self.bound - value };
        margin / if self.bound == 0.0 { 1.0 } else { self.bound.abs() }
    }

    fn text(&self) -> String {
        format!("{}{}{:e}", self.quantity, if self.is_least { ">=" } else { "<=" }, self.bound)
    }
}

impl FromStr for Constraint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "must be QUANTITY<=VALUE or QUANTITY>=VALUE";
        let (is_least, parts) = match (text.split_once("<="), text.split_once(">=")) {
            (Some(parts), None) => (false, parts),
            (None, Some(parts)) => (true, parts),
            _ => return Err(FORM.to_owned()),
        };
        let quantity = parts.0.trim().to_owned();
        let bound = finite_number_in(number_and_unit(&quantity).1, "VALUE")(parts.1.trim())?;
        if quantity.is_empty() { Err(FORM.to_owned()) } else { Ok(Self { quantity, is_least, bound }) }
    }
}

pub(crate) struct Request<'a> {
    pub(crate) file: &'a Path,
    pub(crate) overrides: &'a [Override],
    pub(crate) options: Options,
    /// Makes a scene that was read ready to run.
    pub(crate) hold: &'a (dyn Fn(&mut Scene) -> Result<(), Failure> + Sync),
    pub(crate) quantity: String,
    /// Whether the largest value is sought; the smallest otherwise.
    pub(crate) is_largest: bool,
    pub(crate) ranges: Vec<Range>,
    pub(crate) constraints: Vec<Constraint>,
    /// Points of the grid for each key.
    pub(crate) grid: usize,
    /// Is called after each run.
    pub(crate) done: &'a (dyn Fn() + Sync),
    pub(crate) runs: Runs,
    /// Whether the numbers of the day of the scene's node are among those of a run.
    pub(crate) node: bool,
    /// Whether the best point is run from its own start only.
    pub(crate) single_start: bool,
}

/// The runs so far, and those of them that failed or lack a number.
#[derive(Debug, Default)]
pub(crate) struct Runs {
    all: AtomicUsize,
    failed: AtomicUsize,
}

impl Runs {
    /// All, and those that failed.
    fn counts(&self) -> [usize; 2] {
        [&self.all, &self.failed].map(|count| count.load(Ordering::Relaxed))
    }
}

impl Request<'_> {
    /// The scene at a place: a part of the range for each key.
    fn scene(&self, place: &[f64]) -> Result<Scene, Failure> {
        let mut scene = scene_file::read(self.file, &self.overrides_at(place))?;
        (self.hold)(&mut scene)?;
        Ok(scene)
    }

    fn overrides_at(&self, place: &[f64]) -> Vec<Override> {
        let values = self.ranges.iter().zip(place);
        let values =
            values.map(|(range, part)| Override::new(&range.key, &number(range.value(*part))).by("--over"));
        self.overrides.iter().cloned().chain(values).collect()
    }

    /// The numbers of a run, and of the day of the node.
    fn numbers(&self, place: &[f64], outcome: &Outcome) -> Result<Fields, Failure> {
        let day = if self.node { day_numbers(self.file, &self.overrides_at(place))? } else { Fields::new() };
        Ok(flattened(fields(outcome)).into_iter().chain(day).collect())
    }

    /// A run that is not yet counted.
    fn run(&self, place: &[f64]) -> Result<Outcome, Failure> {
        run_scene(&self.scene(place)?, &self.options)
    }

    fn counted(&self, found: Result<Outcome, Failure>) -> Result<Outcome, Failure> {
        self.runs.all.fetch_add(1, Ordering::Relaxed);
        self.runs.failed.fetch_add(usize::from(found.is_err()), Ordering::Relaxed);
        (self.done)();
        found
    }

    /// Runs the scene at a place and judges it.
    fn point(&self, place: &[f64]) -> Point {
        self.judged(place, self.counted(self.run(place)).ok())
    }

    fn judged(&self, place: &[f64], outcome: Option<Outcome>) -> Point {
        let scene = || self.scene(place).ok();
        let tuned = outcome.as_ref().and_then(|outcome| Some(Tuning::of(&scene()?, outcome)));
        let found = outcome.and_then(|outcome| {
            let found = self.judge(place, &outcome);
            self.runs.failed.fetch_add(usize::from(found.is_none()), Ordering::Relaxed);
            found
        });
        let tuning = tuned.filter(|_| found.is_some()).unwrap_or_default();
        Point { place: place.to_vec(), found, tuning }
    }

    /// The value sought, the higher the better, and the margin of each constraint; `None` where one is undefined.
    fn judge(&self, place: &[f64], outcome: &Outcome) -> Option<(f64, Vec<f64>)> {
        let numbers = self.numbers(place, outcome).ok()?;
        let value = |name: &str| {
            let found = numbers.get(name).and_then(Value::as_f64).filter(|value| value.is_finite());
            // A run that approaches no limit has an ample margin, of which the result warns.
            found.or_else(|| {
                (name.ends_with("_margin") && !outcome.margins.limits.is_empty()).then_some(100.0)
            })
        };
        let sought = value(&self.quantity)? * if self.is_largest { 1.0 } else { -1.0 };
        let margins: Option<Vec<f64>> = self
            .constraints
            .iter()
            .map(|constraint| Some(constraint.margin(value(&constraint.quantity)?)))
            .collect();
        Some((sought, margins?))
    }

    /// A warning where the result has no margin of which a constraint is.
    fn unapproached(&self, place: &[f64], outcome: &Outcome) -> Option<String> {
        let numbers = self.numbers(place, outcome).ok()?;
        let is_unknown = |one: &&Constraint| numbers.get(&one.quantity).is_none_or(Value::is_null);
        let name = self.constraints.iter().find(is_unknown)?.text();
        Some(format!("{name} is not checked: the best run approaches no such limit and has no margin"))
    }

    /// The option that names the quantity.
    fn option(&self) -> &'static str {
        if self.is_largest { "--maximise" } else { "--minimise" }
    }

    /// The option and the name of each quantity.
    fn quantities(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let of_constraints = self.constraints.iter().map(|constraint| ("--subject-to", &constraint.quantity));
        std::iter::once((self.option(), &self.quantity)).chain(of_constraints)
    }

    /// Refuses a quantity that says nothing of the harvester.
    fn check_names(&self) -> Result<(), Failure> {
        let mut refused = self.quantities().filter_map(|(option, name)| {
            let reason = irrelevant(name)?;
            Some(Failure::Input(format!("{option} {name}: cannot be sought: {reason}")))
        });
        refused.next().map_or(Ok(()), Err)
    }

    /// The value in its own sign.
    pub(crate) fn signed(&self, value: f64) -> f64 {
        if self.is_largest { value } else { -value }
    }
}

/// Refuses a number that the result of a scene does not have.
pub(crate) fn check_quantity(option: &str, name: &str, numbers: &Fields) -> Result<(), Failure> {
    if numbers.get(name).is_some_and(|value| value.is_number() || value.is_null()) {
        return Ok(());
    }
    let known = numbers.iter().filter(|(key, value)| value.is_number() && irrelevant(key).is_none());
    let known: Vec<&str> = known.map(|(key, _)| key.as_str()).collect();
    let meant = nearest(name, &known).or_else(|| known.iter().copied().find(|known| known.contains(name)));
    let meant = meant.map_or_else(String::new, |meant| format!(", probably {meant}"));
    let reason = format!("must be a number of the result{meant}; run --format json prints all of them");
    Err(Failure::Input(format!("{option} {name}: {reason}")))
}

/// Why a number of the result says nothing of the harvester; `None` of one that does.
fn irrelevant(name: &str) -> Option<&'static str> {
    match name {
        "processor_s" => Some("it is a time of this computer"),
        "steps" | "rejected_steps" | "newton_iterations" | "simulated_periods" => {
            Some("it is what the computation took")
        }
        "duration_s" | "settle_s" => Some("it is chosen in [run] of the scene"),
        "energy_residual" | "steady_state_residual" => Some("it is an error of the numerics"),
        name if name.starts_with("accuracy") => {
            Some("each point is run once, without its accuracy statement")
        }
        name if name.starts_with("run.") || name.starts_with("run_") => {
            Some("[run] is chosen in the scene, and no result")
        }
        _ => None,
    }
}

/// How far a scene is from its resonances.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Tuning {
    /// Logarithms of the frequency of the excitation over the natural frequencies, in their order; none without one sine.
    distances: Vec<f64>,
    /// Half-power bandwidth over the natural frequency.
    bandwidth: f64,
}

impl Tuning {
    fn of(scene: &Scene, outcome: &Outcome) -> Self {
        let (resonances, damping_ratio) = resonances(scene, outcome);
        let frequency = scene.excitation.single_frequency().filter(|frequency| *frequency > 0.0);
        let distances = frequency
            .iter()
            .flat_map(|frequency| resonances.iter().map(move |natural| (frequency / natural).ln()))
            .collect();
        Self { distances, bandwidth: 2.0 * damping_ratio }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Point {
    /// Part of the range of each key.
    pub(crate) place: Vec<f64>,
    /// The value sought, the higher the better, and the margins of the constraints; `None` where the run failed.
    pub(crate) found: Option<(f64, Vec<f64>)>,
    pub(crate) tuning: Tuning,
}

impl Point {
    /// Whether the key of an index is at an end of its range.
    pub(crate) fn is_at_bound(&self, index: usize) -> bool {
        let part = self.place[index];
        part <= 1e-6 || part >= 1.0 - 1e-6
    }

    pub(crate) fn feasible(&self) -> Option<f64> {
        self.found
            .as_ref()
            .filter(|(_, margins)| margins.iter().all(|margin| *margin >= 0.0))
            .map(|(value, _)| *value)
    }

    /// Its value, whatever the constraints.
    pub(crate) fn value(&self) -> Option<f64> {
        self.found.as_ref().map(|(value, _)| *value)
    }
}

#[derive(Debug)]
pub(crate) struct Optimum {
    pub(crate) best: Point,
    /// The best point without the constraints, where there are any.
    pub(crate) unconstrained: Option<Point>,
    /// For each key the range around the best point within 1 % of the best value.
    pub(crate) flat: Vec<[f64; 2]>,
    /// The other optima, the best first, each with the same ranges within 1 % of its own value.
    pub(crate) others: Vec<(Point, Vec<[f64; 2]>)>,
    /// What was searched.
    pub(crate) searched: String,
    pub(crate) outcome: Outcome,
    /// All points of the grid, the last key running fastest, and then those between them and of the searches.
    pub(crate) points: Vec<Point>,
    /// Runs of these points, of the flat range, of the best point again, and beside it; and those that failed.
    pub(crate) runs: [usize; 2],
    /// What to know before the optimum is used, besides the warnings of its run.
    pub(crate) doubts: Vec<String>,
}

impl Optimum {
    pub(crate) fn values(request: &Request<'_>, point: &Point) -> Vec<(String, f64)> {
        let ranges = request.ranges.iter().zip(&point.place);
        ranges.map(|(range, part)| (range.key.clone(), range.value(*part))).collect()
    }

    /// What to know of the optimum, and the warnings of its run.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = &String> {
        self.doubts.iter().chain(&self.outcome.warnings)
    }

    /// The motion at the best values, from another start, whose mean power is better, where that is sought.
    pub(crate) fn better(&self, request: &Request<'_>) -> Option<(f64, &Branch)> {
        let own = self.best.value().filter(|_| request.quantity == "mean_power_w")?;
        let branches = self.outcome.branches.iter().flatten();
        let others = branches.filter_map(|branch| Some((branch.mean_power_w?, branch)));
        others
            .filter(|(power, _)| request.signed(*power) > own + FLAT * own.abs())
            .max_by(|one, other| request.signed(one.0).total_cmp(&request.signed(other.0)))
    }

    pub(crate) fn json(&self, request: &Request<'_>) -> Map<String, Value> {
        let of_point = |point: &Point| -> Map<String, Value> {
            Self::values(request, point).into_iter().map(|(key, value)| (key, json!(value))).collect()
        };
        let by_key = |of: &dyn Fn(usize) -> Value| -> Value {
            request.ranges.iter().enumerate().map(|(index, range)| (range.key.clone(), of(index))).collect()
        };
        let ranges = |flat: &[[f64; 2]]| by_key(&|index| json!(flat[index]));
        let other = |(point, flat): &(Point, Vec<[f64; 2]>)| {
            json!({
                "value": point.value().map(|value| request.signed(value)),
                "point": of_point(point),
                "range_within_1_percent": ranges(flat),
            })
        };
        let others: Vec<Value> = self.others.iter().map(other).collect();
        let value = self.best.value();
        let mut all = fields(&json!({
            "scene": self.outcome.scene,
            "quantity": request.quantity,
            "sought": if request.is_largest { "maximum" } else { "minimum" },
            "value": value.map(|value| request.signed(value)),
            "point": of_point(&self.best),
            "range_within_1_percent": ranges(&self.flat),
            "other_optima": others,
            "better_motion": self.better(request).map(|(value, Branch { share, starts, .. })|
                json!({ "value": value, "share_of_starts": share, "starts": starts })),
            "searched": self.searched,
            "at_bound": by_key(&|index| json!(self.best.is_at_bound(index))),
        }));
        if let Some(without) = &self.unconstrained {
            let value_without = without.value();
            let cost = value_without.zip(value).map(|(without, with)| without - with);
            let relative = cost.zip(value_without).map(|(cost, without)| cost / without.abs());
            all.extend(fields(&json!({
                "constraints": self.constraints(request),
                "unconstrained_value": value_without.map(|value| request.signed(value)),
                "unconstrained_point": of_point(without),
                "constraint_cost": cost,
                "constraint_cost_relative": relative.filter(|relative| relative.is_finite()),
            })));
        }
        let [runs, failed] = self.runs;
        all.extend(fields(&json!({
            "evaluations": runs,
            "failed": failed,
            "accuracy": self.outcome.accuracy,
            "warnings": self.warnings().collect::<Vec<_>>(),
            "result": self.outcome,
        })));
        all
    }

    /// Each constraint with its quantity at the best point, and whether it limits it.
    fn constraints(&self, request: &Request<'_>) -> Value {
        let numbers = flattened(fields(&self.outcome));
        let of = |constraint: &Constraint| {
            let at = numbers.get(&constraint.quantity).cloned().unwrap_or(Value::Null);
            let is_active = at.as_f64().is_some_and(|at| constraint.margin(at) < 1e-2);
            json!({ "constraint": constraint.text(), "value": at, "active": is_active })
        };
        request.constraints.iter().map(of).collect()
    }
}
