//! Takes one step of a small system of ordinary differential equations `y' = f(y, u)` and controls the length
//! of the next step.
//!
//! A [`System`] gives its flow, its Jacobian as a factored iteration matrix, and a short list of powers. A
//! [`Method`] takes one step from one [`Point`] to the next and integrates the powers with the weights of its
//! stages. A [`StepControl`] accepts or rejects the step and proposes the length of the next one.
//!
//! The length of a step is a whole number of clock ticks of 2⁻⁴⁰ s. A method requests the input `u` at a
//! number of ticks into the step. This module contains no absolute time, no events and no physics.

pub(crate) mod control_memory;
pub(crate) mod cubic;
pub(crate) mod discrete_gradient;
mod linear;
pub(crate) mod modal;
mod runge_kutta;
pub(crate) mod step_control;
mod tr_bdf2;

use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

pub use cubic::Cubic;
pub use linear::DenseFactor;
pub use runge_kutta::RungeKutta4;
pub use step_control::{Adaptive, AnyStepControl, ErrorScale, FixedStep, StepControl};
pub use tr_bdf2::TrBdf2;

/// A system `y' = f(y, u)` of `N` states `y` with one input `u`, and `P` powers that are integrated along
/// with the states.
///
/// `powers[0]` is the power delivered to the load; its error estimate limits the step in addition to that of
/// the state. With [`DenseFactor`] a system states its Jacobian and needs no elimination by hand.
pub trait System<S: Scalar, const N: usize, const P: usize> {
    /// The factored iteration matrix `I − weight · ∂f/∂y`; [`DenseFactor`] suits any system.
    type Factor;

    /// `f(y, u)`.
    fn flow(&self, state: &[S; N], input: S) -> [S; N];

    /// Factors `I − weight · ∂f/∂y` at `state`; `None` if it is singular.
    fn factor(&self, state: &[S; N], input: S, weight: S) -> Option<Self::Factor>;

    /// Solves `(I − weight · ∂f/∂y) x = right`.
    fn solve(&self, factor: &Self::Factor, right: [S; N]) -> [S; N];

    /// One Newton iteration on the implicit stage `z = weight · f(base + z, u)`: improves `increment`, the
    /// present `z`, and returns the correction.
    ///
    /// Override this and [`System::condense`] if some equations have a closed form given the others: Newton
    /// then iterates on the others only.
    #[inline(always)]
    fn iterate(
        &self,
        factor: &Self::Factor,
        base: &[S; N],
        increment: &mut [S; N],
        input: S,
        weight: S,
    ) -> [S; N] {
        let flow = self.flow(&core::array::from_fn(|i| base[i] + increment[i]), input);
        let residual = core::array::from_fn(|i| weight * flow[i] - increment[i]);
        let correction = self.solve(factor, residual);
        *increment = core::array::from_fn(|i| increment[i] + correction[i]);
        correction
    }

    /// Overwrites the entries of `increment` that have a closed form given the others.
    ///
    /// Called once after the last iteration. The rate of a stiff equation is a small difference of large terms.
    /// Its entry must agree with the other entries to rounding.
    #[inline(always)]
    fn condense(&self, _base: &[S; N], _increment: &mut [S; N], _weight: S) {}

    /// The powers in watts at a state and its derivative.
    ///
    /// The derivative is that of the method's stage. In a stiff circuit it is more accurate than a current
    /// computed from the state, which would be a small difference of large voltages.
    fn powers(&self, state: &[S; N], derivative: &[S; N], input: S) -> [S; P];

    /// Overwrites energies in joules that are known exactly from the states at the start and the end of a
    /// step. For example, a transferred charge may be a difference of two states.
    #[inline(always)]
    fn correct_energies(&self, _start: &[S; N], _end: &[S; N], _energies: &mut [S; P]) {}

    /// Error in joules of the integral of `powers[0]` over a step of `step` seconds to `state` that the
    /// rounding of the state causes; 0 where it is negligible.
    ///
    /// Where a stiff equation determines a state, the rate of that state is a difference of roundings divided
    /// by the step.
    #[inline(always)]
    fn rounding_energy(&self, _state: &[S; N], _derivative: &[S; N], _step: S) -> S {
        S::ZERO
    }

    /// The norm of a small change of the state, relative to the scale of the state.
    fn error_norm(&self, state: &[S; N], change: &[S; N]) -> S;
}

/// A state, its derivative and its powers: the end of one step and the start of the next.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Point<S, const N: usize, const P: usize> {
    /// The state.
    pub state: [S; N],
    /// The part of the state that rounding removed: `state + remainder` is more exact.
    pub remainder: [S; N],
    /// The derivative of the state at the last stage of the method.
    pub derivative: [S; N],
    /// The powers in watts.
    pub powers: [S; P],
}

impl<S: Scalar, const N: usize, const P: usize> Point<S, N, P> {
    /// The point of `system` at `state`.
    pub fn at<Y: System<S, N, P>>(system: &Y, state: [S; N], input: S) -> Self {
        Self::with_derivative(system, state, system.flow(&state, input), input)
    }

    /// The point of `system` at `state`, with a derivative that is more accurate than the flow at `state`.
    pub(crate) fn with_derivative<Y: System<S, N, P>>(
        system: &Y,
        state: [S; N],
        derivative: [S; N],
        input: S,
    ) -> Self {
        Self { state, remainder: [S::ZERO; N], derivative, powers: system.powers(&state, &derivative, input) }
    }
}

snapshot_fields!(impl [S: Scalar, const N: usize, const P: usize] Point<S, N, P> {
    state, remainder, derivative, powers,
});

/// The result of an attempted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial<S, const N: usize, const P: usize> {
    /// The end of the step.
    pub end: Point<S, N, P>,
    /// The integral of each power over the step, in joules.
    pub energies: [S; P],
    /// Estimated local error of the state in the norm [`System::error_norm`]; 0 without an estimate.
    pub error: S,
    /// Estimated local error of `energies[0]` in joules: the embedded formula's value less `energies[0]`; 0
    /// without an estimate.
    pub energy_error: S,
    /// Number of Newton iterations.
    pub iterations: u32,
}

/// Newton's iteration did not converge, or the result is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotConverged;

/// A one-step method.
pub trait Method<S: Scalar> {
    /// Whether the method estimates [`Trial::error`] and [`Trial::energy_error`].
    const ESTIMATES_ERROR: bool;

    /// Takes one step of `ticks` clock ticks from `start`.
    ///
    /// `input` returns the input at a number of ticks into the step. Implicit equations are solved to
    /// `accuracy` in the norm [`System::error_norm`].
    ///
    /// # Errors
    /// [`NotConverged`]; a shorter step may succeed.
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        start: &Point<S, N, P>,
        input: impl Fn(u32) -> S,
        ticks: u32,
        accuracy: S,
    ) -> Result<Trial<S, N, P>, NotConverged>;
}

/// `a + factor · b`, entry by entry.
#[inline]
fn add_scaled<S: Scalar, const N: usize>(a: &[S; N], factor: S, b: &[S; N]) -> [S; N] {
    core::array::from_fn(|i| a[i] + factor * b[i])
}
