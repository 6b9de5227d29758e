//! The result of a fit as numbers, as a table and as JSON.

use std::fmt::Write;
use std::sync::atomic::Ordering;

use comfy_table::presets;
use serde::Serialize;
use serde_json::{Value, json};

use super::fitted::Entry;
use super::free::{Free, Place};
use super::lines::{Group, Line, groups};
use super::model::{Interpolation, Problem};
use super::solve::Solved;
use super::uncertainty::{Uncertainty, Unfollowed, remark};
use super::weights::Weighting;
use crate::accuracy::Statements;
use crate::command::json_text;
use crate::method::Failure;
use crate::name::Name;
use crate::outcome::{Format, fields, small};
use crate::rows::{Column, Digits, Rows};
use crate::seeds::quantile;

/// Probability of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Keys with their exponents: a product that the data do not determine.
pub(crate) type Combination = Vec<(String, f64)>;

/// A measured column beside the model, for the picture.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    pub(crate) file: String,
    pub(crate) column: String,
    /// Frequency in Hz or time in s.
    pub(crate) x: Vec<f64>,
    pub(crate) measured: Vec<f64>,
    pub(crate) model: Vec<f64>,
    pub(crate) std: Option<Vec<f64>>,
    pub(crate) is_trace: bool,
    pub(crate) groups: Vec<Group>,
    /// For each group the model between its rows, if it was computed; none of a trace.
    pub(crate) lines: Vec<Line>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct FitResult {
    pub(crate) scene: &'static str,
    pub(crate) converged: bool,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) correlation: Vec<Vec<Option<f64>>>,
    pub(crate) reduced_chi_squared: Option<f64>,
    pub(crate) relative_residual: Vec<(String, f64)>,
    pub(crate) weighting: Vec<(String, Weighting)>,
    pub(crate) points: usize,
    pub(crate) evaluations: usize,
    pub(crate) undetermined: Vec<Combination>,
    pub(crate) interpolation: Option<&'static str>,
    /// Measured columns that the model does not follow.
    pub(super) unfollowed: Vec<Unfollowed>,
    pub(crate) warnings: Vec<String>,
    /// What a run of the fitted scene states.
    pub(crate) statements: Statements,
    pub(crate) curves: Vec<Curve>,
}

fn is_part(combinations: &[Vec<f64>], index: usize) -> bool {
    combinations.iter().any(|combination| combination[index] != 0.0)
}

