//! Takes one step of a small system of ordinary differential equations `y' = f(y, u)` and controls the length
//! of the next step.
//!
//! A [`System`] gives its flow, its Jacobian as a factored iteration matrix, and a short list of powers. A
//! [`Method`] takes one step from one [`Point`] to the next and integrates the powers with the weights of its
//! stages. A [`StepControl`] accepts or rejects the step and proposes the length of the next one.
//!
//! The length of a step is a whole number of clock ticks of 2⁻³⁸ s. A method requests the input `u` at a
//! number of ticks into the step. This module contains no absolute time, no events and no physics.

mod boundary_layer;
pub(crate) mod control_memory;
pub(crate) mod cubic;
pub(crate) mod discrete_gradient;
mod exponential_radau;
mod linear;
pub(crate) mod modal;
mod runge_kutta;
pub(crate) mod step_control;
mod tr_bdf2;

use crate::clock::{Instant, seconds_of_ticks};
use crate::excitation::Excitation;
use crate::oscillator::{Kernel, Oscillator, Response};
use crate::scalar::{Scalar, add_increment, sum, zip_with};
use crate::snapshot::snapshot_fields;

pub use boundary_layer::BoundaryLayer;
pub use cubic::Cubic;
pub use exponential_radau::ExponentialRadau;
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

    /// `f(y, u)` at the state that differs by `change` from that of `start`.
    ///
    /// Override this if a rate at the state alone is a small difference of large terms: it can follow from the
    /// derivative at the start. Set [`System::CARRIED`] then.
    #[inline]
    fn flow_from(&self, start: &Point<S, N, P>, change: &[S; N], input: S) -> [S; N] {
        self.flow(&sum(&start.state, change), input)
    }

    /// Whether [`System::flow_from`] and [`System::condense`] continue the derivative at the start of the step, without
    /// rounding of the state.
    const CARRIED: bool = false;

    /// One Newton iteration on the implicit stage `z = weight · f(y + carried + z, u)`, with `y` the state of `start`:
    /// improves `increment`, the present `z`, and returns the correction.
    ///
    /// Override this and [`System::condense`] if some equations have a closed form given the others: Newton
    /// then iterates on the others only.
    #[inline]
    fn iterate(
        &self,
        factor: &Self::Factor,
        base: Base<'_, S, N, P>,
        increment: &mut [S; N],
        input: S,
        weight: S,
    ) -> [S; N] {
        let flow = self.flow_from(base.start, &base.change(increment), input);
        let residual = zip_with(flow, increment, |flow, increment| weight * flow - *increment);
        let correction = self.solve(factor, residual);
        *increment = sum(increment, &correction);
        correction
    }

    /// Overwrites the entries of `increment` that have a closed form given the others.
    ///
    /// Called once after the last iteration. The rate of a stiff equation is a small difference of large terms.
    /// Its entry must agree with the other entries to rounding.
    #[inline]
    fn condense(&self, _base: Base<'_, S, N, P>, _increment: &mut [S; N], _weight: S) {}

    /// The powers in watts at a state and its derivative.
    ///
    /// The derivative is that of the method's stage. In a stiff circuit it is more accurate than a current
    /// computed from the state, which would be a small difference of large voltages.
    fn powers(&self, state: &[S; N], derivative: &[S; N], input: S) -> [S; P];

    /// Overwrites energies in joules that are known exactly from the states at the start and the end of a
    /// step. For example, a transferred charge may be a difference of two states.
    #[inline]
    fn correct_energies(&self, _start: &[S; N], _end: &[S; N], _energies: &mut [S; P]) {}

    /// Error in joules of the integral of `powers[0]` over a step of `step` seconds to `state` that the
    /// rounding of the state causes; 0 where it is negligible.
    ///
    /// Where a stiff equation determines a state, the rate of that state is a difference of roundings divided by the step.
    #[inline]
    fn rounding_energy(&self, _state: &[S; N], _derivative: &[S; N], _step: S) -> S {
        S::ZERO
    }

    /// Part of the accuracy of a step that its extension to an event may be off, at least a rounding.
    const EXTENSION_PART: f64 = 1e-5;

    /// Whether the system states its split form, by the functions below: [`ExponentialRadau`] needs it.
    ///
    /// The first two states of a split system are a position and its velocity. The others follow one linear circuit equation.
    const SPLIT: bool = false;

    /// Index of the state that the circuit equation determines.
    const CIRCUIT: usize = 2;

    /// The linear part of the motion; `None` while the position is fixed.
    #[inline]
    fn oscillator(&self) -> Option<Oscillator<S>> {
        None
    }

    /// Whether a nearly harmonic motion drives a circuit that is about as slow, and whose coefficients hardly change within a step.
    /// [`ExponentialRadau`] then corrects the energies of [`System::quadratic_energies`] to sixth order, in double precision.
    #[inline]
    fn is_harmonic(&self) -> bool {
        false
    }

    /// Whether no state and no power changes: a step is then exact at any length.
    #[inline]
    fn is_constant(&self) -> bool {
        false
    }

    /// The time derivative along the flow of the force per mass besides the linear part, in m/s³.
    #[inline]
    fn force_rate(&self, _state: &[S; N], _derivative: &[S; N]) -> S {
        S::ZERO
    }

    /// Circuit and force at a displacement in m from `start` and a velocity in m/s.
    #[inline]
    fn stage(&self, _start: &Point<S, N, P>, _displacement: S, _velocity: S) -> Stage<S> {
        Stage { circuit: None, force: [S::ZERO; 3] }
    }

    /// Whether the circuit equation of a stage holds at any change of the circuit's state. If not,
    /// [`System::circuit_defect`] completes it.
    const LINEAR: bool = true;

    /// What the drive of the circuit equation at a displacement lacks at a change of the circuit's state: the equation is
    /// linearised about no change.
    #[inline]
    fn circuit_defect(&self, _start: &Point<S, N, P>, _displacement: S, _change: S) -> S {
        S::ZERO
    }

    /// The time scale of the circuit at the end of a step over that at its start, above 0.
    ///
    /// The step control changes the length of the next step with it.
    #[inline]
    fn time_scale_ratio(&self, _start: &[S; N], _end: &[S; N]) -> S {
        S::ONE
    }

    /// The boundary layer of the circuit at `state`, as after a jump; `None` if the circuit has no time constant.
    #[inline]
    fn boundary_layer(&self, _state: &[S; N]) -> Option<BoundaryLayer<S>> {
        None
    }

    /// The integral of each power that is quadratic in the rate of the circuit, for an integral `square` of the squared rate.
    #[inline]
    fn quadratic_energies(&self, _square: S) -> [S; P] {
        [S::ZERO; P]
    }

    /// The integral of each power that is linear in the rate of the circuit or its magnitude, for a `change` of the
    /// circuit's state. That of a magnitude is an upper bound where the rate opposes the one that follows the motion.
    #[inline]
    fn linear_energies(&self, _change: S) -> [S; P] {
        [S::ZERO; P]
    }

    /// The norm of a small change of the state, relative to the scale of the state.
    fn error_norm(&self, state: &[S; N], change: &[S; N]) -> S;
}

