//! Solving small dense linear systems, for systems without structure of their own to use.

use crate::scalar::Scalar;

/// An `N × N` matrix factored into triangles, with rows exchanged where the pivot asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factored<S, const N: usize> {
    /// Unit lower triangle below the diagonal, upper triangle above, reciprocal pivots on it.
    triangles: [[S; N]; N],
    order: [usize; N],
}

impl<S: Scalar, const N: usize> Factored<S, N> {
    /// Factors `I − weight · jacobian`; `None` if that is singular or not finite.
    #[must_use]
    #[inline]
    pub fn iteration_matrix(jacobian: &[[S; N]; N], weight: S) -> Option<Self> {
        Self::new(core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                if i == j { S::ONE - weight * jacobian[i][j] } else { -weight * jacobian[i][j] }
            })
        }))
    }

    /// Factors `matrix` by Gaussian elimination with partial pivoting.
    #[must_use]
    #[inline]
    pub fn new(mut matrix: [[S; N]; N]) -> Option<Self> {
        let mut order = core::array::from_fn(|i| i);
        for k in 0..N {
            let mut pivot = k;
            for i in k + 1..N {
                if matrix[i][k].abs() > matrix[pivot][k].abs() {
                    pivot = i;
                }
            }
            matrix.swap(k, pivot);
            order.swap(k, pivot);
            let reciprocal = S::ONE / matrix[k][k];
            // An infinite pivot would pass as a reciprocal of zero.
            if !reciprocal.is_finite() || !matrix[k][k].is_finite() {
                return None;
            }
            matrix[k][k] = reciprocal;
            for i in k + 1..N {
                let factor = matrix[i][k] * reciprocal;
                matrix[i][k] = factor;
                let pivot_row = matrix[k];
                for (entry, &above) in matrix[i].iter_mut().zip(&pivot_row).skip(k + 1) {
                    *entry -= factor * above;
                }
            }
        }
        Some(Self { triangles: matrix, order })
    }

    /// Solves for the right-hand side `right`.
    #[must_use]
    #[inline]
    pub fn solve(&self, right: &[S; N]) -> [S; N] {
        let mut x: [S; N] = core::array::from_fn(|i| right.get(self.order[i]).copied().unwrap_or(S::ZERO));
        for i in 1..N {
            for j in 0..i {
                x[i] -= self.triangles[i][j] * x[j];
            }
        }
        for i in (0..N).rev() {
            for j in i + 1..N {
                x[i] -= self.triangles[i][j] * x[j];
            }
            x[i] *= self.triangles[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_needs_a_row_exchange_and_refuses_the_singular() {
        let matrix = [[0.0_f64, 2.0, 1.0], [1.0, -1.0, 3.0], [4.0, 0.5, -2.0]];
        let x = [1.5, -2.0, 0.25];
        let right = core::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * x[j]).sum());
        let solved = Factored::new(matrix).expect("regular").solve(&right);
        for i in 0..3 {
            assert!((solved[i] - x[i]).abs() < 1e-14);
        }
        assert_eq!(Factored::new([[1.0_f64, 2.0], [2.0, 4.0]]), None);
        assert_eq!(Factored::new([[f64::NAN, 2.0], [2.0, 4.0]]), None);
    }

    #[test]
    fn the_iteration_matrix_is_the_identity_less_the_weighted_jacobian() {
        let factored = Factored::iteration_matrix(&[[0.0_f64, 1.0], [-4.0, -0.5]], 0.1).expect("regular");
        // (1, -0.1; 0.4, 1.05) times (2, 3) by hand.
        let solved = factored.solve(&[1.7, 3.95]);
        assert!((solved[0] - 2.0).abs() < 1e-14 && (solved[1] - 3.0).abs() < 1e-14);
    }
}
