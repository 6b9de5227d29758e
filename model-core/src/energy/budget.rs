//! A node's energy budget: the stored energy, its uncertainty, and whether the node can afford an action.
//!
//! The uncertainty bounds how much less the storage may hold than the stored energy. In the worst case all income of an
//! interval comes first, to leak or to find the storage full, and all energy is spent at the end. The uncertainty covers
//! this case and the rounding of the arithmetic. The caller raises it by the uncertainty of income and expenditure.

use super::account::{Account, AccountSums};
use super::battery::BatteryCurve;
use super::forecast::SlotRelaxations;
use super::income::{DAY_SECONDS, Income, IncomeParameters, IncomeState};
use super::storage::{Relaxation, Storage, StorageParameters};
use crate::bounds::{Bounds, ParameterError};
use crate::scalar::{Scalar, add_increment};
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Parameters of a [`Budget`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetParameters<S> {
    /// The storage.
    pub storage: StorageParameters<S>,
    /// The memory of the income.
    pub income: IncomeParameters<S>,
    /// Upper bound of the power in W that the load draws without any action, including the quiescent currents of converters; 0 to 10⁶.
    pub standing_power: S,
}

/// The energy budget of a node, with the day divided into `SLOTS` slots.
///
/// The stored energy in [`BudgetState`] assumes that income and expenditure are spread evenly over each interval.
/// The uncertainty of the state bounds how much less the storage may hold; a measured voltage replaces both.
///
/// ```
/// use model_core::energy::{Action, BudgetParameters, Capacitor, IncomeParameters, StorageParameters};
///
/// # fn main() -> Result<(), model_core::Error> {
/// let budget = BudgetParameters::<f32> {
///     storage: StorageParameters {
///         capacitor: Capacitor { capacitance: 470e-6, leakage_resistance: 20e6 },
///         charging_efficiency: 0.8,
///         discharging_efficiency: 0.9,
///         highest_voltage: 4.5,
///         lock_out_voltage: 1.8,
///         turn_on_voltage: 2.4,
///     },
///     income: IncomeParameters { time_constant: 4.0 * 3600.0, day_weight: 0.5 },
///     standing_power: 1.5e-6, // W, asleep
/// }
/// .build::<48>()?;
/// let measure = Action::new("measure", 40e-6, 0.02)?; // at most 40 µJ in 20 ms
/// let transmit = Action::new("transmit", 600e-6, 0.15)?;
///
/// // Power-up at 06:00; the ADC reads the storage voltage within 2 mV.
/// let mut now = 6 * 3600;
/// let mut state = budget.start(now);
/// budget.correct_by_voltage(&mut state, 2.5, 2e-3);
/// let (mut measured, mut transmitted) = (0, 0);
/// for _minute in 0..120 {
///     if budget.can_run_now(&state, &measure, now) {
///         measured += 1;
///         budget.spend(&mut state, measure.energy());
///     }
///     if budget.can_run_now(&state, &transmit, now + 1) {
///         transmitted += 1;
///         budget.spend(&mut state, transmit.energy());
///     }
///     now += 60; // asleep for the rest of the minute
///     let harvested = 30e-6 * 60.0; // J, from the estimator
///     budget.update(&mut state, 60, harvested, 0.0);
/// }
/// assert!(measured > 100 && transmitted > 50);
/// let period = 1.0 / budget.sustainable_rate(&state, &transmit);
/// assert!((24.0..39.0).contains(&period)); // s
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget<S: 'static, const SLOTS: usize> {
    pub(super) storage: Storage<S>,
    pub(super) income: Income<S, SLOTS>,
    pub(super) standing_power: S,
    pub(super) slots: SlotRelaxations<S>,
    /// Part of the stored energy that a day leaves, and energy in J from the storage that the standing load draws in it.
    pub(super) day_remaining: S,
    pub(super) day_drawn: S,
}