/// The equation of a circuit at a given position, `inertia · y' + stiffness · Δy = drive`, with `Δy` the change of the
/// circuit's state since the start of the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircuitEquation<S> {
    /// Factor of the derivative.
    pub inertia: S,
    /// Factor of the change, per second.
    pub stiffness: S,
    /// The remainder, in units of the inertia times the state per second. At the start of a step it is the inertia
    /// times the derivative there, so that no voltage is computed as a difference.
    pub drive: S,
}

impl<S: Scalar> CircuitEquation<S> {
    /// The rate at a change of the circuit's state.
    #[inline]
    pub(crate) fn rate(&self, change: S) -> S {
        (self.drive - self.stiffness * change) / self.inertia
    }

    /// `z = weight · y'` at the change `carried + z`.
    #[inline]
    pub(crate) fn increment(&self, carried: S, weight: S) -> S {
        weight * (self.drive - self.stiffness * carried) / (self.inertia + weight * self.stiffness)
    }
}

/// A split system at a given position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage<S> {
    /// The circuit; `None` while its state is constant.
    pub circuit: Option<CircuitEquation<S>>,
    /// The force per mass in m/s² besides the linear part and the base acceleration: coefficients of 1, `Δy` and `Δy²`.
    pub force: [S; 3],
}

impl<S: Scalar> Stage<S> {
    /// The force per mass in m/s² at a change of the circuit's state.
    #[inline]
    fn force_at(&self, change: S) -> S {
        let [constant, linear, quadratic] = self.force;
        constant + change * (linear + change * quadratic)
    }
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
    /// The powers in watts, of this state and derivative: a step takes the first as that at its start.
    pub powers: [S; P],
}

impl<S: Scalar, const N: usize, const P: usize> Point<S, N, P> {
    /// The point of `system` at `state`.
    pub fn at<Y: System<S, N, P>>(system: &Y, state: [S; N], input: S) -> Self {
        Self::with_derivative(system, state, system.flow(&state, input), input)
    }

    /// The point after `increments` of the state, with `derivative` and the powers of this one.
    #[inline]
    fn advanced(&self, derivative: [S; N], increments: [S; N]) -> Self {
        let mut end = Self { derivative, ..*self };
        for ((state, remainder), increment) in end.state.iter_mut().zip(&mut end.remainder).zip(increments) {
            (*state, *remainder) = add_increment(*state, *remainder, increment);
        }
        end
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

/// What an implicit stage adds its increment to.
#[derive(Debug, Clone, Copy)]
pub struct Base<'a, S, const N: usize, const P: usize> {
    /// The start of the step.
    pub start: &'a Point<S, N, P>,
    /// The change of the state by earlier stages.
    pub carried: &'a [S; N],
}

impl<S: Scalar, const N: usize, const P: usize> Base<'_, S, N, P> {
    /// The change of the state since the start, with an increment.
    #[inline]
    pub fn change(&self, increment: &[S; N]) -> [S; N] {
        sum(self.carried, increment)
    }
}

