//! A node's energy budget: what is in the store, what came, what went, and what may be done now.
//!
//! The state of charge is two numbers. The stored energy is what it would be had everything come and gone
//! evenly over each interval. Its uncertainty bounds how much lower the truth can be: given what came in and
//! what was spent, the store is lowest if all income came first, to leak or to find the store full, and all
//! was spent at the end; both ends are followed, and the rounding of the arithmetic is added. The caller
//! raises it by what is not known of income and expenditure; a measured voltage replaces both numbers.
//!
//! In `f32`, and with an update a minute or a second, a simulated day ends within 3·10⁻⁷ of the capacity of
//! where `f64` ends.
//!
//! ```
//! use model_core::energy::{Action, BudgetParameters, IncomeParameters, StorageParameters};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let budget = BudgetParameters::<f32> {
//!     storage: StorageParameters {
//!         capacitance: 470e-6,
//!         leakage_resistance: 20e6,
//!         charging_efficiency: 0.8,
//!         discharging_efficiency: 0.9,
//!         highest_voltage: 4.5,
//!         lock_out_voltage: 1.8,
//!         turn_on_voltage: 2.4,
//!     },
//!     income: IncomeParameters { time_constant: 4.0 * 3600.0, day_weight: 0.5 },
//!     standing_power: 1.5e-6, // asleep, watts
//! }
//! .build::<48>()?;
//! let measure = Action::new("measure", 40e-6, 0.02)?; // at most 40 µJ in 20 ms
//! let transmit = Action::new("transmit", 600e-6, 0.15)?;
//!
//! // At power-up, 06:00: the store as the ADC reads it, good to 2 mV.
//! let mut state = budget.start(6 * 3600);
//! budget.correct_by_voltage(&mut state, 2.5, 2e-3);
//! let (mut measured, mut transmitted) = (0, 0);
//! for _minute in 0..120 {
//!     let mut spent = 0.0;
//!     if budget.can_run_now(&state, &measure) {
//!         measured += 1;
//!         spent += measure.energy();
//!         budget.spend(&mut state, measure.energy());
//!     }
//!     if budget.can_run_now(&state, &transmit) {
//!         transmitted += 1;
//!         budget.spend(&mut state, transmit.energy());
//!     }
//!     let harvested = 30e-6 * 60.0; // joules: what the estimator says of this minute
//!     budget.update(&mut state, 60, harvested, 0.0);
//! }
//! assert!(measured > 100 && transmitted > 50);
//! let period = budget.sustainable_period(&state, &transmit).ok_or("never")?;
//! assert!((25..40).contains(&period)); // seconds
//! # Ok(())
//! # }
//! ```

use super::income::{Income, IncomeParameters, IncomeState};
use super::storage::{Storage, StorageParameters};
use crate::part::bounds::{Bounds, ParameterError};
use crate::scalar::{CompensatedSum, Scalar, add_increment};

/// What a budget is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetParameters<S> {
    /// The store.
    pub storage: StorageParameters<S>,
    /// How income is remembered.
    pub income: IncomeParameters<S>,
    /// Power in watts that the load draws whatever it does, converters' quiescent currents included; an
    /// upper bound, as an action's energy is.
    pub standing_power: S,
}

/// Something that a node can do, on top of its standing load.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Action<S> {
    name: &'static str,
    energy: S,
    duration: S,
}

/// A budget whose parameters have been checked, with the day in `SLOTS` slots.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget<S, const SLOTS: usize> {
    pub(super) storage: Storage<S>,
    pub(super) income: Income<S, SLOTS>,
    pub(super) standing_power: S,
}

/// Where energy came from and went since the start, in joules at the store.
///
/// `opening + income − shunted − leaked − (drawn − unserved) + corrected` is the stored energy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Account<S> {
    income: CompensatedSum<S>,
    drawn: CompensatedSum<S>,
    leaked: CompensatedSum<S>,
    shunted: CompensatedSum<S>,
    unserved: CompensatedSum<S>,
    corrected: CompensatedSum<S>,
    refused: u32,
}

/// What a budget knows at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetState<S, const SLOTS: usize> {
    pub(super) income: IncomeState<S, SLOTS>,
    energy: S,
    /// What rounding took from `energy`.
    energy_low: S,
    uncertainty: S,
    supplied: bool,
    account: Account<S>,
}

impl<S: Scalar> Action<S> {
    /// An action that takes at most `energy` joules at the load and at most `duration` seconds.
    ///
    /// # Errors
    /// `energy` or `duration` negative, infinite or not a number.
    pub fn new(name: &'static str, energy: S, duration: S) -> Result<Self, ParameterError<S>> {
        Bounds::new(0.0, 1e9).check("energy", energy)?;
        Bounds::new(0.0, 1e9).check("duration", duration)?;
        Ok(Self { name, energy, duration })
    }

    /// Its name, for a log.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Upper bound of what it takes at the load, in joules.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Upper bound of how long it takes, in seconds.
    #[must_use]
    pub fn duration(&self) -> S {
        self.duration
    }
}

