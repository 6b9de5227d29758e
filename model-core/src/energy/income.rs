//! Averages the harvested power over the recent past and for each slot of the day.
//!
//! The mean over the recent past is exponentially weighted with a time constant. The mean of a slot is
//! updated by the same slot of each day with a weight `a`,
//!
//! ```text
//! x̄ ← (1 − a) x̄ + a x,
//! ```
//!
//! after Kansal, Hsu, Zahedi and Srivastava, *Power management in energy harvesting sensor networks*, ACM
//! Transactions on Embedded Computing Systems 6(4), 2007, who recommend `a = 1/2` with 48 slots for sunlight.
//!
//! Time is a count of whole seconds. A slot that was observed for less than half of its length keeps its
//! mean. The expected power of a slot without any observation is the exponentially weighted mean.

use super::storage::Relaxation;
use crate::bounds::{ParameterError, bounded};
use crate::scalar::{CompensatedSum, Scalar, add_increment};
use crate::snapshot::{Fingerprint, snapshot_fields};

pub(crate) const DAY_SECONDS: u32 = 86_400;

/// The number of mean relative distances in [`IncomeState::certain_part`]. By the test `energy_planner` no node was locked
/// out by an action in 11 000 random days; with 40 two were.
const CAUTION: f64 = 60.0;

/// Parameters of the income memory.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IncomeParameters<S> {
    /// Time constant of the exponentially weighted mean in s, 1 to 10⁹.
    pub time_constant: S,
    /// Weight of the newest day in the mean of a slot, 10⁻³ to 1.
    pub day_weight: S,
}

/// The income memory with the day divided into `SLOTS` slots, 1 to 1440, of equal length to within a second.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Income<S, const SLOTS: usize> {
    per_time_constant: S,
    day_weight: S,
}

/// The state of the income memory. Energies and powers are at the harvester's terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct IncomeState<S, const SLOTS: usize> {
    /// Whole seconds since a midnight.
    second: u32,
    /// Exponentially weighted mean in W, and the part that rounding removed.
    mean: [S; 2],
    /// Sum of the weights in the mean, from 0 towards 1, and the part that rounding removed.
    weight: [S; 2],
    /// Mean power of each slot in W; −1 for a slot without an observation.
    slots: [S; SLOTS],
    /// Energy in J in the observed part of the present slot.
    energy: CompensatedSum<S>,
    /// Length in s of the observed part of the present slot.
    observed: u32,
    /// Weighted means in W over the last slots: distance of a slot from its expected power, and expected power.
    spread: [S; 2],
}

bounded! { IncomeParameters<S>:
    "time_constant" = time_constant: 1.0, 1e9;
    "day_weight" = day_weight: 1e-3, 1.0;
}

impl<S: Scalar> IncomeParameters<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first field outside its bounds.
    pub(crate) fn build<const SLOTS: usize>(self) -> Result<Income<S, SLOTS>, ParameterError<S>> {
        self.check_numbers()?;
        Ok(Income { per_time_constant: S::ONE / self.time_constant, day_weight: self.day_weight })
    }
}

impl<S: Scalar, const SLOTS: usize> IncomeState<S, SLOTS> {
    /// The state before any income at a time in whole seconds since a midnight.
    pub(crate) fn at(second: u32) -> Self {
        const { assert!(SLOTS >= 1 && SLOTS <= 1440, "from 1 to 1440 slots") };
        Self {
            second,
            mean: [S::ZERO; 2],
            weight: [S::ZERO; 2],
            slots: [-S::ONE; SLOTS],
            energy: CompensatedSum::ZERO,
            observed: 0,
            spread: [S::ZERO; 2],
        }
    }

    /// The present time in whole seconds since a midnight; wraps after 136 years.
    pub(super) fn second(&self) -> u32 {
        self.second
    }

    /// Seconds from the present time to a later one; 0 for a time up to 68 years in the past.
    pub(crate) fn seconds_until(&self, second: u32) -> u32 {
        let ahead = second.wrapping_sub(self.second);
        if ahead > u32::MAX / 2 { 0 } else { ahead }
    }

    /// Exponentially weighted mean of the harvested power in W; 0 before any income.
    pub(super) fn mean_power(&self) -> S {
        self.mean[0]
    }

