//! What the two triboelectric scenes have in common: a position, its velocity, and one charge.
//!
//! ```text
//! x' = v        v' = f(x, v, q)        q' = i(x, q)
//! ```
//!
//! The iteration matrix `I − w J` of an implicit stage is eliminated by hand: the position's row is
//! `δx − w δv`, which leaves two equations for velocity and charge. And because the position is
//! linear in the velocity, and the charge linear in itself at a given position, Newton's iteration
//! is on the velocity alone.

use crate::integrate::System;
use crate::scalar::Scalar;

/// Number of states: position in metres, velocity in m/s, charge in units of the scene.
pub const STATES: usize = 3;
/// Place of the position in the state.
pub const POSITION: usize = 0;
/// Place of the velocity.
pub const VELOCITY: usize = 1;
/// Place of the charge.
pub const CHARGE: usize = 2;

/// Derivatives of the restoring force per mass, `−f`, and of the current `i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derivatives<S> {
    /// `−∂f/∂x` in 1/s².
    pub(crate) stiffness: S,
    /// `−∂f/∂v` in 1/s.
    pub(crate) damping: S,
    /// `−∂f/∂q`.
    pub(crate) force_by_charge: S,
    /// `∂i/∂x`.
    pub(crate) current_by_position: S,
    /// `∂i/∂q` in 1/s.
    pub(crate) current_by_charge: S,
}

/// `I − w J`, factored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeFactor<S> {
    /// `w`, or 0 where the position is held.
    position_by_velocity: S,
    /// `w ∂v'/∂x` and `w ∂q'/∂x`.
    by_position: [S; 2],
    /// Inverse of the remaining 2 × 2 matrix.
    inverse: [[S; 2]; 2],
}

impl<S: Scalar> ModeFactor<S> {
    /// Where the position moves; `None` if the matrix is singular.
    #[inline(always)]
    pub(crate) fn moving(weight: S, derivatives: &Derivatives<S>) -> Option<Self> {
        let charge_by_charge = S::ONE - weight * derivatives.current_by_charge;
        let charge_by_position = weight * derivatives.current_by_position;
        let velocity_by_position = -weight * derivatives.stiffness;
        let velocity_by_velocity = S::ONE + weight * (derivatives.damping - velocity_by_position);
        let velocity_by_charge = weight * derivatives.force_by_charge;
        let charge_by_velocity = -weight * charge_by_position;
        let determinant = velocity_by_velocity * charge_by_charge - velocity_by_charge * charge_by_velocity;
        let reciprocal = S::ONE / determinant;
        let inverse = [
            [charge_by_charge * reciprocal, -velocity_by_charge * reciprocal],
            [-charge_by_velocity * reciprocal, velocity_by_velocity * reciprocal],
        ];
        reciprocal.is_finite().then_some(Self {
            position_by_velocity: weight,
            by_position: [velocity_by_position, charge_by_position],
            inverse,
        })
    }

    /// Where position and velocity are held.
    #[inline(always)]
    pub(crate) fn held(weight: S, current_by_charge: S) -> Self {
        let charge_by_charge = S::ONE - weight * current_by_charge;
        let inverse = [[S::ONE, S::ZERO], [S::ZERO, S::ONE / charge_by_charge]];
        Self { position_by_velocity: S::ZERO, by_position: [S::ZERO; 2], inverse }
    }

    /// Solves `(I − w J) x = right`.
    #[inline(always)]
    pub(crate) fn solve(&self, [position, velocity, charge]: [S; STATES]) -> [S; STATES] {
        let velocity = velocity + self.by_position[0] * position;
        let charge = charge + self.by_position[1] * position;
        let [[a, b], [c, d]] = self.inverse;
        let solved = a * velocity + b * charge;
        [position + self.position_by_velocity * solved, solved, c * velocity + d * charge]
    }

    /// The correction of an increment whose velocity row has the residual `residual` and whose other
    /// rows are solved.
    #[inline(always)]
    pub(crate) fn correction(&self, residual: S) -> [S; STATES] {
        let correction = self.inverse[0][0] * residual;
        [self.position_by_velocity * correction, correction, self.inverse[1][0] * correction]
    }
}

/// One Newton iteration on the velocity alone of a stage of `system`, whose `condense` solves the other two
/// rows outright: the position's is linear in the velocity, the charge's in the charge at a position.
///
/// Where the position is `held` there is nothing left to iterate.
#[inline(always)]
pub(crate) fn iterate<S: Scalar, Y, const POWERS: usize>(
    system: &Y,
    held: bool,
    factor: &ModeFactor<S>,
    base: &[S; STATES],
    increment: &mut [S; STATES],
    input: S,
    weight: S,
) -> [S; STATES]
where
    Y: System<S, STATES, POWERS>,
{
    system.condense(base, increment, weight);
    if held {
        return [S::ZERO; STATES];
    }
    let state = core::array::from_fn(|i| base[i] + increment[i]);
    let [_, rate, _] = system.flow(&state, input);
    let correction = factor.correction(weight * rate - increment[VELOCITY]);
    increment[VELOCITY] += correction[VELOCITY];
    correction
}

/// The size of a change of state: motion relative to the present amplitude, at least `least`; charge
/// relative to `1/per_charge`.
#[inline(always)]
pub(crate) fn error_norm<S: Scalar>(
    [deflection, velocity]: [S; 2],
    change: &[S; STATES],
    time_scale: S,
    least: S,
    per_charge: S,
) -> S {
    let amplitude = deflection.abs().max(velocity.abs() * time_scale).max(least);
    let motion = change[POSITION].abs().max(change[VELOCITY].abs() * time_scale);
    // A reciprocal, because it is the same for every change that is weighed in a step.
    let per_amplitude = S::ONE / amplitude;
    (motion * per_amplitude).max(change[CHARGE].abs() * per_charge)
}

/// The rate of a charge where its circuit has just been disturbed, as a step of length `step` needs it.
///
/// The rate itself is `before`. But where the circuit is fast, the charge follows the position within
/// a boundary layer of the circuit's time constant `1/relaxation`, and a step much longer than that
/// starts beyond the layer, at the rate `following` of a charge that follows. The weight between the
/// two is of third order in `h Λ / 10`, so that neither limit is disturbed.
#[inline(always)]
pub(crate) fn beyond_boundary_layer<S: Scalar>(before: S, following: S, relaxation: S, step: S) -> S {
    let thickness = S::from_f64(0.1) * step * relaxation;
    let weight = thickness * thickness * thickness;
    // Beyond this the layer is not seen, and the weight might overflow.
    if weight > S::from_f64(1e9) { following } else { (before + weight * following) / (S::ONE + weight) }
}
