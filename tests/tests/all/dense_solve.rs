//! The dense solve of an implicit stage against nalgebra's LU, for Jacobians of every small size.

use model_core::integrate::DenseFactor;
use nalgebra::{DMatrix, DVector};

fn agree<const N: usize>() {
    for case in 0..50 {
        // Entries without pattern, from −1000 to 1000 in 1/s.
        let entry = |i: usize, j: usize| 1e3 * ((case * 97 + i * 31 + j * 17 + 1) as f64).powi(2).sin();
        let jacobian: [[f64; N]; N] = core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)));
        let right: [f64; N] = core::array::from_fn(|i| entry(i, N));
        for weight in [1e-6, 1e-3, 1.0] {
            let own = DenseFactor::new(&jacobian, weight).expect("regular").solve(&right);
            let matrix = DMatrix::identity(N, N) - weight * DMatrix::from_fn(N, N, |i, j| jacobian[i][j]);
            let peer = matrix.clone().lu().solve(&DVector::from_column_slice(&right)).expect("regular");
            let condition = matrix.norm() * matrix.try_inverse().expect("regular").norm();
            let error = (DVector::from_column_slice(&own) - &peer).norm() / peer.norm();
            assert!(error < 4.0 * f64::EPSILON * condition, "{N}, {case}, {weight}: {error:e} {condition:e}");
        }
    }
}

#[test]
fn the_dense_solve_agrees_with_that_of_nalgebra() {
    agree::<1>();
    agree::<2>();
    agree::<3>();
    agree::<4>();
    agree::<6>();
    agree::<9>();
}
