//! The coming day as a budget expects it: the stretches of constant predicted income from now on, and
//! the storage's path through them.
//!
//! Between the ends of a stretch the stored energy is monotone, so whoever looks at the ends sees its
//! extremes. The path rises with the energy at its start and falls as the load grows, which is what makes
//! bisection sound. The load-independent exponentials are taken once: slots have two lengths at most.

use super::income::{DAY_SECONDS, IncomeState, end_of, shortest_slot, start_of};
use super::storage::{Relaxation, Storage};
use crate::scalar::Scalar;

/// Halvings of an interval: what is left is below a rounding of `f32` of its first length.
const HALVINGS: u32 = 24;

/// A stretch of constant predicted income.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch<S> {
    /// Its length in seconds.
    pub(super) seconds: u32,
    /// Predicted power in watts at the harvester's terminals.
    pub(super) harvested: S,
    /// How the storage relaxes over the whole of it.
    pub(super) relaxation: Relaxation<S>,
}

/// The coming day. Four exponentials to make, and none in a pass over it, which is `SLOTS + 1` stretches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forecast<'a, S, const SLOTS: usize> {
    storage: &'a Storage<S>,
    income: &'a IncomeState<S, SLOTS>,
    slot: usize,
    /// The rest of the present slot, and the part of it that has passed, which ends the coming day.
    first: (u32, Relaxation<S>),
    last: (u32, Relaxation<S>),
    short: Relaxation<S>,
    long: Relaxation<S>,
}

impl<'a, S: Scalar, const SLOTS: usize> Forecast<'a, S, SLOTS> {
    pub(super) fn new(storage: &'a Storage<S>, income: &'a IncomeState<S, SLOTS>) -> Self {
        let second_of_day = income.second() % DAY_SECONDS;
        let slot = income.slot();
        let over = |seconds: u32| storage.relaxation(S::from_u32(seconds));
        let (first, last) = (end_of::<SLOTS>(slot) - second_of_day, second_of_day - start_of::<SLOTS>(slot));
        Self {
            storage,
            income,
            slot,
            first: (first, over(first)),
            last: (last, over(last)),
            short: over(shortest_slot::<SLOTS>()),
            long: over(shortest_slot::<SLOTS>() + 1),
        }
    }

    fn stretch(&self, index: usize) -> Stretch<S> {
        let ahead = self.slot + index;
        let slot = if ahead >= SLOTS { ahead - SLOTS } else { ahead };
        let (seconds, relaxation) = if index == 0 {
            self.first
        } else if index == SLOTS {
            self.last
        } else {
            let length = end_of::<SLOTS>(slot) - start_of::<SLOTS>(slot);
            (length, if length == shortest_slot::<SLOTS>() { self.short } else { self.long })
        };
        Stretch { seconds, harvested: self.income.expected_power(slot), relaxation }
    }

    /// The stretches in order of time; together a day.
    pub(super) fn stretches(&self) -> impl DoubleEndedIterator<Item = Stretch<S>> {
        (0..=SLOTS).map(|index| self.stretch(index))
    }

    /// Mean of the predicted power over the day, in watts at the harvester's terminals.
    pub(super) fn mean_power(&self) -> S {
        let energy = self
            .stretches()
            .fold(S::ZERO, |sum, stretch| sum + stretch.harvested * S::from_u32(stretch.seconds));
        energy / S::from_u32(DAY_SECONDS)
    }

    /// What comes in less what is drawn over a stretch, at the storage, for a load in watts.
    fn net(&self, stretch: &Stretch<S>, load: S) -> S {
        let seconds = S::from_u32(stretch.seconds);
        self.storage.stored(stretch.harvested * seconds) - self.storage.drawn(load * seconds)
    }

    /// Energy at the end of the day under a load in watts, starting with `energy`; `None` if the storage
    /// falls below `floor` on the way.
    pub(super) fn survive(&self, energy: S, load: S, floor: S) -> Option<S> {
        let mut now = energy;
        let mut lowest = energy;
        for stretch in self.stretches() {
            let relaxation = &stretch.relaxation;
            let end = now * relaxation.kept + self.net(&stretch, load) * relaxation.of_income;
            now = end.min(self.storage.capacity());
            lowest = lowest.min(now);
        }
        (lowest >= floor).then_some(now)
    }

    /// The least energy from which a load in watts can be borne for a day without falling below `floor`;
    /// `None` if a full storage is not enough. Backwards through the day.
    pub(super) fn needed(&self, load: S, floor: S) -> Option<S> {
        let mut needed = floor;
        for stretch in self.stretches().rev() {
            if needed > self.storage.capacity() {
                return None;
            }
            let relaxation = &stretch.relaxation;
            let before = (needed - self.net(&stretch, load) * relaxation.of_income) / relaxation.kept;
            needed = before.max(floor);
        }
        (needed <= self.storage.capacity()).then_some(needed)
    }

    /// Whether a load in watts can be borne for ever, were every day as the coming one.
    ///
    /// It can if from some energy that is there the day is survived and ends no lower than it began: then
    /// all days after do. What a day adds to the storage does not grow with the energy at its start, so if
    /// any start will do, the least that survives will.
    pub(super) fn sustain(&self, energy: S, load: S, floor: S) -> bool {
        let rounding = S::from_f64(8.0) * S::EPSILON * self.storage.capacity();
        self.needed(load, floor).is_some_and(|needed| {
            needed <= energy
                && self.survive(needed, load, floor - rounding).is_some_and(|end| end >= needed - rounding)
        })
    }

    /// What of a load in watts is left unserved over the day, in joules at the storage, the load being cut
    /// at the lock-out.
    pub(super) fn shortfall(&self, energy: S, load: S) -> S {
        let (mut now, mut sum) = (energy, S::ZERO);
        for stretch in self.stretches() {
            let seconds = S::from_u32(stretch.seconds);
            let income = self.storage.stored(stretch.harvested * seconds);
            let outgo = self.storage.drawn(load * seconds);
            let step = self.storage.step(now, &stretch.relaxation, income, outgo);
            now = step.end;
            sum += step.unserved;
        }
        sum
    }
}

/// The largest number from 0 to `highest`, to within a part of 2⁻²⁴ of that and from below, of those that
/// are allowed, where whatever is below an allowed number is allowed; `None` if 0 is not.
pub(super) fn largest<S: Scalar>(highest: S, allowed: impl Fn(S) -> bool) -> Option<S> {
    if !allowed(S::ZERO) {
        return None;
    }
    if allowed(highest) {
        return Some(highest);
    }
    let (mut inside, mut outside) = (S::ZERO, highest);
    for _ in 0..HALVINGS {
        let middle = S::from_f64(0.5) * (inside + outside);
        if allowed(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Some(inside)
}
