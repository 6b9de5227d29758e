//! A step of a method that predicts the motion: its event is located on the prediction, before the circuit is solved.

use super::attempt::{Attempts, MOST_GUARDS};
use super::search::{Fall, Next, Reached, Search};
use super::{Automaton, Guard};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, Trial};
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
            Reached::Near { missing, curved } => self.extend(trial, ticks, missing, curved),
        }
        !search.predicted && self.turns(search, index, &{ trial.end })
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
            None => match self.expected_fall(search.ticks, &end, 0) {
                Some(fall) => search.approach(fall),
                None => self.stretches(search, &end),
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

    /// Whether the step is stretched to a guard that falls soon after its end.
    ///
    /// A step that ended just before an event would be followed by a short one.
    #[inline]
    fn stretches(&self, search: &mut Search<S>, end: &Point<S, N, P>) -> bool {
        if search.ticks >= search.most {
            return false;
        }
        let margin = seconds_of_ticks::<S>(search.most - search.ticks);
        for index in 0..self.automaton.guards(self.mode).min(MOST_GUARDS) {
            let Guard { value, rate } = self.guard(index, end, search.ticks);
            if value < -rate * margin {
                search.stretch(index, value / -rate);
                return true;
            }
        }
        false
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
        match self.expected_fall(search.ticks, end, search.done) {
            Some(fall) => search.approach(fall),
            None => false,
        }
    }

    /// The guard that falls first in the step to `end` of those that are at or below zero there and were not due at the
    /// start, without a bit in `done`. A graze that is expected before it does not hide it.
    fn certain_fall(&self, ticks: u32, end: &Point<S, N, P>, done: u32) -> Option<Fall<S>> {
        let guards = 0..self.automaton.guards(self.mode).min(MOST_GUARDS);
        let done = guards.fold(done, |done, index| {
            let rises = self.guard(index, end, ticks).value > S::ZERO;
            done | u32::from(rises || self.guard(index, self.start, 0).is_due()) << index
        });
        self.expected_fall(ticks, end, done)
    }

    /// The guard that is expected to fall first in the step to `point`, among those without a bit in `done`.
    #[inline(always)]
    fn expected_fall(&self, ticks: u32, point: &Point<S, N, P>, done: u32) -> Option<Fall<S>> {
        // Unrolled for two guards, without a closure: the numbers of the guards are then constants, and the points need
        // not be in memory.
        let guards = self.automaton.guards(self.mode).min(MOST_GUARDS);
        let mut first = None;
        if guards > 0 {
            first = self.earlier_fall(0, ticks, point, done, first);
        }
        if guards > 1 {
            first = self.earlier_fall(1, ticks, point, done, first);
        }
        for index in 2..guards {
            first = self.earlier_fall(index, ticks, point, done, first);
        }
        first
    }

    /// The earlier of `first` and the expected fall of guard `index`.
    #[inline(always)]
    fn earlier_fall(
        &self,
        index: usize,
        ticks: u32,
        point: &Point<S, N, P>,
        done: u32,
        first: Option<Fall<S>>,
    ) -> Option<Fall<S>> {
        let end = self.guard(index, point, ticks);
        if end.value > S::ZERO && !(end.rate > S::ZERO) || done & (1 << index) != 0 {
            return first;
        }
        let (start, step) = (self.guard(index, self.start, 0), seconds_of_ticks(ticks));
        // A guard that rises at both ends can have a minimum, but not below zero if its cubic's third Bernstein coefficient is above.
        let least = S::from_f64(1.0 / 3.0) * step * end.rate.max(S::ZERO);
        if end.value > least && !(start.rate < S::ZERO) {
            return first;
        }
        let margin = S::from_f64(NEAR_ZERO) * (start.value + end.value);
        match start.until(&end, step).approximate_fall(margin) {
            Some(theta) if first.is_none_or(|earliest| theta < earliest.theta) => {
                Some(Fall { index, theta, certain: !(end.value > S::ZERO) })
            }
            _ => first,
        }
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
    }
}
