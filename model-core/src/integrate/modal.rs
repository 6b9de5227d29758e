//! The exact step of a damped mode under a force that is linear over the step: Duhamel's integral as a recurrence.
//!
//! ```text
//! q̈ + 2 ζ ω q̇ + ω² q = p(t),   p(t) = p0 + (p1 − p0) t/h
//! ```
//!
//! The state at the end of a step of length `h` is linear in the state at the start and in `p0` and `p1`,
//! with coefficients that depend on `ω`, `ζ` and `h` only. The step is exact at any length, so the fastest
//! mode does not limit it.

use crate::scalar::{Mathematics, Scalar, turns_of_radians};

/// The coefficients of the step of one mode for one step length:
///
/// ```text
/// q⁺ = q + (a11 − 1) q + a12 q̇ + (s − ρ/h) p0 + (ρ/h) p1
/// q̇⁺ = q̇ − ω² a12 q + (a22 − 1) q̇ + (a12 − s/h) p0 + (s/h) p1
/// ```
///
/// The coefficients give increments of the state, which a short step in `f32` does not round away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModalStep<S> {
    /// `a11 − 1`.
    pub(crate) displacement_by_displacement: S,
    /// `a12` in s: also the velocity at the end due to a unit force over the step.
    pub(crate) displacement_by_velocity: S,
    /// `a21 = −ω² a12` in 1/s.
    pub(crate) velocity_by_displacement: S,
    /// `a22 − 1`.
    pub(crate) velocity_by_velocity: S,
    /// `s = (1 − a11)/ω²` in s²: the displacement at the end due to a unit force over the step.
    pub(crate) response: S,
    /// `ρ/h` in s², with `ρ` the integral of `s` over the step: the part of `s` that `p1` causes.
    pub(crate) response_to_end: S,
    /// `s/h` in s: the part of `a12` that `p1` causes.
    pub(crate) velocity_to_end: S,
}

/// Angle `ω h` in radians below which the closed forms cancel and the series are summed.
const SERIES_ANGLE: f64 = 0.5;
/// Number of terms of the series; the last is below 2⁻⁵³ of the first.
const SERIES_TERMS: u32 = 18;

impl<S: Scalar> ModalStep<S> {
    /// The coefficients for an angular frequency `ω > 0` in rad/s, a damping ratio `0 ≤ ζ < 1` and a step `h
    /// > 0` in seconds.
    pub(crate) fn new(angular_frequency: S, damping_ratio: S, step: S) -> Self {
        let square = angular_frequency * angular_frequency;
        let twice_damping = S::from_f64(2.0) * damping_ratio * angular_frequency;
        let (response, response_to_end, by_velocity) = if angular_frequency * step < S::from_f64(SERIES_ANGLE)
        {
            series(square, twice_damping, step)
        } else {
            closed(angular_frequency, damping_ratio, step)
        };
        let displacement = -square * response;
        Self {
            displacement_by_displacement: displacement,
            displacement_by_velocity: by_velocity,
            velocity_by_displacement: -square * by_velocity,
            velocity_by_velocity: displacement - twice_damping * by_velocity,
            response,
            response_to_end,
            velocity_to_end: response / step,
        }
    }
}

/// `s`, `ρ/h` and `a12` by the Taylor series of the response to a unit force,
/// `s = Σ d_n hⁿ/n!` with `d_2 = 1`, `d_3 = −2ζω`, `d_{n+2} = −2ζω d_{n+1} − ω² d_n`.
fn series<S: Scalar>(square: S, twice_damping: S, step: S) -> (S, S, S) {
    let (damping, stiffness) = (twice_damping * step, square * step * step);
    let (mut before, mut term) = (S::ZERO, S::from_f64(0.5) * step * step);
    let (mut response, mut to_end, mut by_velocity) = (S::ZERO, S::ZERO, S::ZERO);
    for n in 2..2 + SERIES_TERMS {
        let count = S::from_u32(n);
        response += term;
        to_end += term / S::from_u32(n + 1);
        by_velocity += count * term;
        // d_{n+1} hⁿ⁺¹/(n+1)! from the terms of order n and n − 1.
        let next = S::from_u32(n + 1);
        (before, term) = (term, -(damping * term + stiffness * before / count) / next);
    }
    (response, to_end, by_velocity / step)
}

