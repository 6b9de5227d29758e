//! The controller of a node: which actions it runs, by the energy budget of the core alone.
//!
//! Actions are listed by importance, after what the node does to know its income. The planned power of the budget, less
//! the standing power, is granted to them in this order, to each at most for its wished rate. Granted rates add up to
//! credits. An action with a credit of one is run if the budget allows it now.

use model_core::bounds::ParameterError;
use model_core::energy::{
    Action, BatteryCurve, Budget, BudgetParameters, BudgetState, Capacitor, IncomeParameters,
    StorageParameters,
};
use model_core::scalar::Scalar;

use crate::method::Failure;
use crate::scene_file::Node;

/// Shortfall of a credit that counts as rounding.
const ROUNDING: f64 = 1e-6;
/// Relative shortfall of a sustainable rate that counts as rounding: it is found by bisection.
const RATE_ROUNDING: f64 = 1e-4;
/// Largest factor of the capacitance that is tried.
const MOST_TIMES: f64 = 1e3;
/// Largest capacitance in F of a storage in a scene file.
const LARGEST_F: f64 = 1e4;

struct Due<S> {
    action: Action<S>,
    /// Wished rate in 1/s.
    wished: S,
    credit: f64,
}

pub(super) struct Controller<'a, S: 'static, const SLOTS: usize> {
    node: &'a Node,
    parameters: BudgetParameters<S>,
    battery: Option<&'static BatteryCurve<S>>,
    budget: Budget<S, SLOTS>,
    state: BudgetState<S, SLOTS>,
    /// The same of a node that is never off: it knows the income of every slot.
    informed: BudgetState<S, SLOTS>,
    due: Vec<Due<S>>,
    /// Whether the node was switched off since the last decision.
    was_off: bool,
}

/// The budget of a storage, with its battery.
fn built<S: Scalar, const SLOTS: usize>(
    parameters: BudgetParameters<S>,
    battery: Option<&'static BatteryCurve<S>>,
) -> Result<Budget<S, SLOTS>, ParameterError<S>> {
    match battery {
        Some(battery) => parameters.build_with_battery(battery),
        None => parameters.build(),
    }
}

impl<'a, S: Scalar, const SLOTS: usize> Controller<'a, S, SLOTS> {
    /// The controller at midnight, with the measured voltage of the storage in V.
    pub(super) fn new(node: &'a Node, voltage: f64) -> Result<Self, Failure> {
        let from = &node.storage;
        let refuse = |error: ParameterError<S>| Failure::Input(format!("node: {error}"));
        let parameters = BudgetParameters {
            storage: StorageParameters {
                capacitor: Capacitor {
                    capacitance: S::from_f64(from.capacitance_f),
                    leakage_resistance: S::from_f64(from.leakage_ohm),
                },
                charging_efficiency: S::from_f64(from.charging_efficiency),
                discharging_efficiency: S::from_f64(from.discharging_efficiency),
                highest_voltage: S::from_f64(from.highest_v),
                lock_out_voltage: S::from_f64(from.turn_off_v),
                turn_on_voltage: S::from_f64(from.turn_on_v),
            },
            income: IncomeParameters {
                time_constant: S::from_f64(node.time_constant_s),
                day_weight: S::from_f64(node.day_weight),
            },
            // The budget has its loads at the node: the storage's own power is converted to the node's side.
            standing_power: S::from_f64(
                node.standing_power_w + from.own_power_w * from.discharging_efficiency,
            ),
        };
        let due = node.all_actions().map(|action| {
            Ok(Due {
                action: Action::new("", S::from_f64(action.energy_j), S::from_f64(action.duration_s))
                    .map_err(refuse)?,
                wished: S::from_f64(1.0 / action.every_s),
                credit: 0.0,
            })
        });
        let due = due.collect::<Result<_, Failure>>()?;
        let battery =
            from.battery.map(|battery| battery.of_core().curve(from.capacitance_f as f32)).transpose();
        let battery = battery.map_err(|error| Failure::Input(format!("node: {error}")))?;
        // A day of a node makes one, which the budget of a firmware has in its flash.
        let battery: Option<&'static BatteryCurve<S>> = battery.map(|curve| &*Box::leak(Box::new(curve)));
        let budget = built(parameters, battery).map_err(refuse)?;
        let mut state = budget.start(0);
        budget.correct_by_voltage(&mut state, S::from_f64(voltage), S::ZERO);
        Ok(Self { node, parameters, battery, budget, state, informed: state, due, was_off: false })
    }

    /// The rates in 1/s at which the actions can run for ever by the income learnt so far, at most the wished rates.
    pub(super) fn sustainable_rates(&self) -> Vec<f64> {
        self.rates_with(self.parameters, &self.state)
    }

