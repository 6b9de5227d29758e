//! Attempts steps of one mode from one start, evaluates the guards along them, and locates the tick at which one falls through zero.

use super::{Automaton, Driver, Guard, InputAt, Work};
use crate::clock::{Instant, seconds_of_ticks};
use crate::excitation::Excitation;
use crate::integrate::{Attempt, ErrorScale, InputFrom, Method, NotConverged, Point, StepControl, Trial};
use crate::scalar::Scalar;

/// Largest number of guards of a mode: each has a bit in the set of guards located in a step.
pub(super) const MOST_GUARDS: usize = 32;

/// The bit of a guard.
pub(super) const fn bit(index: usize) -> u32 {
    1_u32.wrapping_shl(index as u32)
}

/// Most attempts to locate the events of one step. Newton's iteration needs two or three per event; bisection of 2³² ticks needs 32.
pub(super) const MOST_ATTEMPTS: u32 = 40;

/// Guards at a point by their numbers, if the automaton [keeps](Automaton::KEEPS_GUARDS) them.
#[derive(Clone, Copy)]
pub(super) struct Memo<S>([Option<Guard<S>>; 5]);

impl<S: Scalar> Memo<S> {
    /// Without guards.
    pub(super) const EMPTY: Self = Self([None; 5]);

    /// Takes all guards at a point. Returns the number of the first one for which `test` holds.
    #[inline]
    pub(super) fn take<A: Automaton<S, N, P>, E: Excitation<S>, const N: usize, const P: usize>(
        &mut self,
        automaton: &A,
        (mode, armed): (A::Mode, bool),
        point: &Point<S, N, P>,
        input: &InputAt<'_, E>,
        test: impl Fn(&Guard<S>) -> bool,
    ) -> Option<usize> {
        let mut first = None;
        automaton.each_guard(mode, armed, point, input, |index, guard| {
            if let Some(entry) = self.0.get_mut(index).filter(|_| A::KEEPS_GUARDS) {
                *entry = Some(guard);
            }
            first = first.or(test(&guard).then_some(index));
        });
        first
    }
}

/// The result of a search.
pub(super) struct Located<S, const N: usize, const P: usize> {
    pub(super) trial: Trial<S, N, P>,
    pub(super) ticks: u32,
    /// Whether the guard fell. The dense output may show a graze that the step itself does not have.
    pub(super) fell: bool,
}

/// The data common to all attempts of one step.
pub(super) struct Attempts<'a, S: Scalar, A: Automaton<S, N, P>, E, M, C, const N: usize, const P: usize> {
    pub(super) automaton: &'a A,
    pub(super) mode: A::Mode,
    pub(super) armed: bool,
    pub(super) start: &'a Point<S, N, P>,
    pub(super) clock: Instant,
    pub(super) excitation: &'a E,
    pub(super) driver: &'a Driver<M, C>,
    pub(super) scale: &'a ErrorScale<S>,
    /// The length of the first attempt.
    pub(super) planned: u32,
    pub(super) after_jump: bool,
    /// Guards at the start.
    pub(super) memo: &'a Memo<S>,
}

