//! Integrates the charge along a given motion by the Lobatto IIIC method of order 4, which damps the transient of a
//! fast circuit within one step.

use crate::scalar::Scalar;

/// Weights of the stages.
pub(super) const WEIGHTS: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
/// The Butcher matrix.
pub(super) const STAGES: [[f64; 3]; 3] = [
    [1.0 / 6.0, -1.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 5.0 / 12.0, -1.0 / 12.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
];

/// The rates of the charge `P` at the stages, times the step: a constant, and a coefficient of the charge at the
/// start.
pub(super) struct Increments<S> {
    constant: [S; 3],
    by_charge: [S; 3],
}

impl<S: Scalar> Increments<S> {
    /// The increments of a constant charge.
    pub(super) const NONE: Self = Self { constant: [S::ZERO; 3], by_charge: [S::ZERO; 3] };

    /// `τ s1 z/h + A z = σS s1 − P` at the three stages, by Cramer's rule; `per_step` is `τ/h`.
    pub(super) fn new(active: &[S; 3], per_step: S, tribo_charge: S) -> Self {
        // All rows are scaled by their largest entry, so that an open circuit does not overflow.
        let scale = S::ONE / (S::ONE + per_step);
        let stages = STAGES.map(|row| row.map(S::from_f64));
        let row = |stage: usize| {
            let mut row = [S::ZERO; 3];
            let own = active.get(stage).copied().unwrap_or(S::ZERO);
            let coefficients = stages.get(stage).copied().unwrap_or([S::ZERO; 3]);
            for (column, (place, coefficient)) in row.iter_mut().zip(coefficients).enumerate() {
                let diagonal = if column == stage { per_step * own } else { S::ZERO };
                *place = scale * (coefficient + diagonal);
            }
            row
        };
        let rows = [row(0), row(1), row(2)];
        let cross = [cross(&rows[1], &rows[2]), cross(&rows[2], &rows[0]), cross(&rows[0], &rows[1])];
        let determinant = sum(&rows[0], &cross[0]);
        let factor = scale / determinant;
        let solve = |right: [S; 3]| {
            [0, 1, 2].map(|column| {
                let along = |which: usize| {
                    cross
                        .get(which)
                        .and_then(|vector: &[S; 3]| vector.get(column))
                        .copied()
                        .unwrap_or(S::ZERO)
                };
                factor * (along(0) * right[0] + along(1) * right[1] + along(2) * right[2])
            })
        };
        let minus_one = -S::ONE;
        Self { constant: solve(active.map(|own| tribo_charge * own)), by_charge: solve([minus_one; 3]) }
    }

    /// The increment over the whole step: a constant, and a coefficient of the charge at the start.
    pub(super) fn over_step(&self) -> [S; 2] {
        let weights = WEIGHTS.map(S::from_f64);
        [sum(&weights, &self.constant), sum(&weights, &self.by_charge)]
    }

    /// The rates, times the step, from a charge at the start.
    pub(super) fn at(&self, charge: S) -> [S; 3] {
        let [a, b, c] = self.by_charge;
        let [x, y, z] = self.constant;
        [x + a * charge, y + b * charge, z + c * charge]
    }
}

/// The product of a row and a column.
pub(super) fn sum<S: Scalar>([a, b, c]: &[S; 3], [x, y, z]: &[S; 3]) -> S {
    *a * *x + *b * *y + *c * *z
}

fn cross<S: Scalar>([a, b, c]: &[S; 3], [x, y, z]: &[S; 3]) -> [S; 3] {
    [*b * *z - *c * *y, *c * *x - *a * *z, *a * *y - *b * *x]
}
