//! The exact step of a damped mode under a force that is linear over the step: Duhamel's integral as a recurrence.
//!
//! ```text
//! q̈ + 2 ζ ω q̇ + ω² q = p(t),   p(t) = p + r (2t/h − 1)
//! ```
//!
//! The state at the end of a step of length `h` is linear in the state at the start and in `p` and `r`,
//! with coefficients that depend on `ω`, `ζ` and `h` only. The step is exact at any length, so the fastest
//! mode does not limit it.

use crate::scalar::{Mathematics, Scalar, turns_of_radians};

/// The coefficients of the step of one mode for one step length:
///
/// ```text
/// q⁺ = q + (a11 − 1) q + a12 q̇ + s p + s1 r
/// q̇⁺ = q̇ − ω² a12 q + (a22 − 1) q̇ + a12 p + w1 r
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
    /// Due to a force that rises from −1 to 1 over the step: displacement `s1` in s² and velocity `w1` in s at the end,
    /// and the first moment `∫ (2t/h − 1) q̇ dt` of the velocity in s².
    pub(crate) tilt: [S; 3],
}

impl<S: Scalar> ModalStep<S> {
    /// The first moment `∫ (2t/h − 1) q̇ dt` of the velocity without force, `[by q, by q̇]`.
    pub(crate) fn moment(&self, angular_frequency: S) -> [S; 2] {
        let [displacement, velocity, _] = self.tilt;
        [angular_frequency * angular_frequency * displacement, -velocity]
    }
}

/// The responses to a unit force from which all coefficients follow.
struct Responses<S> {
    response: S,
    displacement_by_velocity: S,
    tilt: [S; 3],
}

/// Angle `ω h` in radians below which the closed forms cancel and the series are summed.
const SERIES_ANGLE: f64 = 2.0;
/// Most terms of the series; the last is below 2⁻⁵³ of the first.
const SERIES_TERMS: u32 = 24;

impl<S: Scalar> ModalStep<S> {
    /// The coefficients for an angular frequency `ω > 0` in rad/s, a damping ratio `0 ≤ ζ < 1` and a step `h > 0` in seconds.
    pub(crate) fn new(angular_frequency: S, damping_ratio: S, step: S) -> Self {
        let square = angular_frequency * angular_frequency;
        let twice_damping = S::from_f64(2.0) * damping_ratio * angular_frequency;
        let Responses { response, displacement_by_velocity: by_velocity, tilt } =
            if angular_frequency * step < S::from_f64(SERIES_ANGLE) {
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
            tilt,
        }
    }
}

/// The Taylor series of the response to a unit force, `s = Σ d_n hⁿ/n!` with `d_2 = 1`, `d_3 = −2ζω`,
/// `d_{n+2} = −2ζω d_{n+1} − ω² d_n`, and the series of the others.
fn series<S: Scalar>(square: S, twice_damping: S, step: S) -> Responses<S> {
    let (damping, stiffness) = (twice_damping * step, square * step * step);
    let (mut before, mut term) = (S::ZERO, S::from_f64(0.5) * step * step);
    let (mut response, mut by_velocity) = (S::ZERO, S::ZERO);
    let (mut tilt, mut settled) = ([S::ZERO; 3], false);
    for n in 2..2 + SERIES_TERMS {
        let (count, next) = (S::from_u32(n), S::from_u32(n + 1));
        response += term;
        by_velocity += count * term;
        // 1 − 2/(n + 1), n − 2, and 1 − 4/(n + 1) + 4/((n + 1)(n + 2)).
        let excess = S::from_u32(n - 2);
        tilt[0] -= term * S::from_u32(n - 1) / next;
        tilt[1] -= term * excess;
        let moment = tilt[2] - term * excess / S::from_u32(n + 2);
        // The smallest sum keeps its value over two terms: without damping every other term is zero.
        let settles = moment == tilt[2];
        if n > 4 && settles && settled {
            break;
        }
        (tilt[2], settled) = (moment, settles);
        // d_{n+1} hⁿ⁺¹/(n+1)! from the terms of order n and n − 1.
        (before, term) = (term, -(damping * term + stiffness * before / count) / next);
    }
    tilt[1] = tilt[1] / step;
    Responses { response, displacement_by_velocity: by_velocity / step, tilt }
}

