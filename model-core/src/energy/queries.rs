//! What firmware asks of a budget.
//!
//! Answers about the future take each slot of the coming day to bring what the memory of the income expects
//! of it, the standing load to go on, and the load to be cut at the lock-out without the hysteresis of
//! turning on again. A *pass* below is one walk through the `SLOTS + 1` stretches of the coming day, with two
//! multiplications and a few additions each; a forecast takes four exponentials once.

use super::budget::{Action, Budget, BudgetState};
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
        let mut left = seconds_until(state, second);
        let mut sum = S::ZERO;
        for stretch in self.forecast(state).stretches() {
            let seconds = stretch.seconds.min(left);
            sum += stretch.harvested * S::from_u32(seconds);
            left -= seconds;
        }
        sum
    }

    /// What the store is expected to gain until a second of the clock, in joules, negative for a loss: income,
    /// standing load, leakage, and what has no room or cannot be served; 0 if that second has passed, and that
    /// of a day if it is further off.
    ///
    /// Cost: one pass and one exponential more.
    #[must_use]
    pub fn energy_until(&self, state: &BudgetState<S, SLOTS>, second: u32) -> S {
        let mut left = seconds_until(state, second);
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

    /// Whole seconds until the store is expected to have reached a voltage in volts, from below or from above,
    /// rounded up; 0 if it is there. `None` if that is not expected within a day.
    ///
    /// Cost: one pass, and 17 exponentials in the stretch in which it is reached.
    #[must_use]
    pub fn time_to_reach(&self, state: &BudgetState<S, SLOTS>, voltage: S) -> Option<u32> {
        let target = self.storage.energy(voltage);
        let rising = target > state.energy();
        let reached = |energy: S| if rising { energy >= target } else { energy <= target };
        let (mut energy, mut passed) = (state.energy(), 0);
        if reached(energy) && !(energy > target) {
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
    /// what is certain of the store below a voltage in volts within a day; `None` if the store falls below it
    /// under no load at all. From below, to within 2⁻²⁴ of the power that would use up everything.
    ///
    /// After Renner, Meier and Turau, *Policies for predictive energy management with supercapacitors*, PerSeNS
    /// 2012, whose question this is: the store may be empty at the end of the day. See
    /// [`Budget::sustainable_rate`] for what can go on for ever.
    ///
    /// Cost: 27 passes.
    #[must_use]
    pub fn largest_uniform_load(&self, state: &BudgetState<S, SLOTS>, minimum_voltage: S) -> Option<S> {
        let floor = self.storage.energy(minimum_voltage);
        let energy = state.certain_energy();
        let forecast = self.forecast(state);
        let everything = (energy - floor).larger(S::ZERO) / S::from_u32(DAY_SECONDS)
            + self.storage.stored(forecast.mean_power());
        let highest = everything * self.storage.parameters().discharging_efficiency;
        largest(highest, |load| forecast.survive(energy, load, floor).is_some())
    }

    /// How many times per second an action can be run for ever, were every day like the one expected; 0 if
    /// never.
    ///
    /// The largest uniform rate at which, starting with what is certain of the store, it never falls below the
    /// lock-out with room for one action above it, and a day ends with no less in the store than it began:
    /// the energy-neutral operation of Kansal et al. (2007) with a store of finite size and with losses. The
    /// day may begin from less than there is, so that a store filled once is not asked to stay so. At most one
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
        let rate = (load - self.standing_power).larger(S::ZERO) / action.energy();
        rate.smaller(S::ONE / action.duration())
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

    /// Whether an action can be run now: it can be afforded, and nothing of the standing load is expected to
    /// go unserved for it in the coming day.
    ///
    /// The first is certain, the second as good as the prediction: before a night without income, it keeps
    /// what the night will take, but where the store is expected to fill up or to run out in any case, it does
    /// not hold the action back.
    ///
    /// Cost: five exponentials and two passes, or one exponential where it cannot be afforded.
    #[must_use]
    pub fn can_run_now(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>) -> bool {
        if !self.can_afford(state, action) {
            return false;
        }
        let forecast = self.forecast(state);
        let (energy, load) = (state.certain_energy(), self.standing_power);
        let without = forecast.shortfall(energy, load);
        let with = forecast.shortfall(energy - self.storage.drawn(action.energy()), load);
        // A few roundings a stretch, of a sum of what the standing load draws.
        let drawn = self.storage.drawn(load * S::from_u32(DAY_SECONDS));
        with - without <= S::literal(16.0) * S::EPSILON * (drawn + self.storage.capacity())
    }

    fn forecast<'a>(&'a self, state: &'a BudgetState<S, SLOTS>) -> Forecast<'a, S, SLOTS> {
        Forecast::new(&self.storage, &state.income)
    }

    /// What comes to the store and what the standing load draws from it in so many seconds.
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

/// Seconds from now until a second of the clock, at most a day; 0 if it has passed.
fn seconds_until<S: Scalar, const SLOTS: usize>(state: &BudgetState<S, SLOTS>, second: u32) -> u32 {
    let ahead = second.wrapping_sub(state.income.second());
    // Half of the clock's range is the past.
    if ahead > u32::MAX / 2 { 0 } else { ahead.min(DAY_SECONDS) }
}
