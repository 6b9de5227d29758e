//! Hybrid systems: flows joined by events.
//!
//! A harvester that hits a stop or sticks to a surface is a hybrid automaton: in each *mode* it
//! follows a smooth *flow*; a *guard* is positive while the mode lasts, and where it falls through
//! zero a *jump* gives the next mode and state. An [`Automaton`] states these as pure functions
//! and holds parameters only. The [`Driver`] advances a [`HybridState`] and knows no physics.

mod attempt;
mod driver;
mod locate;

use core::fmt::Debug;

use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::integrate::Cubic;
use crate::integrate::step_control::{ControlMemory, ErrorScale};
use crate::integrate::{Point, StepControl, System};
use crate::observer::Outputs;
use crate::scalar::Scalar;
use crate::snapshot::{Snapshot, snapshot_fields};

pub use driver::{Advance, Driver, Ended, LEAST_BUDGET, StepError, StepFailure, Work};

/// A guard and its rate of change along the flow.
///
/// Positive while the mode lasts; the event is where it falls through zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard<S> {
    /// The value.
    pub value: S,
    /// Its time derivative along the flow.
    pub rate: S,
}

impl<S: Scalar> Guard<S> {
    /// Whether the event is already due: below zero, or at zero and falling.
    #[inline(always)]
    fn is_due(&self) -> bool {
        self.value < S::ZERO || self.value == S::ZERO && self.rate < S::ZERO
    }

    /// The guard over a step that starts here and ends at `end`.
    #[inline(always)]
    fn until(&self, end: &Self, step: S) -> Cubic<S> {
        Cubic::new(self.value, self.rate, end.value, end.rate, step)
    }
}

/// What happens at an event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump<S, Mode, const N: usize> {
    /// The mode after the event.
    pub mode: Mode,
    /// The state after the event.
    pub state: [S; N],
    /// What rounding took from it; see [`Point::remainder`].
    pub remainder: [S; N],
    /// The derivative after the event, in the new mode.
    pub derivative: [S; N],
    /// Energy lost in the event, in joules.
    pub loss: S,
    /// Whether the guards of the new mode are watched from the start. `false` where one of them
    /// starts at zero with no rate; then [`Automaton::rearms`] says when they are watched.
    pub armed: bool,
}

/// The excitation at one instant: evaluated where it is asked for.
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
    #[inline(always)]
    pub fn acceleration<S: Scalar>(&self) -> S
    where
        E: Excitation<S>,
    {
        self.excitation.acceleration(self.at)
    }

    /// Time derivative of the base acceleration in m/s³.
    #[inline(always)]
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

    /// Number of guards of `mode`, at most 32; by default none, for a system without events.
    #[inline(always)]
    fn guards(&self, _mode: Self::Mode) -> usize {
        0
    }

    /// Guard number `index` of `mode`.
    ///
    /// Where `armed` is false the guard is to be lowered by a margin of rounding size, so that it
    /// cannot fire at its start but still catches a state that sinks through.
    #[inline(always)]
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

    /// Whether guards that were left unwatched by a jump into `mode` can be watched from here on.
    #[inline(always)]
    fn rearms(&self, _mode: Self::Mode, _point: &Point<S, N, P>) -> bool {
        true
    }

    /// What happens where guard number `index` of `mode` falls through zero.
    ///
    /// `step` is the length in seconds of the step that is to follow: a derivative that changes
    /// within a boundary layer much thinner than that is best given as it is beyond the layer.
    #[inline(always)]
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

    /// The part of each power that passes in no time in that jump, to `after`, in joules: a capacitor that
    /// is joined to another shares its charge at once.
    #[inline(always)]
    fn jump_energies(
        &self,
        _mode: Self::Mode,
        _index: usize,
        _point: &Point<S, N, P>,
        _after: &Jump<S, Self::Mode, N>,
    ) -> [S; P] {
        [S::ZERO; P]
    }

    /// The outputs at a point of `mode`; by default zeros with the state variables.
    #[inline(always)]
    fn outputs<'a>(&self, _mode: Self::Mode, point: &'a Point<S, N, P>) -> Outputs<'a, S> {
        Outputs::of_state(&point.state)
    }

    /// Whether the moving part sticks in `mode`.
    #[inline(always)]
    fn is_stick(&self, _mode: Self::Mode) -> bool {
        false
    }

    /// Whether guard number `index` of `mode` is an impact.
    #[inline(always)]
    fn is_impact(&self, _mode: Self::Mode, _index: usize) -> bool {
        false
    }

    /// The scales by which the step control measures errors.
    fn error_scale(&self) -> ErrorScale<S>;

    /// Whether the model holds at `state`; if not, the quantity that left its domain and its value.
    ///
    /// # Errors
    /// The name and the value of the quantity.
    #[inline(always)]
    fn check(&self, _mode: Self::Mode, _state: &[S; N]) -> Result<(), (&'static str, S)> {
        Ok(())
    }
}

/// Everything that changes while a hybrid system runs: a plain value that can be copied, saved,
/// compared and restored, and resumes with the same bits.
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
    /// Ticks since the last event, saturating.
    since_event: u32,
    /// Events in a row that followed the one before within a nanosecond.
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
            since_event: u32::MAX,
            crowded_events: 0,
        }
    }

    /// Whether the guards are watched.
    pub(crate) fn is_armed(&self) -> bool {
        self.armed
    }

    /// The same state with its guards not watched until [`Automaton::rearms`] says so: for a start
    /// at which a guard is zero with no rate.
    #[must_use]
    pub(crate) fn disarmed(self) -> Self {
        Self { armed: false, ..self }
    }
}

snapshot_fields!(impl [S: Scalar, Mode: Snapshot, const N: usize, const P: usize] HybridState<S, Mode, N, P> {
    clock, mode, point, armed, control, since_event, crowded_events,
} if |state| state.crowded_events <= driver::MOST_CROWDED_EVENTS);
