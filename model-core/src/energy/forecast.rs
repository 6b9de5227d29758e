//! The forecast of the coming day: stretches of constant expected income, and the stored energy along them.
//!
//! The stored energy is monotone within a stretch, so its extremes lie at the ends of stretches. It rises
//! with the energy at the start of the day and falls with the load, so bisection finds the largest load. The
//! exponentials do not depend on the load, and whole slots have at most two lengths, whose exponentials the budget keeps.

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
pub(super) struct Forecast<'a, S: 'static, const SLOTS: usize> {
    storage: &'a Storage<S>,
    income: &'a IncomeState<S, SLOTS>,
    /// Part of the expected income that is counted.
    part: S,
    /// The present slot.
    slot: usize,
    /// The remaining part of the present slot in s, and the elapsed one, which ends the coming day.
    first: (u32, Relaxation<S>),
    last: (u32, Relaxation<S>),
    /// Relaxation over whole slots.
    slots: &'a SlotRelaxations<S>,
}

/// The relaxation over the shortest slot, and over one that is a second longer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct SlotRelaxations<S> {
    short: Relaxation<S>,
    long: Relaxation<S>,
}

impl<S: Scalar> SlotRelaxations<S> {
    /// Those of a day of `SLOTS` slots.
    pub(super) fn new<const SLOTS: usize>(storage: &Storage<S>) -> Self {
        let over = |seconds: u32| storage.relaxation(S::from_u32(seconds));
        Self { short: over(shortest_slot::<SLOTS>()), long: over(shortest_slot::<SLOTS>() + 1) }
    }
}

impl<'a, S: Scalar, const SLOTS: usize> Forecast<'a, S, SLOTS> {
    pub(super) fn new(
        storage: &'a Storage<S>,
        slots: &'a SlotRelaxations<S>,
        income: &'a IncomeState<S, SLOTS>,
    ) -> Self {
        let second_of_day = income.second() % DAY_SECONDS;
        let slot = income.slot();
        let (first, last) = (end_of::<SLOTS>(slot) - second_of_day, second_of_day - start_of::<SLOTS>(slot));
        let over = |seconds: u32| (seconds, storage.relaxation(S::from_u32(seconds)));
        Self { storage, income, part: S::ONE, slot, first: over(first), last: over(last), slots }
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
            let is_short = length == shortest_slot::<SLOTS>();
            (length, if is_short { &self.slots.short } else { &self.slots.long })
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
            let end = now * relaxation.remaining + self.net(&stretch, load) * relaxation.of_income;
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
            let before = (needed - self.net(&stretch, load) * relaxation.of_income) / relaxation.remaining;
            needed = before.max(floor);
        }
        (needed <= self.storage.capacity()).then_some(needed)
    }

    /// Whether the storage can serve a load in W for ever if every day is like the coming one.
    ///
    /// It can if some energy up to the present one is enough for the day, and the day ends with no less: then
    /// all later days do. The gain of a day does not grow with the energy at its start, so the least sufficient energy decides.
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
            a = a * relaxation.remaining
                + self.storage.stored(stretch.harvested * seconds) * relaxation.of_income;
            b = b * relaxation.remaining + self.storage.drawn(seconds) * relaxation.of_income;
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

    /// Whether an expenditure of `used` in J at the start leaves the unserved energy of the standing load over the day as it
    /// is, to within `rounding` in J at the storage. The load is cut at the lock-out.
    ///
    /// Both days are followed at once, until they are the same: with a full storage, or at the lock-out. What is unserved more
    /// grows only, so that the first shortage most often decides.
    pub(super) fn spares(&self, energy: S, used: S, load: S, rounding: S) -> bool {
        let (capacity, lock_out) = (self.storage.capacity(), self.storage.lock_out());
        let (mut without, mut with) = (energy, energy - used);
        let mut more = S::ZERO;
        let mut length = Length::default();
        for index in 0..=SLOTS {
            let (slot, seconds, relaxation) = self.place(index);
            if seconds != length.seconds {
                length = self.length(seconds, relaxation, load);
            }
            let power = self.income.expected_power(slot);
            let net = power * length.of_watt - length.of_load;
            let end = |now: S| {
                let end = now * relaxation.remaining + net;
                if end < lock_out {
                    let step =
                        self.storage.step(now, relaxation, power * length.stored_of_watt, length.outgo);
                    (step.end, step.unserved)
                } else {
                    (end.min(capacity), S::ZERO)
                }
            };
            let (of_with, unserved) = end(with);
            let (of_without, less) = end(without);
            more += unserved - less;
            if more > rounding {
                return false;
            }
            (with, without) = (of_with, of_without);
            if with >= without {
                return true;
            }
        }
        true
    }

    fn length(&self, seconds: u32, relaxation: &Relaxation<S>, load: S) -> Length<S> {
        let time = S::from_u32(seconds);
        let stored_of_watt = self.storage.stored(self.part * time);
        let outgo = self.storage.drawn(load * time);
        let [of_watt, of_load] = [stored_of_watt, outgo].map(|energy| energy * relaxation.of_income);
        Length { seconds, stored_of_watt, outgo, of_watt, of_load }
    }
}

