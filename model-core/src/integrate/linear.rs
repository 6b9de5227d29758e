//! Solves small dense linear systems by LU factorisation with partial pivoting, for systems whose Jacobian
//! has no structure to use.
//!
//! nalgebra's static LU is not used: its assertions and bounds checks may panic, and it takes `abs` from
//! simba, hence from the platform or from a feature that another crate sets.

use crate::scalar::Scalar;

/// The iteration matrix `I − weight · J` of an implicit stage, factored: [`System::Factor`] for a system of
/// any size that states its Jacobian `J`.
///
/// ```
/// use model_core::clock::ticks_of_seconds;
/// use model_core::integrate::{Attempt, DenseFactor, Method, Point, System, TrBdf2};
///
/// /// `x'' = −ω² x + u`, with the state `[x, x']` in m and m/s and the input `u` in m/s².
/// struct Oscillator {
///     angular_frequency: f64, // rad/s
/// }
///
/// impl Oscillator {
///     fn jacobian(&self) -> [[f64; 2]; 2] {
///         [[0.0, 1.0], [-self.angular_frequency.powi(2), 0.0]]
///     }
/// }
///
/// impl System<f64, 2, 0> for Oscillator {
///     type Factor = DenseFactor<f64, 2>;
///
///     fn flow(&self, &[x, v]: &[f64; 2], input: f64) -> [f64; 2] {
///         [v, input - self.angular_frequency.powi(2) * x]
///     }
///
///     fn factor(&self, _state: &[f64; 2], _input: f64, weight: f64) -> Option<Self::Factor> {
///         DenseFactor::new(&self.jacobian(), weight)
///     }
///
///     fn solve(&self, factor: &Self::Factor, right: [f64; 2]) -> [f64; 2] {
///         factor.solve(&right)
///     }
///
///     fn powers(&self, _state: &[f64; 2], _derivative: &[f64; 2], _input: f64) -> [f64; 0] {
///         []
///     }
///
///     fn error_norm(&self, _state: &[f64; 2], change: &[f64; 2]) -> f64 {
///         change[0].abs().max(change[1].abs() / self.angular_frequency)
///     }
/// }
///
/// let system = Oscillator { angular_frequency: 10.0 };
/// let start = Point::at(&system, [1.0, 0.0], 0.0);
/// let ticks = ticks_of_seconds(1e-3);
/// let step = Attempt { start: &start, input: |_ticks| 0.0, ticks, accuracy: 1e-12, after_jump: false };
/// let trial = TrBdf2.attempt(&system, &step, None);
/// let end = trial.expect("the stages converge").end;
/// assert!((end.state[0] - 0.01_f64.cos()).abs() < 1e-7);
/// ```
///
/// [`System::Factor`]: crate::integrate::System::Factor
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DenseFactor<S, const N: usize> {
    /// Unit lower triangle below the diagonal, upper triangle above, reciprocal pivots on the diagonal.
    triangles: [[S; N]; N],
    /// The row of the matrix that each row of the triangles comes from.
    order: [usize; N],
}

impl<S: Scalar, const N: usize> DenseFactor<S, N> {
    /// Factors `I − weight · jacobian`, with `jacobian[i][j] = ∂f_i/∂y_j`; `None` if the matrix is singular or not finite.
    #[must_use]
    #[inline]
    pub fn new(jacobian: &[[S; N]; N], weight: S) -> Option<Self> {
        let mut matrix = *jacobian;
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = if i == j { S::ONE - weight * *entry } else { -weight * *entry };
            }
        }
        Self::of_matrix(matrix)
    }

    fn of_matrix(mut matrix: [[S; N]; N]) -> Option<Self> {
        let mut order = core::array::from_fn(|i| i);
        for k in 0..N {
            // Every larger entry is swapped into the pivot's place at once: the compiler then sees that `i`
            // is in bounds.
            for i in k + 1..N {
                if matrix[i][k].abs() > matrix[k][k].abs() {
                    matrix.swap(k, i);
                    order.swap(k, i);
                }
            }
            let reciprocal = S::ONE / matrix[k][k];
            // The reciprocal of an infinite pivot is a finite zero.
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

    /// Solves `(I − weight · jacobian) x = right` for `x`.
    #[must_use]
    #[inline]
    pub fn solve(&self, right: &[S; N]) -> [S; N] {
        let mut x: [S; N] = self.order.map(|row| right.get(row).copied().unwrap_or(S::ZERO));
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
        let solved = DenseFactor::of_matrix(matrix).expect("regular").solve(&right);
        for i in 0..3 {
            assert!((solved[i] - x[i]).abs() < 1e-14);
        }
        assert_eq!(DenseFactor::of_matrix([[1.0_f64, 2.0], [2.0, 4.0]]), None);
        assert_eq!(DenseFactor::of_matrix([[f64::NAN, 2.0], [2.0, 4.0]]), None);
    }

    #[test]
    fn the_iteration_matrix_is_the_identity_less_the_weighted_jacobian() {
        let factor = DenseFactor::new(&[[0.0_f64, 1.0], [-4.0, -0.5]], 0.1).expect("regular");
        // (1, -0.1; 0.4, 1.05) times (2, 3) by hand.
        let solved = factor.solve(&[1.7, 3.95]);
        assert!((solved[0] - 2.0).abs() < 1e-14 && (solved[1] - 3.0).abs() < 1e-14);
    }

    /// `J = −a u uᵀ`, whose solution is `b − u w a (u·b) / (1 + w a u·u)` by Sherman and Morrison (1950).
    fn solves_a_rank_one_jacobian<S: Scalar, const N: usize>(tolerance: f64) {
        let u: [f64; N] = core::array::from_fn(|i| if i % 2 == 0 { 1.0 } else { -0.5 } / (1.0 + i as f64));
        let right: [f64; N] = core::array::from_fn(|i| 0.3 + i as f64);
        let dot = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (a, weight) in [(1.0, 1e-3), (-0.3, 0.5), (1e4, 1e-2), (1e9, 1e-6)] {
            let jacobian: [[S; N]; N] =
                core::array::from_fn(|i| core::array::from_fn(|j| S::from_f64(-a * u[i] * u[j])));
            let factor = DenseFactor::new(&jacobian, S::from_f64(weight)).expect("regular");
            let solved = factor.solve(&right.map(S::from_f64));
            let along = weight * a * dot(&u, &right) / (1.0 + weight * a * dot(&u, &u));
            // The condition of the matrix is 1 + w a u·u.
            let bound = tolerance * (1.0 + weight * a.abs() * dot(&u, &u)) * (N as f64);
            for i in 0..N {
                let error = (solved[i].to_f64() - (right[i] - u[i] * along)).abs();
                assert!(error < bound * right[i].abs().max(1.0), "N = {N}, {a} {weight}: {error:e}");
            }
        }
    }

    #[test]
    fn any_size_agrees_with_the_closed_form_of_a_rank_one_jacobian() {
        solves_a_rank_one_jacobian::<f64, 1>(f64::EPSILON);
        solves_a_rank_one_jacobian::<f64, 2>(f64::EPSILON);
        solves_a_rank_one_jacobian::<f64, 5>(f64::EPSILON);
        solves_a_rank_one_jacobian::<f64, 12>(f64::EPSILON);
        solves_a_rank_one_jacobian::<f32, 5>(f64::from(f32::EPSILON));
    }
}
