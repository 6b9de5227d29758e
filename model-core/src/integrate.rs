//! One step of a small system of ordinary differential equations, `y' = f(y, u)`, and the length of the
//! next step.
//!
//! A [`System`] gives its flow, its Jacobian as a factored iteration matrix, and a short list of powers. A
//! [`Method`] takes one step from one [`Point`] to the next and integrates the powers with the weights of its
//! stages. A [`StepControl`] accepts or rejects the step and proposes the length of the next one.
//!
//! The length of a step is a whole number of clock ticks of 2⁻⁴⁰ s. A method asks for the input `u` at a
//! number of ticks into the step. Absolute time, events and physics are unknown to this module.

pub mod cubic;
pub mod discrete_gradient;
mod linear;
pub mod modal;
mod runge_kutta;
pub mod step_control;
mod tr_bdf2;

use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

pub use linear::DenseFactor;
pub use runge_kutta::RungeKutta4;
pub use step_control::{Adaptive, AnyStepControl, FixedStep, StepControl};
pub use tr_bdf2::TrBdf2;

/// A system `y' = f(y, u)` of `N` states with one input `u`, and `P` powers to integrate along
/// with it.
///
/// By convention `powers[0]` is the power delivered to the load: its error estimate steers the
/// step beside that of the states.
pub trait System<S: Scalar, const N: usize, const P: usize> {
    /// `I − w J` in a form that [`System::solve`] can use.
    type Factor;

    /// `f(y, u)`.
    fn flow(&self, state: &[S; N], input: S) -> [S; N];

    /// Factors `I − weight · ∂f/∂y` at `state`; `None` if it is singular.
    fn factor(&self, state: &[S; N], input: S, weight: S) -> Option<Self::Factor>;

    /// Solves `(I − weight · ∂f/∂y) x = right`.
    fn solve(&self, factor: &Self::Factor, right: [S; N]) -> [S; N];

    /// One Newton iteration on an implicit stage `z = weight · f(base + z, u)`: improves
    /// `increment`, the `z` so far, and gives the correction made to it.
    ///
    /// A system of which some equations can be solved outright given the others overrides this and
    /// [`System::condense`], and iterates on the others only.
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

    /// Puts those entries of `increment` in order that have a closed form given the others.
    ///
    /// Called once after the last iteration. Where such an equation is stiff this is not a matter of
    /// speed: its rate is the small difference of large terms, and must be consistent with the
    /// other entries to rounding.
    #[inline(always)]
    fn condense(&self, _base: &[S; N], _increment: &mut [S; N], _weight: S) {}

    /// The powers in watts (or whatever is to be integrated) at a state and its derivative.
    ///
    /// The derivative is the method's own stage derivative: where the current of a stiff circuit
    /// would be a small difference of large voltages, it is the accurate source.
    fn powers(&self, state: &[S; N], derivative: &[S; N], input: S) -> [S; P];

    /// Puts those entries of `energies`, the integrals of the powers over a step from `start` to `end`, in order that
    /// the two states tell better than the stage weights.
    ///
    /// Where a power is that of a current which is algebraic, the charge that has passed is a difference of two
    /// states, and exact however few the steps.
    #[inline(always)]
    fn settle(&self, _start: &[S; N], _end: &[S; N], _energies: &mut [S; P]) {}

    /// Error that rounding the state makes in the integral of `powers[0]` over a step of
    /// length `step` that ends here; 0 if it is nothing to speak of.
    ///
    /// Where a power is taken from the rate of a state that a stiff equation holds to the others, the rate
    /// is a difference of roundings over the step.
    #[inline(always)]
    fn rounding_energy(&self, _state: &[S; N], _derivative: &[S; N], _step: S) -> S {
        S::ZERO
    }

    /// The size of a small change of the state, relative to what the state is measured by.
    fn error_norm(&self, state: &[S; N], change: &[S; N]) -> S;
}

/// A state with what the next step needs of the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Point<S, const N: usize, const P: usize> {
    /// The state.
    pub state: [S; N],
    /// What rounding took from the state: the true state is `state + remainder`.
    pub remainder: [S; N],
    /// The derivative of the state, as the method's last stage has it.
    pub derivative: [S; N],
    /// The powers at this point.
    pub powers: [S; P],
}

impl<S: Scalar, const N: usize, const P: usize> Point<S, N, P> {
    /// The point of `system` at a given state.
    pub fn at<Y: System<S, N, P>>(system: &Y, state: [S; N], input: S) -> Self {
        Self::with_derivative(system, state, system.flow(&state, input), input)
    }

    /// The point of `system` at a given state with a derivative that is known better than the
    /// flow can tell it.
    pub fn with_derivative<Y: System<S, N, P>>(
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

/// What a method found at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial<S, const N: usize, const P: usize> {
    /// The end of the step.
    pub end: Point<S, N, P>,
    /// The integral of each power over the step.
    pub energies: [S; P],
    /// Estimated local error of the state, as [`System::error_norm`] measures it; 0 if the method has
    /// no estimate.
    pub error: S,
    /// Estimated local error of `energies[0]`, with its sign: what is to be added to come to the embedded
    /// formula's value; 0 if there is no estimate.
    pub energy_error: S,
    /// Newton iterations spent.
    pub iterations: u32,
}

/// A step whose implicit equations were not solved, or whose result is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotConverged;

/// A one-step method.
pub trait Method<S: Scalar> {
    /// Whether [`Trial::error`] and [`Trial::energy_error`] are estimates, and not zero for want of one.
    const ESTIMATES_ERROR: bool;

    /// Takes one step of `ticks` clock ticks from `start`.
    ///
    /// `input` gives the input at a number of ticks into the step; `accuracy` is the size, as
    /// [`System::error_norm`] measures it, down to which implicit equations are to be solved.
    ///
    /// # Errors
    /// [`NotConverged`]; the caller is to try a shorter step.
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
#[inline(always)]
fn add_scaled<S: Scalar, const N: usize>(a: &[S; N], factor: S, b: &[S; N]) -> [S; N] {
    core::array::from_fn(|i| a[i] + factor * b[i])
}