/// `s`, `ρ/h` and `a12` in closed form.
fn closed<S: Scalar>(angular_frequency: S, damping_ratio: S, step: S) -> (S, S, S) {
    let damped = angular_frequency * ((S::ONE - damping_ratio) * (S::ONE + damping_ratio)).sqrt();
    let phase = turns_of_radians(damped * step).unwrap_or(0);
    let decay = S::Build::exponential(-damping_ratio * angular_frequency * step);
    let (sine, cosine) = (S::Build::sine_of_turns(phase), S::Build::cosine_of_turns(phase));
    let by_velocity = decay * sine / damped;
    let rest = S::ONE - decay * cosine - damping_ratio * angular_frequency * by_velocity;
    let per_square = S::ONE / (angular_frequency * angular_frequency);
    let delay = (by_velocity + S::from_f64(2.0) * damping_ratio * rest / angular_frequency) / step;
    (rest * per_square, (S::ONE - delay) * per_square, by_velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The exact propagator by the matrix exponential of the mode with its force as two more states
    /// (value and slope), by scaling and squaring a Taylor series.
    fn exponential(omega: f64, zeta: f64, step: f64) -> [[f64; 4]; 4] {
        let generator = [
            [0.0, 1.0, 0.0, 0.0],
            [-omega * omega, -2.0 * zeta * omega, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0; 4],
        ];
        let multiply = |a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]| {
            let mut product = [[0.0; 4]; 4];
            for (i, row) in product.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = (0..4).map(|k| a[i][k] * b[k][j]).sum();
                }
            }
            product
        };
        let halvings = ((omega * step).max(1e-9).log2().ceil() as i32 + 6).max(0);
        let scaled = generator.map(|row| row.map(|entry| entry * step / 2f64.powi(halvings)));
        let mut result = [[0.0; 4]; 4];
        let mut term = [[0.0; 4]; 4];
        for i in 0..4 {
            (result[i][i], term[i][i]) = (1.0, 1.0);
        }
        for n in 1..16 {
            term = multiply(&term, &scaled).map(|row| row.map(|entry| entry / f64::from(n)));
            for i in 0..4 {
                for j in 0..4 {
                    result[i][j] += term[i][j];
                }
            }
        }
        for _ in 0..halvings {
            result = multiply(&result, &result);
        }
        result
    }

    #[test]
    fn coefficients_are_those_of_the_matrix_exponential() {
        for omega in [1.0, 1506.0, 3.8e5] {
            for zeta in [0.0, 0.01, 0.5] {
                for angle in [1e-4, 0.01, 0.3, 0.499, 0.501, 1.0, 7.0, 40.0] {
                    let step = angle / omega;
                    let exact = exponential(omega, zeta, step);
                    let modal = ModalStep::new(omega, zeta, step);
                    // Columns: displacement, velocity, force at the start, its slope times the step.
                    let found = [
                        [
                            1.0 + modal.displacement_by_displacement,
                            modal.displacement_by_velocity,
                            modal.response,
                            modal.response_to_end * step,
                        ],
                        [
                            modal.velocity_by_displacement,
                            1.0 + modal.velocity_by_velocity,
                            modal.displacement_by_velocity,
                            modal.velocity_to_end * step,
                        ],
                    ];
                    let scale = [1.0, 1.0 / omega, 1.0 / omega.powi(2), 1.0 / omega.powi(3)];
                    for i in 0..2 {
                        for j in 0..4 {
                            let size = scale[j] * omega.powi(i as i32);
                            let error = (found[i][j] - exact[i][j]).abs() / size;
                            // Short steps: relative to the entry itself, which is then small.
                            let tolerance = if angle < 0.5 { 1e-12 * exact[i][j].abs() / size } else { 0.0 };
                            assert!(
                                error < tolerance.max(4e-14 * (1.0 + angle)),
                                "{omega} {zeta} {angle} {i}{j} {error}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn single_precision_cancels_nothing() {
        for angle in [1e-5, 1e-3, 0.1, 0.45, 0.6, 3.0] {
            let (fine, coarse) = (
                ModalStep::<f64>::new(1506.0, 0.01, angle / 1506.0),
                ModalStep::<f32>::new(1506.0, 0.01, (angle / 1506.0) as f32),
            );
            for (a, b) in [
                (fine.response, coarse.response),
                (fine.response_to_end, coarse.response_to_end),
                (fine.displacement_by_displacement, coarse.displacement_by_displacement),
                (fine.velocity_to_end, coarse.velocity_to_end),
            ] {
                assert!((f64::from(b) / a - 1.0).abs() < 4e-6, "{angle} {a} {b}");
            }
        }
    }
}