    /// Expected mean power of a slot in W: the mean of that slot, or the exponentially weighted mean for a slot without an observation.
    pub(crate) fn expected_power(&self, slot: usize) -> S {
        match self.slots.get(slot) {
            Some(&learnt) if learnt >= S::ZERO => learnt,
            _ => self.mean_power(),
        }
    }

    /// The part of the expected income that is as good as certain, 0 to 1: `1/(1 + 60 d)`, where `d` is the mean
    /// distance of a slot from its expected income over the mean expected income. 1 where no slot was observed twice.
    ///
    /// The part is positive, because distances are sums of magnitudes. All slots share one `d`: the few days for which a
    /// slot is remembered say little of its own.
    pub(crate) fn certain_part(&self) -> S {
        let [distance, expected] = self.spread;
        if expected > S::ZERO { expected / (expected + S::from_f64(CAUTION) * distance) } else { S::ONE }
    }

    /// The present slot.
    pub(crate) fn slot(&self) -> usize {
        slot_at::<SLOTS>(self.second % DAY_SECONDS)
    }

    fn observe(&mut self, seconds: u32, energy: S) {
        self.energy.add(energy);
        self.observed += seconds;
    }
}

snapshot_fields!(impl [S: Scalar, const SLOTS: usize] IncomeState<S, SLOTS> {
    second, mean, weight, slots, energy, observed, spread,
} if |state| {
    let slots_are_sound = state.slots.iter().all(|&learnt| learnt >= S::ZERO || learnt == -S::ONE);
    let spread_is_sound = state.spread.iter().all(|&power| power >= S::ZERO);
    slots_are_sound && spread_is_sound && state.weight[0] >= S::ZERO && state.observed <= DAY_SECONDS
});

impl<S: Scalar, const SLOTS: usize> Income<S, SLOTS> {
    /// Includes the parameters in a fingerprint.
    pub(super) fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.count(SLOTS as u32);
        fingerprint.numbers(&[self.per_time_constant, self.day_weight]);
    }

    /// Advances the time by `interval` in s with an evenly distributed income of `energy` in J.
    ///
    /// An interval longer than the shortest slot changes the exponentially weighted mean only.
    pub(crate) fn update(&self, state: &mut IncomeState<S, SLOTS>, interval: u32, energy: S) {
        if interval == 0 {
            return;
        }
        let seconds = S::from_u32(interval);
        let power = energy / seconds;
        self.remember(state, seconds, power);
        if interval > shortest_slot::<SLOTS>() {
            self.gap(state, interval);
            return;
        }
        let slot = state.slot();
        let before_end = end_of::<SLOTS>(slot) - state.second % DAY_SECONDS;
        if interval < before_end {
            state.observe(interval, energy);
        } else {
            state.observe(before_end, power * S::from_u32(before_end));
            self.close(state, slot);
            let rest = interval - before_end;
            state.observe(rest, power * S::from_u32(rest));
        }
        state.second = state.second.wrapping_add(interval);
    }

    /// Advances the time by `interval` in s with unknown income. The slots in the interval keep their means.
    pub(crate) fn gap(&self, state: &mut IncomeState<S, SLOTS>, interval: u32) {
        let slot = state.slot();
        let before_end = end_of::<SLOTS>(slot) - state.second % DAY_SECONDS;
        if interval >= before_end {
            self.close(state, slot);
        }
        state.second = state.second.wrapping_add(interval);
    }

    fn remember(&self, state: &mut IncomeState<S, SLOTS>, seconds: S, power: S) {
        let new = Relaxation::new(seconds * self.per_time_constant).lost();
        // Divided by the sum of the weights, so that the mean is not biased towards zero at the start.
        state.weight = moved(state.weight, (S::ONE - state.weight[0]) * new);
        state.mean = moved(state.mean, (power - state.mean[0]) * (new / state.weight[0]));
    }

    /// Ends the present slot and updates its mean if at least half of the slot was observed.
    fn close(&self, state: &mut IncomeState<S, SLOTS>, slot: usize) {
        let length = end_of::<SLOTS>(slot) - start_of::<SLOTS>(slot);
        if 2 * state.observed >= length
            && let Some(learnt) = state.slots.get_mut(slot)
        {
            let power = state.energy.value() / S::from_u32(state.observed);
            if *learnt < S::ZERO {
                *learnt = power;
            } else {
                // A slot of one day in the means over the slots of several days.
                let weight = self.day_weight / S::from_u32(const { SLOTS as u32 });
                let [distance, expected] = &mut state.spread;
                *distance += weight * ((power - *learnt).abs() - *distance);
                *expected += weight * (*learnt - *expected);
                *learnt += self.day_weight * (power - *learnt);
            }
        }
        (state.energy, state.observed) = (CompensatedSum::ZERO, 0);
    }
}