/// The state of a [`Budget`] at one time, with the income by slot of the day.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetState<S, const SLOTS: usize> {
    pub(super) income: IncomeState<S, SLOTS>,
    /// Stored energy in J.
    energy: S,
    /// The part of `energy` that rounding removed.
    energy_low: S,
    /// Upper bound in J of `energy` less the actual stored energy.
    uncertainty: S,
    /// Energy spent since the last update, in J at the storage.
    pending: S,
    account: AccountSums<S>,
}

impl<S: Scalar, const SLOTS: usize> BudgetState<S, SLOTS> {
    /// Stored energy in J at the last update.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Certain stored energy in J: at the last update, less the energy spent since.
    #[must_use]
    pub fn certain_energy(&self) -> S {
        (self.energy - self.uncertainty) - self.pending
    }

    /// Seconds since the midnight before [`Budget::start`].
    #[must_use]
    pub fn second(&self) -> u32 {
        self.income.second()
    }

    /// Mean harvested power in W, weighted towards the recent past with the time constant of [`IncomeParameters`].
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.income.mean_power()
    }

    /// The account of the energies since the start.
    #[must_use]
    pub fn account(&self) -> Account<S> {
        self.account.read()
    }

    /// Raises the uncertainty by `energy` in J: for an estimated income, by its error over the interval. An `energy`
    /// that is negative, not finite, or above 10⁹ J makes all of the stored energy uncertain.
    pub fn raise_uncertainty(&mut self, energy: S) {
        self.uncertainty = match self.account.admit(energy) {
            Some(energy) => (self.uncertainty + energy).min(self.energy),
            None => self.energy,
        };
    }
}

impl<S: Scalar> BudgetParameters<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first field outside its bounds.
    pub fn build<const SLOTS: usize>(self) -> Result<Budget<S, SLOTS>, ParameterError<S>> {
        self.build_on(self.storage.build())
    }

    /// As [`Self::build`], with a battery beside the capacitor of the storage.
    ///
    /// # Errors
    /// The first field outside its bounds.
    pub fn build_with_battery<const SLOTS: usize>(
        self,
        battery: &'static BatteryCurve<S>,
    ) -> Result<Budget<S, SLOTS>, ParameterError<S>> {
        self.build_on(self.storage.build_with_battery(battery))
    }

    fn build_on<const SLOTS: usize>(
        self,
        storage: Result<Storage<S>, ParameterError<S>>,
    ) -> Result<Budget<S, SLOTS>, ParameterError<S>> {
        Bounds::new(0.0, 1e6).check("standing_power", self.standing_power)?;
        let storage = storage?;
        let day = S::from_u32(DAY_SECONDS);
        Ok(Budget {
            income: self.income.build()?,
            standing_power: self.standing_power,
            slots: SlotRelaxations::new::<SLOTS>(&storage),
            day_remaining: storage.relaxation(day).remaining,
            day_drawn: storage.drawn(self.standing_power * day),
            storage,
        })
    }
}

impl<S: Scalar, const SLOTS: usize> Budget<S, SLOTS> {
    /// The storage.
    #[must_use]
    pub fn storage(&self) -> &Storage<S> {
        &self.storage
    }

    /// The state at a time in whole seconds since a midnight, with an empty storage. The node can afford no
    /// action before the first correction.
    #[must_use]
    pub fn start(&self, second: u32) -> BudgetState<S, SLOTS> {
        BudgetState {
            income: IncomeState::at(second),
            energy: S::ZERO,
            energy_low: S::ZERO,
            uncertainty: S::ZERO,
            pending: S::ZERO,
            account: AccountSums::default(),
        }
    }