/// The closed form.
fn closed<S: Scalar>(angular_frequency: S, damping_ratio: S, step: S) -> Responses<S> {
    let damped = angular_frequency * ((S::ONE - damping_ratio) * (S::ONE + damping_ratio)).sqrt();
    let phase = turns_of_radians(damped * step).unwrap_or(0);
    let decay = S::Build::exponential(-damping_ratio * angular_frequency * step);
    let (sine, cosine) = (S::Build::sine_of_turns(phase), S::Build::cosine_of_turns(phase));
    let by_velocity = decay * sine / damped;
    let rest = S::ONE - decay * cosine - damping_ratio * angular_frequency * by_velocity;
    let per_square = S::ONE / (angular_frequency * angular_frequency);
    let (two, four) = (S::from_f64(2.0), S::from_f64(4.0));
    let lag = two * damping_ratio / angular_frequency;
    let delay = (by_velocity + lag * rest) / step;
    let (response, to_end) = (rest * per_square, (S::ONE - delay) * per_square);
    // Mean displacement due to a force that rises from 0 to 1: the integral of the equation of motion.
    let velocity_to_end = response / step;
    let damping = two * damping_ratio * angular_frequency;
    let mean = (S::from_f64(0.5) - (velocity_to_end + damping * to_end) / step) * per_square;
    let tilt = [
        two * to_end - response,
        two * velocity_to_end - by_velocity,
        four * to_end - response - four * mean,
    ];
    Responses { response, displacement_by_velocity: by_velocity, tilt }
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
                for angle in [1e-4, 0.01, 0.3, 0.499, 0.501, 1.0, 1.99, 2.01, 7.0, 40.0] {
                    let step = angle / omega;
                    let exact = exponential(omega, zeta, step);
                    let modal = ModalStep::new(omega, zeta, step);
                    // Columns: displacement, velocity, force at the start, its slope times the step.
                    let found = [
                        [
                            1.0 + modal.displacement_by_displacement,
                            modal.displacement_by_velocity,
                            modal.response,
                            0.5 * (modal.tilt[0] + modal.response) * step,
                        ],
                        [
                            modal.velocity_by_displacement,
                            1.0 + modal.velocity_by_velocity,
                            modal.displacement_by_velocity,
                            0.5 * (modal.tilt[1] + modal.displacement_by_velocity) * step,
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
    fn the_response_to_a_tilt_is_that_of_the_matrix_exponential() {
        for (omega, zeta) in [(1.0, 0.0), (1506.0, 0.01), (3.8e5, 0.5)] {
            for angle in [1e-3, 0.1, 0.99, 1.99, 2.01, 7.0, 40.0] {
                let step = angle / omega;
                let modal = ModalStep::<f64>::new(omega, zeta, step);
                // Displacement from a unit of displacement, of velocity, and of the tilt of a force; their means by
                // Gauss's rule over short panels.
                let at = |part: f64| {
                    let [row, _, ..] = exponential(omega, zeta, part * step);
                    // The slope of the tilt is 2/h.
                    [row[0], row[1], 2.0 * row[3] / step - row[2]]
                };
                let (end, mut means) = (at(1.0), [0.0; 3]);
                let panels = 40 + (4.0 * angle) as u32;
                for panel in 0..panels {
                    for side in [-1.0, 1.0] {
                        let part = (f64::from(panel) + 0.5 + side * 0.5 / 3f64.sqrt()) / f64::from(panels);
                        for (mean, value) in means.iter_mut().zip(at(part)) {
                            *mean += 0.5 * value / f64::from(panels);
                        }
                    }
                }
                let start = [1.0, 0.0, 0.0];
                let [by_displacement, by_velocity] = modal.moment(omega);
                let rows = [by_displacement, by_velocity, modal.tilt[2]];
                let sizes = [1.0, 1.0 / omega, 1.0 / omega.powi(2)];
                for k in 0..3 {
                    let moment = end[k] + start[k] - 2.0 * means[k];
                    assert!(
                        (rows[k] - moment).abs() < 1e-6 * sizes[k],
                        "{omega} {angle} {k}: {} {moment}",
                        rows[k]
                    );
                }
                assert!((modal.tilt[0] - end[2]).abs() < 1e-12 * sizes[2], "{omega} {angle}");
                assert!(modal.tilt[2] > 0.0);
            }
        }
    }

    #[test]
    fn single_precision_cancels_nothing() {
        for angle in [1e-5, 1e-3, 0.1, 0.45, 0.6, 0.99, 1.01, 1.2, 1.5, 1.99, 2.01, 3.0] {
            let (fine, coarse) = (
                ModalStep::<f64>::new(1506.0, 0.01, angle / 1506.0),
                ModalStep::<f32>::new(1506.0, 0.01, (angle / 1506.0) as f32),
            );
            for (a, b) in [
                (fine.response, coarse.response),
                (fine.displacement_by_displacement, coarse.displacement_by_displacement),
                (fine.tilt[0], coarse.tilt[0]),
                (fine.tilt[1], coarse.tilt[1]),
                (fine.tilt[2], coarse.tilt[2]),
            ] {
                assert!((f64::from(b) / a - 1.0).abs() < 4e-6, "{angle} {a} {b}");
            }
        }
    }
}
