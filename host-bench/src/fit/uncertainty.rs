//! Standard errors, correlations, and the combinations of keys that the data do not determine.

use nalgebra::{DMatrix, DVector};

/// Singular value of the Jacobian, its columns scaled to one, relative to the largest, below which a combination has no
/// influence on the data beyond the differences' own error. It is that of two keys with a correlation of `1 − 10⁻⁶`.
const NO_INFLUENCE: f64 = 1e-3;
/// Standard deviation of a combination, in coordinates (logarithms), above which the data do not determine it …
const WIDE: f64 = 0.5;
/// … if its singular value is also below this.
const WEAK: f64 = 0.1;
/// Part of the largest entry of a combination from which on a key is named.
const NAMED: f64 = 0.1;

/// What the Jacobian at the solution says.
#[derive(Debug, Clone)]
pub(crate) struct Uncertainty {
    /// Covariance of the coordinates; a row and a column of 0 for a coordinate at its bound.
    pub(crate) covariance: DMatrix<f64>,
    /// The combinations that the data do not determine: for each coordinate its part, the largest 1.
    pub(crate) undetermined: Vec<Vec<f64>>,
}

impl Uncertainty {
    /// Of weighted `columns`, one for each coordinate, with `variance` for each weighted value. A coordinate that is not `free`
    /// is held.
    pub(crate) fn of(columns: &[DVector<f64>], free: &[bool], variance: f64) -> Self {
        let count = columns.len();
        let mut covariance = DMatrix::zeros(count, count);
        let held = |index: &usize| free[*index];
        let indices: Vec<usize> = (0..count).filter(held).collect();
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

    /// Standard error of a coordinate.
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
}