    /// Advances the time by `interval` in s with the standing load, `harvested` J from the harvester, and
    /// `spent` J of actions in addition to those given to [`Budget::spend`]. For an interval in which the
    /// node was off, call [`Budget::gap`].
    ///
    /// An energy that is negative, not finite, or above 10⁹ J is refused and counted. A refused income counts as zero
    /// in the storage and as unknown in the income memory. After a refused expenditure the storage may be empty.
    ///
    /// Cost: at most two exponentials.
    pub fn update(&self, state: &mut BudgetState<S, SLOTS>, interval: u32, harvested: S, spent: S) {
        self.spend(state, spent);
        let harvested = state.account.admit(harvested);
        match harvested {
            Some(energy) => self.income.update(&mut state.income, interval, energy),
            None => self.income.gap(&mut state.income, interval),
        }
        let income = self.storage.stored(harvested.unwrap_or(S::ZERO));
        let standing = self.storage.drawn(self.standing_power * S::from_u32(interval));
        self.move_store(state, &self.storage.relaxation(S::from_u32(interval)), income, standing);
    }

    /// Books `spent` J of an action at once, before the next update.
    ///
    /// Cost: no exponential.
    pub fn spend(&self, state: &mut BudgetState<S, SLOTS>, spent: S) {
        match state.account.admit(spent) {
            Some(spent) => state.pending += self.storage.drawn(spent),
            None => state.uncertainty = state.energy,
        }
    }

    /// Advances the time by `interval` in s in which the node was off: the storage leaks, no income is
    /// counted, and the slots of the day in the interval keep their means.
    pub fn gap(&self, state: &mut BudgetState<S, SLOTS>, interval: u32) {
        self.income.gap(&mut state.income, interval);
        let relaxation = self.storage.relaxation(S::from_u32(interval));
        self.move_store(state, &relaxation, S::ZERO, S::ZERO);
    }

    /// Sets the stored energy to a measured `energy` in J that may be `uncertainty` in J too high. An energy
    /// that is negative, not finite, or above 10⁹ J is refused and counted.
    pub fn correct(&self, state: &mut BudgetState<S, SLOTS>, energy: S, uncertainty: S) {
        let Some(energy) = state.account.admit(energy) else { return };
        let energy = energy.min(self.storage.capacity());
        if state.pending > S::ZERO {
            // The measurement includes the energy spent since the last update.
            self.move_store(state, &self.storage.relaxation(S::ZERO), S::ZERO, S::ZERO);
        }
        state.account.corrected.add(energy - state.energy);
        state.account.corrected.add(-state.energy_low);
        (state.energy, state.energy_low) = (energy, S::ZERO);
        state.uncertainty = S::ZERO;
        state.raise_uncertainty(uncertainty);
    }

    /// Sets the stored energy by a measured voltage in V with an error of at most `error` in V, by quantisation and
    /// noise. A [`VoltageNode`](crate::node::VoltageNode) makes an income of such readings.
    ///
    /// A voltage or an error that is negative or not finite is refused and counted. A voltage that, less its
    /// error, exceeds the highest voltage of the storage is refused and counted too.
    pub fn correct_by_voltage(&self, state: &mut BudgetState<S, SLOTS>, voltage: S, error: S) {
        let readings = (state.account.admit(voltage), state.account.admit(error));
        let (Some(voltage), Some(error)) = readings else { return };
        let lowest = (voltage - error).max(S::ZERO);
        if lowest > self.storage.parameters().highest_voltage {
            state.account.refuse();
            return;
        }
        let energy = self.storage.energy(voltage).min(self.storage.capacity());
        self.correct(state, energy, (energy - self.storage.energy(lowest)).max(S::ZERO));
    }

