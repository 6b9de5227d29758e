//! A step of a method that predicts the motion: its event is located on the prediction, before the circuit is solved.

use super::attempt::{Attempts, MOST_GUARDS};
use super::{Automaton, Guard};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::integrate::{Method, NotConverged, Point, Trial};
use crate::scalar::{Scalar, add_increment};

/// Most attempts after the first to reach an event. Each is a Newton step from the attempt before; one or two suffice. A step
/// that they do not bring to its event is shortened to before it, by halves: at most 32 more attempts.
const MOST_CORRECTIONS: u32 = 8;
/// Most predictions to locate an event: those that halve a step to a tick, and some more.
const MOST_PREDICTIONS: u32 = 40;
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
            Reached::Kept | Reached::Near { .. } if self.returns(search, index, ticks, &{ trial.end }) => {
                return true;
            }
            Reached::Kept if search.event.is_none() => return false,
            Reached::Kept => {}
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
        let Some(fall) = self.certain_fall(ticks, end, 1 << index) else { return false };
        search.ticks = ticks;
        if search.corrections == 0 {
            search.short = 0;
            return matches!(search.shorten(fall.index), Reached::Beyond);
        }
        search.corrections -= 1;
        (search.done, search.missing) = (1 << index, S::INFINITY);
        search.approach(fall)
    }

    /// Whether the search for an event along the predicted motion needs a prediction of [`Search::ticks`].
    #[inline(always)]
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
    #[inline(always)]
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
        let stays = |index: usize| {
            self.guard(index, end, ticks).value > S::ZERO || self.guard(index, self.start, 0).is_due()
        };
        let guards = 0..self.automaton.guards(self.mode).min(MOST_GUARDS);
        let done = guards.fold(done, |done, index| {
            let bit = 1 << index;
            if done & bit == 0 && stays(index) { done | bit } else { done }
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
        let start = self.guard(index, self.start, 0);
        if end.value > S::ZERO && !(start.rate < S::ZERO) {
            return first;
        }
        let margin = S::from_f64(NEAR_ZERO) * (start.value + end.value);
        match start.until(&end, seconds_of_ticks(ticks)).approximate_fall(margin) {
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

/// The expected fall of a guard.
#[derive(Debug, Clone, Copy)]
struct Fall<S> {
    /// The number of the guard.
    index: usize,
    /// A guess of the fraction of the step at which it falls.
    theta: S,
    /// Whether the guard is at or below zero at the end of the step; if not, it may only graze.
    certain: bool,
}

/// What follows a prediction of an event.
enum Next {
    /// The step ends here.
    Located,
    /// A prediction of so many ticks.
    Near(u32),
    /// A prediction of so many ticks: half of the bracket, since the tangent of a guard above zero leads out of it.
    Half(u32),
}

/// How an attempt ends that was to reach an event.
enum Reached<S> {
    /// It is kept as it is.
    Kept,
    /// The event is `missing` seconds after its end or, below zero, before it, along a parabola if it is `curved`.
    Near { missing: S, curved: bool },
    /// Another attempt is needed.
    Beyond,
    /// The guard has fallen and rises again: the event is before the end.
    Past,
}

/// The search for the event at the end of a step.
pub(super) struct Search<S> {
    /// Length of the step.
    pub(super) ticks: u32,
    /// The guard that falls at its end.
    pub(super) event: Option<usize>,
    /// Whether the motion is predicted.
    predicted: bool,
    /// The bracket along the predicted motion, in ticks: the guard is above zero at `short`.
    short: u32,
    far: u32,
    /// Whether the guard is known to be at or below zero at `far`.
    falls: bool,
    /// Whether the bracket is that of predictions: an attempt can end outside of it.
    of_prediction: bool,
    /// The longest step.
    most: u32,
    /// One bit for each guard that was located: each is located at most once.
    done: u32,
    /// Predictions left.
    left: u32,
    /// Attempts left.
    corrections: u32,
    /// The magnitude in s of the last correction.
    missing: S,
    /// In rad/s, of the motion.
    angular_frequency: S,
    /// Whether the step begins with a jump.
    after_jump: bool,
}

impl<S: Scalar> Search<S> {
    /// Of a step of `ticks`, or of at most `most` if an event follows.
    pub(super) fn within(ticks: u32, most: u32, angular_frequency: S, after_jump: bool) -> Self {
        Self {
            ticks,
            event: None,
            predicted: false,
            short: 0,
            far: ticks,
            falls: false,
            of_prediction: true,
            most,
            done: 0,
            left: MOST_PREDICTIONS,
            corrections: MOST_CORRECTIONS,
            missing: S::INFINITY,
            angular_frequency,
            after_jump,
        }
    }

    /// Whether [`Attempts::extend`] is exact to rounding over a time, or the time is below a tick.
    fn is_near(&self, seconds: S) -> bool {
        // A bounce that is short against a radian must keep its own energy.
        let part = seconds / seconds_of_ticks(self.ticks);
        self.is_brief(seconds) && part * part <= S::EPSILON
            || self.is_curved(seconds)
            || seconds.abs() <= seconds_of_ticks(1)
    }

    /// Whether a line over a time is exact to rounding, in radians of the motion.
    fn is_brief(&self, seconds: S) -> bool {
        let radians = seconds * self.angular_frequency;
        radians * radians <= S::EPSILON
    }

    /// Whether over a time a parabola is exact to rounding and a line is not.
    ///
    /// The step is then longer than the sixth root of a rounding in radians; the parabola of a much shorter one would be
    /// that of its roundings. After a jump the derivative at the start can be that of a boundary layer.
    fn is_curved(&self, seconds: S) -> bool {
        let part = (seconds / seconds_of_ticks(self.ticks)).abs();
        let radians = (seconds * self.angular_frequency).abs();
        let largest = part.max(radians);
        !self.after_jump && !self.is_brief(seconds) && largest * largest * largest <= S::EPSILON
    }

    /// Continues near an expected fall within the present step.
    #[cold]
    fn approach(&mut self, fall: Fall<S>) -> bool {
        self.event = Some(fall.index);
        (self.short, self.far, self.falls) = (0, self.ticks, fall.certain);
        (self.left, self.of_prediction) = (MOST_PREDICTIONS, true);
        self.ticks = (fall.theta * S::from_u32(self.ticks)).to_u32().max(1).min(self.ticks);
        true
    }

    /// Continues beyond the end of the step, where a guard is expected to fall in `missing` seconds.
    #[cold]
    #[inline(never)]
    fn stretch(&mut self, index: usize, missing: S) {
        self.event = Some(index);
        (self.short, self.far, self.falls) = (self.ticks, self.most, false);
        self.of_prediction = true;
        self.ticks = ticks_after(self.ticks, missing).min(self.most);
    }

    /// Takes the guard at the end of a prediction.
    #[cold]
    #[inline(never)]
    fn advance(&mut self, guard: &Guard<S>) -> Next {
        let Guard { value, rate } = *guard;
        let missing = value / -rate;
        self.left -= 1;
        if rate < S::ZERO && self.is_near(missing) || self.far - self.short <= 1 {
            self.left = 0;
            return Next::Located;
        }
        if value > S::ZERO && !(rate < S::ZERO) && !self.falls {
            // The guard has passed a minimum above zero. The step ends here: it is not predicted again.
            self.event = None;
            return Next::Located;
        }
        if value > S::ZERO {
            self.short = self.ticks;
        } else {
            (self.far, self.falls) = (self.ticks, true);
        }
        let there = ticks_after(self.ticks, missing);
        // A fall within the first tick is at its end.
        if rate < S::ZERO && there > self.short && there < self.far {
            return Next::Near(there.max(1));
        }
        let half = (self.short + (self.far - self.short) / 2).max(1);
        if value > S::ZERO { Next::Half(half) } else { Next::Near(half) }
    }

    /// Takes guard `index` at the end of an attempt.
    ///
    /// The attempt is no argument: every attempt would then be written to memory.
    #[cold]
    #[inline(never)]
    fn reach(&mut self, guard: &Guard<S>, index: usize) -> Reached<S> {
        let missing = guard.value / -guard.rate;
        let there = ticks_after(self.ticks, missing);
        if self.of_prediction {
            (self.short, self.falls, self.of_prediction) = (0, false, false);
        }
        if guard.value > S::ZERO {
            self.short = self.ticks;
        } else {
            (self.far, self.falls) = (self.ticks, true);
        }
        self.left = 0;
        self.event = (guard.value <= S::ZERO).then_some(index);
        let is_falling = guard.rate < S::ZERO;
        if !is_falling && guard.value < S::ZERO {
            if self.corrections == 0 {
                return self.shorten(index);
            }
            self.corrections -= 1;
            self.done &= !(1 << index);
            return Reached::Past;
        }
        if !self.falls && (!is_falling || there > self.most) {
            // A graze, or an event beyond the end of the step.
            return Reached::Kept;
        }
        // Where the correction does not shrink, the guard is known no better: its value is a rounding.
        let stalls = missing.abs() > S::from_f64(0.5) * self.missing;
        self.missing = missing.abs();
        if is_falling && (self.is_near(missing) || stalls && self.is_brief(missing)) {
            let curved = self.is_curved(missing);
            (self.ticks, self.event) = (there, Some(index));
            return Reached::Near { missing, curved };
        }
        let is_inside = is_falling && there > self.short && (there < self.far || !self.falls);
        // A guard that is a stair of its roundings leads out of the bracket: the event is at its known end.
        if !is_inside && guard.value <= S::ZERO {
            return Reached::Kept;
        }
        if self.corrections == 0 {
            return if self.event.is_none() { Reached::Kept } else { self.shorten(index) };
        }
        let there = if is_inside { there } else { self.far };
        self.corrections -= 1;
        (self.ticks, self.event) = (there, Some(index));
        Reached::Beyond
    }

    /// Shortens the step to before the fall of guard `index`, or by half, where there are no corrections left.
    fn shorten(&mut self, index: usize) -> Reached<S> {
        if self.ticks <= 1 {
            return Reached::Kept;
        }
        self.ticks = if self.short > 0 { self.short } else { self.ticks / 2 };
        (self.event, self.left) = (Some(index), 0);
        Reached::Beyond
    }
}

/// `ticks` and `missing` seconds, which may be negative, in ticks; at least 1.
#[inline(always)]
fn ticks_after<S: Scalar>(ticks: u32, missing: S) -> u32 {
    let moved = (missing.abs() / seconds_of_ticks(1) + S::from_f64(0.5)).to_u32();
    if missing < S::ZERO { ticks.saturating_sub(moved).max(1) } else { ticks.saturating_add(moved) }
}