impl<S: Scalar> Account<S> {
    const EMPTY: Self = Self {
        income: CompensatedSum::ZERO,
        drawn: CompensatedSum::ZERO,
        leaked: CompensatedSum::ZERO,
        shunted: CompensatedSum::ZERO,
        unserved: CompensatedSum::ZERO,
        corrected: CompensatedSum::ZERO,
        refused: 0,
    };

    /// Harvested, through the charging efficiency.
    #[must_use]
    pub fn income(&self) -> S {
        self.income.value()
    }

    /// Asked for by the load, through the discharging efficiency.
    #[must_use]
    pub fn drawn(&self) -> S {
        self.drawn.value()
    }

    /// Leaked.
    #[must_use]
    pub fn leaked(&self) -> S {
        self.leaked.value()
    }

    /// Income for which the store had no room.
    #[must_use]
    pub fn shunted(&self) -> S {
        self.shunted.value()
    }

    /// Of what the load asked for, the part that the store could not give above its lock-out. On a node that
    /// did spend it, a sign that the store was thought lower than it was.
    #[must_use]
    pub fn unserved(&self) -> S {
        self.unserved.value()
    }

    /// Put right by measurements, the first one included: positive where the store held more than thought.
    #[must_use]
    pub fn corrected(&self) -> S {
        self.corrected.value()
    }

    /// Number of energies that were negative or not finite, and were not counted.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// What the store holds by this account: it began with nothing.
    #[must_use]
    pub fn balance(&self) -> S {
        let mut sum = self.corrected;
        for term in [self.income(), -self.shunted(), -self.leaked(), -self.drawn(), self.unserved()] {
            sum.add(term);
        }
        sum.value()
    }

    /// `value` if it can be an amount of energy.
    fn admit(&mut self, value: S) -> Option<S> {
        if value >= S::ZERO && value < S::INFINITY {
            return Some(value);
        }
        self.refused = self.refused.saturating_add(1);
        None
    }
}

impl<S: Scalar, const SLOTS: usize> BudgetState<S, SLOTS> {
    /// Stored energy in joules.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// By how many joules the stored energy may be lower than that.
    #[must_use]
    pub fn uncertainty(&self) -> S {
        self.uncertainty
    }

    /// Stored energy that is certain, in joules.
    #[must_use]
    pub fn certain_energy(&self) -> S {
        self.energy - self.uncertainty
    }

    /// Whether the load is switched on: not since the lock-out was met, until the turn-on voltage is.
    #[must_use]
    pub fn is_supplied(&self) -> bool {
        self.supplied
    }

    /// What is remembered of the income, and the time.
    #[must_use]
    pub fn income(&self) -> &IncomeState<S, SLOTS> {
        &self.income
    }

    /// Where energy came from and went.
    #[must_use]
    pub fn account(&self) -> &Account<S> {
        &self.account
    }

    /// The stored energy may be lower by another `energy` joules: for an income that is only estimated, its
    /// error over the interval. What is negative or not finite makes all of it uncertain.
    pub fn raise_uncertainty(&mut self, energy: S) {
        self.uncertainty = match self.account.admit(energy) {
            Some(energy) => (self.uncertainty + energy).smaller(self.energy),
            None => self.energy,
        };
    }
}

impl<S: Scalar> BudgetParameters<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first field that is out of its bounds.
    pub fn build<const SLOTS: usize>(self) -> Result<Budget<S, SLOTS>, ParameterError<S>> {
        Bounds::new(0.0, 1e6).check("standing_power", self.standing_power)?;
        Ok(Budget {
            storage: self.storage.build()?,
            income: self.income.build()?,
            standing_power: self.standing_power,
        })
    }
}

impl<S: Scalar, const SLOTS: usize> Budget<S, SLOTS> {
    /// The store.
    #[must_use]
    pub fn storage(&self) -> &Storage<S> {
        &self.storage
    }

    /// The state at a time in whole seconds since a midnight, with an empty store: until a first correction
    /// nothing can be afforded.
    #[must_use]
    pub fn start(&self, second: u32) -> BudgetState<S, SLOTS> {
        BudgetState {
            income: IncomeState::at(second),
            energy: S::ZERO,
            energy_low: S::ZERO,
            uncertainty: S::ZERO,
            supplied: false,
            account: Account::EMPTY,
        }
    }

    /// Time moves on by `interval` seconds, in which `harvested` joules came from the harvester and `spent`
    /// joules went into actions; the standing load, while switched on, is added here.
    ///
    /// An energy that is negative or not finite is refused and counted: an income as none at all and unknown
    /// to the memory, an expenditure as one that may have emptied the store. At most two exponentials.
    pub fn update(&self, state: &mut BudgetState<S, SLOTS>, interval: u32, harvested: S, spent: S) {
        let (harvested, spent) = (state.account.admit(harvested), state.account.admit(spent));
        match harvested {
            Some(energy) => self.income.update(&mut state.income, interval, energy),
            None => self.income.gap(&mut state.income, interval),
        }
        let standing = if state.supplied { self.standing_power * S::from_u32(interval) } else { S::ZERO };
        let used = spent.unwrap_or(S::ZERO) + standing;
        self.move_store(state, interval, harvested.unwrap_or(S::ZERO), used);
        if spent.is_none() {
            state.uncertainty = state.energy;
        }
    }

