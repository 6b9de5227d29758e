//! Parameters of a scene from measurements: weighted nonlinear least squares with the model of the scene.

pub(crate) mod data;
mod fitted;
pub(crate) mod free;
mod model;
mod picture;
mod result;
mod ring_down;
mod solve;
mod starts;
mod uncertainty;
mod weights;

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};

use self::data::{Data, Rows};
pub(crate) use self::fitted::{Entry, fitted_scene};
use self::free::{Asked, Free};
use self::model::{Interpolation, Problem};
pub(crate) use self::picture::draw;
pub(crate) use self::result::{Found, text};
use self::solve::{Loss, Solved, cost, solve};
use self::uncertainty::Uncertainty;
use self::weights::{Weighting, Weights};
use crate::method::{Failure, Math, Method, Options, Precision, refuse_first};
use crate::scene_file::{Model, Override, Scene};

/// Relative error of the mean power of the model: in the search, and at the end.
const ACCURACIES: [f64; 2] = [1e-6, 1e-9];
/// Steps of a beam without a stop in s, the same.
const BEAM_STEPS: [f64; 2] = [2e-5, 5e-6];
/// Change of a coordinate by which the model is differentiated: in the search, and the least and the largest at the end.
const SEARCH_STEP: f64 = 2e-3;
const STEPS: [f64; 2] = [1e-4, 2e-3];
/// Most starts that are followed to their end, besides the first.
const FOLLOWED: usize = 4;
/// RMS of the residual, in standard deviations or as a part of that of the data, at which no other start is tried.
const GOOD: [f64; 2] = [2.0, 0.03];
/// Correlation of two keys from which on a warning names them.
const CORRELATED: f64 = 0.99;
/// Reduced chi-squared above which the standard deviations, or the model, are doubted.
const DOUBTED: f64 = 3.0;

/// What is to be fitted to what.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    pub(crate) file: &'a Path,
    pub(crate) overrides: &'a [Override],
    pub(crate) options: Options,
    pub(crate) data: Vec<PathBuf>,
    pub(crate) free: Vec<Asked>,
    /// Whether large residuals count linearly.
    pub(crate) huber: bool,
    /// Most further starts that are looked at.
    pub(crate) starts: usize,
}

/// Huber's limit in standard deviations: 95 % of the efficiency of least squares on Gaussian data.
const HUBER: f64 = 1.345;

/// Fits; calls `done` after each evaluation of the model for all data.
pub(crate) fn fit(request: &Request<'_>, scene: &Scene, done: &(dyn Fn() + Sync)) -> Result<Found, Failure> {
    check(request, scene)?;
    let data: Vec<Data> =
        request.data.iter().map(|file| data::read(file, scene)).collect::<Result<_, _>>()?;
    let mut free = Vec::new();
    for asked in &request.free {
        free.push(free::of_key(request.file, request.overrides, asked)?);
    }
    let [coarse, fine] = [0, 1].map(|stage| options(request, scene, stage));
    ring_down::free_starts(scene, &data, &coarse, &mut free)?;
    let mut problem = Problem::new(request.file, request.overrides, coarse, data, free, done);
    if problem.count() < problem.free.len() {
        return Err(Failure::Input(format!(
            "--data: {} measured values are fewer than the {} free keys",
            problem.count(),
            problem.free.len()
        )));
    }
    let loss = if request.huber { Loss::Huber(HUBER) } else { Loss::Squares };
    let start: Vec<f64> = problem.free.iter().map(|free| free.coordinate(free.start)).collect();
    // Bad input is told at once; a start that fails on its way may have better ones beside it.
    if let Err(failure @ Failure::Input(_)) = problem.evaluate(&start, &problem.options) {
        return Err(failure);
    }
    let first = Weights::new(&problem, request.huber);
    let mut best = search(&problem, &start, &first, loss, request.starts)?;
    if problem.has_samples() {
        best = better_interpolation(&mut problem, best, &first, loss);
    }
    let (mut weights, best) = settled(&problem, first, best, loss, request.huber);
    problem.options = fine;
    let evaluation = problem.evaluate(&best.at, &problem.options)?;
    weights.widen(&problem, &evaluation);
    let step = difference(&problem, &best.at, &evaluation.values)?;
    let polished = solve(&problem, &best.at, weights.sigma(), loss, step);
    let solved = polished.ok_or_else(|| Failure::Step("the model fails at the solution".to_owned()))?;
    Ok(described(&problem, request, &weights, loss, &solved, step))
}

