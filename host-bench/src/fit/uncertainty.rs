//! Standard errors, correlations, the combinations of keys that the data do not determine, and what the model does not follow.

use nalgebra::{DMatrix, DVector};

use super::model::Problem;
use super::solve::Solved;

/// Singular value of the Jacobian, its columns scaled to one, relative to the largest, below which a combination has no
/// influence on the data beyond the differences' own error. It is that of two keys with a correlation of `1 − 10⁻⁶`.
const NO_INFLUENCE: f64 = 1e-3;
/// Standard deviation of a combination, in coordinates (logarithms), above which the data do not determine it …
const WIDE: f64 = 0.5;
/// … if its singular value is also below this.
const WEAK: f64 = 0.1;
/// Part of the largest entry of a combination from which on a key is named.
const NAMED: f64 = 0.1;

#[derive(Debug, Clone)]
pub(crate) struct Uncertainty {
    /// Covariance of the coordinates; a row and a column of 0 for a coordinate at its bound.
    pub(crate) covariance: DMatrix<f64>,
    /// The combinations that the data do not determine: for each coordinate its part, the largest 1.
    pub(crate) undetermined: Vec<Vec<f64>>,
}

impl Uncertainty {
    /// Of weighted `columns`, one for each coordinate, with `variance` for each weighted value. Others than the `free` ones are held.
    pub(crate) fn of(columns: &[DVector<f64>], free: &[bool], variance: f64) -> Self {
        let count = columns.len();
        let mut covariance = DMatrix::zeros(count, count);
        let is_free = |index: &usize| free[*index];
        let indices: Vec<usize> = (0..count).filter(is_free).collect();
        let lengths: Vec<f64> = columns.iter().map(|column| column.norm()).collect();
        let largest = indices.iter().fold(0.0_f64, |largest, &index| largest.max(lengths[index]));
        let mut undetermined = Vec::new();
        // A column that is 0 is a combination by itself.
        let (used, unused): (Vec<usize>, Vec<usize>) =
            indices.iter().partition(|&&index| lengths[index] > 1e-12 * largest && lengths[index] > 0.0);
        for index in unused {
            let mut alone = vec![0.0; count];
            alone[index] = 1.0;
            undetermined.push(alone);
        }
        if used.is_empty() {
            return Self { covariance, undetermined };
        }
        let scaled: Vec<DVector<f64>> = used.iter().map(|&index| &columns[index] / lengths[index]).collect();
        let decomposed = DMatrix::from_columns(&scaled).svd(false, true);
        let Some(rows) = decomposed.v_t else { return Self { covariance, undetermined } };
        let most = decomposed.singular_values.max();
        for (row, &value) in decomposed.singular_values.iter().enumerate() {
            let direction: Vec<f64> =
                used.iter().enumerate().map(|(at, &index)| rows[(row, at)] / lengths[index]).collect();
            let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
            let deviation = variance.sqrt() * length / value.max(f64::MIN_POSITIVE);
            let relative = value / most;
            if relative < NO_INFLUENCE || deviation > WIDE && relative < WEAK {
                undetermined.push(combination(count, &used, &direction));
            }
            for (one, &i) in used.iter().enumerate() {
                for (other, &j) in used.iter().enumerate() {
                    covariance[(i, j)] += variance * direction[one] * direction[other] / (value * value);
                }
            }
        }
        // One column alone is no pair: it is undetermined if it says nothing.
        if let (&[index], [_]) = (&used[..], decomposed.singular_values.as_slice())
            && variance.sqrt() / lengths[index] > WIDE
        {
            undetermined.push(combination(count, &used, &[1.0]));
        }
        Self { covariance, undetermined }
    }

    /// Widens the covariance to that by the squares of the residuals themselves, where that is larger: it holds whatever the
    /// standard deviation of each value is (HC3 of J. G. MacKinnon and H. White, J. Econometrics 29 (1985) 305).
    pub(crate) fn widen(&mut self, columns: &[DVector<f64>], residuals: &[f64], variance: f64) {
        /// Least part of a degree of freedom that a value has left.
        const LEFT: f64 = 0.1;
        let count = columns.len();
        let inverse = &self.covariance / variance;
        let mut found = DVector::<f64>::zeros(count);
        for (row, residual) in residuals.iter().enumerate() {
            let slopes = DVector::from_iterator(count, columns.iter().map(|column| column[row]));
            let influence = &inverse * &slopes;
            let left = (1.0 - slopes.dot(&influence)).max(LEFT);
            found += influence.map(|part| (part * residual / left).powi(2));
        }
        for index in 0..count {
            let ratio = (found[index] / self.covariance[(index, index)]).sqrt();
            // Not-a-number of a held coordinate widens nothing.
            if ratio > 1.0 && ratio.is_finite() {
                self.covariance.row_mut(index).scale_mut(ratio);
                self.covariance.column_mut(index).scale_mut(ratio);
            }
        }
    }