/// The result of an attempted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial<S, const N: usize, const P: usize> {
    /// The end of the step.
    pub end: Point<S, N, P>,
    /// The integral of each power over the step, in joules.
    pub energies: [S; P],
    /// Estimated local error of the state in the norm [`System::error_norm`]; 0 without an estimate.
    pub error: S,
    /// Estimated local error of `energies[0]` in joules: the embedded formula's value less `energies[0]`; 0 without an estimate.
    pub energy_error: S,
    /// Number of Newton iterations.
    pub iterations: u32,
}

/// Newton's iteration did not converge, or the result is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotConverged;

/// The input of a system during a step.
pub trait Input<S: Scalar> {
    /// The input `ticks` into the step.
    fn at(&self, ticks: u32) -> S;

    /// The response of an oscillator at rest to the input over a step of `ticks`; `kernel` is of this step.
    #[inline]
    fn response(&self, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        kernel.to_parabola([0, ticks / 2, ticks].map(|offset| self.at(offset)))
    }
}

impl<S: Scalar, F: Fn(u32) -> S> Input<S> for F {
    #[inline]
    fn at(&self, ticks: u32) -> S {
        self(ticks)
    }
}

/// An excitation from an instant on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InputFrom<'a, E> {
    pub(crate) excitation: &'a E,
    pub(crate) from: Instant,
}

impl<S: Scalar, E: Excitation<S>> Input<S> for InputFrom<'_, E> {
    #[inline]
    fn at(&self, ticks: u32) -> S {
        self.excitation.acceleration(self.from.after(ticks))
    }

    #[inline(always)]
    fn response(&self, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        self.excitation.response(self.from, ticks, kernel)
    }
}

/// A step to attempt.
#[derive(Debug)]
pub struct Attempt<'a, S, I, const N: usize, const P: usize> {
    /// The start of the step.
    pub start: &'a Point<S, N, P>,
    /// The input during the step.
    pub input: I,
    /// Length in clock ticks.
    pub ticks: u32,
    /// Accuracy to which implicit equations are solved, in the norm [`System::error_norm`].
    pub accuracy: S,
    /// Whether the step begins with a jump.
    pub after_jump: bool,
}

impl<S: Scalar, I, const N: usize, const P: usize> Attempt<'_, S, I, N, P> {
    /// The boundary layer at the start, after a jump, and the rate of the circuit's state there, beyond the layer.
    #[inline(always)]
    fn settled_rate<Y: System<S, N, P>>(&self, system: &Y) -> (Option<BoundaryLayer<S>>, S) {
        let (step, rate) = (seconds_of_ticks(self.ticks), self.start.derivative[Y::CIRCUIT]);
        let layer = if self.after_jump { system.boundary_layer(&self.start.state) } else { None };
        (layer, layer.map_or(rate, |layer| layer.settled(rate, step)))
    }
}

/// A one-step method.
pub trait Method<S: Scalar> {
    /// Whether the method estimates [`Trial::error`] and [`Trial::energy_error`].
    const ESTIMATES_ERROR: bool;

    /// Order in the step of the estimated errors per second.
    const ESTIMATE_ORDER: i32 = 2;
    /// Part of the sum of the estimated errors of the steps that covers the error of the energy: 1, or less if the
    /// method is of a higher order than its estimate.
    const ERROR_PER_ESTIMATE: f64 = 1.0;

    /// Longest step under error control, in radians of the motion or of its excitation.
    const LONGEST_RADIANS: f64 = 0.4;

    /// Whether the derivative of a system with [`System::CARRIED`] or [`System::SPLIT`] is carried from step to step
    /// without rounding of the state, and a jump returns the derivative inside a boundary layer.
    const CARRIES_DERIVATIVES: bool = false;

    /// Whether [`Method::predict`] returns a prediction for a moving system.
    const PREDICTS: bool = false;

    /// What the method computes of a step before its circuit.
    type Prediction: Copy;

    /// The longest step in seconds of a system, whose angular frequency and that of the input are at most `angular_frequency` in rad/s.
    #[inline]
    fn longest_step<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        _system: &Y,
        _angular_frequency: S,
    ) -> S {
        S::INFINITY
    }

    /// Predicts the motion, without the circuit; `None` if the method has no prediction that costs less than a step.
    #[inline]
    fn predict<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        _system: &Y,
        _attempt: &Attempt<'_, S, impl Input<S>, N, P>,
    ) -> Option<Self::Prediction> {
        None
    }

    /// The end of a step as predicted.
    #[inline]
    fn predicted_end<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        _system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        _prediction: &Self::Prediction,
    ) -> Point<S, N, P> {
        *attempt.start
    }

    /// Takes one step; `prediction` is of the same step.
    ///
    /// # Errors
    /// [`NotConverged`]; a shorter step may succeed.
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        prediction: Option<&Self::Prediction>,
    ) -> Result<Trial<S, N, P>, NotConverged>;
}