/// Refuses what a fit does not use.
fn check(request: &Request<'_>, scene: &Scene) -> Result<(), Failure> {
    let options = &request.options;
    options.check()?;
    options.check_scene(scene)?;
    let of_core = match scene.model {
        Model::BumpStop(_) => matches!(options.method, Method::Auto | Method::DiscreteGradient),
        _ => matches!(options.method, Method::Auto | Method::ExponentialRadau),
    };
    refuse_first(&[
        (!of_core, "--method: must be auto for a fit"),
        (options.precision == Some(Precision::F32), "--precision f32: must be f64 for a fit"),
        (options.math.is_some_and(|math| math != Math::Polynomial), "--math: must be polynomial for a fit"),
        (request.data.is_empty(), "--data: must name a file, here or as data in [fit]"),
        (request.free.is_empty(), "--free: must name a key, here or as free in [fit]"),
    ])?;
    for (index, asked) in request.free.iter().enumerate() {
        if request.free[..index].iter().any(|other| other.key == asked.key) {
            return Err(Failure::Input(format!("--free {}: must be given once", asked.key)));
        }
    }
    Ok(())
}

/// The options of a run of the model, where those of the command say nothing: of the search, or of the end.
fn options(request: &Request<'_>, scene: &Scene, stage: usize) -> Options {
    let given = request.options;
    let base = Options { bare: true, ..given };
    if given.step_s.is_some() || given.tolerance.is_some() || given.accuracy.is_some() {
        return base;
    }
    match &scene.model {
        Model::BumpStop(model) if model.stop.is_some() => base,
        Model::BumpStop(_) => {
            let step = Some(BEAM_STEPS[stage]);
            Options { step_s: step, long_step_s: given.long_step_s.or(step), ..base }
        }
        _ => Options { accuracy: Some(ACCURACIES[stage]), ..base },
    }
}

/// The best end of several starts: the given one alone if it ends well.
fn search(
    problem: &Problem<'_>,
    start: &[f64],
    weights: &Weights,
    loss: Loss,
    count: usize,
) -> Result<Solved, Failure> {
    let sigma = weights.sigma();
    let mut best = solve(problem, start, sigma, loss, SEARCH_STEP);
    if best.as_ref().is_some_and(|solved| is_good(problem, weights, solved)) || count == 0 {
        return best.ok_or_else(|| Failure::Step("the model fails at the start".to_owned()));
    }
    let measured = problem.measured();
    let mut others: Vec<(f64, Vec<f64>)> = starts::starts(problem, start, count)
        .into_iter()
        .filter_map(|at| {
            let values = problem.evaluate(&at, &problem.options).ok()?.values;
            Some((cost(&values, &measured, sigma, loss), at))
        })
        .collect();
    // The order of equal costs is that of the starts.
    others.sort_by(|one, other| one.0.total_cmp(&other.0));
    for (_, at) in others.into_iter().take(FOLLOWED) {
        let Some(solved) = solve(problem, &at, sigma, loss, SEARCH_STEP) else { continue };
        let is_done = is_good(problem, weights, &solved);
        if best.as_ref().is_none_or(|best| solved.cost < best.cost) {
            best = Some(solved);
        }
        if is_done {
            break;
        }
    }
    best.ok_or_else(|| Failure::Step("the model fails at every start".to_owned()))
}

/// Whether a solution leaves so little that no other is sought.
fn is_good(problem: &Problem<'_>, weights: &Weights, solved: &Solved) -> bool {
    let [of_std, of_data] = GOOD;
    if weights.all_given() {
        return solved.cost <= of_std * of_std * problem.count() as f64;
    }
    let residuals = relative_residuals(problem, &solved.evaluation.values);
    residuals.iter().all(|(_, residual)| *residual <= of_data)
}