    pub(crate) fn standard_error(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0).sqrt()
    }

    /// Correlation of two coordinates; `None` where one is held.
    pub(crate) fn correlation(&self, one: usize, other: usize) -> Option<f64> {
        let size = self.standard_error(one) * self.standard_error(other);
        (size > 0.0).then(|| (self.covariance[(one, other)] / size).clamp(-1.0, 1.0))
    }
}

/// A direction over all coordinates, with its largest part 1 and small parts 0.
fn combination(count: usize, used: &[usize], direction: &[f64]) -> Vec<f64> {
    let largest = direction
        .iter()
        .fold(0.0_f64, |largest, part| if part.abs() > largest.abs() { *part } else { largest });
    let mut all = vec![0.0; count];
    for (&index, part) in used.iter().zip(direction) {
        let part = part / largest;
        all[index] = if part.abs() < NAMED { 0.0 } else { part };
    }
    all
}

// Whether residuals are systematic: runs of one sign (A. Wald and J. Wolfowitz, *On a test whether two samples are from the
// same population*, Annals of Mathematical Statistics 11 (1940) 147), here of several sequences together.

/// Least number of residuals that are judged.
const LEAST: f64 = 8.0;
/// Standard deviations by which the runs must be fewer than those of chance: one in 700.
const DEVIATIONS: f64 = 3.0;

/// Runs of one sign in one or several sequences of residuals.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Runs {
    /// Residuals above and below zero.
    above: f64,
    below: f64,
    /// Neighbours in a sequence, and pairs of such neighbours that have a residual in common.
    neighbours: f64,
    overlaps: f64,
    sequences: usize,
    pub(super) count: usize,
}

impl Runs {
    /// Adds a sequence of residuals in their order.
    pub(super) fn add(&mut self, residuals: impl IntoIterator<Item = f64>) {
        let signs: Vec<bool> = residuals
            .into_iter()
            .filter(|residual| *residual != 0.0)
            .map(|residual| residual > 0.0)
            .collect();
        if signs.is_empty() {
            return;
        }
        let above = signs.iter().filter(|sign| **sign).count();
        self.above += above as f64;
        self.below += (signs.len() - above) as f64;
        self.neighbours += (signs.len() - 1) as f64;
        self.overlaps += signs.len().saturating_sub(2) as f64;
        self.sequences += 1;
        self.count += 1 + signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    }

    /// Mean of the number of runs, and its variance, where all orders of the signs over all sequences are equally likely, so
    /// that a sequence of one sign beside one of the other is unlikely. With `n₊` and `n₋` signs of each kind, neighbours
    /// differ with the probability `p = 2 n₊ n₋/(n (n − 1))`, two pairs of them with a residual in common with `p/2`, and two
    /// without with `4 n₊ (n₊ − 1) n₋ (n₋ − 1)/(n (n − 1) (n − 2) (n − 3))`.
    pub(super) fn expected(&self) -> [f64; 2] {
        let Self { above, below, neighbours, overlaps, .. } = *self;
        let all = above + below;
        if all < 4.0 {
            return [self.count as f64, 0.0];
        }
        let one = 2.0 * above * below / (all * (all - 1.0));
        let apart = 2.0 * one * (above - 1.0) * (below - 1.0) / ((all - 2.0) * (all - 3.0));
        let mean = neighbours * one;
        let pairs = neighbours * (neighbours - 1.0) / 2.0;
        let square = mean + overlaps * one + 2.0 * (pairs - overlaps) * apart;
        [self.sequences as f64 + mean, (square - mean * mean).max(0.0)]
    }

    /// Whether the runs are so few that the residuals hang together.
    pub(super) fn are_systematic(&self) -> bool {
        let [expected, variance] = self.expected();
        self.above + self.below >= LEAST && (self.count as f64) < expected - DEVIATIONS * variance.sqrt()
    }
}

/// Relative residual above which the model does not follow a column: 9 % of its mean square are then left. Noise of a usable
/// measurement leaves less, and so does the wrong branch of a bistable band (0.18 in the test of such sweeps).
const UNFOLLOWED: f64 = 0.3;
/// Most by which a ratio is off a power of a thousand that a prefix of a unit would be.
const NEAR: f64 = 2.0;

/// A measured column that the model does not follow.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unfollowed {
    column: String,
    residual: f64,
    /// Medians of the magnitudes of data over model: at the solution, and at the start. `None` where the model is 0.
    ratios: [Option<f64>; 2],
}

