//! Weighted least squares: Levenberg and Marquardt's method within bounds, from several starts.

use rmpfit::{MPConfig, MPError, MPFitter, MPMaxFev, MPPar, MPResult, MPSide, MPSuccess};

use super::model::{Evaluation, Problem};

/// A residual of a trial that failed, relative to the best norm so far: the trial is refused.
const REFUSED: f64 = 1e3;

/// What is added up of the weighted residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Loss {
    /// Their squares.
    Squares,
    /// Huber's function: linear beyond this many standard deviations.
    Huber(f64),
}

impl Loss {
    /// The residual whose square is the loss, and its derivative.
    pub(crate) fn residual(self, residual: f64) -> [f64; 2] {
        match self {
            Self::Huber(limit) if residual.abs() > limit => {
                let root = (2.0 * limit * residual.abs() - limit * limit).sqrt();
                [root.copysign(residual), limit / root]
            }
            _ => [residual, 1.0],
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Solved {
    pub(crate) at: Vec<f64>,
    pub(crate) evaluation: Evaluation,
    /// Sum of the losses.
    pub(crate) cost: f64,
    pub(crate) converged: bool,
}

struct Fitter<'p, 'a> {
    problem: &'p Problem<'a>,
    measured: &'p [f64],
    sigma: &'p [f64],
    loss: Loss,
    step: f64,
    bounds: Vec<MPPar>,
    config: MPConfig,
    last: Option<(Vec<f64>, Evaluation)>,
    best: Option<Solved>,
}

/// The sum of the losses of some values.
pub(crate) fn cost(values: &[f64], measured: &[f64], sigma: &[f64], loss: Loss) -> f64 {
    let all = values.iter().zip(measured).zip(sigma);
    all.map(|((value, measured), sigma)| loss.residual((value - measured) / sigma)[0].powi(2)).sum()
}

impl Fitter<'_, '_> {
    fn evaluation(&mut self, at: &[f64]) -> Option<&Evaluation> {
        let is_last = self.last.as_ref().is_some_and(|(last, _)| last == at);
        if !is_last {
            let found = self.problem.evaluate(at, &self.problem.options).ok()?;
            self.last = Some((at.to_vec(), found));
        }
        self.last.as_ref().map(|(_, evaluation)| evaluation)
    }
}

impl MPFitter for Fitter<'_, '_> {
    fn eval(&mut self, at: &[f64], deviates: &mut [f64]) -> MPResult<()> {
        let (measured, sigma, loss) = (self.measured, self.sigma, self.loss);
        let Some(evaluation) = self.evaluation(at) else {
            let Some(best) = &self.best else { return Err(MPError::Eval) };
            deviates.fill(REFUSED * (1.0 + best.cost.sqrt()));
            return Ok(());
        };
        let evaluation = evaluation.clone();
        for (index, deviate) in deviates.iter_mut().enumerate() {
            *deviate = loss.residual((evaluation.values[index] - measured[index]) / sigma[index])[0];
        }
        let cost = deviates.iter().map(|deviate| deviate * deviate).sum();
        if self.best.as_ref().is_none_or(|best| cost < best.cost) {
            self.best = Some(Solved { at: at.to_vec(), evaluation, cost, converged: false });
        }
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.measured.len()
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.bounds
    }

    fn jacobian(
        &mut self,
        at: &[f64],
        deviates: &mut [f64],
        derivatives: &mut [Option<Vec<f64>>],
    ) -> MPResult<()> {
        self.eval(at, deviates)?;
        let (problem, step, loss) = (self.problem, self.step, self.loss);
        let base = self.evaluation(at).ok_or(MPError::Eval)?.clone();
        let columns = problem.jacobian(at, &base, step);
        for (derivative, column) in derivatives.iter_mut().zip(columns) {
            let Some(derivative) = derivative else { continue };
            for (index, entry) in derivative.iter_mut().enumerate() {
                let residual = (base.values[index] - self.measured[index]) / self.sigma[index];
                *entry = loss.residual(residual)[1] * column[index] / self.sigma[index];
            }
        }
        Ok(())
    }
}

/// The least sum of losses near a start; `None` if the model fails there.
pub(crate) fn solve(
    problem: &Problem<'_>,
    start: &[f64],
    sigma: &[f64],
    loss: Loss,
    step: f64,
) -> Option<Solved> {
    let measured = problem.measured();
    let bounds = problem.free.iter().map(|free| {
        let [limit_low, limit_up] = free.ends();
        MPPar { limited_low: true, limited_up: true, limit_low, limit_up, side: MPSide::User, ..MPPar::new() }
    });
    let config = MPConfig {
        ftol: 1e-10,
        xtol: 1e-8,
        gtol: 1e-10,
        max_iter: problem.iterations,
        max_fev: MPMaxFev::Limited(4 * problem.iterations * (1 + problem.free.len())),
        // A coordinate is a logarithm, or relative: its first step is a part of its unit.
        step_factor: 1.0,
        ..MPConfig::new()
    };
    let mut fitter = Fitter {
        problem,
        measured: &measured,
        sigma,
        loss,
        step,
        bounds: bounds.collect(),
        config,
        last: None,
        best: None,
    };
    let mut at: Vec<f64> = start.to_vec();
    for (coordinate, free) in at.iter_mut().zip(&problem.free) {
        let [low, high] = free.ends();
        *coordinate = coordinate.clamp(low, high);
    }
    let ended = fitter.mpfit(&mut at);
    let converged = match ended {
        Ok(status) => !matches!(status.success, MPSuccess::MaxIter | MPSuccess::NotDone),
        Err(_) => false,
    };
    fitter.best.map(|best| Solved { converged, ..best })
}
