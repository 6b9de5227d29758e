//! The common equations of the two triboelectric scenes: a position, its velocity, and one charge.
//!
//! ```text
//! x' = v        v' = f(x, v, q)        q' = i(x, q)
//! ```
//!
//! The iteration matrix `I − w J` of an implicit stage is eliminated by hand: the row of the position is `δx − w δv`,
//! which leaves two equations for velocity and charge. The position is linear in the velocity, and the charge
//! equation is linear in the charge at a given position, so Newton iterates on the velocity alone.

use crate::observer::{ALL_POWERS, PowerIndex};
use crate::part::load::Resistance;
use crate::scalar::Scalar;

/// Number of states: position in m, velocity in m/s, charge in units of the scene.
pub const STATES: usize = 3;
/// Index of the position in the state.
pub const POSITION: usize = 0;
/// Index of the velocity.
pub const VELOCITY: usize = 1;
/// Index of the charge.
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
    /// `w`, or 0 if the position is fixed.
    position_by_velocity: S,
    /// `w ∂v'/∂x` and `w ∂q'/∂x`.
    by_position: [S; 2],
    /// Inverse of the remaining 2 × 2 matrix.
    inverse: [[S; 2]; 2],
}

impl<S: Scalar> ModeFactor<S> {
    /// The factor for a moving position; `None` if the matrix is singular.
    #[inline]
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

    /// The factor for a fixed position and velocity.
    #[inline]
    pub(crate) fn at_rest(weight: S, current_by_charge: S) -> Self {
        let charge_by_charge = S::ONE - weight * current_by_charge;
        let inverse = [[S::ONE, S::ZERO], [S::ZERO, S::ONE / charge_by_charge]];
        Self { position_by_velocity: S::ZERO, by_position: [S::ZERO; 2], inverse }
    }

    /// Solves `(I − w J) x = right`.
    #[inline]
    pub(crate) fn solve(&self, [position, velocity, charge]: [S; STATES]) -> [S; STATES] {
        let velocity = velocity + self.by_position[0] * position;
        let charge = charge + self.by_position[1] * position;
        let [[a, b], [c, d]] = self.inverse;
        let solved = a * velocity + b * charge;
        [position + self.position_by_velocity * solved, solved, c * velocity + d * charge]
    }

    /// The correction of an increment for the residual `residual` of the velocity row, with the other rows solved.
    #[inline]
    pub(crate) fn correction(&self, residual: S) -> [S; STATES] {
        let correction = self.inverse[0][0] * residual;
        [self.position_by_velocity * correction, correction, self.inverse[1][0] * correction]
    }
}

/// The items of [`System`] that the flows of both scenes have in common, by their `is_stick`, `derivatives`,
/// `equation` and `all_powers`.
///
/// Newton iterates on the velocity alone. [`System::condense`] solves the other two rows. With a fixed position no iteration is needed.
macro_rules! flow_items {
    () => {
        type Factor = ModeFactor<S>;

        #[inline]
        fn factor(&self, state: &[S; STATES], _acceleration: S, weight: S) -> Option<ModeFactor<S>> {
            let derivatives = self.derivatives(state);
            if self.is_stick() {
                return Some(ModeFactor::at_rest(weight, derivatives.current_by_charge));
            }
            ModeFactor::moving(weight, &derivatives)
        }

        #[inline]
        fn solve(&self, factor: &ModeFactor<S>, right: [S; STATES]) -> [S; STATES] {
            factor.solve(right)
        }

        #[inline]
        fn iterate(
            &self,
            factor: &ModeFactor<S>,
            base: Base<'_, S, STATES, POWERS>,
            increment: &mut [S; STATES],
            acceleration: S,
            weight: S,
        ) -> [S; STATES] {
            self.condense(base, increment, weight);
            if self.is_stick() {
                return [S::ZERO; STATES];
            }
            let [_, rate, _] = self.flow_from(base.start, &base.change(increment), acceleration);
            let correction = factor.correction(weight * rate - increment[VELOCITY]);
            increment[VELOCITY] += correction[VELOCITY];
            correction
        }

        const CARRIED: bool = true;

        /// The charge by its equation relative to the start of the step.
        #[inline]
        fn condense(&self, base: Base<'_, S, STATES, POWERS>, increment: &mut [S; STATES], weight: S) {
            let Base { start, carried } = base;
            if !self.is_stick() {
                increment[POSITION] =
                    weight * ((start.state[VELOCITY] + carried[VELOCITY]) + increment[VELOCITY]);
            }
            increment[CHARGE] = match self.equation(start, carried[POSITION] + increment[POSITION]) {
                Some(equation) => equation.increment(carried[CHARGE], weight),
                None => S::ZERO,
            };
        }

        const SPLIT: bool = true;

        /// In a stick without a current.
        #[inline]
        fn is_constant(&self) -> bool {
            self.is_stick() && !(self.circuit_rate > S::ZERO)
        }

        #[inline]
        fn linear_energies(&self, change: S) -> [S; POWERS] {
            let scene = self.scene;
            first_powers(&$crate::scene::coupled::linear_energies(
                scene.load.resistance(),
                scene.charge_unit * change,
            ))
        }

        #[inline]
        fn quadratic_energies(&self, square: S) -> [S; POWERS] {
            let scene = self.scene;
            first_powers(&$crate::scene::coupled::quadratic_energies(
                scene.load.resistance(),
                scene.charge_unit,
                square,
            ))
        }

        #[inline]
        fn powers(&self, state: &[S; STATES], rate: &[S; STATES], acceleration: S) -> [S; POWERS] {
            first_powers(&self.all_powers(state, rate, acceleration))
        }
    };
}
pub(crate) use flow_items;

/// The norm of a change of state: motion relative to the present amplitude, at least `least`; charge relative to `1/per_charge`.
#[inline]
pub(crate) fn error_norm<S: Scalar>(
    [deflection, velocity]: [S; 2],
    change: &[S; STATES],
    time_scale: S,
    least: S,
    per_charge: S,
) -> S {
    let amplitude = deflection.abs().max(velocity.abs() * time_scale).max(least);
    let motion = change[POSITION].abs().max(change[VELOCITY].abs() * time_scale);
    // The reciprocal is the same for every change in a step.
    let per_amplitude = S::ONE / amplitude;
    (motion * per_amplitude).max(change[CHARGE].abs() * per_charge)
}

/// The integrals of [`crate::integrate::System::linear_energies`] in a resistor; `charge` in C.
#[inline]
pub(crate) fn linear_energies<S: Scalar>(resistance: Resistance<S>, charge: S) -> [S; ALL_POWERS] {
    let mut integrals = [S::ZERO; ALL_POWERS];
    if let Resistance::Finite(resistance) = resistance {
        integrals[PowerIndex::Voltage as usize] = resistance * charge;
        integrals[PowerIndex::CurrentMagnitude as usize] = charge.abs();
    }
    integrals
}

/// The energies of [`crate::integrate::System::quadratic_energies`] in a resistor; `charge_unit` in C.
#[inline]
pub(crate) fn quadratic_energies<S: Scalar>(
    resistance: Resistance<S>,
    charge_unit: S,
    square: S,
) -> [S; ALL_POWERS] {
    let mut energies = [S::ZERO; ALL_POWERS];
    if let Resistance::Finite(resistance) = resistance {
        let energy = resistance * charge_unit * charge_unit * square;
        energies[PowerIndex::Load as usize] = energy;
        energies[PowerIndex::VoltageSquared as usize] = resistance * energy;
    }
    energies
}
