//! The forecast of the coming day: stretches of constant expected income, and the stored energy along them.
//!
//! The stored energy is monotone within a stretch, so its extremes lie at the ends of stretches. It rises
//! with the energy at the start of the day and falls with the load, so bisection finds the largest load. The
//! exponentials do not depend on the load, and slots have at most two lengths, so they are computed once.

use super::income::{DAY_SECONDS, IncomeState, end_of, shortest_slot, start_of};
use super::storage::{Relaxation, Storage};
use crate::scalar::Scalar;

/// Number of bisections: the remaining interval is below a rounding of its first length in `f32`.
const HALVINGS: u32 = 24;

/// A stretch of constant predicted income.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch<S> {
    /// Length in s.
    pub(super) seconds: u32,
    /// Expected power in W at the harvester's terminals.
    pub(super) harvested: S,
    /// Relaxation of the storage over the stretch.
    pub(super) relaxation: Relaxation<S>,
}

/// The coming day in `SLOTS + 1` stretches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forecast<'a, S, const SLOTS: usize> {
    storage: &'a Storage<S>,
    income: &'a IncomeState<S, SLOTS>,
    /// Part of the expected income that is counted.
    part: S,
    /// The present slot.
    slot: usize,
    /// The remaining part of the present slot in s.
    first: (u32, Relaxation<S>),
    /// The elapsed part of the present slot in s; it ends the coming day.
    last: (u32, Relaxation<S>),
    /// Relaxation over the shortest slot.
    short: Relaxation<S>,
    /// Relaxation over a slot that is one second longer.
    long: Relaxation<S>,
}

impl<'a, S: Scalar, const SLOTS: usize> Forecast<'a, S, SLOTS> {
    pub(super) fn new(storage: &'a Storage<S>, income: &'a IncomeState<S, SLOTS>) -> Self {
        let second_of_day = income.second() % DAY_SECONDS;
        let slot = income.slot();
        let over = |seconds: u32| storage.relaxation(S::from_u32(seconds));
        let (first, last) = (end_of::<SLOTS>(slot) - second_of_day, second_of_day - start_of::<SLOTS>(slot));
        let short = over(shortest_slot::<SLOTS>());
        let is_even = const { DAY_SECONDS.is_multiple_of(SLOTS as u32) };
        Self {
            storage,
            income,
            part: S::ONE,
            slot,
            first: (first, over(first)),
            last: (last, over(last)),
            short,
            long: if is_even { short } else { over(shortest_slot::<SLOTS>() + 1) },
        }
    }

    /// The same day with the income that is as good as certain in place of the expected one.
    pub(super) fn certain(self) -> Self {
        Self { part: self.income.certain_part(), ..self }
    }

    /// Slot, length in s and relaxation of a stretch.
    fn place(&self, index: usize) -> (usize, u32, &Relaxation<S>) {
        let ahead = self.slot + index;
        let slot = if ahead >= SLOTS { ahead - SLOTS } else { ahead };
        let (seconds, relaxation) = if index == 0 {
            (self.first.0, &self.first.1)
        } else if index == SLOTS {
            (self.last.0, &self.last.1)
        } else {
            let length = end_of::<SLOTS>(slot) - start_of::<SLOTS>(slot);
            (length, if length == shortest_slot::<SLOTS>() { &self.short } else { &self.long })
        };
        (slot, seconds, relaxation)
    }

    fn stretch(&self, index: usize) -> Stretch<S> {
        let (slot, seconds, &relaxation) = self.place(index);
        Stretch { seconds, harvested: self.part * self.income.expected_power(slot), relaxation }
    }

    /// The stretches of the day in the order of time.
    fn stretches(&self) -> impl DoubleEndedIterator<Item = Stretch<S>> {
        (0..=SLOTS).map(|index| self.stretch(index))
    }

    /// Mean of the expected power over the day in W at the harvester's terminals.
    pub(super) fn mean_power(&self) -> S {
        let energy = self
            .stretches()
            .fold(S::ZERO, |sum, stretch| sum + stretch.harvested * S::from_u32(stretch.seconds));
        energy / S::from_u32(DAY_SECONDS)
    }

