//! What firmware asks of a budget.
//!
//! Answers about the future take each slot of the coming day to bring what the memory of the income expects
//! of it, the standing load to go on, and the load to be cut at the lock-out without the hysteresis of
//! turning on again. A *pass* below is one walk through the `SLOTS + 1` stretches of the coming day, with two
//! multiplications and a few additions each; a forecast takes four exponentials once.

use super::action::Action;
use super::budget::{Budget, BudgetState};
use super::forecast::{Forecast, largest};
use super::income::DAY_SECONDS;
use crate::scalar::Scalar;

impl<S: Scalar, const SLOTS: usize> Budget<S, SLOTS> {
    /// Exponentially weighted mean of the harvested power in watts, before the charging efficiency. No
    /// arithmetic.
    #[must_use]
    pub fn mean_power(&self, state: &BudgetState<S, SLOTS>) -> S {
        state.income.mean_power()
    }

    /// Energy in joules that the harvester is expected to bring until a second of the clock, before the
    /// charging efficiency; 0 if that has passed, and that of a day if it is further off.
    ///
    /// Cost: one pass.
    #[must_use]
    pub fn income_until(&self, state: &BudgetState<S, SLOTS>, second: u32) -> S {
        let mut left = state.income.seconds_until(second).min(DAY_SECONDS);
        let mut sum = S::ZERO;
        for stretch in self.forecast(state).stretches() {
            let seconds = stretch.seconds.min(left);
            sum += stretch.harvested * S::from_u32(seconds);
            left -= seconds;
        }
        sum
    }

    /// What the storage is expected to gain until a second of the clock, in joules, negative for a loss: income,
    /// standing load, leakage, and what has no room or cannot be served; 0 if that second has passed, and that
    /// of a day if it is further off.
    ///
    /// Cost: one pass and one exponential more.
    #[must_use]
    pub fn energy_until(&self, state: &BudgetState<S, SLOTS>, second: u32) -> S {
        let mut left = state.income.seconds_until(second).min(DAY_SECONDS);
        let mut energy = state.energy();
        for stretch in self.forecast(state).stretches() {
            let seconds = stretch.seconds.min(left);
            left -= seconds;
            if seconds == stretch.seconds {
                let (income, outgo) = self.exchange(stretch.harvested, seconds);
                energy = self.storage.step(energy, &stretch.relaxation, income, outgo).end;
            } else {
                energy = self.after(energy, stretch.harvested, seconds);
                break;
            }
        }
        energy - state.energy()
    }

    /// Whole seconds until the storage is expected to have reached a voltage in volts, from below or from above,
    /// rounded up; 0 if it is there. `None` if that is not expected within a day.
    ///
    /// Cost: one pass, and 17 exponentials in the stretch in which it is reached.
    #[must_use]
    pub fn time_to_reach(&self, state: &BudgetState<S, SLOTS>, voltage: S) -> Option<u32> {
        let target = self.storage.energy(voltage);
        let rising = target > state.energy();
        let reached = |energy: S| if rising { energy >= target } else { energy <= target };
        let (mut energy, mut passed) = (state.energy(), 0);
        if energy == target {
            return Some(0);
        }
        for stretch in self.forecast(state).stretches() {
            let (income, outgo) = self.exchange(stretch.harvested, stretch.seconds);
            let end = self.storage.step(energy, &stretch.relaxation, income, outgo).end;
            if reached(end) {
                let (mut before, mut after) = (0, stretch.seconds);
                while after - before > 1 {
                    let middle = before + (after - before) / 2;
                    if reached(self.after(energy, stretch.harvested, middle)) {
                        after = middle;
                    } else {
                        before = middle;
                    }
                }
                return Some(passed + after);
            }
            energy = end;
            passed += stretch.seconds;
        }
        None
    }

    /// The largest uniform power in watts at the load, standing load included, that is not expected to take
    /// what is certain of the storage below a voltage in volts within a day; `None` if the storage falls below it
    /// under no load at all. From below, to within 2⁻²⁴ of the power that would use up everything.
    ///
    /// After Renner, Meier and Turau, *Policies for predictive energy management with supercapacitors*, PerSeNS
    /// 2012, whose question this is: the storage may be empty at the end of the day. See
    /// [`Budget::sustainable_rate`] for what can go on for ever.
    ///
    /// Cost: 27 passes.
    #[must_use]
    pub fn largest_uniform_load(&self, state: &BudgetState<S, SLOTS>, minimum_voltage: S) -> Option<S> {
        let floor = self.storage.energy(minimum_voltage);
        let energy = state.certain_energy();
        let forecast = self.forecast(state);
        let everything = (energy - floor).max(S::ZERO) / S::from_u32(DAY_SECONDS)
            + self.storage.stored(forecast.mean_power());
        let highest = everything * self.storage.parameters().discharging_efficiency;
        largest(highest, |load| forecast.survive(energy, load, floor).is_some())
    }

