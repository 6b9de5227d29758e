//! Attempts steps of one mode from one start and evaluates the guards along them.

use super::{Automaton, Guard, InputAt};
use crate::clock::{Instant, seconds_of_ticks};
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, Trial};
use crate::scalar::Scalar;

/// Largest number of guards of a mode: each has a bit in the set of guards located in a step.
pub(super) const MOST_GUARDS: usize = 32;

/// The data common to all attempts of one step.
pub(super) struct Attempts<'a, S: Scalar, A: Automaton<S, N, P>, E, M, const N: usize, const P: usize> {
    pub(super) automaton: &'a A,
    pub(super) mode: A::Mode,
    pub(super) armed: bool,
    pub(super) start: &'a Point<S, N, P>,
    pub(super) clock: Instant,
    pub(super) excitation: &'a E,
    pub(super) method: &'a M,
    pub(super) accuracy: S,
}

impl<S: Scalar, A: Automaton<S, N, P>, E, M, const N: usize, const P: usize> Clone
    for Attempts<'_, S, A, E, M, N, P>
{
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Scalar, A: Automaton<S, N, P>, E, M, const N: usize, const P: usize> Copy
    for Attempts<'_, S, A, E, M, N, P>
{
}

impl<S: Scalar, A: Automaton<S, N, P>, E: Excitation<S>, M: Method<S>, const N: usize, const P: usize>
    Attempts<'_, S, A, E, M, N, P>
{
    /// Attempts a step of `ticks`.
    #[inline(always)]
    pub(super) fn attempt(&self, ticks: u32) -> Result<Trial<S, N, P>, NotConverged> {
        let flow = self.automaton.flow(self.mode);
        let input = |offset: u32| self.excitation.acceleration(self.clock.after(offset));
        self.method.attempt(&flow, self.start, input, ticks, self.accuracy)
    }

    /// Guard number `index` at a point `ticks` into the step.
    #[inline(always)]
    pub(super) fn guard(&self, index: usize, point: &Point<S, N, P>, ticks: u32) -> Guard<S> {
        let input = InputAt::new(self.excitation, self.clock.after(ticks));
        self.automaton.guard(self.mode, index, self.armed, point, &input)
    }

    /// The guard that falls first in the step to `trial`, among those without a bit in `done`, and the
    /// fraction of the step at which the dense output falls through zero.
    #[inline(always)]
    pub(super) fn first_fall(&self, trial: &Trial<S, N, P>, ticks: u32, done: u32) -> Option<(usize, S)> {
        let mut first = None;
        for index in 0..self.automaton.guards(self.mode).min(MOST_GUARDS) {
            let (start, end) = (self.guard(index, self.start, 0), self.guard(index, &trial.end, ticks));
            if done & (1 << index) == 0
                && let Some(theta) = start.until(&end, seconds_of_ticks(ticks)).first_fall()
                && first.is_none_or(|(_, earliest)| theta < earliest)
            {
                first = Some((index, theta));
            }
        }
        first
    }
}