impl Unfollowed {
    /// The columns of a solution with these relative residuals that it does not follow.
    pub(super) fn of(problem: &Problem<'_>, solved: &Solved, residuals: &[(String, f64)]) -> Vec<Self> {
        let large: Vec<&(String, f64)> =
            residuals.iter().filter(|(_, residual)| !(*residual <= UNFOLLOWED)).collect();
        if large.is_empty() {
            return Vec::new();
        }
        let start: Vec<f64> = problem.free.iter().map(|free| free.coordinate(free.start)).collect();
        let at_start = problem.evaluate(&start, &problem.options).ok();
        let of_column = |(column, residual): &(String, f64)| {
            let ratio = |values: &[f64]| median(ratios(problem, values, column));
            let at_start = at_start.as_ref().and_then(|found| ratio(&found.values));
            let ratios = [ratio(&solved.evaluation.values), at_start];
            Self { column: column.clone(), residual: *residual, ratios }
        };
        large.into_iter().map(of_column).collect()
    }

    pub(super) fn text(&self) -> String {
        let shown =
            |ratio: Option<f64>| ratio.map_or_else(|| "unknown".to_owned(), |ratio| format!("{ratio:.3e}"));
        let [solution, start] = self.ratios.map(shown);
        let mut ratios = self.ratios.iter().flatten();
        let is_of_a_unit = ratios.any(|ratio| is_near_a_power_of_a_thousand(*ratio));
        let unit = if is_of_a_unit { "; check its unit" } else { "" };
        format!(
            "the model does not follow {}: its relative residual is {:.3}; the median ratio of data to model is {solution}, at \
             the start {start}{unit}",
            self.column, self.residual
        )
    }
}

/// What the comments of a fitted scene add where the model does not follow these columns.
pub(super) fn remark(unfollowed: &[Unfollowed]) -> String {
    let names: Vec<&str> = unfollowed.iter().map(|one| one.column.as_str()).collect();
    if names.is_empty() { String::new() } else { format!(", the model does not follow {}", names.join(", ")) }
}

/// Magnitudes of data over model in a column.
fn ratios(problem: &Problem<'_>, values: &[f64], name: &str) -> Vec<f64> {
    let mut all = Vec::new();
    for (file, data) in problem.data.iter().enumerate() {
        let columns = data.columns.iter().enumerate().filter(|(_, column)| column.name == name);
        for (index, column) in columns {
            let rows = column.values.iter().enumerate();
            all.extend(
                rows.map(|(row, measured)| (measured / values[problem.index(file, index, row)]).abs()),
            );
        }
    }
    all
}

