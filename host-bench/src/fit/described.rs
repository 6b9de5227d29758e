//! A solution as a result: standard errors, what the data do not determine, and what to know before the numbers are used.

use nalgebra::DVector;

use super::data::Rows;
use super::lines::groups;
use super::model::Problem;
use super::result::{self, FitResult};
use super::solve::{Loss, Solved};
use super::uncertainty::{Runs, Uncertainty, Unfollowed};
use super::weights::{self, Weighting, Weights};
use super::{Request, relative_residuals};
use crate::name::Name;

/// Correlation of two keys from which on a warning names them.
const CORRELATED: f64 = 0.99;
/// Reduced chi-squared above which the standard deviations, or the model, are doubted.
const DOUBTED: f64 = 3.0;
/// Relative residual below which it does not matter whether the residuals are systematic.
const SMALL: f64 = 1e-3;
/// Most rows that a warning names.
const NAMED_ROWS: usize = 6;

pub(super) fn described(
    problem: &Problem<'_>,
    request: &Request<'_>,
    weights: &Weights,
    loss: Loss,
    solved: &Solved,
    step: f64,
) -> FitResult {
    let measured = problem.measured();
    let sigma = weights.sigma();
    let values = &solved.evaluation.values;
    let at_value = |index: usize| problem.free[index].value(solved.at[index]);
    let is_free: Vec<bool> =
        (0..solved.at.len()).map(|index| !problem.free[index].is_at_bound(at_value(index))).collect();
    let moving = is_free.iter().filter(|free| **free).count();
    let freedom = problem.count().saturating_sub(moving);
    let residuals: Vec<f64> =
        (0..measured.len()).map(|index| (values[index] - measured[index]) / sigma[index]).collect();
    let chi_squared: f64 = residuals.iter().map(|residual| residual * residual).sum();
    let reduced = (freedom > 0).then(|| chi_squared / freedom as f64);
    let variance = match loss {
        Loss::Huber(limit) => robust_variance(&residuals, limit, moving),
        Loss::Squares if weights.all_given() => 1.0,
        // Without a degree of freedom nothing is known of the scatter.
        Loss::Squares => reduced.unwrap_or(f64::INFINITY),
    };
    let columns = weighted(problem, solved, sigma, step);
    let mut uncertainty = Uncertainty::of(&columns, &is_free, variance);
    // A combination without influence may have drifted to a bound, which would hide it.
    let all = Uncertainty::of(&columns, &vec![true; columns.len()], variance);
    if !all.undetermined.is_empty() {
        uncertainty.undetermined = all.undetermined;
    }
    if loss == Loss::Squares && !weights.all_given() {
        uncertainty.widen(&columns, &residuals, variance);
    }
    let mut found = FitResult::new(problem, solved, &uncertainty, &is_free, freedom);
    found.reduced_chi_squared = reduced.filter(|_| weights.all_given());
    found.relative_residual = relative_residuals(problem, values);
    found.unfollowed = Unfollowed::of(problem, solved, &found.relative_residual);
    found.weighting = weights.weightings().to_vec();
    found.warnings = warnings(problem, request, weights, solved, &found);
    found
}

/// The slopes of the values over each parameter at a solution, in standard deviations.
pub(super) fn weighted(
    problem: &Problem<'_>,
    solved: &Solved,
    sigma: &[f64],
    step: f64,
) -> Vec<DVector<f64>> {
    let over = |column: Vec<f64>| {
        DVector::from_iterator(column.len(), column.iter().zip(sigma).map(|(slope, sigma)| slope / sigma))
    };
    problem.jacobian(&solved.at, &solved.evaluation, step).into_iter().map(over).collect()
}

/// The variance of a weighted value under Huber's loss (P. J. Huber, *Robust Statistics*, 1981, section 7.6).
fn robust_variance(residuals: &[f64], limit: f64, moving: usize) -> f64 {
    let count = residuals.len() as f64;
    let inside = residuals.iter().filter(|residual| residual.abs() < limit).count() as f64 / count;
    let squares: f64 = residuals.iter().map(|residual| residual.clamp(-limit, limit).powi(2)).sum();
    let correction = 1.0 + moving as f64 / count * (1.0 - inside) / inside;
    correction * correction * squares / (count - moving as f64) / (inside * inside)
}

