//! A step of a method that predicts the motion: its event is located on the prediction, before the circuit is solved.

use super::attempt::Attempts;
use super::search::{Fall, Next, Reached, Search, ticks_after};
use super::{Automaton, Guard};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, System, Trial};
use crate::scalar::{Scalar, add_increment};

/// The least value of a guard along its cubic, relative to its values at both ends, below which the prediction is
/// evaluated there. The cubic's own error is a hundredth of this.
const NEAR_ZERO: f64 = 1.0 / 64.0;

impl<S: Scalar, A: Automaton<S, N, P>, E: Excitation<S>, M: Method<S>, const N: usize, const P: usize>
    Attempts<'_, S, A, E, M, N, P>
{
    /// Attempts the step of `search`, or to the first guard that falls along the predicted motion.
    #[inline(always)]
    pub(super) fn attempt_to_event(&self, search: &mut Search<S>) -> Result<Trial<S, N, P>, NotConverged> {
        // One call of `predict` and one of `attempt`, which are long and inlined.
        loop {
            let prediction = self.predict(search.ticks);
            if let Some(predicted) = &prediction
                && search.left > 0
                && self.continues(search, predicted)
            {
                continue;
            }
            search.predicted = prediction.is_some();
            return self.attempt(search.ticks, prediction.as_ref());
        }
    }

    /// Whether an attempted step must be repeated with [`Search::ticks`] to end at the fall of a guard.
    #[inline(always)]
    pub(super) fn must_repeat(&self, trial: &mut Trial<S, N, P>, search: &mut Search<S>) -> bool {
        let fallen = match search.event {
            None if search.predicted => self.fallen(&trial.end, search.ticks),
            // Without a prediction only an attempt shows whether a guard falls.
            None => return self.approaches(search, &{ trial.end }),
            event => event,
        };
        let Some(index) = fallen else { return false };
        let ticks = search.ticks;
        let guard = self.guard(index, &trial.end, ticks);
        match search.reach(&guard, index) {
            Reached::Past => return self.approaches(search, &{ trial.end }),
            Reached::Beyond => {
                if guard.value > S::ZERO {
                    self.returns(search, index, ticks, &{ trial.end });
                }
                return true;
            }
            Reached::Clear | Reached::Near { .. } if self.returns(search, index, ticks, &{ trial.end }) => {
                return true;
            }
            Reached::Clear if search.event.is_none() => return false,
            Reached::Clear => {}
            Reached::Near { missing, curved } => {
                let mut missing = self.first_within(search, index, missing, &{ trial.end });
                self.extend(trial, ticks, missing, curved);
                if curved && let Some(index) = search.event {
                    // The tangent misses the event by the square of the time.
                    let guard = self.guard(index, &trial.end, ticks_after(ticks, missing));
                    let more = guard.value / -guard.rate;
                    let is_within = ticks_after(ticks, missing + more) <= search.most;
                    if guard.rate < S::ZERO && more.abs() < missing.abs() && is_within {
                        self.extend(trial, ticks, more, false);
                        missing += more;
                    }
                }
                search.ticks = ticks_after(ticks, missing);
            }
        }
        !search.predicted && self.turns(search, search.event.unwrap_or(index), &{ trial.end })
    }

    /// The seconds from the end of an attempt to the first fall of a guard, at most `missing` to that of guard `index`. The
    /// search ends at that guard.
    ///
    /// The order of events within the time that an attempt is extended over is that of their guards' tangents.
    #[cold]
    #[inline(never)]
    fn first_within(&self, search: &mut Search<S>, index: usize, missing: S, end: &Point<S, N, P>) -> S {
        let mut first = missing;
        search.event = Some(index);
        self.each_guard(end, search.ticks, |other, Guard { value, rate }| {
            let missing = value / -rate;
            if other != index && rate < S::ZERO && missing < first && search.is_near(missing) {
                (first, search.event) = (missing, Some(other));
            }
        });
        first
    }

    /// Whether the search for an event returns to another guard that has fallen in an attempt of `ticks`.
    ///
    /// The predicted circuit can conduct before an impact, and that of the attempt after it.
    #[cold]
    #[inline(never)]
    fn returns(&self, search: &mut Search<S>, index: usize, ticks: u32, end: &Point<S, N, P>) -> bool {
        match self.certain_fall(ticks, end, 1 << index) {
            Some(fall) => search.return_to(fall, index, ticks),
            None => false,
        }
    }

    /// Whether the search for an event along the predicted motion needs a prediction of [`Search::ticks`].
    #[inline]
    fn continues(&self, search: &mut Search<S>, prediction: &M::Prediction) -> bool {
        let end = self.predicted_end(search.ticks, prediction);
        match search.event {
            None => match self.expected_fall([search.ticks, search.most], &end, 0) {
                Some(fall) => search.approach(fall),
                None => false,
            },
            // Copies: the end of every prediction would otherwise be written to memory.
            Some(index) => match search.advance(&self.guard(index, &end, search.ticks)) {
                Next::Located => self.turns(search, index, &{ end }),
                Next::Half(_) if self.turns_early(search, index, &{ end }) => true,
                Next::Near(ticks) | Next::Half(ticks) => {
                    search.ticks = ticks;
                    true
                }
            },
        }
    }

    /// Whether the search turns to another guard that falls before the located one.
    ///
    /// Along the whole step such a fall can be hidden, as a slider's turn just beyond the centre.
    #[cold]
    #[inline(never)]
    fn turns(&self, search: &mut Search<S>, index: usize, end: &Point<S, N, P>) -> bool {
        search.done |= 1 << index;
        self.approaches(search, end)
    }

    /// Whether the search leaves a guard that is above zero at `end` for another one that is below zero there.
    ///
    /// The other one falls first. Beyond its fall the first one can be without meaning: the voltage of a parasitic
    /// capacitance has a pole at a gap below zero.
    #[cold]
    #[inline(never)]
    fn turns_early(&self, search: &mut Search<S>, index: usize, end: &Point<S, N, P>) -> bool {
        let done = search.done | 1 << index;
        let Some(fall) = self.certain_fall(search.ticks, end, done) else { return false };
        search.done = done;
        search.approach(fall)
    }

    /// Whether a guard that was not located is expected to fall before `end`. The search then continues there.
    #[cold]
    #[inline(never)]
    fn approaches(&self, search: &mut Search<S>, end: &Point<S, N, P>) -> bool {
        match self.expected_fall([search.ticks; 2], end, search.done) {
            Some(fall) => search.approach(fall),
            None => false,
        }
    }

    /// The guard that falls first in the step to `end` of those that are at or below zero there and were not due at the
    /// start, without a bit in `done`. A graze that is expected before it does not hide it.
    fn certain_fall(&self, ticks: u32, end: &Point<S, N, P>, done: u32) -> Option<Fall> {
        let mut stay = done;
        self.each_guard(end, ticks, |index, guard| {
            let stays = guard.value > S::ZERO || self.guard(index, self.start, 0).is_due();
            stay |= u32::from(stays) << index;
        });
        self.expected_fall([ticks; 2], end, stay)
    }

    /// The guard that is expected to fall first in the step of `ticks` to `point`, or soon after it within `most`, among
    /// those without a bit in `done`.
    #[inline(always)]
    fn expected_fall(&self, [ticks, most]: [u32; 2], point: &Point<S, N, P>, done: u32) -> Option<Fall> {
        let mut first: Option<Fall> = None;
        self.each_guard(point, ticks, |index, end| {
            if done & (1 << index) == 0
                && let Some(ticks) = self.fall_of(index, &end, [ticks, most])
                && first.is_none_or(|earliest| ticks < earliest.ticks)
            {
                first = Some(Fall { index, ticks, certain: !(end.value > S::ZERO) });
            }
        });
        first
    }

    /// A guess of the ticks at which guard `index` falls in a step to `end`, or soon after it within `most`.
    #[inline(always)]
    fn fall_of(&self, index: usize, end: &Guard<S>, [ticks, most]: [u32; 2]) -> Option<u32> {
        if end.value > S::ZERO && !(end.rate > S::ZERO) {
            // A step that ended just before an event would be followed by a short one.
            let soon = end.value < -end.rate * seconds_of_ticks(most.saturating_sub(ticks));
            return soon.then(|| ticks_after(ticks, end.value / -end.rate).min(most));
        }
        let (start, step) = (self.guard(index, self.start, 0), seconds_of_ticks(ticks));
        // A guard that rises at both ends can have a minimum, but not below zero if its cubic's third Bernstein coefficient is above.
        let least = S::from_f64(1.0 / 3.0) * step * end.rate.max(S::ZERO);
        if end.value > least && !(start.rate < S::ZERO) {
            return None;
        }
        let margin = S::from_f64(NEAR_ZERO) * (start.value + end.value);
        let theta = start.until(end, step).approximate_fall(margin)?;
        Some((theta * S::from_u32(ticks)).to_u32().max(1).min(ticks))
    }

    /// Extends a step of `ticks` by `missing` seconds, which may be negative: along its derivative at the end or, if
    /// it is `curved`, along the parabola that has value, slope and curvature of the step's cubic at its end.
    #[inline(always)]
    fn extend(&self, trial: &mut Trial<S, N, P>, ticks: u32, missing: S, curved: bool) {
        let (start, end) = (self.start, &mut trial.end);
        let step = seconds_of_ticks::<S>(ticks);
        let bend = |change: S, before: S, after: S| {
            if !curved {
                return S::ZERO;
            }
            let (before, after) = (before + before, after + after);
            (before + after + after - S::from_f64(6.0) * change / step) / step
        };
        let half = S::from_f64(0.5) * missing;
        for i in 0..N {
            let change = end.state[i] - start.state[i];
            let turn = bend(change, start.derivative[i], end.derivative[i]);
            let increment = missing * (end.derivative[i] + half * turn);
            (end.state[i], end.remainder[i]) = add_increment(end.state[i], end.remainder[i], increment);
            end.derivative[i] += missing * turn;
        }
        for (i, energy) in trial.energies.iter_mut().enumerate() {
            let turn = bend(*energy, start.powers[i], end.powers[i]);
            *energy += missing * (end.powers[i] + half * turn);
            end.powers[i] += missing * turn;
        }
        self.automaton.flow(self.mode).correct_energies(&start.state, &end.state, &mut trial.energies);
    }
}
