//! Finding the tick at which a guard falls through zero.

use super::{Automaton, Guard, InputAt, Work};
use crate::clock::{Instant, seconds_of_ticks};
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, Trial};
use crate::scalar::Scalar;

/// Guards that a mode may have: each has a bit in the set of those located in a step.
pub(super) const MOST_GUARDS: usize = 32;
/// Attempts that the events of one step may take to locate. Newton needs two or three for one;
/// bisection of 2³² ticks, 32.
pub(super) const MOST_ATTEMPTS: u32 = 40;

/// One mode of one automaton from one start: what every attempt of a location has in common.
pub(super) struct Attempts<'a, S, A, E, M, const N: usize, const P: usize>
where
    S: Scalar,
    A: Automaton<S, N, P>,
{
    pub(super) automaton: &'a A,
    pub(super) mode: A::Mode,
    pub(super) armed: bool,
    pub(super) start: &'a Point<S, N, P>,
    pub(super) clock: Instant,
    pub(super) excitation: &'a E,
    pub(super) method: &'a M,
    pub(super) accuracy: S,
}

impl<S, A, E, M, const N: usize, const P: usize> Clone for Attempts<'_, S, A, E, M, N, P>
where
    S: Scalar,
    A: Automaton<S, N, P>,
{
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, A, E, M, const N: usize, const P: usize> Copy for Attempts<'_, S, A, E, M, N, P>
where
    S: Scalar,
    A: Automaton<S, N, P>,
{
}

/// The end of a search.
pub(super) struct Located<S, const N: usize, const P: usize> {
    pub(super) trial: Trial<S, N, P>,
    pub(super) ticks: u32,
    /// Whether the guard did fall: the dense output may promise a graze that the step itself misses.
    pub(super) fell: bool,
}

impl<S, A, E, M, const N: usize, const P: usize> Attempts<'_, S, A, E, M, N, P>
where
    S: Scalar,
    A: Automaton<S, N, P>,
    E: Excitation<S>,
    M: Method<S>,
{
    /// Takes a step of `ticks`.
    #[inline(always)]
    pub(super) fn attempt(&self, ticks: u32) -> Result<Trial<S, N, P>, NotConverged> {
        let flow = self.automaton.flow(self.mode);
        let input = |offset: u32| self.excitation.acceleration(self.clock.after(offset));
        self.method.attempt(&flow, self.start, input, ticks, self.accuracy)
    }

    /// Guard number `index` at a point `ticks` into the step.
    #[inline(always)]
    pub(super) fn guard(&self, index: usize, point: &Point<S, N, P>, ticks: u32) -> Guard<S> {
        let moment = InputAt::new(self.excitation, self.clock.after(ticks));
        self.automaton.guard(self.mode, index, self.armed, point, &moment)
    }

    /// The guard, without those whose bit is in `done`, that falls first in the step to `trial`, with
    /// the fraction of the step at which the dense output has it.
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

    /// Steps from the start to the tick at which guard `index` falls through zero: a tick on the
    /// far side, the first as far as rounding tells, found by Newton's iteration on steps taken anew, in a bracket.
    ///
    /// Positions in the step are whole ticks from its start, so nothing is lost to the size of
    /// absolute time.
    #[cold]
    #[inline(never)]
    pub(super) fn locate(
        self,
        index: usize,
        theta: S,
        full: Trial<S, N, P>,
        full_ticks: u32,
        most_attempts: u32,
        work: &mut Work,
    ) -> Result<Located<S, N, P>, NotConverged> {
        let mut reached = Located { trial: full, ticks: full_ticks, fell: false };
        let mut attempts = 0;
        // The largest number of ticks known to stop short, the smallest known to reach the far side.
        let mut short = 0;
        let mut far = full_ticks.saturating_add(1);
        if self.guard(index, &full.end, full_ticks).value <= S::ZERO {
            (far, reached.fell) = (full_ticks, true);
        }
        // What rounding leaves undecided.
        let blur = (S::from_u32(full_ticks) * S::EPSILON * S::from_f64(8.0)).to_u32().max(1);
        let mut ticks = (theta * S::from_u32(full_ticks)).to_u32().saturating_add(1);
        while far - short > 1 && attempts < most_attempts {
            // Not `clamp`, which can panic: `far` stays above `short + 1` here.
            ticks = ticks.max(short + 1).min(far - 1);
            attempts += 1;
            work.locating += 1;
            let trial = self.attempt(ticks)?;
            work.iterations = work.iterations.saturating_add(trial.iterations);
            let guard = self.guard(index, &trial.end, ticks);
            let fallen = guard.value <= S::ZERO;
            if fallen || !reached.fell {
                (reached.trial, reached.ticks, reached.fell) = (trial, ticks, fallen);
            }
            if fallen {
                far = ticks
            } else {
                short = ticks
            }
            if !fallen && !(guard.rate < S::ZERO) && far > full_ticks {
                // The lowest point has been passed above zero: a graze that does not touch.
                return Ok(reached);
            }
            let correction = (guard.value / guard.rate).abs() / seconds_of_ticks(1);
            let correction = if guard.rate < S::ZERO { correction.to_u32() } else { u32::MAX };
            if fallen && correction < blur || far - short <= blur {
                break;
            }
            ticks = if correction > far - short {
                short + (far - short) / 2
            } else if fallen {
                ticks.saturating_sub(correction)
            } else {
                // A little further than the estimate, to land on the far side.
                ticks.saturating_add(correction).saturating_add(blur)
            };
        }
        Ok(reached)
    }
}
