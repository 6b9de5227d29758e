//! TR-BDF2: a trapezoidal stage and a backward-differentiation stage with one iteration matrix (Bank et al. 1985).

use super::boundary_layer::without_layer;
use super::{Attempt, Base, Input, Method, NotConverged, System, Trial};
use crate::clock::seconds_of_ticks;
use crate::scalar::{Scalar, sum, zip_with};

/// Weight of the implicit stage derivative, `d = γ/2 = 1 − 1/√2`.
const D: f64 = 0.292_893_218_813_452_475_6;
/// Weight of the two earlier stage derivatives in the last stage, `w = √2/4`, over `d`.
const W_OVER_D: f64 = 1.207_106_781_186_547_524_4;
/// `1/γ`, `γ = 2 − √2`: extrapolates the first two stage derivatives linearly to the end of the step.
const ONE_OVER_GAMMA: f64 = 1.707_106_781_186_547_524_4;
/// `γ` in units of 2⁻³².
const GAMMA_Q32: u64 = 2_515_933_592;
/// Shortest step in ticks (61 µs) in which the intermediate stage may be a part of a tick off.
const COARSE_TICKS: u32 = 1 << 24;
/// `2 C (1/γ, −1/(γ(1−γ)), 1/(1−γ)) / d` with `C = (−3γ² + 4γ − 2) / (12 (2 − γ))`: the weights of the local
/// error, the difference to the embedded third-order formula with the weights `((1 − w)/3, (1 + 3w)/3, d/3)`.
const ERROR_OVER_D: [f64; 3] = [-0.471_404_520_791_031_682_9, 1.138_071_187_457_698_349_6, -2.0 / 3.0];

/// The method of Bank, Coughran, Fichtner, Grosse, Rose and Smith (IEEE Trans. CAD 4, 1985) as
/// analysed by Hosea and Shampine (Appl. Numer. Math. 20, 1996).
///
/// Butcher array, `γ = 2 − √2`, `d = γ/2`, `w = √2/4`:
///
/// ```text
///   0 |
///   γ | d   d
///   1 | w   w   d
///   --+-----------
///     | w   w   d
/// ```
///
/// Second order, L-stable and stiffly accurate: the last stage is the result, and its derivative is the first
/// stage of the next step. Both stages share the iteration matrix `I − d h J`, factored once at the predicted
/// intermediate stage.
///
/// The unknown of each stage is `z = d h k` and not the state. In a stiff circuit `z / (d h)` is then the
/// accurate current, and in `f32` the rounding of a state enters no difference. The estimate of the local
/// error is multiplied by the inverse of the iteration matrix, as Hosea and Shampine propose, so that stiff
/// components do not limit the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrBdf2;

/// Most Newton iterations per stage.
const MOST_ITERATIONS: u32 = 10;

/// Assumed constant `c` of quadratic convergence: a first correction of size `δ` leaves an error of `c δ²`.
///
/// With 10 to 100 the results of the contact-separation scene agree to four digits; 10 takes the fewest iterations.
const ASSUMED_CURVATURE: f64 = 10.0;

/// One implicit stage, `z = weight · f(base + z, input)`.
struct Stage<'a, S, Y, F, const N: usize, const P: usize> {
    system: &'a Y,
    factor: &'a F,
    base: Base<'a, S, N, P>,
    input: S,
    weight: S,
}

impl<S: Scalar, Y, F, const N: usize, const P: usize> Stage<'_, S, Y, F, N, P> {
    /// Solves the stage from the guess `z` to `accuracy`, with the error norm at the start. Returns `z` and the number of iterations.
    #[inline]
    fn solve(&self, mut z: [S; N], accuracy: S) -> Result<([S; N], u32), NotConverged>
    where
        Y: System<S, N, P, Factor = F>,
    {
        let Self { system, factor, base, input, weight } = self;
        let mut previous = S::INFINITY;
        for iteration in 1..=MOST_ITERATIONS {
            let correction = system.iterate(factor, *base, &mut z, *input, *weight);
            let size = system.error_norm(&base.start.state, &correction);
            let rate = if iteration == 1 { S::from_f64(ASSUMED_CURVATURE) * size } else { size / previous };
            if size <= accuracy || rate * size <= accuracy && rate < S::ONE {
                system.condense(*base, &mut z, *weight);
                return Ok((z, iteration));
            }
            // `!(rate < 2)` also ends the iteration at not-a-number.
            if iteration > 1 && !(rate < S::from_f64(2.0)) || !size.is_finite() {
                return Err(NotConverged);
            }
            previous = size;
        }
        Err(NotConverged)
    }
}

