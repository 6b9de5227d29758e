//! A step of a method that predicts the motion: its event is located on the prediction, before the circuit is solved.

use super::attempt::{Attempts, Memo, bit};
use super::search::{Extension, Fall, Next, Reached, Search, ticks_after};
use super::{Automaton, Guard};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, StepControl, System, Trial};
use crate::scalar::{Scalar, add_increment};

/// The least value of a guard along its cubic, relative to its values at both ends, below which the prediction is
/// evaluated there. The cubic's own error is a hundredth of this.
const NEAR_ZERO: f64 = 1.0 / 64.0;

impl<S, A, E, M, C, const N: usize, const P: usize> Attempts<'_, S, A, E, M, C, N, P>
where
    S: Scalar,
    A: Automaton<S, N, P>,
    E: Excitation<S>,
    M: Method<S>,
    C: StepControl<S>,
{
    /// Attempts the step of `search`, or to the first guard that falls along the predicted motion.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
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
    pub(super) fn must_repeat(
        &self,
        trial: &mut Trial<S, N, P>,
        search: &mut Search<S>,
        memo: &mut Memo<S>,
    ) -> bool {
        let fallen = match search.event {
            None if search.predicted => self.fallen(&trial.end, search.ticks, memo),
            event => event,
        };
        if let Some(index) = fallen {
            // Another end follows, or a jump.
            *memo = Memo::EMPTY;
            // Copies, here and below: every attempt would otherwise be written to memory.
            match self.reaches(search, index, &{ trial.end }) {
                Reached::Clear if search.event.is_some() => {}
                Reached::Near { missing: mut more, mut curved } => {
                    let (ticks, mut missing) = (search.ticks, S::ZERO);
                    loop {
                        self.extend(trial, ticks, more, curved);
                        missing += more;
                        search.ticks = ticks_after(ticks, missing);
                        let Some(index) = search.event.filter(|_| curved) else { break };
                        // The tangent misses the event by the square of the time.
                        let guard = self.guard(index, &trial.end, search.ticks);
                        (more, curved) = (guard.value / -guard.rate, false);
                        let is_within = ticks_after(ticks, missing + more) <= search.most;
                        if !(guard.rate < S::ZERO && more.abs() < missing.abs() && is_within) {
                            break;
                        }
                    }
                    let Trial { end, energies, .. } = trial;
                    let flow = self.automaton.flow(self.mode);
                    flow.correct_energies(&self.start.state, &end.state, energies);
                }
                reached => return matches!(reached, Reached::Beyond),
            }
        }
        // Without a prediction only an attempt shows whether a guard falls.
        !search.predicted && {
            search.done |= search.event.map_or(0, bit);
            self.approaches(search, &{ trial.end })
        }
    }

    /// What follows an attempt to `end` at which guard `index` has fallen or was to fall.
    #[cold]
    #[inline(never)]
    fn reaches(&self, search: &mut Search<S>, index: usize, end: &Point<S, N, P>) -> Reached<S> {
        let (ticks, extension) = (search.ticks, self.extension());
        let (mut guard, mut sooner) = (Guard { value: S::ONE, rate: S::ZERO }, (S::INFINITY, index));
        let mut others_fell = false;
        self.each_guard(end, ticks, |other, Guard { value, rate }| {
            let missing = value / -rate;
            if other == index {
                guard = Guard { value, rate };
            } else {
                others_fell |= !(value > S::ZERO);
                if rate < S::ZERO && missing < sooner.0 && extension.is_near(missing, ticks) {
                    sooner = (missing, other);
                }
            }
        });
        let reached = search.reach(&guard, index, &extension);
        if matches!(reached, Reached::Past) {
            return if self.approaches(search, end) { Reached::Beyond } else { Reached::Clear };
        }
        // The predicted circuit can conduct before an impact, and that of the attempt after it.
        if others_fell
            && (guard.value > S::ZERO || !matches!(reached, Reached::Beyond))
            && let Some(fall) = self.expected_fall([ticks; 2], end, bit(index), true)
            && search.return_to(fall, index, ticks)
        {
            return Reached::Beyond;
        }
        let Reached::Near { mut missing, curved } = reached else { return reached };
        // The order of events within the time that an attempt is extended over is that of their guards' tangents.
        search.event = Some(index);
        if sooner.0 < missing {
            (missing, search.event) = (sooner.0, Some(sooner.1));
        }
        Reached::Near { missing, curved }
    }

    /// The limits of an extension of an attempt.
    #[inline]
    fn extension(&self) -> Extension<S> {
        let flow = self.automaton.flow(self.mode);
        Extension {
            angular_frequency: self.scale.angular_frequency,
            in_layer: self.after_jump && flow.boundary_layer(&self.start.state).is_some(),
            cube: (S::from_f64(<A::Flow<'_> as System<S, N, P>>::EXTENSION_PART) * self.accuracy())
                .max(S::EPSILON),
        }
    }

    /// Whether the search for an event along the predicted motion needs a prediction of [`Search::ticks`].
    #[inline(always)]
    fn continues(&self, search: &mut Search<S>, prediction: &M::Prediction) -> bool {
        let end = self.predicted_end(search.ticks, prediction);
        match search.event {
            None => self
                .expected_fall([search.ticks, search.most], &end, 0, false)
                .is_some_and(|fall| search.approach(fall)),
            // A copy: the end of every prediction would otherwise be written to memory.
            Some(index) => self.narrows(search, index, &{ end }),
        }
    }

    /// Whether the search for the fall of guard `index` needs another prediction than that to `end`.
    #[cold]
    #[inline(never)]
    fn narrows(&self, search: &mut Search<S>, index: usize, end: &Point<S, N, P>) -> bool {
        let done = search.done | bit(index);
        match search.advance(&self.guard(index, end, search.ticks), &self.extension()) {
            Next::Located => {
                // Along the whole step the fall of another guard can be hidden, as a slider's turn just beyond the centre.
                search.done = done;
                self.approaches(search, end)
            }
            // Another guard that is below zero falls before one that is above. Beyond its fall the first one can be without
            // meaning: the voltage of a parasitic capacitance has a pole at a gap below zero.
            Next::Half(half) => {
                let Some(fall) = self.expected_fall([search.ticks; 2], end, done, true) else {
                    search.ticks = half;
                    return true;
                };
                search.done = done;
                search.approach(fall)
            }
            Next::Near(ticks) => {
                search.ticks = ticks;
                true
            }
        }
    }

    /// Whether a guard that was not located is expected to fall before `end`. The search then continues there.
    #[cold]
    #[inline(never)]
    fn approaches(&self, search: &mut Search<S>, end: &Point<S, N, P>) -> bool {
        let fall = self.expected_fall([search.ticks; 2], end, search.done, false);
        fall.is_some_and(|fall| search.approach(fall))
    }

    /// The guard that is expected to fall first in the step of `ticks` to `point`, or soon after it within `most`, among
    /// those without a bit in `done`; if `certain`, among those that are at or below zero there and were not due at the
    /// start. A graze that is expected before it does not hide it.
    #[inline(always)]
    fn expected_fall(
        &self,
        [ticks, most]: [u32; 2],
        point: &Point<S, N, P>,
        done: u32,
        certain: bool,
    ) -> Option<Fall> {
        let [step, beyond] = [ticks, most.saturating_sub(ticks)].map(seconds_of_ticks::<S>);
        let mut first: Option<Fall> = None;
        self.each_guard(point, ticks, |index, end| {
            let (is_above, rises) = (end.value > S::ZERO, end.rate > S::ZERO);
            // Without a start the guard falls soon after the end: a step that ended just before an event would be followed by
            // a short one.
            let stays = is_above && (certain || !rises && !(end.value < -end.rate * beyond));
            if stays || done & bit(index) != 0 {
                return;
            }
            let start = (!is_above || rises).then(|| self.start_guard(index));
            // A guard that rises at both ends can have a minimum, but not below zero if the third Bernstein coefficient is above.
            let least = S::from_f64(1.0 / 3.0) * step * end.rate.max(S::ZERO);
            if start.as_ref().is_some_and(|start| {
                end.value > least && !(start.rate < S::ZERO) || certain && start.is_due()
            }) {
                return;
            }
            let falls = approximate_fall(start, end, [ticks, most]);
            if let Some(ticks) = falls
                && first.is_none_or(|earliest| ticks < earliest.ticks)
            {
                first = Some(Fall { index, ticks, certain: !is_above });
            }
        });
        first
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
        for ((energy, &from), to) in trial.energies.iter_mut().zip(&start.powers).zip(&mut end.powers) {
            let turn = bend(*energy, from, *to);
            *energy += missing * (*to + half * turn);
            *to += missing * turn;
        }
    }
}

/// A guess of the ticks at which a guard falls in a step of `ticks` or, without a value at its start, after it within `most`.
#[cold]
#[inline(never)]
fn approximate_fall<S: Scalar>(
    start: Option<Guard<S>>,
    end: Guard<S>,
    [ticks, most]: [u32; 2],
) -> Option<u32> {
    let Some(start) = start else {
        return Some(ticks_after(ticks, end.value / -end.rate).min(most));
    };
    let margin = S::from_f64(NEAR_ZERO) * (start.value + end.value);
    let theta = start.until(&end, seconds_of_ticks(ticks)).approximate_fall(margin)?;
    Some((theta * S::from_u32(ticks)).to_u32().max(1).min(ticks))
}