/// What to know before the numbers are used.
fn warnings(
    problem: &Problem<'_>,
    request: &Request<'_>,
    weights: &Weights,
    solved: &Solved,
    found: &FitResult,
) -> Vec<String> {
    let mut all = Vec::new();
    all.extend(found.unfollowed.iter().map(Unfollowed::text));
    all.extend(without_orbit(problem, solved));
    for combination in &found.undetermined {
        let way =
            if combination.len() > 1 { "one of these keys, or measure what separates them" } else { "it" };
        let keys = result::product(combination);
        all.push(format!("not identifiable: the data do not determine {keys}; hold {way}"));
    }
    for parameter in found.parameters.iter().filter(|parameter| parameter.at_bound) {
        all.push(format!("{} is at its bound: it has no standard error", parameter.key));
    }
    if found.undetermined.is_empty() {
        for (one, row) in found.correlation.iter().enumerate() {
            for (other, value) in row.iter().enumerate().skip(one + 1) {
                if let Some(value) = value.filter(|value| value.abs() > CORRELATED) {
                    let [one, other] = [one, other].map(|index| &found.parameters[index].key);
                    all.push(format!("{one} and {other} have a correlation of {value:.4}"));
                }
            }
        }
    }
    if let Some(reduced) = found.reduced_chi_squared.filter(|reduced| *reduced > DOUBTED) {
        all.push(format!(
            "the reduced chi-squared is {reduced:.1}: the model does not follow the data within their standard \
             deviations, and the standard errors are too small"
        ));
    }
    if !request.huber && weights.weightings().iter().any(|(_, weighting)| *weighting == Weighting::Relative) {
        let relative = weights.weightings().iter().filter(|(_, weighting)| *weighting == Weighting::Relative);
        let names: Vec<&str> = relative.map(|(name, _)| name.as_str()).collect();
        all.push(format!(
            "the scatter of {} grows with the value: it is weighted by its size; give columns _std to say otherwise",
            names.join(", ")
        ));
    }
    all.extend(systematic(problem, solved, found));
    all
}

/// The warning of the rows whose motion has no period, which names the first of them.
fn without_orbit(problem: &Problem<'_>, solved: &Solved) -> Option<String> {
    let rows: Vec<(usize, usize)> = solved.evaluation.rows_without_orbit(&problem.data).collect();
    let place = |&(file, row): &(usize, usize)| {
        let data = &problem.data[file];
        let name = Name::of_file(&data.file).line();
        let frequency = match &data.rows {
            Rows::Sweep(rows) => rows.get(row).map(|row| format!(" ({} Hz)", row.frequency_hz)),
            Rows::Trace { .. } => None,
        };
        format!("{name}:{}{}", data.lines.get(row).copied().unwrap_or(0), frequency.unwrap_or_default())
    };
    let named: Vec<String> = rows.iter().take(NAMED_ROWS).map(place).collect();
    let more = if rows.len() > NAMED_ROWS { " and others" } else { "" };
    (!rows.is_empty()).then(|| {
        format!(
            "at {} row{} the model has no stable motion of one period: {}{more}: the numbers of the run stand there, with a \
             standard deviation of at least {} % of the value",
            rows.len(),
            if rows.len() == 1 { "" } else { "s" },
            named.join(", "),
            100.0 * weights::WITHOUT_PERIOD
        )
    })
}

/// A warning for each measured column without standard deviations whose residuals hang together.
fn systematic(problem: &Problem<'_>, solved: &Solved, found: &FitResult) -> Vec<String> {
    let large = found.relative_residual.iter().filter(|(_, residual)| *residual > SMALL);
    let texts = large.filter_map(|(name, _)| {
        let mut runs = Runs::default();
        for (file, data) in problem.data.iter().enumerate() {
            let columns = data.columns.iter().enumerate();
            for (index, column) in columns.filter(|(_, column)| column.name == *name && column.std.is_none()) {
                for group in groups(data) {
                    let value = |row: usize| solved.evaluation.values[problem.index(file, index, row)];
                    runs.add(group.rows.iter().map(|&row| column.values[row] - value(row)));
                }
            }
        }
        runs.are_systematic().then(|| {
            format!(
                "the residuals of {name} are systematic: {} runs of one sign where chance has {:.1}; the model does not \
                 follow the data, and the standard errors are too small",
                runs.count,
                runs.expected()[0]
            )
        })
    });
    texts.collect()
}
