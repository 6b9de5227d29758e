//! Decisions of a node: the rate at which an action can run for ever, the power to draw now, and whether an action can
//! run now.
//!
//! The forecast of the coming day consists of the expected income of each slot, the standing load, and a cut
//! of the load at the lock-out without hysteresis. A *pass* is one walk through the `SLOTS + 1` stretches of
//! that day, with two multiplications and a few additions per stretch. The whole takes two exponentials.

use super::budget::Action;
use super::budget::{Budget, BudgetState};
use super::forecast::{Forecast, largest};
use crate::scalar::Scalar;

impl<S: Scalar, const SLOTS: usize> Budget<S, SLOTS> {
    /// The rate in 1/s at which an action can run for ever if every day is like the forecast; 0 if never.
    ///
    /// This is the energy-neutral operation of Kansal and others (2007) for a storage of finite size with
    /// losses: the largest uniform rate at which the storage, from its certain energy, never falls below the
    /// lock-out plus one action, and no day ends with less energy than it began with. The day may begin with
    /// less than the certain energy, so a full storage need not stay full. Actions do not overlap.
    ///
    /// Cost: 53 passes.
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

    /// The power in W that the node can draw now, standing power included, so that its consumption is as even as the
    /// storage allows: it neither fills up nor empties by the forecast of the coming two days, and ends with the present
    /// energy. At least the standing power.
    ///
    /// A node that grants its actions what is above the standing power, and asks again after some minutes, wastes
    /// little of the income and keeps energy for the night. `reserve` in J at the load stays in the storage above the
    /// lock-out: the energy of the largest action.
    ///
    /// This is the shortest path within a finite storage of Tutuncuoglu and Yener, *Optimum transmission policies for
    /// battery limited energy harvesting nodes*, IEEE Transactions on Wireless Communications 11(3), 2012, on the
    /// forecast and with leakage. Whether the storage can serve an action stays with [`Budget::can_run_now`].
    ///
    /// Cost: two passes with two divisions for each stretch.
    #[must_use]
    pub fn planned_power(&self, state: &BudgetState<S, SLOTS>, reserve: S) -> S {
        let floor = self.storage.lock_out() + self.storage.drawn(reserve.max(S::ZERO));
        let load = self.forecast(state).smoothest_load(state.certain_energy(), floor);
        load.max(self.standing_power)
    }

    /// Whether an action can run at the present second `now` of the clock: it can be afforded, and by the
    /// forecast it does not increase the unserved standing load of the coming day.
    ///
    /// The first condition is certain ([`Budget::can_afford`]), the second is as good as the forecast, of which it counts
    /// a part only: `1/(1 + 60 d)`, where `d` is the mean relative distance of the slots from their expected incomes. A
    /// node whose days are alike counts on them; one whose days differ keeps enough for its standing load. Before
    /// a night without income the second condition reserves the energy for the night. It does not hold back
    /// an action if the storage fills up.
    ///
    /// Cost: an exponential; where the stored energy does not last for the day without income, two more and both passes, up to
    /// the first shortage or a full storage.
    #[must_use]
    pub fn can_run_now(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>, now: u32) -> bool {
        self.can_afford(state, action, now) && self.leaves_the_day(state, action)
    }

    /// The second condition of [`Budget::can_run_now`].
    pub(super) fn leaves_the_day(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>) -> bool {
        let (energy, load) = (state.certain_energy(), self.standing_power);
        let used = self.storage.drawn(action.energy());
        // A few roundings per stretch of the energy that the standing load draws.
        let rounding = S::from_f64(16.0) * S::EPSILON * (self.day_drawn + self.storage.capacity());
        if (energy - used) * self.day_remaining >= self.storage.lock_out() + self.day_drawn + rounding {
            // It lasts for the day without any income.
            return true;
        }
        self.forecast(state).certain().spares(energy, used, load, rounding)
    }

    fn forecast<'a>(&'a self, state: &'a BudgetState<S, SLOTS>) -> Forecast<'a, S, SLOTS> {
        Forecast::new(&self.storage, &self.slots, &state.income)
    }
}

#[cfg(test)]
mod tests {
    use super::super::budget::BudgetParameters;
    use super::super::income::{DAY_SECONDS, IncomeParameters};
    use super::super::storage::{StorageParameters, tests::example};
    use super::*;
    use crate::part::storage::Capacitor;

    const SLOTS: usize = 48;

    fn budget(storage: StorageParameters<f64>, standing_power: f64) -> Budget<f64, SLOTS> {
        let income = IncomeParameters { time_constant: 7200.0, day_weight: 0.5 };
        BudgetParameters { storage, income, standing_power }.build().expect("within bounds")
    }

    /// Without leakage, so that sums are closed forms.
    fn tight() -> StorageParameters<f64> {
        StorageParameters {
            capacitor: Capacitor { leakage_resistance: f64::INFINITY, ..example().capacitor },
            ..example()
        }
    }

    /// Power in watts in a half hour of the day: 40 µW from 6 to 18 h.
    fn daylight(slot: usize) -> f64 {
        if (12..36).contains(&slot) { 40e-6 } else { 0.0 }
    }