/// The median of those that are finite.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.retain(|number| number.is_finite());
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// Whether a ratio is within [`NEAR`] of a thousand, a thousandth, a million and so on.
fn is_near_a_power_of_a_thousand(ratio: f64) -> bool {
    let power = (ratio.log10() / 3.0).round();
    let off = ratio / 1000f64.powf(power);
    power != 0.0 && (1.0 / NEAR..=NEAR).contains(&off)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The straight line `y = a + b x` at 0, 1, 2, 3 has the covariance of the textbooks.
    #[test]
    fn the_covariance_of_a_line_is_that_of_the_textbooks() {
        let ones = DVector::from_element(4, 1.0);
        let x = DVector::from_vec(vec![0.0, 1.0, 2.0, 3.0]);
        let found = Uncertainty::of(&[ones, x], &[true, true], 0.04);
        assert!(found.undetermined.is_empty());
        // Var b = s² / Σ(x − mean)² = 0.04 / 5, Var a = s² Σx² / (n Σ(x − mean)²) = 0.04 · 14 / 20.
        assert!((found.standard_error(1) - (0.04_f64 / 5.0).sqrt()).abs() < 1e-12);
        assert!((found.standard_error(0) - (0.04_f64 * 14.0 / 20.0).sqrt()).abs() < 1e-12);
        let correlation = found.correlation(0, 1).expect("both are free");
        assert!((correlation + 1.5 / 3.5_f64.sqrt()).abs() < 1e-12);
    }

    /// By hand: the mean of four values, whose HC3 variance is `Σ e² / (1 − 1/n)² / n²`.
    #[test]
    fn unequal_scatter_widens_the_standard_error() {
        let ones = [DVector::from_element(4, 1.0)];
        let residuals = [3.0, -3.0, 0.1, -0.1];
        let mut found = Uncertainty::of(&ones, &[true], 1.0);
        found.widen(&ones, &residuals, 1.0);
        let expected = (18.02_f64 / 0.75_f64.powi(2)).sqrt() / 4.0;
        assert!((found.standard_error(0) - expected).abs() < 1e-12);
        let mut same = Uncertainty::of(&ones, &[true], 1.0);
        same.widen(&ones, &[0.1; 4], 1.0);
        assert!((same.standard_error(0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn two_columns_that_are_parallel_are_named_with_their_exponents() {
        let column = DVector::from_vec(vec![1.0, 2.0, -1.0, 0.5]);
        let other = DVector::from_vec(vec![0.0, 1.0, 1.0, 1.0]);
        let found = Uncertainty::of(&[column.clone(), other.clone(), &column * -2.0], &[true; 3], 1e-8);
        assert_eq!(found.undetermined.len(), 1);
        let parts = &found.undetermined[0];
        // A change of the first by 2 and of the third by 1 leaves the data as they are.
        assert!((parts[0] - 1.0).abs() < 1e-9 && parts[1] == 0.0 && (parts[2] - 0.5).abs() < 1e-9);
        // A held column is no part of it.
        let found = Uncertainty::of(&[column, other.clone(), other * 0.0], &[true, true, false], 1e-8);
        assert!(found.undetermined.is_empty());
        assert_eq!(found.standard_error(2), 0.0);
    }

    fn runs(residuals: impl IntoIterator<Item = f64>) -> Runs {
        let mut runs = Runs::default();
        runs.add(residuals);
        runs
    }

    #[test]
    fn a_slow_wave_is_systematic_and_alternating_or_random_signs_are_not() {
        let wave = runs((0..40).map(|index| (f64::from(index) * std::f64::consts::TAU / 20.0 + 0.1).sin()));
        assert_eq!(wave.count, 4);
        assert!((wave.expected()[0] - 21.0).abs() < 0.2 && wave.are_systematic(), "{wave:?}");
        let alternating = runs((0..40).map(|index| if index % 2 == 0 { 1.0 } else { -1.0 }));
        assert!(alternating.count == 40 && !alternating.are_systematic());
        // The parity of the binary digits: the sequence of Thue and Morse.
        let mixed = runs((0..64_u32).map(|index| f64::from(index.count_ones() % 2) - 0.5));
        assert!(!mixed.are_systematic(), "{mixed:?}");
    }

    /// All orders of five positive and four negative residuals, in one sequence and in three.
    #[test]
    fn mean_and_variance_are_those_of_all_orders() {
        for lengths in [&[9][..], &[5, 3, 1], &[7, 2]] {
            let (mut sum, mut squares, mut orders) = (0.0, 0.0, 0.0);
            let mut stated = Runs::default();
            for order in (0..1_u32 << 9).filter(|order| order.count_ones() == 5) {
                let mut residuals = (0..9).map(|bit| if order >> bit & 1 == 1 { 1.0 } else { -1.0 });
                stated = Runs::default();
                for &length in lengths {
                    stated.add(residuals.by_ref().take(length));
                }
                sum += stated.count as f64;
                squares += (stated.count as f64).powi(2);
                orders += 1.0;
            }
            let (mean, [expected, variance]) = (sum / orders, stated.expected());
            assert!((expected - mean).abs() < 1e-12, "{lengths:?}: {mean}");
            assert!((variance - (squares / orders - mean * mean)).abs() < 1e-12, "{lengths:?}");
        }
    }

    #[test]
    fn a_sequence_of_each_sign_is_systematic() {
        let mut apart = Runs::default();
        for sign in [1.0, -1.0] {
            apart.add([sign; 10]);
        }
        assert!(apart.count == 2 && apart.are_systematic(), "{apart:?}");
    }

    #[test]
    fn few_residuals_are_not_judged() {
        assert!(!runs([1.0, 1.0, 1.0, -1.0, -1.0, -1.0]).are_systematic());
        assert!(!runs([1.0; 12]).are_systematic(), "one sign alone has one run in every order");
    }

    #[test]
    fn a_ratio_of_a_prefix_is_recognised() {
        for (ratio, expected) in [
            (1000.0, true),
            (1900.0, true),
            (510.0, true),
            (1.2e-3, true),
            (0.8e6, true),
            (1.0, false),
            (0.6, false),
            (30.0, false),
            (4000.0, false),
            (0.0, false),
            (f64::NAN, false),
        ] {
            assert_eq!(is_near_a_power_of_a_thousand(ratio), expected, "{ratio}");
        }
    }

    #[test]
    fn the_median_leaves_out_what_the_model_has_no_value_for() {
        assert_eq!(median(vec![f64::INFINITY, 3.0, 1.0, 2.0, f64::NAN]), Some(2.0));
        assert_eq!(median(vec![f64::INFINITY]), None);
    }
}