/// The input at the intermediate stage: in a short step between two ticks, because a motion that starts from rest resolves
/// less than a tick of its excitation.
#[inline]
fn middle_input<S: Scalar>(input: &impl Input<S>, ticks: u32) -> S {
    let position = u64::from(ticks) * GAMMA_Q32;
    let before = (position >> 32) as u32;
    let at = input.at(before);
    if ticks >= COARSE_TICKS {
        return at;
    }
    let part = S::from_u32(position as u32) * S::from_f64(1.0 / 4_294_967_296.0);
    at + part * (input.at(before + 1) - at)
}

impl<S: Scalar> Method<S> for TrBdf2 {
    const ESTIMATES_ERROR: bool = true;
    const CARRIES_DERIVATIVES: bool = true;

    type Prediction = ();

    #[inline]
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        _prediction: Option<&()>,
    ) -> Result<Trial<S, N, P>, NotConverged> {
        let Attempt { ref input, ticks, accuracy, .. } = *attempt;
        let step = seconds_of_ticks::<S>(ticks);
        let weight = step * S::from_f64(D);
        let (middle_input, end_input) = (middle_input(input, ticks), input.at(ticks));
        let outside =
            if attempt.after_jump { without_layer(system, attempt.start, input.at(0)) } else { None };
        let start = outside.as_ref().map_or(attempt.start, |(start, _)| start);

        let z_start = start.derivative.map(|rate| weight * rate);
        let predicted = sum(&sum(&start.state, &z_start), &z_start);
        let factor = system.factor(&predicted, middle_input, weight).ok_or(NotConverged)?;
        let base = Base { start, carried: &z_start };
        let middle = Stage { system, factor: &factor, base, input: middle_input, weight };
        let (z_middle, middle_iterations) = middle.solve(z_start, accuracy)?;

        let carried = sum(&z_start, &z_middle).map(|both| S::from_f64(W_OVER_D) * both);
        let extrapolated = zip_with(z_start, &z_middle, |start, middle| {
            start + S::from_f64(ONE_OVER_GAMMA) * (*middle - start)
        });
        let base = Base { start, carried: &carried };
        let last = Stage { system, factor: &factor, base, input: end_input, weight };
        let (z_end, end_iterations) = last.solve(extrapolated, accuracy)?;

        let per_weight = S::ONE / weight;
        let derivative_of = |z: &[S; N]| -> [S; N] { z.map(|z| z * per_weight) };
        let mut end = start.advanced(derivative_of(&z_end), sum(&carried, &z_end));
        end.powers = system.powers(&end.state, &end.derivative, end_input);

        let middle_state = sum(&start.state, &sum(&z_start, &z_middle));
        let middle_powers: [S; P] = system.powers(&middle_state, &derivative_of(&z_middle), middle_input);
        let mut energies = zip_with(sum(&start.powers, &middle_powers), &end.powers, |others, end| {
            weight * (S::from_f64(W_OVER_D) * others + *end)
        });

        let [e_start, e_middle, e_end] = ERROR_OVER_D.map(S::from_f64);
        let raw = zip_with(z_start, &z_middle, |start, middle| e_start * start + e_middle * *middle);
        let raw = zip_with(raw, &z_end, |others, end| others + e_end * *end);
        let error = system.error_norm(&start.state, &system.solve(&factor, raw));
        let energy_error = match (start.powers.first(), middle_powers.first(), end.powers.first()) {
            (Some(&first), Some(&second), Some(&third)) => {
                weight * (e_start * first + e_middle * second + e_end * third)
            }
            _ => S::ZERO,
        };
        if let Some((_, layer)) = &outside {
            layer.restore(system, step, end_input, &mut end, &mut energies);
        }
        system.correct_energies(&attempt.start.state, &end.state, &mut energies);
        let finite = end.state.iter().chain(&end.derivative).all(|value| value.is_finite());
        if !finite || !error.is_finite() || !energy_error.is_finite() {
            return Err(NotConverged);
        }
        Ok(Trial { end, energies, error, energy_error, iterations: middle_iterations + end_iterations })
    }
}