    /// An action has just taken `spent` joules: an update of no length. No exponential.
    pub fn spend(&self, state: &mut BudgetState<S, SLOTS>, spent: S) {
        self.update(state, 0, S::ZERO, spent);
    }

    /// Time moves on by `interval` seconds of which nothing is known, the node having been off: the store
    /// leaks, no income is counted, and the slots of the day in between stay as they are.
    pub fn gap(&self, state: &mut BudgetState<S, SLOTS>, interval: u32) {
        self.income.gap(&mut state.income, interval);
        self.move_store(state, interval, S::ZERO, S::ZERO);
    }

    /// The store holds `energy` joules, and may hold `uncertainty` joules less: by a measurement. Whoever
    /// can measure is supplied, if above the lock-out. Not-a-number is refused.
    pub fn correct(&self, state: &mut BudgetState<S, SLOTS>, energy: S, uncertainty: S) {
        let Some(energy) = state.account.admit(energy) else { return };
        let energy = energy.smaller(self.storage.capacity());
        state.account.corrected.add(energy - state.energy);
        state.account.corrected.add(-state.energy_low);
        (state.energy, state.energy_low) = (energy, S::ZERO);
        state.uncertainty = S::ZERO;
        state.raise_uncertainty(uncertainty);
        state.supplied = energy > self.storage.lock_out();
    }

    /// The store is at `voltage` volts to within `error` volts: a reading whose error is bounded, by the
    /// quantisation of the converter and its noise. See the estimator of gain and store for readings that are
    /// weighed against a model.
    pub fn correct_by_voltage(&self, state: &mut BudgetState<S, SLOTS>, voltage: S, error: S) {
        let energy = self.storage.energy(voltage).smaller(self.storage.capacity());
        let least = self.storage.energy((voltage - error).larger(S::ZERO));
        self.correct(state, energy, (energy - least).larger(S::ZERO));
    }

    /// Whether an action can be afforded now, whatever income does: whether what is certain of the store,
    /// after all that the action and the standing load may take of it and all that may leak meanwhile, with
    /// no income, is still at or above the lock-out.
    ///
    /// No prediction enters. At most one exponential.
    #[must_use]
    pub fn can_afford(&self, state: &BudgetState<S, SLOTS>, action: &Action<S>) -> bool {
        let used = action.energy + self.standing_power * action.duration;
        // Leakage is largest if all is taken at the end.
        let kept = state.certain_energy() * self.storage.relaxation(action.duration).kept;
        let rounding = S::literal(4.0) * S::EPSILON * self.storage.capacity();
        state.supplied && kept - self.storage.drawn(used) >= self.storage.lock_out() + rounding
    }

    fn move_store(&self, state: &mut BudgetState<S, SLOTS>, interval: u32, harvested: S, used: S) {
        let storage = &self.storage;
        let (income, outgo) = (storage.stored(harvested), storage.drawn(used));
        let relaxation = storage.relaxation(S::from_u32(interval));
        // A load that is off takes nothing: what it is said to have taken is unserved.
        let served = if state.supplied { outgo } else { S::ZERO };
        let step = storage.step(state.energy, &relaxation, income, served);
        let account = &mut state.account;
        account.income.add(income);
        account.drawn.add(outgo);
        account.leaked.add(step.leaked);
        account.shunted.add(step.shunted);
        account.unserved.add(step.unserved + (outgo - served));

        // The lower end: all income first, what has no room lost, leakage, all expenditure last. Followed by
        // its distance from the stored energy, term by term, so that nothing cancels.
        let early = state.certain_energy() + income - storage.capacity();
        let limited = step.shunted > S::ZERO || step.unserved > S::ZERO;
        let mut distance = state.uncertainty * relaxation.kept
            + income * relaxation.lost_by_early_income()
            + served * relaxation.lost_of_income()
            + early.larger(S::ZERO) * relaxation.kept;
        let mut rounded = income + served + step.leaked;
        if limited {
            distance += step.end - (state.energy + step.change);
            rounded += storage.capacity();
            (state.energy, state.energy_low) = (step.end, S::ZERO);
        } else {
            (state.energy, state.energy_low) = add_increment(state.energy, state.energy_low, step.change);
        }
        distance += S::literal(4.0) * S::EPSILON * rounded;
        state.uncertainty = distance.larger(S::ZERO).smaller(state.energy);
        if state.energy <= storage.lock_out() {
            state.supplied = false;
        } else if state.energy >= storage.turn_on() {
            state.supplied = true;
        }
    }
}