    /// A state after two days of `power`, at an hour of the third day, with a measured voltage.
    fn estimation(
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

    /// The lowest stored energy over some days of `daylight` from an hour on, with one action a period: an
    /// independent simulation in steps of ten seconds.
    fn lowest(
        storage: &StorageParameters<f64>,
        [energy, standing]: [f64; 2],
        hour: u32,
        days: u32,
        [action, period]: [f64; 2],
    ) -> f64 {
        let rate = 2.0 / (storage.capacitor.capacitance * storage.capacitor.leakage_resistance);
        let capacity = 0.5 * storage.capacitor.capacitance * storage.highest_voltage.powi(2);
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
    fn sustainable_rate_can_go_on_and_hardly_more_can() {
        let large = StorageParameters {
            capacitor: Capacitor { capacitance: 0.5, leakage_resistance: 1e6 },
            ..example()
        };
        for (storage, hour, voltage, standing, energy) in [
            (
                StorageParameters {
                    capacitor: Capacitor { capacitance: 0.5, ..tight().capacitor },
                    ..tight()
                },
                5,
                2.5,
                1e-6,
                2e-3,
            ),
            (
                StorageParameters {
                    capacitor: Capacitor { capacitance: 20e-3, ..tight().capacitor },
                    ..tight()
                },
                18,
                4.4,
                0.5e-6,
                1e-4,
            ),
            (
                StorageParameters {
                    capacitor: Capacitor { capacitance: 20e-3, ..tight().capacitor },
                    ..tight()
                },
                9,
                1.9,
                0.2e-6,
                1e-4,
            ),
            (large, 22, 3.0, 1e-6, 1e-3),
        ] {
            let budget = budget(storage, standing);
            let state = estimation(&budget, daylight, hour, voltage);
            let action = Action::new("measure", energy, 0.01).expect("finite");
            let rate = budget.sustainable_rate(&state, &action);
            let floor = budget.storage().lock_out();
            // In forty days the initial energy is used up.
            let under =
                |rate: f64| lowest(&storage, [state.energy(), standing], hour, 40, [energy, 1.0 / rate]);
            assert!(under(rate) >= floor, "{storage:?} {rate}");
            assert!(under(rate * 1.1) < floor, "{storage:?} {rate}");
        }
    }

    #[test]
    fn without_losses_the_sustainable_rate_is_the_mean_income() {
        let storage =
            StorageParameters { capacitor: Capacitor { capacitance: 1.0, ..tight().capacitor }, ..tight() };
        let budget = budget(storage, 3e-6);
        let state = estimation(&budget, daylight, 0, 3.0);
        let action = Action::new("measure", 1e-3, 0.01).expect("finite");
        let neutral = (20e-6 * 0.8 * 0.9 - 3e-6) / 1e-3;
        assert!((budget.sustainable_rate(&state, &action) / neutral - 1.0).abs() < 1e-6);
        // An action beyond the capacity of the storage, and one without any income, can never run.
        let huge = Action::new("transmit", 20.0, 1.0).expect("finite");
        assert_eq!(budget.sustainable_rate(&state, &huge), 0.0);
        let dark = estimation(&budget, |_| 0.0, 0, 4.0);
        assert_eq!(budget.sustainable_rate(&dark, &action), 0.0);
    }

    #[test]
    fn what_uncertain_days_may_lack_is_reserved() {
        // By day the mean income is twice the standing load. 20 mF at 2.4 V hold 25 mJ above the lock-out.
        let storage =
            StorageParameters { capacitor: Capacitor { capacitance: 20e-3, ..tight().capacitor }, ..tight() };
        let budget = budget(storage, 14e-6);
        let action = Action::new("transmit", 15e-3, 0.1).expect("finite");
        let state = |dim: f64| {
            let mut state = budget.start(0);
            for slot in 0..6 * SLOTS {
                let power = 40e-6 * if (slot / SLOTS).is_multiple_of(2) { dim } else { 2.0 - dim };
                budget.update(&mut state, 1800, power * 1800.0, 0.0);
            }
            budget.correct_by_voltage(&mut state, 2.4, 0.0);
            (
                budget.can_afford(&state, &action, state.second()),
                budget.can_run_now(&state, &action, state.second()),
            )
        };
        assert_eq!(state(1.0), (true, true));
        assert_eq!(state(0.99), (true, true));
        assert_eq!(state(0.5), (true, false));
    }

    #[test]
    fn what_the_night_will_take_is_reserved() {
        // 20 mF hold 0.17 J above the lock-out; a night takes 2 µW for 12 h, 0.0864 J.
        let storage =
            StorageParameters { capacitor: Capacitor { capacitance: 20e-3, ..tight().capacitor }, ..tight() };
        let budget = budget(storage, 1.8e-6);
        let action = Action::new("transmit", 20e-3, 0.1).expect("finite");
        let full = estimation(&budget, daylight, 18, 4.5);
        let low = estimation(&budget, daylight, 18, 3.6);
        let morning = estimation(&budget, daylight, 7, 3.6);
        let answers = |state: &BudgetState<f64, SLOTS>| {
            let now = state.second();
            (budget.can_afford(state, &action, now), budget.can_run_now(state, &action, now))
        };
        assert_eq!(answers(&full), (true, true));
        assert_eq!(answers(&low), (true, false));
        assert_eq!(answers(&morning), (true, true));
    }
}