    /// Income less drawn energy over a stretch in J at the storage, for a load in W.
    fn net(&self, stretch: &Stretch<S>, load: S) -> S {
        let seconds = S::from_u32(stretch.seconds);
        self.storage.stored(stretch.harvested * seconds) - self.storage.drawn(load * seconds)
    }

    /// Energy in J at the end of the day under a load in W, from `energy` in J at the start; `None` if the
    /// storage falls below `floor` in J.
    fn survive(&self, energy: S, load: S, floor: S) -> Option<S> {
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

    /// The least energy in J at the start of the day with which the storage does not fall below `floor` under
    /// a load in W; `None` if a full storage is not enough. Computed backwards through the day.
    fn needed(&self, load: S, floor: S) -> Option<S> {
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

    /// Whether the storage can serve a load in W for ever if every day is like the coming one.
    ///
    /// It can if some energy up to the present one is enough for the day, and the day ends with no less: then
    /// all later days do. The gain of a day does not grow with the energy at its start, so the least
    /// sufficient energy decides.
    pub(super) fn sustain(&self, energy: S, load: S, floor: S) -> bool {
        let rounding = S::from_f64(8.0) * S::EPSILON * self.storage.capacity();
        self.needed(load, floor).is_some_and(|needed| {
            needed <= energy
                && self.survive(needed, load, floor - rounding).is_some_and(|end| end >= needed - rounding)
        })
    }

    /// The load in W that comes nearest to a constant load over the coming two days without filling the storage, and
    /// without emptying it to `floor` in J: the first segment of the shortest path between the two bounds of the
    /// cumulative consumption. After two days the storage is to hold what it holds now.
    ///
    /// Under a constant load `u` the energy at the end of each stretch is `a − u b`. It lies within the bounds for `u`
    /// from `(a − capacity)/b` to `(a − floor)/b`. The common range of these intervals shrinks from stretch to stretch;
    /// where it ends, the path bends, and its first segment goes to the bound that ended it.
    pub(super) fn smoothest_load(&self, energy: S, floor: S) -> S {
        let (mut a, mut b) = (energy, S::ZERO);
        let (mut least, mut most) = (S::ZERO, S::INFINITY);
        for stretch in self.stretches().chain(self.stretches()).filter(|stretch| stretch.seconds > 0) {
            let (seconds, relaxation) = (S::from_u32(stretch.seconds), &stretch.relaxation);
            a = a * relaxation.kept + self.storage.stored(stretch.harvested * seconds) * relaxation.of_income;
            b = b * relaxation.kept + self.storage.drawn(seconds) * relaxation.of_income;
            let (fills, empties) = ((a - self.storage.capacity()) / b, (a - floor) / b);
            if empties <= least {
                return least;
            }
            if fills >= most {
                return most;
            }
            (least, most) = (least.max(fills), most.min(empties));
        }
        ((a - energy) / b).max(least).min(most)
    }

    /// Unserved energy of a load in W over the day, in J at the storage. The load is cut at the lock-out.
    pub(super) fn shortfall(&self, energy: S, load: S) -> S {
        let (mut now, mut sum) = (energy, S::ZERO);
        // What a watt of income stores and what the load draws in a stretch: most stretches have the same length.
        let (mut length, mut of_watt, mut outgo) = (0, S::ZERO, S::ZERO);
        for index in 0..=SLOTS {
            let (slot, seconds, relaxation) = self.place(index);
            if seconds != length {
                let time = S::from_u32(seconds);
                (length, of_watt) = (seconds, self.storage.stored(self.part * time));
                outgo = self.storage.drawn(load * time);
            }
            let income = of_watt * self.income.expected_power(slot);
            let end = now * relaxation.kept + (income - outgo) * relaxation.of_income;
            if end < self.storage.lock_out() {
                let step = self.storage.step(now, relaxation, income, outgo);
                now = step.end;
                sum += step.unserved;
            } else {
                now = end.min(self.storage.capacity());
            }
        }
        sum
    }
}

/// The largest allowed number from 0 to `highest` by bisection, from below and to within 2⁻²⁴ of `highest`;
/// `None` if 0 is not allowed. All numbers below an allowed number must be allowed.
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