impl<'a, S, A, E, M, C, const N: usize, const P: usize> Attempts<'a, S, A, E, M, C, N, P>
where
    S: Scalar,
    A: Automaton<S, N, P>,
    E: Excitation<S>,
    M: Method<S>,
    C: StepControl<S>,
{
    /// A step of `ticks`.
    #[inline]
    fn of(&self, ticks: u32) -> Attempt<'a, S, InputFrom<'a, E>, N, P> {
        let input = InputFrom { excitation: self.excitation, from: self.clock };
        Attempt { start: self.start, input, ticks, accuracy: self.accuracy(), after_jump: self.after_jump }
    }

    /// The accuracy to which implicit equations are solved.
    #[inline]
    pub(super) fn accuracy(&self) -> S {
        self.driver.control.accuracy(self.planned, self.scale)
    }

    /// Predicts a step of `ticks`.
    #[inline(always)]
    pub(super) fn predict(&self, ticks: u32) -> Option<M::Prediction> {
        self.driver.method.predict(&self.automaton.flow(self.mode), &self.of(ticks))
    }

    /// The end of a step of `ticks` as predicted.
    #[inline]
    pub(super) fn predicted_end(&self, ticks: u32, prediction: &M::Prediction) -> Point<S, N, P> {
        self.driver.method.predicted_end(&self.automaton.flow(self.mode), &self.of(ticks), prediction)
    }

    /// Attempts a step of `ticks`, with its prediction.
    #[inline(always)]
    pub(super) fn attempt(
        &self,
        ticks: u32,
        prediction: Option<&M::Prediction>,
    ) -> Result<Trial<S, N, P>, NotConverged> {
        self.driver.method.attempt(&self.automaton.flow(self.mode), &self.of(ticks), prediction)
    }

    /// Guard number `index` at a point `ticks` into the step.
    #[inline]
    pub(super) fn guard(&self, index: usize, point: &Point<S, N, P>, ticks: u32) -> Guard<S> {
        let input = InputAt::new(self.excitation, self.clock.after(ticks));
        self.automaton.guard(self.mode, index, self.armed, point, &input)
    }

    /// Calls `take` with each guard at a point `ticks` into the step.
    #[inline]
    pub(super) fn each_guard(&self, point: &Point<S, N, P>, ticks: u32, take: impl FnMut(usize, Guard<S>)) {
        let input = InputAt::new(self.excitation, self.clock.after(ticks));
        self.automaton.each_guard(self.mode, self.armed, point, &input, take);
    }

    /// Guard number `index` at the start of the step.
    #[inline]
    pub(super) fn start_guard(&self, index: usize) -> Guard<S> {
        let memo = if A::KEEPS_GUARDS { self.memo.0.get(index).copied().flatten() } else { None };
        memo.unwrap_or_else(|| self.guard(index, self.start, 0))
    }

    /// A guard below zero at the end of a step; all of them are put into `memo`.
    #[inline]
    pub(super) fn fallen(&self, end: &Point<S, N, P>, ticks: u32, memo: &mut Memo<S>) -> Option<usize> {
        let (at, input) = ((self.mode, self.armed), InputAt::new(self.excitation, self.clock.after(ticks)));
        memo.take(self.automaton, at, end, &input, |guard| guard.value < S::ZERO)
    }

    /// The guard that falls first in the step to `end`, among those without a bit in `done`, and the
    /// fraction of the step at which the dense output falls through zero.
    #[inline]
    pub(super) fn first_fall(&self, end: &Point<S, N, P>, ticks: u32, done: u32) -> Option<(usize, S)> {
        let mut first = None;
        for index in 0..self.automaton.guards(self.mode).min(MOST_GUARDS) {
            let (start, end) = (self.guard(index, self.start, 0), self.guard(index, end, ticks));
            if done & bit(index) == 0
                && let Some(theta) = start.until(&end, seconds_of_ticks(ticks)).first_fall()
                && first.is_none_or(|(_, earliest)| theta < earliest)
            {
                first = Some((index, theta));
            }
        }
        first
    }

    /// Steps from the start to the tick at which guard `index` falls through zero, by bracketed Newton iteration with
    /// a new step per iterate. The result is the first tick with a guard at or below zero, to within rounding.
    ///
    /// Positions are whole ticks from the start of the step, so they do not depend on absolute time.
    #[cold]
    #[inline(never)]
    pub(super) fn locate(
        &self,
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
        while far.wrapping_sub(short) > 1 && attempts < most_attempts {
            // `clamp` can panic, `max` and `min` cannot: `far` stays above `short + 1` here.
            ticks = ticks.max(short.wrapping_add(1)).min(far.wrapping_sub(1));
            attempts += 1;
            work.locating = work.locating.wrapping_add(1);
            let trial = self.attempt(ticks, None)?;
            work.iterations = work.iterations.saturating_add(trial.iterations);
            let guard = self.guard(index, &trial.end, ticks);
            let fallen = guard.value <= S::ZERO;
            if fallen || !reached.fell {
                (reached.trial, reached.ticks, reached.fell) = (trial, ticks, fallen);
            }
            (short, far) = if fallen { (short, ticks) } else { (ticks, far) };
            if !fallen && !(guard.rate < S::ZERO) && far > full_ticks {
                // The guard has passed a minimum above zero: a graze without contact.
                return Ok(reached);
            }
            let correction = (guard.value / guard.rate).abs() / seconds_of_ticks(1);
            let correction = if guard.rate < S::ZERO { correction.to_u32() } else { u32::MAX };
            if fallen && correction < resolution || far.wrapping_sub(short) <= resolution {
                break;
            }
            ticks = if correction > far.wrapping_sub(short) {
                short.midpoint(far)
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
