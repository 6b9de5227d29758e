//! Simulates hybrid systems: smooth flows in modes, joined by instantaneous events.
//!
//! A harvester with a stop or with friction is a hybrid automaton. In each *mode* the state follows the
//! *flow* `y' = f(y, u)`. A *guard* `g(y, u)` is positive while the mode lasts. At `g = 0` the *jump* gives
//! the next mode and state. An [`Automaton`] states modes, flows, guards and jumps as pure functions of its
//! parameters. The [`Driver`] advances a [`HybridState`] and contains no physics.

mod attempt;
mod driver;
mod outcome;
mod predicted;
mod search;

use core::fmt::Debug;

use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::integrate::Cubic;
use crate::integrate::control_memory::ControlMemory;
use crate::integrate::{ErrorScale, Point, StepControl, System};
use crate::observer::Outputs;
use crate::scalar::Scalar;
use crate::snapshot::{Snapshot, snapshot_fields};
use attempt::MOST_GUARDS;

pub use driver::{Driver, LEAST_BUDGET};
pub use outcome::{Advance, Ended, StepError, StepFailure, Work};

/// A guard and its rate of change along the flow, in the guard's own unit.
///
/// The guard is positive while the mode lasts; its fall through zero is the event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard<S> {
    /// The value.
    pub value: S,
    /// Its time derivative along the flow.
    pub rate: S,
}

impl<S: Scalar> Guard<S> {
    /// Whether the event is due: the guard is below zero, or at zero and falling.
    #[inline]
    fn is_due(&self) -> bool {
        self.value < S::ZERO || self.value == S::ZERO && self.rate < S::ZERO
    }

    /// The interpolant of the guard over a step of `step` seconds from here to `end`.
    #[inline]
    fn until(&self, end: &Self, step: S) -> Cubic<S> {
        Cubic::new(self.value, self.rate, end.value, end.rate, step)
    }
}

/// The result of an event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump<S, Mode, const N: usize> {
    /// The mode after the event.
    pub mode: Mode,
    /// The state after the event.
    pub state: [S; N],
    /// The part of the state that rounding removed; see [`Point::remainder`].
    pub remainder: [S; N],
    /// The derivative after the event, in the new mode.
    pub derivative: [S; N],
    /// Energy lost in the event, in joules.
    pub loss: S,
    /// Whether the guards of the new mode are watched from the start. `false` if a guard starts at zero with
    /// zero rate; [`Automaton::rearms`] then decides when the guards are watched again.
    pub armed: bool,
}

/// The excitation at one instant, evaluated on request.
#[derive(Debug, Clone, Copy)]
pub struct InputAt<'a, E> {
    excitation: &'a E,
    at: Instant,
}

impl<'a, E> InputAt<'a, E> {
    /// The excitation `excitation` at `at`.
    pub(crate) const fn new(excitation: &'a E, at: Instant) -> Self {
        Self { excitation, at }
    }

    /// Base acceleration in m/s².
    #[inline]
    pub fn acceleration<S: Scalar>(&self) -> S
    where
        E: Excitation<S>,
    {
        self.excitation.acceleration(self.at)
    }

    /// Time derivative of the base acceleration in m/s³.
    #[inline]
    pub fn jerk<S: Scalar>(&self) -> S
    where
        E: Excitation<S>,
    {
        self.excitation.jerk(self.at)
    }
}

/// A hybrid system of `N` states with `P` powers.
pub trait Automaton<S: Scalar, const N: usize, const P: usize> {
    /// The modes.
    type Mode: Copy + Debug + PartialEq;

    /// The flow of one mode.
    type Flow<'a>: System<S, N, P>
    where
        Self: 'a;

    /// The flow of `mode`.
    fn flow(&self, mode: Self::Mode) -> Self::Flow<'_>;

    /// Whether the guards at the end of a step serve the next one, the first five of them: where a guard costs more than its copy.
    /// [`Automaton::each_guard`] then gives every guard below [`Automaton::guards`].
    const KEEPS_GUARDS: bool = false;

    /// Number of guards of `mode`, at most 32; 0 by default.
    #[inline]
    fn guards(&self, _mode: Self::Mode) -> usize {
        0
    }

    /// Guard number `index` of `mode`.
    ///
    /// If `armed` is false, lower the guard by a margin of rounding size: the guard then does not fire at its
    /// start but still detects a state that moves through zero.
    #[inline]
    fn guard<E: Excitation<S>>(
        &self,
        _mode: Self::Mode,
        _index: usize,
        _armed: bool,
        _point: &Point<S, N, P>,
        _input: &InputAt<'_, E>,
    ) -> Guard<S> {
        Guard { value: S::ONE, rate: S::ZERO }
    }