/// The solution with the samples of an acceleration joined by lines, if it fits better than with a smooth curve.
fn better_interpolation(problem: &mut Problem<'_>, best: Solved, weights: &Weights, loss: Loss) -> Solved {
    problem.interpolation = Interpolation::Linear;
    let by_lines = solve(problem, &best.at, weights.sigma(), loss, SEARCH_STEP);
    match by_lines {
        Some(solved) if solved.cost < best.cost => solved,
        _ => {
            problem.interpolation = Interpolation::Smooth;
            best
        }
    }
}

/// Weights by the scatter around the solution, where no standard deviations are given, and the solution with them: with an
/// absolute and with a relative scatter, whichever makes the residuals the more likely, then for each column.
fn settled(
    problem: &Problem<'_>,
    first: Weights,
    best: Solved,
    loss: Loss,
    robust: bool,
) -> (Weights, Solved) {
    if first.all_given() {
        return (first, best);
    }
    let measured = problem.measured();
    let again = |weights: &mut Weights, solved: &mut Solved, wanted| {
        let (leverage, _) = leverages(problem, solved, weights.sigma());
        weights.settle(problem, &solved.evaluation, &leverage, robust, wanted);
        if let Some(next) = solve(problem, &solved.at, weights.sigma(), loss, SEARCH_STEP) {
            *solved = next;
        }
    };
    let mut ends = Vec::new();
    for wanted in [Weighting::Absolute, Weighting::Relative] {
        let (mut weights, mut solved) = (first.clone(), best.clone());
        for _ in 0..2 {
            again(&mut weights, &mut solved, Some(wanted));
        }
        let (_, information) = leverages(problem, &solved, weights.sigma());
        let unlikelihood = weights.unlikelihood(&solved.evaluation.values, &measured) + information;
        ends.push((unlikelihood, weights, solved));
        if !problem.has_sweep() {
            break;
        }
    }
    ends.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (_, mut weights, mut solved) = ends.swap_remove(0);
    // Columns whose scatter is clearly of the other kind.
    again(&mut weights, &mut solved, None);
    (weights, solved)
}

/// The part of a degree of freedom that the fit takes from each value, the diagonal of the hat matrix; and half the logarithm
/// of the determinant of the information, by which the residuals of two weightings of the same data are compared
/// (H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545).
fn leverages(problem: &Problem<'_>, solved: &Solved, sigma: &[f64]) -> (Vec<f64>, f64) {
    let columns: Vec<DVector<f64>> = problem
        .jacobian(&solved.at, &solved.evaluation, SEARCH_STEP)
        .into_iter()
        .map(|column| {
            DVector::from_iterator(column.len(), column.iter().zip(sigma).map(|(slope, sigma)| slope / sigma))
        })
        .filter(|column| column.norm() > 0.0)
        .collect();
    let mut information: f64 = columns.iter().map(|column| column.norm().ln()).sum();
    let columns: Vec<DVector<f64>> = columns.into_iter().map(|column| column.normalize()).collect();
    let mut all = vec![0.0; problem.count()];
    if columns.is_empty() {
        return (all, information);
    }
    let decomposed = DMatrix::from_columns(&columns).svd(true, false);
    let Some(left) = decomposed.u else { return (all, information) };
    for (index, value) in decomposed.singular_values.iter().enumerate() {
        // A combination without influence takes nothing.
        if *value > 1e-6 {
            information += value.ln();
            for (leverage, part) in all.iter_mut().zip(left.column(index).iter()) {
                *leverage += part * part;
            }
        }
    }
    (all, information)
}

/// The change of a coordinate for central differences: the cube root of thrice the model's own error, which a run with
/// half the tolerance or step shows.
fn difference(problem: &Problem<'_>, at: &[f64], values: &[f64]) -> Result<f64, Failure> {
    let finer = Options { halvings: problem.options.halvings + 1, ..problem.options };
    let other = problem.evaluate(at, &finer)?.values;
    let size: f64 = values.iter().map(|value| value * value).sum();
    let error: f64 = values.iter().zip(&other).map(|(one, other)| (one - other).powi(2)).sum();
    let [least, largest] = STEPS;
    Ok((3.0 * (error / size.max(f64::MIN_POSITIVE)).sqrt()).cbrt().clamp(least, largest))
}