/// What does not change among stretches of one length.
#[derive(Debug, Clone, Copy, Default)]
struct Length<S> {
    seconds: u32,
    /// Stored energy in J of a watt of expected income, and energy in J that the load draws.
    stored_of_watt: S,
    outgo: S,
    /// What of both is left at the end of the stretch.
    of_watt: S,
    of_load: S,
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

#[cfg(test)]
mod tests {
    use super::super::budget::{Budget, BudgetParameters};
    use super::super::income::IncomeParameters;
    use super::super::storage::{StorageParameters, tests::example};
    use super::*;
    use crate::energy::Action;
    use crate::part::storage::Capacitor;

    const SLOTS: usize = 24;

    /// Unserved energy over the day, stretch by stretch.
    fn shortfall(forecast: &Forecast<'_, f64, SLOTS>, energy: f64, load: f64) -> f64 {
        let storage = forecast.storage;
        let day = forecast.stretches().map(|Stretch { seconds, harvested, relaxation }| {
            let time = f64::from(seconds);
            (relaxation, storage.stored(harvested * time), storage.drawn(load * time))
        });
        let steps = day.scan(energy, |now, (relaxation, income, outgo)| {
            let step = storage.step(*now, &relaxation, income, outgo);
            *now = step.end;
            Some(step.unserved)
        });
        steps.sum()
    }

    #[test]
    fn an_action_is_spared_where_both_days_lack_the_same() {
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        let (mut spared, mut refused, mut short) = (0, 0, 0);
        for _ in 0..3000 {
            let [size, leakage, standing] = [100.0, 1e4, 30.0].map(|most: f64| most.powf(random()));
            let capacitor = Capacitor { capacitance: 1e-3 * size, leakage_resistance: 2e5 * leakage };
            let income = IncomeParameters { time_constant: 7200.0, day_weight: 0.5 };
            let parameters = BudgetParameters {
                storage: StorageParameters { capacitor, ..example() },
                income,
                standing_power: 3e-7 * standing,
            };
            let budget: Budget<f64, SLOTS> = parameters.build().expect("within bounds");
            let mut state = budget.start((86_400.0 * random()) as u32);
            let most = 2e-5 * random();
            for _ in 0..60 {
                let power = if random() < 0.5 { most } else { 0.0 };
                budget.update(&mut state, 3600, power * 3600.0, 0.0);
            }
            budget.correct_by_voltage(&mut state, 1.8 + 2.7 * random(), 0.0);
            let above = state.certain_energy() - budget.storage().lock_out();
            let action = Action::new("any", 0.9 * above * random(), 0.1).expect("within bounds");
            let (energy, load) = (state.certain_energy(), budget.standing_power);
            let forecast = Forecast::new(&budget.storage, &budget.slots, &state.income).certain();
            let with = shortfall(&forecast, energy - budget.storage().drawn(action.energy()), load);
            let without = shortfall(&forecast, energy, load);
            short += u32::from(without > 0.0);
            let is_spared = budget.leaves_the_day(&state, &action);
            assert_eq!(is_spared, with - without <= 1e-12 * budget.storage().capacity(), "{with} {without}");
            *(if is_spared { &mut spared } else { &mut refused }) += 1;
        }
        assert!(spared.min(refused).min(short) > 300, "{spared} {refused} {short}");
    }
}