    /// Whether the storage is certain to stay at or above the lock-out through an action that begins at the
    /// second `now`, without any income.
    ///
    /// The certain energy is reduced by the action, and by the standing load and the leakage from the last
    /// update to the end of the action. Pass overlapping actions combined: the duration of a booked action is
    /// not counted. The current second of the clock counts as elapsed.
    ///
    /// Cost: at most one exponential.
    #[must_use]
    pub fn can_afford(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>, now: u32) -> bool {
        let seconds = S::from_u32(state.income.seconds_until(now)) + action.duration();
        let used = action.energy() + self.standing_power * seconds;
        // Leakage is largest if all energy is drawn at the end.
        let remaining = (state.energy - state.uncertainty) * self.storage.relaxation(seconds).remaining;
        let left = remaining - state.pending - self.storage.drawn(used);
        let rounding = S::from_f64(4.0) * S::EPSILON * self.storage.capacity();
        left >= self.storage.lock_out() + rounding
    }

    /// Advances the storage by the interval of `relaxation`, with the pending energy; `income` and `standing` are in J at the storage.
    fn move_store(
        &self,
        state: &mut BudgetState<S, SLOTS>,
        relaxation: &Relaxation<S>,
        income: S,
        standing: S,
    ) {
        let storage = &self.storage;
        let least = state.energy - state.uncertainty;
        let wanted = standing + state.pending;
        state.pending = S::ZERO;
        let step = storage.step(state.energy, relaxation, income, wanted);
        state.account.enter(income, wanted, &step);

        // The lower bound of the energy: all income first, the part without room lost, then leakage, then all
        // expenditure. Its distance from the stored energy is computed term by term, so that nothing cancels.
        let mut distance = state.uncertainty * relaxation.remaining
            + income * relaxation.lost_by_early_income()
            + wanted * relaxation.lost_of_income()
            + (least + income - storage.capacity()).max(S::ZERO) * relaxation.remaining;
        let mut rounded = income + wanted + step.leaked;
        if step.shunted > S::ZERO || step.unserved > S::ZERO {
            distance += step.end - (state.energy + step.change);
            rounded += storage.capacity();
            (state.energy, state.energy_low) = (step.end, S::ZERO);
        } else {
            (state.energy, state.energy_low) = add_increment(state.energy, state.energy_low, step.change);
        }
        distance += S::from_f64(4.0) * S::EPSILON * rounded;
        // The load is cut at the lock-out. At worst the storage then leaks until the end of the interval.
        let floor = storage.lock_out().min(least + income) * relaxation.remaining;
        let above_floor = state.energy - floor + S::from_f64(4.0) * S::EPSILON * storage.capacity();
        state.uncertainty = distance.min(above_floor).max(S::ZERO).min(state.energy);
    }
}

snapshot_fields!(impl [S: Scalar, const SLOTS: usize] BudgetState<S, SLOTS> {
    income, energy, energy_low, uncertainty, pending, account,
} if |state| {
    let uncertain = S::ZERO <= state.uncertainty && state.uncertainty <= state.energy;
    uncertain && state.pending >= S::ZERO
});

impl<S: Scalar, const SLOTS: usize> Configuration for Budget<S, SLOTS> {
    type State = BudgetState<S, SLOTS>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("budget");
        self.storage.identify(fingerprint);
        self.income.identify(fingerprint);
        fingerprint.numbers(&[self.standing_power]);
    }
}

#[cfg(test)]
mod tests;

/// An action of a node on top of its standing load, such as a measurement or a transmission.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Action<S> {
    name: &'static str,
    energy: S,
    duration: S,
}

impl<S: Scalar> Action<S> {
    /// An action that takes at most `energy` in J at the load and at most `duration` in s. `name` is for logs.
    ///
    /// # Errors
    /// An `energy` or a `duration` that is not from 0 to 10⁹.
    pub fn new(name: &'static str, energy: S, duration: S) -> Result<Self, ParameterError<S>> {
        Bounds::new(0.0, 1e9).check("energy", energy)?;
        Bounds::new(0.0, 1e9).check("duration", duration)?;
        Ok(Self { name, energy, duration })
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Upper bound of the energy at the load in J.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Upper bound of the duration in s.
    #[must_use]
    pub fn duration(&self) -> S {
        self.duration
    }
}