    /// How many times per second an action can be run for ever, were every day like the one expected; 0 if
    /// never.
    ///
    /// The largest uniform rate at which, starting with what is certain of the storage, it never falls below the
    /// lock-out with room for one action above it, and a day ends with no less in the storage than it began:
    /// the energy-neutral operation of Kansal et al. (2007) with a storage of finite size and with losses. The
    /// day may begin from less than there is, so that a storage filled once is not asked to stay so. At most one
    /// action at a time.
    ///
    /// Cost: 53 passes, a quarter of them divisions.
    #[must_use]
    pub fn sustainable_rate(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>) -> S {
        let forecast = self.forecast(state);
        let parameters = self.storage.parameters();
        let energy = state.certain_energy();
        let floor = self.storage.lock_out() + self.storage.drawn(action.energy());
        let neutral = self.storage.stored(forecast.mean_power()) * parameters.discharging_efficiency;
        let load = largest(neutral, |load| forecast.sustain(energy, load, floor)).unwrap_or(S::ZERO);
        let spare = (load - self.standing_power).max(S::ZERO);
        if spare == S::ZERO {
            return S::ZERO;
        }
        (spare / action.energy()).min(S::ONE / action.duration())
    }

    /// Least number of whole seconds between two starts of an action that can go on for ever, as by
    /// [`Budget::sustainable_rate`]; `None` if it is not expected to be possible even once a day.
    #[must_use]
    pub fn sustainable_period(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>) -> Option<u32> {
        let rate = self.sustainable_rate(state, action);
        if !(rate * S::from_u32(DAY_SECONDS) >= S::ONE) {
            return None;
        }
        let period = S::ONE / rate;
        let whole = period.to_u32();
        Some(if S::from_u32(whole) < period { whole + 1 } else { whole })
    }

    /// Whether an action can be run at a second of the clock, the present one: it can be afforded, and nothing
    /// of the standing load is expected to go unserved for it in the coming day.
    ///
    /// The first is certain, the second as good as the prediction: before a night without income, it keeps
    /// what the night will take, but where the storage is expected to fill up or to run out in any case, it does
    /// not hold the action back.
    ///
    /// Cost: five exponentials and two passes, or one exponential where it cannot be afforded.
    #[must_use]
    pub fn can_run_now(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>, now: u32) -> bool {
        if !self.can_afford(state, action, now) {
            return false;
        }
        let forecast = self.forecast(state);
        let (energy, load) = (state.certain_energy(), self.standing_power);
        let without = forecast.shortfall(energy, load);
        let with = forecast.shortfall(energy - self.storage.drawn(action.energy()), load);
        // A few roundings a stretch, of a sum of what the standing load draws.
        let drawn = self.storage.drawn(load * S::from_u32(DAY_SECONDS));
        with - without <= S::from_f64(16.0) * S::EPSILON * (drawn + self.storage.capacity())
    }

    fn forecast<'a>(&'a self, state: &'a BudgetState<S, SLOTS>) -> Forecast<'a, S, SLOTS> {
        Forecast::new(&self.storage, &state.income)
    }

    /// What comes to the storage and what the standing load draws from it in so many seconds.
    fn exchange(&self, harvested: S, seconds: u32) -> (S, S) {
        let seconds = S::from_u32(seconds);
        (self.storage.stored(harvested * seconds), self.storage.drawn(self.standing_power * seconds))
    }

    /// The stored energy after so many seconds of an income and the standing load.
    fn after(&self, energy: S, harvested: S, seconds: u32) -> S {
        let (income, outgo) = self.exchange(harvested, seconds);
        self.storage.step(energy, &self.storage.relaxation(S::from_u32(seconds)), income, outgo).end
    }
}

#[cfg(test)]
mod tests {
    use super::super::budget::BudgetParameters;
    use super::super::income::IncomeParameters;
    use super::super::storage::{StorageParameters, tests::example};
    use super::*;

    const SLOTS: usize = 48;

    fn budget(storage: StorageParameters<f64>, standing_power: f64) -> Budget<f64, SLOTS> {
        let income = IncomeParameters { time_constant: 7200.0, day_weight: 0.5 };
        BudgetParameters { storage, income, standing_power }.build().expect("within bounds")
    }

    /// Without leakage, so that sums are closed forms.
    fn tight() -> StorageParameters<f64> {
        StorageParameters { leakage_resistance: f64::INFINITY, ..example() }
    }

