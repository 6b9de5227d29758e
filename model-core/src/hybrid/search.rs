//! The search for the event at the end of a step: its bracket, and what follows each prediction and each attempt.

use super::{Guard, attempt::bit};
use crate::clock::seconds_of_ticks;
use crate::scalar::Scalar;

/// Most attempts after the first to reach an event. Each is a Newton step from the attempt before; one or two suffice. A step
/// that they do not bring to its event is shortened to before it, by halves: at most 32 more attempts.
const MOST_CORRECTIONS: u32 = 8;
/// Most predictions to locate an event: those that halve a step to a tick, and some more.
const MOST_PREDICTIONS: u32 = 40;
/// The expected fall of a guard.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    /// The number of the guard.
    pub(super) index: usize,
    /// A guess of the time at which it falls, in ticks from the start of the step.
    pub(super) ticks: u32,
    /// Whether the guard is at or below zero at the end of the step; if not, it may only graze.
    pub(super) certain: bool,
}

/// What follows a prediction of an event.
pub(super) enum Next {
    /// The step ends here.
    Located,
    /// A prediction of so many ticks.
    Near(u32),
    /// A prediction of so many ticks: half of the bracket, since the tangent of a guard above zero leads out of it.
    Half(u32),
}

/// How an attempt ends that was to reach an event.
pub(super) enum Reached<S> {
    /// It is kept as it is.
    Clear,
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
    pub(super) predicted: bool,
    /// The bracket along the predicted motion, in ticks: the guard is above zero at `short`.
    short: u32,
    far: u32,
    /// Whether the guard is known to be at or below zero at `far`.
    falls: bool,
    /// Whether the bracket is that of predictions: an attempt can end outside of it.
    of_prediction: bool,
    /// The longest step.
    pub(super) most: u32,
    /// One bit for each guard that was located: each is located at most once.
    pub(super) done: u32,
    /// Predictions left.
    pub(super) left: u32,
    /// Attempts left.
    corrections: u32,
    /// The magnitude in s of the last correction.
    missing: S,
}

/// The limits of an extension of an attempt to an event.
pub(super) struct Extension<S> {
    /// In rad/s, of the motion.
    pub(super) angular_frequency: S,
    /// Whether the step begins in a boundary layer.
    pub(super) in_layer: bool,
    /// The largest cube of a time, in radians and in steps, over which a parabola is exact.
    pub(super) cube: S,
}

impl<S: Scalar> Extension<S> {
    /// Whether [`Attempts::extend`] is exact to a small part of the error of the step over a time after `ticks`, or the time is
    /// below a tick.
    pub(super) fn is_near(&self, seconds: S, ticks: u32) -> bool {
        // A bounce that is short against a radian must keep its own energy.
        let part = seconds / seconds_of_ticks(ticks);
        self.is_brief(seconds) && part * part <= S::EPSILON
            || self.is_curved(seconds, ticks)
            || seconds.abs() <= seconds_of_ticks(1)
    }

    /// Whether a line over a time is exact to rounding, in radians of the motion.
    fn is_brief(&self, seconds: S) -> bool {
        let radians = seconds * self.angular_frequency;
        radians * radians <= S::EPSILON
    }

    /// Whether over a time after `ticks` a parabola is exact to a small part of the error of the step and a line is not.
    ///
    /// The time is above the root of a rounding in radians: the parabola over a much shorter step would be that of its
    /// roundings. In a boundary layer the derivative at the start is not that of the step.
    fn is_curved(&self, seconds: S, ticks: u32) -> bool {
        let part = (seconds / seconds_of_ticks(ticks)).abs();
        let radians = (seconds * self.angular_frequency).abs();
        let largest = part.max(radians);
        !self.in_layer && !self.is_brief(seconds) && largest * largest * largest <= self.cube
    }
}