/// RMS of the residual over RMS of the data, for each name of a measured column.
fn relative_residuals(problem: &Problem<'_>, values: &[f64]) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, [f64; 2])> = Vec::new();
    for (file, data) in problem.data.iter().enumerate() {
        for (index, column) in data.columns.iter().enumerate() {
            let place = match sums.iter().position(|(name, _)| *name == column.name) {
                Some(place) => place,
                None => {
                    sums.push((column.name.clone(), [0.0; 2]));
                    sums.len() - 1
                }
            };
            for (row, measured) in column.values.iter().enumerate() {
                let [residual, size] = &mut sums[place].1;
                *residual += (values[problem.index(file, index, row)] - measured).powi(2);
                *size += measured * measured;
            }
        }
    }
    sums.into_iter()
        .map(|(name, [residual, size])| (name, (residual / size.max(f64::MIN_POSITIVE)).sqrt()))
        .collect()
}

/// The numbers of a solution.
fn described(
    problem: &Problem<'_>,
    request: &Request<'_>,
    weights: &Weights,
    loss: Loss,
    solved: &Solved,
    step: f64,
) -> Found {
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
    let columns: Vec<DVector<f64>> = problem
        .jacobian(&solved.at, &solved.evaluation, step)
        .into_iter()
        .map(|column| {
            DVector::from_iterator(column.len(), column.iter().zip(sigma).map(|(slope, sigma)| slope / sigma))
        })
        .collect();
    let mut uncertainty = Uncertainty::of(&columns, &is_free, variance);
    // A combination without influence may have drifted to a bound, which would hide it.
    let all = Uncertainty::of(&columns, &vec![true; columns.len()], variance);
    if !all.undetermined.is_empty() {
        uncertainty.undetermined = all.undetermined;
    }
    if loss == Loss::Squares && !weights.all_given() {
        uncertainty.widen(&columns, &residuals, variance);
    }
    let mut found = Found::new(problem, solved, &uncertainty, &is_free, freedom);
    found.reduced_chi_squared = reduced.filter(|_| weights.all_given());
    found.relative_residual = relative_residuals(problem, values);
    found.weighting = weights.weightings().to_vec();
    found.warnings = warnings(problem, request, weights, solved, &found);
    found
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
    found: &Found,
) -> Vec<String> {
    let mut all = Vec::new();
    let lacking = solved.evaluation.lacks_orbits(&problem.data);
    if lacking > 0 {
        all.push(format!(
            "at {lacking} rows the model has no stable motion of one period: the numbers of the run stand there, with a \
             standard deviation of at least {} % of the value",
            100.0 * weights::WITHOUT_PERIOD
        ));
    }
    for combination in &found.undetermined {
        all.push(format!(
            "not identifiable: the data do not determine {}; hold one of these keys, or measure what separates them",
            result::product(combination)
        ));
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
    all
}

impl Problem<'_> {
    fn has_sweep(&self) -> bool {
        self.data.iter().any(|data| matches!(data.rows, Rows::Sweep(_)))
    }

    /// Whether a file has a recorded acceleration.
    fn has_samples(&self) -> bool {
        self.data.iter().any(|data| matches!(data.rows, Rows::Trace { acceleration: Some(_), .. }))
    }
}

/// A free number with its result.
#[derive(Debug, Clone)]
pub(crate) struct Parameter {
    pub(crate) key: String,
    pub(crate) value: f64,
    /// `None` at a bound, and of a key that the data do not determine.
    pub(crate) standard_error: Option<f64>,
    pub(crate) interval_95: Option<[f64; 2]>,
    pub(crate) start: f64,
    pub(crate) at_bound: bool,
    /// Whether it is a key of the scene that may be written.
    pub(crate) is_written: bool,
}

impl Parameter {
    /// What a scene file says of it.
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
    fn of(free: &Free, at: f64, error: Option<f64>, quantile: f64) -> Self {
        let value = free.value(at);
        let interval =
            error.map(|error| [at - quantile * error, at + quantile * error].map(|end| free.value(end)));
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
