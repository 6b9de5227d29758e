//! The numbers of a simulated day.

use serde::Serialize;
use serde_json::json;

use super::plant::StorageAccount;
use crate::embedded::WholeDay;
use crate::name::Name;
use crate::outcome::{Fields, Format, fields, text};
use crate::report::setting::with_unit;
use harvester_scene::market::Evidence;

use crate::scene_file::{EstimationCost, HOURS, PartFigure};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeDay {
    /// Where energy came from and went.
    pub(super) account: StorageAccount,
    /// The actions, in the order of the scene file, without what is done to know the income.
    pub(super) actions: Vec<ActionOutcome>,
    /// What was done to know the income.
    pub(super) estimation: Vec<EstimationOutcome>,
    /// Energy that it took from the storage in J.
    pub(super) estimation_j: f64,
    /// Power of the named parts asleep in W, if parts are named.
    pub(super) asleep_power_w: Option<f64>,
    /// Power that the node takes whatever it does in W.
    pub(super) standing_power_w: f64,
    pub(super) figures: Vec<PartFigure>,
    /// Stored energy in J at the start.
    pub(super) start_j: f64,
    /// At the end.
    pub(super) end_j: f64,
    /// The least during the day.
    pub(super) lowest_j: f64,
    /// At the highest voltage.
    pub(super) capacity_j: f64,
    /// At the voltage at which the node is switched off.
    pub(super) turn_off_j: f64,
    /// Lowest voltage of the storage in V.
    pub(super) lowest_v: f64,
    /// Largest difference between the stored energy and the node's estimate of it, over the capacity.
    pub(super) budget_error: f64,
    /// Residual of the account of the node's budget since the start, over all income; `None` without income.
    pub(super) budget_ledger: Option<f64>,
    /// The smallest capacitance in F with which all wished actions can be run every day, by the budget at the start of
    /// the day; `None` if a thousand times the capacitance is too small.
    pub(super) smallest_capacitance_f: Option<f64>,
    /// Stored energy and income over the day, at the updates.
    pub(super) samples: Vec<Sample>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ActionOutcome {
    pub(super) name: Name,
    pub(super) runs: u32,
    /// How often it was to be run.
    #[serde(rename = "wished_runs")]
    pub(super) wished: f64,
    /// How often, by the budget at the start of the day, it could be run every day at an even rate.
    #[serde(rename = "sustainable_runs")]
    pub(super) predicted: f64,
    /// The time in s between runs at that rate; `None` if it can never be run.
    pub(super) sustainable_period_s: Option<f64>,
    /// Energy that it took at the node in J.
    pub(super) spent_j: f64,
    /// How often it was run in each hour.
    #[serde(skip)]
    pub(super) by_hour: [u32; HOURS],
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct EstimationOutcome {
    #[serde(flatten)]
    pub(super) outcome: ActionOutcome,
    /// Energy at the node of one in J.
    energy_j: f64,
    /// The same by what takes it.
    #[serde(skip)]
    costs: Vec<(&'static str, f64)>,
}

impl EstimationOutcome {
    pub(super) fn new(estimation: &EstimationCost, outcome: ActionOutcome) -> Self {
        Self { outcome, energy_j: estimation.action.energy_j, costs: estimation.costs.clone() }
    }

    /// Names and values, those of its costs at the end.
    fn fields(&self) -> Fields {
        let mut all = fields(self);
        all.extend(self.costs.iter().map(|(name, joules)| ((*name).to_owned(), json!(joules))));
        all
    }

    /// Mean power in W in an hour of the day.
    pub(super) fn power_w(&self, hour: usize) -> f64 {
        f64::from(self.outcome.by_hour.get(hour).copied().unwrap_or(0)) * self.energy_j / 3600.0
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Second of the day.
    pub(super) second: u32,
    pub(super) stored_j: f64,
    /// Mean power delivered by the harvester over the interval, in W.
    pub(super) income_w: f64,
}

/// How the income was computed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    pub(crate) scene: &'static str,
    /// Precision of harvester and budget.
    pub(crate) precision: &'static str,
    /// `by-level` or `exact`.
    pub(crate) income: &'static str,
    /// Days before this one.
    pub(crate) learning_days: u32,
    /// The harvester's day, if every step of it was taken.
    pub(crate) whole_day: Option<WholeDay>,
    /// The largest statement and the warnings of the runs by which the income was computed.
    pub(crate) stated: Fields,
}

impl NodeDay {
    /// Residual of the account of the storage, over the larger of its income and its capacity.
    pub(crate) fn storage_residual(&self) -> f64 {
        let StorageAccount { income, shunted, leaked, actions, standing, .. } = self.account;
        let left = self.end_j - self.start_j - (income - shunted - leaked - actions - standing);
        left.abs() / income.max(self.capacity_j)
    }

    /// Names and values, without the actions.
    fn fields(&self, source: &Source) -> Fields {
        let account = &self.account;
        let mut all = fields(&json!({
            "scene": source.scene,
            "precision": source.precision,
            "income": source.income,
            "learning_days": source.learning_days,
            "harvested_energy_j": account.harvested,
            "mean_harvested_power_w": account.harvested / f64::from(super::DAY_S),
            "income_j": account.income,
            "shunted_j": account.shunted,
            "leaked_j": account.leaked,
            "actions_j": account.actions - self.estimation_j,
            "estimation_j": self.estimation_j,
            "standing_j": account.standing,
            "standing_power_w": self.standing_power_w,
            "asleep_power_w": self.asleep_power_w,
            "estimation_share_of_income": (account.income > 0.0).then(|| self.estimation_j / account.income),
            "store_residual": self.storage_residual(),
            "start_charge": self.start_j / self.capacity_j,
            "end_charge": self.end_j / self.capacity_j,
            "lowest_charge": self.lowest_j / self.capacity_j,
            "lowest_voltage_v": self.lowest_v,
            "lockout_s": account.lockout_s,
            "lockouts": account.lockouts,
            "budget_error": self.budget_error,
            "budget_ledger_residual": self.budget_ledger,
            "capacitance_for_wishes_f": self.smallest_capacitance_f,
        }));
        if let Some(day) = &source.whole_day {
            all.extend(fields(&json!({ "steps": day.steps, "energy_residual": day.energy_residual })));
            all.extend(fields(&day.created));
        }
        if account.steps > 0 {
            all.extend(fields(&json!({ "steps": account.steps, "diode_loss_j": account.diodes })));
        }
        all.extend(source.stated.clone());
        all
    }

    /// Those of the whole day that a search over keys has, with the largest statement of its income.
    pub(super) fn numbers(&self, income_accuracy: Option<f64>) -> Fields {
        let [runs, wished] = self.runs();
        let actions =
            self.actions.iter().map(|one| (format!("node_{}_runs", one.name.line()), json!(one.runs)));
        let all = fields(&json!({
            "node_runs": runs,
            "node_wished_runs": wished,
            "node_lockouts": self.account.lockouts,
            "node_lockout_s": self.account.lockout_s,
            "node_lowest_voltage_v": self.lowest_v,
            "node_shunted_j": self.account.shunted,
            "node_capacitance_for_wishes_f": self.smallest_capacitance_f,
            "node_income_accuracy": income_accuracy,
        }));
        all.into_iter().chain(actions).collect()
    }

    /// Runs of all actions, and how often they were to be run.
    fn runs(&self) -> [f64; 2] {
        let runs = self.actions.iter().map(|one| f64::from(one.runs)).sum();
        [runs, self.actions.iter().map(|one| one.wished).sum()]
    }

    /// Whether the wishes are met, and by which storage they would be, in a sentence. A
    /// wish is met to a hundredth: decisions fall between its periods, and a day begins and ends within one.
    fn verdict(&self) -> String {
        let [runs, wished] = self.runs();
        let is_met = self.actions.iter().all(|one| f64::from(one.runs) + 1.0 >= 0.99 * one.wished);
        let storage = match self.smallest_capacitance_f {
            Some(smallest) => {
                // It is sought to a thousandth.
                let smallest = format!("{smallest:.3e}").parse().unwrap_or(smallest);
                format!("the smallest storage that sustains all of them has {}", with_unit(smallest, "F"))
            }
            None => "no capacitance is known that sustains all of them".to_owned(),
        };
        let (word, lockouts) = (if is_met { "met" } else { "not met" }, self.account.lockouts);
        format!(
            "wishes {word}: {runs:.0} of {wished:.0} runs, {lockouts} lock-out{}; {storage}",
            if lockouts == 1 { "" } else { "s" }
        )
    }

    /// The figures of the named parts that no source confirms, as one text.
    fn not_confirmed(&self) -> String {
        let figures = self.figures.iter().filter(|figure| figure.evidence != Evidence::Confirmed);
        let texts = figures.map(|PartFigure { part, quantity, evidence, .. }| {
            format!("{part} {quantity} {}", format!("{evidence:?}").to_lowercase())
        });
        texts.collect::<Vec<_>>().join("; ")
    }

    /// The whole text, line break at its end included. In JSON the actions, what is done to know the income, and the
    /// figures of the parts are lists of objects; in the other formats the name of an action is a prefix of the names of its values.
    pub(crate) fn text(&self, source: &Source, format: Format) -> String {
        let mut all = self.fields(source);
        if format == Format::Json {
            all.insert("actions".to_owned(), json!(self.actions));
            let estimation: Vec<Fields> = self.estimation.iter().map(EstimationOutcome::fields).collect();
            all.insert("estimation".to_owned(), json!(estimation));
            all.insert("figures".to_owned(), json!(self.figures));
        } else {
            let estimation =
                self.estimation.iter().map(|estimation| (&estimation.outcome.name, estimation.fields()));
            let actions = self.actions.iter().map(|action| (&action.name, fields(action)));
            for (name, values) in estimation.chain(actions) {
                let values = values.into_iter().filter(|(key, _)| key != "name");
                all.extend(values.map(|(key, value)| (format!("{}_{key}", name.line()), value)));
            }
            if !self.figures.is_empty() {
                all.insert("figures_not_confirmed".to_owned(), json!(self.not_confirmed()));
            }
        }
        all.insert("verdict".to_owned(), json!(self.verdict()));
        text(&all, format)
    }
}