    /// Power in watts in a half hour of the day: 40 µW from 6 to 18 h.
    fn daylight(slot: usize) -> f64 {
        if (12..36).contains(&slot) { 40e-6 } else { 0.0 }
    }

    /// A state that has learnt two days of `power` and is at an hour of the third, with a voltage.
    fn knowing(
        budget: &Budget<f64, SLOTS>,
        power: impl Fn(usize) -> f64,
        hour: u32,
        voltage: f64,
    ) -> BudgetState<f64, SLOTS> {
        let mut state = budget.start(0);
        for slot in 0..2 * SLOTS + 2 * hour as usize {
            budget.update(&mut state, 1800, power(slot % SLOTS) * 1800.0, 0.0);
        }
        budget.correct_by_voltage(&mut state, voltage, 0.0);
        state
    }

    /// The lowest stored energy over so many days of `daylight` from an hour on, with actions once a period: by
    /// the exact solution in steps of at most ten seconds, written here anew.
    fn lowest(
        storage: &StorageParameters<f64>,
        [energy, standing]: [f64; 2],
        hour: u32,
        days: u32,
        [action, period]: [f64; 2],
    ) -> f64 {
        let rate = 2.0 / (storage.capacitance * storage.leakage_resistance);
        let capacity = 0.5 * storage.capacitance * storage.highest_voltage.powi(2);
        let (step, mut energy, mut lowest, mut next) = (10.0, energy, energy, 0.0);
        for k in 0..days * DAY_SECONDS / 10 {
            let time = f64::from(k) * step;
            let slot = (f64::from(hour) * 3600.0 + time) / 1800.0;
            let power = daylight(slot as usize % SLOTS) * storage.charging_efficiency
                - standing / storage.discharging_efficiency;
            energy = energy * (-rate * step).exp() + power * step * (1.0 - 0.5 * rate * step);
            energy = energy.min(capacity);
            while next < time + step {
                energy -= action / storage.discharging_efficiency;
                next += period;
            }
            lowest = lowest.min(energy);
        }
        lowest
    }

