//! Standard deviations of the measured values: given, or from the scatter of the residuals.

use super::data::Rows;
use super::model::{Evaluation, Problem};

/// Least standard deviation of a row whose motion has no period, as a part of the value: the scatter of a chaotic mean.
pub(super) const WITHOUT_PERIOD: f64 = 0.03;
/// Difference of the logarithms of the likelihoods from which on the scatter counts as relative.
const CLEARLY: f64 = 4.0;
/// Least value, as a part of the RMS of its column, whose scatter is relative to it.
const LEAST_VALUE: f64 = 1e-2;
/// Scatter, as a part of the RMS of its column, up to which it may be the model's own error.
const OWN_ERROR: f64 = 1e-4;
/// Least standard deviation, as a part of the RMS of its column: data without scatter.
const LEAST_SCATTER: f64 = 1e-9;
/// Standard deviation of a Gaussian over its median magnitude.
const OF_MEDIAN: f64 = 1.4826;
/// Standard deviation that Huber's loss begins with, as a part of the RMS of a column.
const FIRST_ROBUST: f64 = 0.03;

/// Where the standard deviations of a column come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Weighting {
    /// A column `_std`.
    Given,
    /// One for the whole column.
    Absolute,
    /// In proportion to the value.
    Relative,
}

/// The standard deviation of each measured value.
#[derive(Debug, Clone)]
pub(crate) struct Weights {
    sigma: Vec<f64>,
    columns: Vec<(String, Weighting)>,
}

impl Weights {
    /// Those that are given; of any other column its RMS, so that all columns count alike.
    pub(super) fn new(problem: &Problem<'_>, robust: bool) -> Self {
        let (mut sigma, mut columns) = (Vec::new(), Vec::new());
        for column in problem.data.iter().flat_map(|data| &data.columns) {
            let size = rms(column.values.iter().copied()).max(f64::MIN_POSITIVE);
            let first = if robust { FIRST_ROBUST * size } else { size };
            match &column.std {
                Some(std) => sigma.extend(std),
                None => sigma.extend(std::iter::repeat_n(first, column.values.len())),
            }
            let weighting = if column.std.is_some() { Weighting::Given } else { Weighting::Absolute };
            columns.push((column.name.clone(), weighting));
        }
        Self { sigma, columns }
    }

    pub(super) fn sigma(&self) -> &[f64] {
        &self.sigma
    }

    /// The name and the weighting of each column.
    pub(super) fn weightings(&self) -> &[(String, Weighting)] {
        &self.columns
    }

    pub(super) fn all_given(&self) -> bool {
        self.columns.iter().all(|(_, weighting)| *weighting == Weighting::Given)
    }

    /// Sets what is not given by the scatter around a solution, each value of which takes its `leverage` of a degree of
    /// freedom. The scatter is of the `wanted` kind, or of the one that makes the residuals of a sweep the more likely; a
    /// column of a trace has values near 0, and an absolute scatter.
    pub(super) fn settle(
        &mut self,
        problem: &Problem<'_>,
        around: &Evaluation,
        leverage: &[f64],
        robust: bool,
        wanted: Option<Weighting>,
    ) {
        let mut number = 0;
        for (file, data) in problem.data.iter().enumerate() {
            for (index, column) in data.columns.iter().enumerate() {
                let count = column.values.len();
                let from = problem.index(file, index, 0);
                let values = &around.values[from..from + count];
                let sigma = &mut self.sigma[from..from + count];
                let weighting = &mut self.columns[number].1;
                number += 1;
                if *weighting == Weighting::Given {
                    continue;
                }
                let residuals: Vec<f64> =
                    values.iter().zip(&column.values).map(|(value, measured)| value - measured).collect();
                let size = rms(column.values.iter().copied()).max(f64::MIN_POSITIVE);
                let least: Vec<f64> =
                    values.iter().map(|value| value.abs().max(LEAST_VALUE * size)).collect();
                let relative: Vec<f64> =
                    residuals.iter().zip(&least).map(|(residual, value)| residual / value).collect();
                let taken: f64 = leverage[from..from + count].iter().sum();
                let freedom = (count as f64 - taken).max(0.5);
                let scatter = |residuals: &[f64]| {
                    let squares = || residuals.iter().map(|residual| residual * residual).sum::<f64>();
                    if robust { of_median(residuals) } else { (squares() / freedom).sqrt() }
                };
                let (absolute, of_value) = (scatter(&residuals), scatter(&relative));
                let logarithms: f64 = least.iter().map(|value| value.ln()).sum();
                let gain = count as f64 * (absolute.ln() - of_value.ln()) - logarithms;
                // A column changes its kind only for a clear gain.
                let likelier =
                    if *weighting == Weighting::Relative { gain > -CLEARLY } else { gain > CLEARLY };
                let has_scatter = absolute > OWN_ERROR * size;
                let is_likelier = wanted.map_or(likelier, |wanted| wanted == Weighting::Relative);
                let is_relative = matches!(data.rows, Rows::Sweep(_)) && has_scatter && is_likelier;
                *weighting = if is_relative { Weighting::Relative } else { Weighting::Absolute };
                for (sigma, value) in sigma.iter_mut().zip(&least) {
                    *sigma = if is_relative { of_value * value } else { absolute.max(LEAST_SCATTER * size) };
                }
            }
        }
    }

    /// The negative logarithm of the likelihood of residuals of a Gaussian scatter with these standard deviations.
    pub(super) fn unlikelihood(&self, values: &[f64], measured: &[f64]) -> f64 {
        let all = values.iter().zip(measured).zip(&self.sigma);
        all.map(|((value, measured), sigma)| sigma.ln() + 0.5 * ((value - measured) / sigma).powi(2)).sum()
    }

    /// Widens those of the rows whose motion has no period.
    pub(super) fn widen(&mut self, problem: &Problem<'_>, around: &Evaluation) {
        for (file, data) in problem.data.iter().enumerate() {
            for (index, column) in data.columns.iter().enumerate() {
                for row in 0..column.values.len() {
                    if matches!(data.rows, Rows::Sweep(_)) && !around.has_orbit(file, row) {
                        let sigma = &mut self.sigma[problem.index(file, index, row)];
                        *sigma = sigma.hypot(WITHOUT_PERIOD * column.values[row]);
                    }
                }
            }
        }
    }
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

/// The scatter by the median magnitude, on which outliers have no effect.
fn of_median(residuals: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals.iter().map(|residual| residual.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    OF_MEDIAN * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
}