/// A number and the part that rounding removed, after a small increment.
fn moved<S: Scalar>([high, low]: [S; 2], increment: S) -> [S; 2] {
    let (high, low) = add_increment(high, low, increment);
    [high, low]
}

pub(super) fn slot_at<const SLOTS: usize>(second_of_day: u32) -> usize {
    (second_of_day * const { SLOTS as u32 } / DAY_SECONDS) as usize
}

/// The first second of a slot.
pub(super) fn start_of<const SLOTS: usize>(slot: usize) -> u32 {
    let slots = const { SLOTS as u32 };
    if const { DAY_SECONDS.is_multiple_of(SLOTS as u32) } {
        // Without a division, which is a hundred instructions on a core that has none.
        return slot as u32 * shortest_slot::<SLOTS>();
    }
    (slot as u32 * DAY_SECONDS + (slots - 1)).checked_div(slots).unwrap_or(0)
}

/// The first second after a slot.
pub(super) fn end_of<const SLOTS: usize>(slot: usize) -> u32 {
    start_of::<SLOTS>(slot + 1)
}

/// Length in s of the shortest slot; the longest is at most a second longer.
pub(super) const fn shortest_slot<const SLOTS: usize>() -> u32 {
    const { DAY_SECONDS / SLOTS as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of slots with an observation.
    fn slots_learnt<const SLOTS: usize>(state: &IncomeState<f64, SLOTS>) -> usize {
        state.slots.iter().filter(|&&learnt| learnt >= 0.0).count()
    }

    fn model<const SLOTS: usize>() -> Income<f64, SLOTS> {
        IncomeParameters { time_constant: 3600.0, day_weight: 0.5 }.build().expect("within bounds")
    }

    #[test]
    fn slots_cover_the_day_without_gap_or_overlap() {
        fn check<const SLOTS: usize>() {
            assert_eq!((start_of::<SLOTS>(0), end_of::<SLOTS>(SLOTS - 1)), (0, DAY_SECONDS));
            for second in 0..DAY_SECONDS {
                let slot = slot_at::<SLOTS>(second);
                assert!(start_of::<SLOTS>(slot) <= second && second < end_of::<SLOTS>(slot));
            }
            for slot in 0..SLOTS {
                let length = end_of::<SLOTS>(slot) - start_of::<SLOTS>(slot);
                assert!(length - shortest_slot::<SLOTS>() <= 1, "{SLOTS} {slot} {length}");
            }
        }
        check::<1>();
        check::<7>();
        check::<48>();
        check::<1439>();
        check::<1440>();
    }

    #[test]
    fn the_mean_weighs_by_age_and_not_by_number() {
        // The mean is that of the weighted integral, for any division of an income into intervals.
        let income = model::<48>();
        for interval in [1_u32, 7, 60, 600] {
            let mut state = IncomeState::at(0);
            let (mut integral, mut weight) = (0.0, 0.0);
            for k in 0..(16_800 / interval) {
                let power = if k * interval < 8_400 { 1e-3 } else { 5e-3 };
                income.update(&mut state, interval, power * f64::from(interval));
                let end = f64::from((k + 1) * interval);
                let part = ((end - 16_800.0) / 3600.0).exp()
                    - ((end - f64::from(interval) - 16_800.0) / 3600.0).exp();
                integral += power * part;
                weight += part;
            }
            assert!((state.mean_power() / (integral / weight) - 1.0).abs() < 1e-12, "{interval}");
        }
    }

    #[test]
    fn a_slot_is_the_weighted_mean_over_days() {
        let income = model::<7>();
        let mut state = IncomeState::at(5);
        let power = |day: u32, slot: usize| f64::from(day + 1) * 1e-3 * (slot + 1) as f64;
        // Updates of 61 s cross the edges of slots: 12 342 s is not a multiple of 61 s. Constant within a slot.
        for second in (5..4 * DAY_SECONDS).step_by(61) {
            let day_of = |s: u32| power(s / DAY_SECONDS, slot_at::<7>(s % DAY_SECONDS));
            let energy: f64 = (second..second + 61).map(day_of).sum();
            income.update(&mut state, 61, energy);
        }
        assert_eq!(slots_learnt(&state), 7);
        for slot in 0..6 {
            let expected = [0.125, 0.125, 0.25, 0.5]
                .iter()
                .zip(0..)
                .map(|(weight, day)| weight * power(day, slot))
                .sum::<f64>();
            // An update across an edge spreads an uneven income evenly: 61 s in 12 342 s.
            assert!((state.expected_power(slot) / expected - 1.0).abs() < 61.0 / 12_342.0, "{slot}");
        }
    }

    #[test]
    fn a_gap_leaves_slots_unlearnt_and_not_zero() {
        let income = model::<24>();
        let mut state = IncomeState::at(0);
        for _ in 0..60 {
            income.update(&mut state, 60, 0.06);
        }
        // Twenty minutes of the second hour are too few; then the node is off until 05:30.
        for _ in 0..20 {
            income.update(&mut state, 60, 0.12);
        }
        income.gap(&mut state, 5 * 3600 + 1800 - 4800);
        assert_eq!((state.second(), slots_learnt(&state)), (19_800, 1));
        assert_eq!(state.expected_power(1), state.mean_power());
        assert!(state.mean_power() > 1e-3 && state.mean_power() < 2e-3);
        // From half past, half of the sixth hour suffices.
        for _ in 0..30 {
            income.update(&mut state, 60, 0.24);
        }
        assert_eq!(slots_learnt(&state), 2);
        assert!((state.expected_power(5) - 4e-3).abs() < 1e-15);
        // A day without income data changes only the time.
        let before = state;
        income.gap(&mut state, DAY_SECONDS);
        assert_eq!(state, IncomeState { second: before.second + DAY_SECONDS, ..before });
    }

    #[test]
    fn the_certain_part_falls_with_the_distance_of_days_from_one_another() {
        for change in [0.0, 0.01, -0.3, 2.0] {
            let income = model::<24>();
            let mut state = IncomeState::at(0);
            // Nothing at night; all slots of the second day differ from the first by the same factor.
            for hour in 0..48_u32 {
                if hour == 30 {
                    assert_eq!(state.certain_part(), 1.0, "no slot with an income was observed twice");
                }
                let light = if (6..18).contains(&(hour % 24)) { f64::from(hour % 24) } else { 0.0 };
                let energy = 0.06 * light * if hour < 24 { 1.0 } else { 1.0 + change };
                (0..60).for_each(|_| income.update(&mut state, 60, energy));
            }
            let expected = 1.0 / (1.0 + 60.0 * f64::abs(change));
            assert!((state.certain_part() - expected).abs() < 1e-12, "{change}: {}", state.certain_part());
        }
    }

    #[test]
    fn intervals_longer_than_a_slot_teach_the_mean_only() {
        let income = model::<48>();
        let mut state = IncomeState::at(0);
        for _ in 0..48 {
            income.update(&mut state, 3600, 3.6);
        }
        assert_eq!(slots_learnt(&state), 0);
        assert!((state.expected_power(3) - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn single_precision_forgets_as_double_does_at_an_update_a_second() {
        // A weight of 2e-6 an update: without the remainder the mean would stall with an error of a few per cent.
        let parameters = |time_constant| IncomeParameters { time_constant, day_weight: 0.5 };
        let double = parameters(500_000.0).build::<48>().expect("within bounds");
        let single = IncomeParameters::<f32> { time_constant: 500_000.0, day_weight: 0.5 };
        let single = single.build::<48>().expect("within bounds");
        let (mut wide, mut narrow) = (IncomeState::at(0), IncomeState::at(0));
        for k in 0..DAY_SECONDS {
            let energy = 1e-5_f32 * (1.0 + ((k * 37) % 101) as f32 * 0.02 + (k / 20_000) as f32);
            double.update(&mut wide, 1, f64::from(energy));
            single.update(&mut narrow, 1, energy);
        }
        let close = |a: f32, b: f64| assert!((f64::from(a) / b - 1.0).abs() < 2e-6, "{a} {b}");
        close(narrow.mean_power(), wide.mean_power());
        for slot in 0..48 {
            close(narrow.expected_power(slot), wide.expected_power(slot));
        }
    }
}