/// The combinations of parameters that the data do not determine, with each parameter whose interval covers most of its bounds.
fn undetermined(
    (problem, solved): (&Problem<'_>, &Solved),
    uncertainty: &Uncertainty,
    is_free: impl Fn(usize) -> bool,
    t: f64,
) -> Vec<Vec<f64>> {
    let count = problem.free.len();
    let mut all = uncertainty.undetermined.clone();
    let is_wide = |index: &usize| {
        let error = uncertainty.standard_error(*index);
        let parameter = Parameter::of(&problem.free[*index], solved.at[*index], Some(error), t);
        parameter.interval_95.is_some_and(|ends| problem.free[*index].covers_most(ends))
    };
    let wide = (0..count).filter(|index| is_free(*index) && !is_part(&all, *index)).filter(is_wide);
    for index in wide.collect::<Vec<_>>() {
        all.push((0..count).map(|other| f64::from(other == index)).collect());
    }
    all
}

impl FitResult {
    pub(super) fn new(
        problem: &Problem<'_>,
        solved: &Solved,
        uncertainty: &Uncertainty,
        is_free: &[bool],
        freedom: usize,
    ) -> Self {
        let count = problem.free.len();
        let t = quantile(u32::try_from(freedom).unwrap_or(u32::MAX), CONFIDENCE);
        let is_free = |index: usize| is_free[index] && freedom > 0;
        let undetermined = undetermined((problem, solved), uncertainty, is_free, t);
        let known = |index: usize| is_free(index) && !is_part(&undetermined, index);
        let parameters = (0..count).map(|index| {
            let error = known(index).then(|| uncertainty.standard_error(index));
            let parameter = Parameter::of(&problem.free[index], solved.at[index], error, t);
            let is_shared = !matches!(problem.free[index].place, Place::StartOf(_))
                || !problem.free[index].name.contains(' ');
            Parameter { is_written: is_shared, ..parameter }
        });
        let correlation = (0..count).map(|one| {
            let of = |other: usize| {
                if one == other {
                    Some(1.0)
                } else {
                    uncertainty.correlation(one, other).filter(|_| known(one) && known(other))
                }
            };
            (0..count).map(of).collect()
        });
        let names = problem.free.iter().map(|free| free.name.clone());
        let undetermined = undetermined
            .iter()
            .map(|parts| names.clone().zip(parts.iter().copied()).filter(|(_, part)| *part != 0.0).collect());
        Self {
            scene: problem.scene(&solved.at).map_or("", |scene| scene.name()),
            converged: solved.converged,
            parameters: parameters.collect(),
            correlation: correlation.collect(),
            points: problem.count(),
            evaluations: problem.evaluations.load(Ordering::Relaxed),
            undetermined: undetermined.collect(),
            interpolation: problem.has_samples().then_some(match problem.interpolation {
                Interpolation::Smooth => "smooth",
                Interpolation::Linear => "linear",
            }),
            curves: curves(problem, &solved.evaluation.values),
            ..Self::default()
        }
    }

    pub(crate) fn is_identifiable(&self) -> bool {
        self.undetermined.is_empty()
    }

    /// What a scene file is to have of the fit.
    pub(crate) fn entries(&self) -> Vec<Entry> {
        let remark = remark(&self.unfollowed);
        let written = self.parameters.iter().filter(|parameter| parameter.is_written);
        let entry = |parameter: &Parameter| {
            let entry = parameter.entry();
            Entry { comment: entry.comment + &remark, ..entry }
        };
        written.map(entry).collect()
    }

    fn json(&self) -> Value {
        let parameters: Vec<_> = self.parameters.iter().map(|one| (one.key.clone(), fields(one))).collect();
        let not_determined: Vec<Value> = self.undetermined.iter().map(|parts| object(parts)).collect();
        let mut all = fields(&json!({
            "scene": self.scene,
            "converged": self.converged,
            "parameters": object(&parameters),
            "correlation": self.correlation,
        }));
        let mut put = |key: &str, value: Value| all.insert(key.to_owned(), value);
        self.reduced_chi_squared.map(|reduced| put("reduced_chi_squared", json!(reduced)));
        put("relative_residual", object(&self.relative_residual));
        put("weights", object(&self.weighting));
        put("points", json!(self.points));
        put("evaluations", json!(self.evaluations));
        put("identifiable", json!(self.is_identifiable()));
        if !self.is_identifiable() {
            put("not_determined", json!(not_determined));
        }
        self.interpolation.map(|interpolation| put("interpolation", json!(interpolation)));
        all.extend(self.statements.fields(&self.warnings));
        Value::Object(all)
    }
}

/// Names and values as an object.
fn object(pairs: &[(String, impl Serialize)]) -> Value {
    pairs.iter().map(|(name, value)| (name.clone(), json!(value))).collect()
}

/// The data and the model of each measured column.
fn curves(problem: &Problem<'_>, values: &[f64]) -> Vec<Curve> {
    use super::data::Rows;
    let mut all = Vec::new();
    for (file, data) in problem.data.iter().enumerate() {
        let x: Vec<f64> = match &data.rows {
            Rows::Sweep(rows) => rows.iter().map(|row| row.frequency_hz).collect(),
            Rows::Trace { spacing_s, .. } => (0..data.count()).map(|row| row as f64 * spacing_s).collect(),
        };
        for (index, column) in data.columns.iter().enumerate() {
            let from = problem.index(file, index, 0);
            all.push(Curve {
                file: Name::of_file(&data.file).line(),
                column: column.name.clone(),
                x: x.clone(),
                measured: column.values.clone(),
                model: values[from..from + column.values.len()].to_vec(),
                std: column.std.clone(),
                is_trace: matches!(data.rows, Rows::Trace { .. }),
                groups: groups(data),
                lines: Vec::new(),
            });
        }
    }
    all
}

/// A combination in words: the change of the keys that leaves the data as they are.
pub(super) fn product(combination: &Combination) -> String {
    let [(key, _)] = combination.as_slice() else {
        let parts: Vec<String> = combination.iter().map(|(key, part)| format!("{key}^{part:.2}")).collect();
        return format!("the keys along the change {}", parts.join(" · "));
    };
    key.clone()
}

/// The result as text, line break at its end included.
pub(crate) fn text(found: &FitResult, format: Format) -> Result<String, Failure> {
    match format {
        Format::Json => json_text(&found.json()),
        Format::Csv => Ok(rows(found).csv()),
        Format::Table => Ok(for_people(found)),
    }
}

fn rows(found: &FitResult) -> Rows {
    let stated = found.statements.fields(&found.warnings);
    let row = |parameter: &Parameter| {
        let Parameter { key, value, standard_error, interval_95, start, at_bound, .. } = parameter;
        let [low, high] = [0, 1].map(|end| interval_95.map(|ends| ends[end]));
        let mut row = fields(&json!({
            "key": key, "value": value, "standard_error": standard_error, "low_95": low, "high_95": high, "start": start,
            "at_bound": at_bound,
        }));
        row.extend(stated.clone());
        row
    };
    Rows(found.parameters.iter().map(row).collect())
}

const COLUMNS: [Column<'_>; 6] = [
    ("key", "key", Digits::Word),
    ("value", "value", Digits::Exponent(5)),
    ("standard error", "standard_error", Digits::Exponent(2)),
    ("95 % from", "low_95", Digits::Exponent(5)),
    ("to", "high_95", Digits::Exponent(5)),
    ("start", "start", Digits::Exponent(5)),
];

fn for_people(found: &FitResult) -> String {
    let mut text = rows(found).table(presets::NOTHING, &COLUMNS, 1);
    text.push('\n');
    for Parameter { key, .. } in found.parameters.iter().filter(|parameter| parameter.at_bound) {
        let _ = writeln!(text, "at its bound: {key}");
    }
    for (name, value) in &found.relative_residual {
        let _ = writeln!(text, "relative residual of {name}: {value:.3e}");
    }
    if let Some(reduced) = found.reduced_chi_squared {
        let _ = writeln!(text, "reduced chi-squared: {reduced:.3}");
    }
    let converged = if found.converged { "" } else { ", NOT converged" };
    let _ = writeln!(text, "{} points, {} evaluations{converged}", found.points, found.evaluations);
    let _ =
        writeln!(text, "accuracy of the mean power of the fitted scene: {}", small(found.statements.total()));
    for combination in &found.undetermined {
        let _ = writeln!(text, "not identifiable: {}", product(combination));
    }
    text
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct Parameter {
    #[serde(skip)]
    pub(crate) key: String,
    pub(crate) value: f64,
    /// `None` at a bound, and of a key that the data do not determine.
    pub(crate) standard_error: Option<f64>,
    pub(crate) interval_95: Option<[f64; 2]>,
    pub(crate) start: f64,
    pub(crate) at_bound: bool,
    /// Whether it is a key of the scene that may be written.
    #[serde(skip)]
    pub(crate) is_written: bool,
}

impl Parameter {
    pub(crate) fn entry(&self) -> Entry {
        let known = match self.interval_95 {
            Some([low, high]) => format!("95 % from {low:.4e} to {high:.4e}"),
            None if self.at_bound => "at its bound".to_owned(),
            None => "without an interval".to_owned(),
        };
        let comment = format!("fitted, {known}, start {:e}", self.start);
        Entry { key: self.key.clone(), value: self.value, comment }
    }

    /// Of a coordinate with a standard error, and the quantile of Student's t for its interval.
    pub(super) fn of(free: &Free, at: f64, error: Option<f64>, quantile: f64) -> Self {
        let value = free.value(at);
        let interval =
            error.map(|error| [at - quantile * error, at + quantile * error].map(|end| free.within(end)));
        Self {
            key: free.name.clone(),
            value,
            standard_error: error.map(|error| error * free.slope(value)),
            interval_95: interval,
            start: free.start,
            at_bound: free.is_at_bound(value),
            is_written: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_stays_inside_its_bounds_and_one_over_most_of_them_determines_nothing() {
        let of = |unit| Free {
            name: "parameters.restitution.coefficient".to_owned(),
            place: Place::Key,
            start: 0.8,
            low: 0.0,
            high: 1.0,
            is_bounded: false,
            unit,
        };
        // A coordinate that is the logarithm, and one that is the value.
        for (free, wide, narrow) in [(of(None), 9.0, 0.02), (of(Some(0.8)), 8.62 / 0.8, 0.02)] {
            let at = free.coordinate(0.952);
            let interval = |error| Parameter::of(&free, at, Some(error), 1.96).interval_95.expect("an error");
            let [low, high] = interval(wide);
            assert!((0.0..0.01).contains(&low) && high == 1.0, "{low} {high}");
            assert!(free.covers_most([low, high]));
            assert!(!Free { is_bounded: true, ..free.clone() }.covers_most([low, high]));
            let [low, high] = interval(narrow);
            assert!(low > 0.9 && high < 1.0 && !free.covers_most([low, high]), "{low} {high}");
        }
    }
}