    #[test]
    fn income_and_energy_until_a_second_add_up_the_slots() {
        let standing = 1.8e-6;
        let budget = budget(tight(), standing);
        let state = knowing(&budget, daylight, 10, 2.5);
        let now = state.income().second();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs().max(1e-9), "{a} {b}");
        close(budget.income_until(&state, now + 600), 40e-6 * 600.0);
        close(budget.income_until(&state, now + 11 * 3600), 40e-6 * 8.0 * 3600.0);
        close(budget.income_until(&state, now + DAY_SECONDS), 40e-6 * 12.0 * 3600.0);
        close(budget.income_until(&state, now + 2 * DAY_SECONDS), 40e-6 * 12.0 * 3600.0);
        assert_eq!(budget.income_until(&state, now - 1), 0.0);
        // 32 µW in, 2 µW out, until it is full.
        close(budget.energy_until(&state, now + 45), 30e-6 * 45.0);
        let room = budget.storage().capacity() - state.energy();
        close(budget.energy_until(&state, now + 7 * 3600), room);
        // From 18 h on the standing load empties it down to the lock-out.
        close(budget.energy_until(&state, now + 8 * 3600 + 100), room - 200e-6);
        close(budget.energy_until(&state, now + 18 * 3600), budget.storage().lock_out() - state.energy());
    }

    #[test]
    fn time_to_reach_is_where_the_line_or_the_exponential_crosses() {
        let tight_budget = budget(tight(), 1.8e-6);
        let state = knowing(&tight_budget, daylight, 4, 2.5);
        let storage = tight_budget.storage();
        // Two hours down at 2 µW, or as far as the lock-out; then up at 30 µW.
        let bottom = (state.energy() - 2e-6 * 7200.0).max(storage.lock_out());
        let expected = 7200.0 + (storage.energy(3.0) - bottom) / 30e-6;
        assert_eq!(tight_budget.time_to_reach(&state, 3.0), Some(expected.ceil() as u32));
        let down = (state.energy() - storage.energy(2.4)) / 2e-6;
        assert_eq!(tight_budget.time_to_reach(&state, 2.4), Some(down.ceil() as u32));
        assert_eq!(tight_budget.time_to_reach(&state, 2.5), Some(0));
        assert_eq!(tight_budget.time_to_reach(&state, 4.6), None);
        assert_eq!(tight_budget.time_to_reach(&state, 1.7), None);

        let leaky = budget(example(), 0.0);
        let state = knowing(&leaky, |_| 0.0, 20, 4.0);
        // V falls as e^(−t/RC).
        let expected = 220e-6 * 10e6 * (4.0_f64 / 2.0).ln();
        assert_eq!(leaky.time_to_reach(&state, 2.0), Some(expected.ceil() as u32));
    }

    #[test]
    fn largest_uniform_load_just_keeps_the_voltage() {
        for (storage, hour, voltage) in
            [(tight(), 4, 3.5), (tight(), 17, 4.4), (example(), 4, 4.0), (example(), 12, 2.0)]
        {
            let storage =
                StorageParameters { leakage_resistance: storage.leakage_resistance * 100.0, ..storage };
            let budget = budget(storage, 0.0);
            let state = knowing(&budget, daylight, hour, voltage);
            let load = budget.largest_uniform_load(&state, 1.9).expect("some");
            let floor = budget.storage().energy(1.9);
            let under = |load: f64| lowest(&storage, [state.energy(), load], hour, 1, [0.0, 1e9]);
            let (within, beyond) = (under(load * 0.999), under(load * 1.001));
            assert!(load > 1e-9 && within >= floor && beyond < floor, "{load:e} {within:e} {beyond:e}");
        }
        let leaky = budget(example(), 0.0);
        let state = knowing(&leaky, daylight, 18, 2.0);
        assert_eq!(leaky.largest_uniform_load(&state, 1.9), None);
    }

    #[test]
    fn sustainable_rate_can_go_on_and_hardly_more_can() {
        let large = StorageParameters { capacitance: 0.5, leakage_resistance: 1e6, ..example() };
        for (storage, hour, voltage, standing, energy) in [
            (StorageParameters { capacitance: 0.5, ..tight() }, 5, 2.5, 1e-6, 2e-3),
            (StorageParameters { capacitance: 20e-3, ..tight() }, 18, 4.4, 0.5e-6, 1e-4),
            (StorageParameters { capacitance: 20e-3, ..tight() }, 9, 1.9, 0.2e-6, 1e-4),
            (large, 22, 3.0, 1e-6, 1e-3),
        ] {
            let budget = budget(storage, standing);
            let state = knowing(&budget, daylight, hour, voltage);
            let action = Action::new("measure", energy, 0.01).expect("finite");
            let rate = budget.sustainable_rate(&state, &action);
            let period = budget.sustainable_period(&state, &action).expect("some");
            assert!(f64::from(period) >= 1.0 / rate && f64::from(period) < 1.0 / rate + 1.0);
            let floor = budget.storage().lock_out();
            // Forty days, or as many as it takes to use up what is there at the start.
            let under =
                |rate: f64| lowest(&storage, [state.energy(), standing], hour, 40, [energy, 1.0 / rate]);
            assert!(under(rate) >= floor, "{storage:?} {rate}");
            assert!(under(rate * 1.1) < floor, "{storage:?} {rate}");
        }
    }

    #[test]
    fn without_losses_the_sustainable_rate_is_the_mean_income() {
        let storage = StorageParameters { capacitance: 1.0, ..tight() };
        let budget = budget(storage, 3e-6);
        let state = knowing(&budget, daylight, 0, 3.0);
        let action = Action::new("measure", 1e-3, 0.01).expect("finite");
        let neutral = (20e-6 * 0.8 * 0.9 - 3e-6) / 1e-3;
        assert!((budget.sustainable_rate(&state, &action) / neutral - 1.0).abs() < 1e-6);
        // One that the storage cannot hold, and one for which there is no income, never.
        let huge = Action::new("transmit", 20.0, 1.0).expect("finite");
        assert_eq!(budget.sustainable_rate(&state, &huge), 0.0);
        assert_eq!(budget.sustainable_period(&state, &huge), None);
        let dark = knowing(&budget, |_| 0.0, 0, 4.0);
        assert_eq!(budget.sustainable_period(&dark, &action), None);
    }

    #[test]
    fn what_the_night_will_take_is_kept() {
        // 20 mF hold 0.17 J above the lock-out; a night takes 2 µW for 12 h, 0.0864 J.
        let storage = StorageParameters { capacitance: 20e-3, ..tight() };
        let budget = budget(storage, 1.8e-6);
        let action = Action::new("transmit", 20e-3, 0.1).expect("finite");
        let full = knowing(&budget, daylight, 18, 4.5);
        let low = knowing(&budget, daylight, 18, 3.6);
        let morning = knowing(&budget, daylight, 7, 3.6);
        let answers = |state: &BudgetState<f64, SLOTS>| {
            let now = state.income().second();
            (budget.can_afford(state, &action, now), budget.can_run_now(state, &action, now))
        };
        assert_eq!(answers(&full), (true, true));
        assert_eq!(answers(&low), (true, false));
        assert_eq!(answers(&morning), (true, true));
    }
}