impl<S: Scalar> Search<S> {
    /// Of a step of `ticks`, or of at most `most` ticks if an event follows.
    pub(super) fn within([ticks, most]: [u32; 2]) -> Self {
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
        }
    }

    /// Continues near an expected fall within the present step or soon after it.
    #[cold]
    pub(super) fn approach(&mut self, fall: Fall) -> bool {
        self.event = Some(fall.index);
        let is_within = fall.ticks <= self.ticks;
        (self.short, self.far) = if is_within { (0, self.ticks) } else { (self.ticks, self.most) };
        (self.left, self.of_prediction) = (MOST_PREDICTIONS, true);
        (self.ticks, self.falls) = (fall.ticks, fall.certain);
        true
    }

    /// Returns from guard `index` to another one that has fallen before it, within `ticks`; false if the step cannot be shorter.
    pub(super) fn return_to(&mut self, fall: Fall, index: usize, ticks: u32) -> bool {
        self.ticks = ticks;
        if self.corrections == 0 {
            self.short = 0;
            return matches!(self.shorten(fall.index), Reached::Beyond);
        }
        self.corrections -= 1;
        (self.done, self.missing) = (bit(index), S::INFINITY);
        self.approach(fall)
    }

    /// Takes the guard at the end of a prediction.
    pub(super) fn advance(&mut self, guard: &Guard<S>, extension: &Extension<S>) -> Next {
        let Guard { value, rate } = *guard;
        let missing = value / -rate;
        self.left = self.left.wrapping_sub(1);
        let bracket = self.far.wrapping_sub(self.short);
        if rate < S::ZERO && extension.is_near(missing, self.ticks) || bracket <= 1 {
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
        let half = self.short.wrapping_add(self.far.wrapping_sub(self.short) / 2).max(1);
        if value > S::ZERO { Next::Half(half) } else { Next::Near(half) }
    }

    /// Takes guard `index` at the end of an attempt.
    pub(super) fn reach(&mut self, guard: &Guard<S>, index: usize, extension: &Extension<S>) -> Reached<S> {
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
            self.done &= !bit(index);
            return Reached::Past;
        }
        if !self.falls && (!is_falling || there > self.most) {
            // A graze, or an event beyond the end of the step.
            return Reached::Clear;
        }
        // Where the correction does not shrink, the guard is known no better: its value is a rounding.
        let stalls = missing.abs() > S::from_f64(0.5) * self.missing;
        self.missing = missing.abs();
        if is_falling && (extension.is_near(missing, self.ticks) || stalls && extension.is_brief(missing)) {
            return Reached::Near { missing, curved: extension.is_curved(missing, self.ticks) };
        }
        let is_inside = is_falling && there > self.short && (there < self.far || !self.falls);
        // A guard that is a stair of its roundings leads out of the bracket: the event is at its known end.
        if !is_inside && guard.value <= S::ZERO {
            return Reached::Clear;
        }
        if self.corrections == 0 {
            return if self.event.is_none() { Reached::Clear } else { self.shorten(index) };
        }
        let there = if is_inside { there } else { self.far };
        self.corrections -= 1;
        (self.ticks, self.event) = (there, Some(index));
        Reached::Beyond
    }

    /// Shortens the step to before the fall of guard `index`, or by half, where there are no corrections left.
    fn shorten(&mut self, index: usize) -> Reached<S> {
        if self.ticks <= 1 {
            return Reached::Clear;
        }
        self.ticks = if self.short > 0 { self.short } else { self.ticks / 2 };
        (self.event, self.left) = (Some(index), 0);
        Reached::Beyond
    }
}

/// `ticks` and `missing` seconds, which may be negative, in ticks; at least 1.
#[inline]
pub(super) fn ticks_after<S: Scalar>(ticks: u32, missing: S) -> u32 {
    let moved = (missing.abs() / seconds_of_ticks(1) + S::from_f64(0.5)).to_u32();
    if missing < S::ZERO { ticks.saturating_sub(moved).max(1) } else { ticks.saturating_add(moved) }
}
