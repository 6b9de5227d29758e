//! Locates the tick at which a guard falls through zero.

use super::attempt::Attempts;
use super::{Automaton, Work};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Trial};
use crate::scalar::Scalar;

/// Most attempts to locate the events of one step. Newton's iteration needs two or three per event; bisection
/// of 2³² ticks needs 32.
pub(super) const MOST_ATTEMPTS: u32 = 40;

/// The result of a search.
pub(super) struct Located<S, const N: usize, const P: usize> {
    pub(super) trial: Trial<S, N, P>,
    pub(super) ticks: u32,
    /// Whether the guard fell. The dense output may show a graze that the step itself does not have.
    pub(super) fell: bool,
}

impl<S: Scalar, A: Automaton<S, N, P>, E: Excitation<S>, M: Method<S>, const N: usize, const P: usize>
    Attempts<'_, S, A, E, M, N, P>
{
    /// Steps from the start to the tick at which guard `index` falls through zero, by bracketed Newton iteration with
    /// a new step per iterate. The result is the first tick with a guard at or below zero, to within rounding.
    ///
    /// Positions are whole ticks from the start of the step, so they do not depend on absolute time.
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
        // The bracket in ticks: the guard is positive at `short` and at or below zero at `far`.
        let mut short = 0;
        let mut far = full_ticks.saturating_add(1);
        if self.guard(index, &full.end, full_ticks).value <= S::ZERO {
            (far, reached.fell) = (full_ticks, true);
        }
        // Resolution in ticks that rounding allows.
        let resolution = (S::from_u32(full_ticks) * S::EPSILON * S::from_f64(8.0)).to_u32().max(1);
        let mut ticks = (theta * S::from_u32(full_ticks)).to_u32().saturating_add(1);
        while far - short > 1 && attempts < most_attempts {
            // `clamp` can panic, `max` and `min` cannot: `far` stays above `short + 1` here.
            ticks = ticks.max(short + 1).min(far - 1);
            attempts += 1;
            work.locating += 1;
            let trial = self.attempt(ticks, None)?;
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
                // The guard has passed a minimum above zero: a graze without contact.
                return Ok(reached);
            }
            let correction = (guard.value / guard.rate).abs() / seconds_of_ticks(1);
            let correction = if guard.rate < S::ZERO { correction.to_u32() } else { u32::MAX };
            if fallen && correction < resolution || far - short <= resolution {
                break;
            }
            ticks = if correction > far - short {
                short + (far - short) / 2
            } else if fallen {
                ticks.saturating_sub(correction)
            } else {
                // Overshoot the estimate, to land at or below zero.
                ticks.saturating_add(correction).saturating_add(resolution)
            };
        }
        Ok(reached)
    }
}