    /// Calls `take` with the number of each guard of `mode`, in order, and with the guard. Override it if guards have a part
    /// in common: with the bits of [`Automaton::guard`], and with numbers below 32.
    #[inline(always)]
    fn each_guard<E: Excitation<S>>(
        &self,
        mode: Self::Mode,
        armed: bool,
        point: &Point<S, N, P>,
        input: &InputAt<'_, E>,
        mut take: impl FnMut(usize, Guard<S>),
    ) {
        for index in 0..self.guards(mode).min(MOST_GUARDS) {
            take(index, self.guard(mode, index, armed, point, input));
        }
    }

    /// Whether the guards of `mode`, unwatched since the jump into it, are watched from `point` on.
    #[inline]
    fn rearms(&self, _mode: Self::Mode, _point: &Point<S, N, P>) -> bool {
        true
    }

    /// The jump at the zero of guard number `index` of `mode`.
    ///
    /// `step` is the length of the next step in seconds. If the derivative has a boundary layer much thinner
    /// than `step`, return the derivative beyond the layer.
    #[inline]
    fn jump<E: Excitation<S>>(
        &self,
        mode: Self::Mode,
        _index: usize,
        point: &Point<S, N, P>,
        _input: &InputAt<'_, E>,
        _step: S,
    ) -> Jump<S, Self::Mode, N> {
        let Point { state, remainder, derivative, .. } = *point;
        Jump { mode, state, remainder, derivative, loss: S::ZERO, armed: true }
    }

    /// The energy in joules that each power transfers instantaneously in the jump to `after`, for example
    /// when two capacitors are connected.
    #[inline]
    fn jump_energies(
        &self,
        _mode: Self::Mode,
        _index: usize,
        _point: &Point<S, N, P>,
        _after: &Jump<S, Self::Mode, N>,
    ) -> [S; P] {
        [S::ZERO; P]
    }

    /// The outputs at a point of `mode`; by default the state variables, and zero for every other output.
    #[inline]
    fn outputs<'a>(&self, _mode: Self::Mode, point: &'a Point<S, N, P>) -> Outputs<'a, S> {
        Outputs::of_state(&point.state)
    }

    /// Whether guard number `index` of `mode` is an impact.
    #[inline]
    fn is_impact(&self, _mode: Self::Mode, _index: usize) -> bool {
        false
    }

    /// The scales of the errors for the step control.
    fn error_scale(&self) -> ErrorScale<S>;

    /// Checks that `state` is within the domain of the model.
    ///
    /// # Errors
    /// The name and the value in SI units of the quantity outside the domain.
    #[inline]
    fn check(&self, _mode: Self::Mode, _state: &[S; N]) -> Result<(), (&'static str, S)> {
        Ok(())
    }
}

/// The complete state of a simulation. A copy, or a state restored from a snapshot, resumes with the same bits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HybridState<S, Mode, const N: usize, const P: usize> {
    /// Simulated time.
    pub clock: Instant,
    /// The mode.
    pub mode: Mode,
    /// State, derivative and powers.
    pub point: Point<S, N, P>,
    armed: bool,
    control: ControlMemory<S>,
    /// Ticks since the start or the last event, saturating.
    since_event: u32,
    /// Number of successive events, each within a nanosecond of the event before.
    crowded_events: u8,
}

impl<S: Scalar, Mode: Copy, const N: usize, const P: usize> HybridState<S, Mode, N, P> {
    /// The state of `automaton` at time zero, in `mode`, at `state`.
    pub fn start<A, E, C>(automaton: &A, mode: Mode, state: [S; N], excitation: &E, control: &C) -> Self
    where
        A: Automaton<S, N, P, Mode = Mode>,
        E: Excitation<S>,
        C: StepControl<S>,
    {
        let input = excitation.acceleration(Instant::START);
        Self {
            clock: Instant::START,
            mode,
            point: Point::at(&automaton.flow(mode), state, input),
            armed: true,
            control: control.start(&automaton.error_scale()),
            since_event: 0,
            crowded_events: 0,
        }
    }

    /// Whether the guards are watched.
    pub(crate) fn is_armed(&self) -> bool {
        self.armed
    }

    /// This state with its guards unwatched until [`Automaton::rearms`] returns true: for a start at which a
    /// guard is zero with zero rate.
    pub(crate) fn disarmed(self) -> Self {
        Self { armed: false, ..self }
    }
}

snapshot_fields!(impl [S: Scalar, Mode: Snapshot, const N: usize, const P: usize] HybridState<S, Mode, N, P> {
    clock, mode, point, armed, control, since_event, crowded_events,
} if |state| state.crowded_events <= driver::MOST_CROWDED_EVENTS);
