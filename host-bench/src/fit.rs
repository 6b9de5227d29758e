//! Parameters of a scene from measurements: weighted nonlinear least squares with the model of the scene.

pub(crate) mod data;
mod described;
mod fitted;
pub(crate) mod free;
mod lines;
mod model;
mod picture;
mod result;
mod solve;
mod starts;
mod uncertainty;
mod weights;

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};

use self::data::{Data, Rows};
use self::described::{described, weighted};
pub(crate) use self::fitted::{Entry, fitted_scene};
use self::free::Asked;
use self::model::{Interpolation, Problem};
pub(crate) use self::picture::picture;
pub(crate) use self::result::{FitResult, text};
use self::solve::{Loss, Solved, cost, solve};
use self::weights::{Weighting, Weights};
use crate::accuracy::{Statements, run_as_it_is};
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

pub(crate) struct Request<'a> {
    pub(crate) file: &'a Path,
    pub(crate) overrides: &'a [Override],
    pub(crate) options: Options,
    pub(crate) data: Vec<PathBuf>,
    /// The rate in Hz of the even times at which traces are taken; `None` of traces with even ones.
    pub(crate) resample_hz: Option<f64>,
    pub(crate) free: Vec<Asked>,
    /// Whether large residuals count linearly.
    pub(crate) huber: bool,
    /// Most further starts that are looked at.
    pub(crate) starts: usize,
    /// Iterations after which a search is given up.
    pub(crate) iterations: usize,
    /// Whether the result will be drawn: the model is run between the rows of sweeps too.
    pub(crate) is_drawn: bool,
}

/// Huber's limit in standard deviations: 95 % of the efficiency of least squares on Gaussian data.
const HUBER: f64 = 1.345;

/// Fits; calls `done` after each evaluation of the model for all data.
pub(crate) fn fit(
    request: &Request<'_>,
    scene: &Scene,
    done: &(dyn Fn() + Sync),
) -> Result<FitResult, Failure> {
    check(request, scene)?;
    let data: Vec<Data> = request
        .data
        .iter()
        .map(|file| data::read(file, scene, request.resample_hz))
        .collect::<Result<_, _>>()?;
    if let Some(rate) = request.resample_hz
        && !data.iter().any(|data| matches!(data.rows, data::Rows::Trace { .. }))
    {
        return Err(Failure::Input(format!("--resample {rate}: must not be without a trace in --data")));
    }
    let mut free = Vec::new();
    for asked in &request.free {
        free.push(free::of_key(request.file, request.overrides, asked)?);
    }
    let [coarse, fine] = [0, 1].map(|stage| options(request, scene, stage));
    starts::free_starts(scene, &data, &coarse, &mut free)?;
    let mut problem = Problem::new(request.file, request.overrides, coarse, data, free, done);
    problem.iterations = request.iterations;
    if problem.count() < problem.free.len() {
        return Err(Failure::Input(format!(
            "--data: {} measured values are fewer than the {} free keys",
            problem.count(),
            problem.free.len()
        )));
    }
    let loss = if request.huber { Loss::Huber(HUBER) } else { Loss::Squares };
    let start: Vec<f64> = problem.free.iter().map(|free| free.coordinate(free.start)).collect();
    // Bad input is refused at once; a start that fails on its way may have better ones beside it.
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
    let mut found = described(&problem, request, &weights, loss, &solved, step);
    let whole = Options { bare: false, ..problem.options };
    found.statements = Statements::of(&run_as_it_is(&problem.scene(&solved.at)?, &whole).ok());
    if request.is_drawn {
        draw_lines(&problem, &solved.at, &coarse, &mut found)?;
    }
    Ok(found)
}

/// Adds the model between the rows of sweeps to the curves.
fn draw_lines(
    problem: &Problem<'_>,
    at: &[f64],
    options: &Options,
    found: &mut FitResult,
) -> Result<(), Failure> {
    let mut curves = found.curves.iter_mut();
    for (file, data) in problem.data.iter().enumerate() {
        let groups = lines::lines(problem, at, options, file)?;
        for (column, curve) in curves.by_ref().take(data.columns.len()).enumerate() {
            curve.lines = groups.iter().map(|columns| columns[column].clone()).collect();
        }
    }
    Ok(())
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
        if !problem.data.iter().any(|data| matches!(data.rows, Rows::Sweep(_))) {
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
    let mut columns = weighted(problem, solved, sigma, SEARCH_STEP);
    columns.retain(|column| column.norm() > 0.0);
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

impl Problem<'_> {
    /// Whether a file has a recorded acceleration.
    fn has_samples(&self) -> bool {
        self.data.iter().any(|data| matches!(data.rows, Rows::Trace { acceleration: Some(_), .. }))
    }
}