    fn rates_with(&self, mut parameters: BudgetParameters<S>, state: &BudgetState<S, SLOTS>) -> Vec<f64> {
        let rates = self.due.iter().map(|due| {
            // The actions may raise the standing power above its bound: then no rate is left.
            let rate = built::<S, SLOTS>(parameters, self.battery)
                .map_or(S::ZERO, |budget| budget.sustainable_rate(state, &due.action).min(due.wished));
            parameters.standing_power += rate * due.action.energy();
            rate.to_f64()
        });
        rates.collect()
    }

    /// The smallest capacitance in F with which a full storage sustains all wished rates by the income of every slot, at least a thousandth of that of the
    /// node; `None` if a thousand times it, or the largest one that a scene may have, does not, and with a battery. The leakage
    /// resistance stays.
    pub(super) fn smallest_capacitance(&self) -> Option<f64> {
        if self.battery.is_some() {
            return None;
        }
        let suffices = |factor: f64| {
            let mut parameters = self.parameters;
            let storage = &mut parameters.storage;
            storage.capacitor.capacitance *= S::from_f64(factor);
            let highest = storage.highest_voltage;
            parameters.build::<SLOTS>().is_ok_and(|budget| {
                let mut state = self.informed;
                budget.correct_by_voltage(&mut state, highest, S::ZERO);
                let rates = self.rates_with(parameters, &state);
                rates
                    .iter()
                    .zip(&self.due)
                    .all(|(rate, due)| *rate >= due.wished.to_f64() * (1.0 - RATE_ROUNDING))
            })
        };
        let own = self.node.storage.capacitance_f;
        let (mut little, mut enough) = (1.0 / MOST_TIMES, MOST_TIMES.min(LARGEST_F / own));
        if !suffices(enough) {
            return None;
        }
        while enough > 1.001 * little {
            let middle = (little * enough).sqrt();
            *(if suffices(middle) { &mut enough } else { &mut little }) = middle;
        }
        Some(enough * own)
    }

    /// The rates in 1/s that the actions are granted now.
    fn granted_rates(&self) -> Vec<f64> {
        let reserve = self.due.iter().map(|due| due.action.energy()).fold(S::ZERO, S::max);
        let planned = self.budget.planned_power(&self.state, reserve);
        let mut spare = planned - self.parameters.standing_power;
        let rates = self.due.iter().map(|due| {
            let rate = (spare / due.action.energy()).max(S::ZERO).min(due.wished);
            spare -= rate * due.action.energy();
            rate.to_f64()
        });
        rates.collect()
    }

    /// Measures the voltage of the storage in V, if the node was switched off before.
    pub(super) fn wake(&mut self, voltage: f64) {
        if std::mem::take(&mut self.was_off) {
            self.budget.correct_by_voltage(&mut self.state, S::from_f64(voltage), S::ZERO);
        }
    }

    /// The actions to run now, by their number in [`Node::all_actions`]; their energy is booked as spent.
    pub(super) fn decide(&mut self) -> Vec<usize> {
        let rates = self.granted_rates();
        let now = self.state.second();
        let mut run = Vec::new();
        for (index, (due, rate)) in self.due.iter_mut().zip(rates).enumerate() {
            let granted = rate * f64::from(self.node.decision_s);
            // Credit for actions that could not be run does not add up.
            due.credit = (due.credit + granted).min(1.0 + granted);
            while due.credit >= 1.0 - ROUNDING && self.budget.can_run_now(&self.state, &due.action, now) {
                self.budget.spend(&mut self.state, due.action.energy());
                due.credit -= 1.0;
                run.push(index);
            }
        }
        run
    }

    /// Books an interval in which the harvester delivered `harvested_j` in J. A node that was off knows only its length.
    pub(super) fn update(&mut self, seconds: u32, harvested_j: f64, was_on: bool) {
        self.budget.update(&mut self.informed, seconds, S::from_f64(harvested_j), S::ZERO);
        if was_on {
            self.budget.update(&mut self.state, seconds, S::from_f64(harvested_j), S::ZERO);
        } else {
            self.budget.gap(&mut self.state, seconds);
            self.was_off = true;
        }
    }

    /// Estimate of the stored energy in J.
    pub(super) fn stored_j(&self) -> f64 {
        self.state.energy().to_f64()
    }

    /// Residual of the account of the budget since the start, over all income.
    pub(super) fn ledger_residual(&self) -> Option<f64> {
        let account = self.state.account();
        let income = account.income.to_f64();
        let left = (account.balance - self.state.energy()).to_f64();
        (income > 0.0).then(|| left.abs() / income)
    }
}
