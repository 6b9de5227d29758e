//! What a simulated day was like, as numbers.

use serde_json::{Map, Value, json};

use super::store::StoreAccount;
use crate::outcome::{Format, text};
use crate::scene_file::HOURS;

/// The day of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeDay {
    /// Where energy came from and went.
    pub account: StoreAccount,
    /// The actions, in the order of the scene file.
    pub actions: Vec<ActionOutcome>,
    /// Stored energy in J at the start.
    pub start_j: f64,
    /// At the end.
    pub end_j: f64,
    /// The least in between.
    pub lowest_j: f64,
    /// At the highest voltage.
    pub capacity_j: f64,
    /// At the voltage at which the node is switched off.
    pub turn_off_j: f64,
    /// Lowest voltage of the store in V.
    pub lowest_v: f64,
    /// Largest difference between what the node believed to be in its store and what was, over the capacity.
    pub budget_error: f64,
    /// What is left over in the account of the node's budget since the start, over all income; `None` without any.
    pub budget_ledger: Option<f64>,
    /// The store and the income over the day, at the updates.
    pub samples: Vec<Sample>,
}

/// An action over the day.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionOutcome {
    /// Its name.
    pub name: String,
    /// How often it was run.
    pub runs: u32,
    /// How often it was wished for.
    pub wished: f64,
    /// How often, by the budget at the start of the day, it could be run every day.
    pub predicted: f64,
    /// What it took at the node, in J.
    pub spent_j: f64,
    /// How often it was run in each hour.
    pub by_hour: [u32; HOURS],
}

/// The end of an update interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Second of the day.
    pub second: u32,
    /// Stored energy in J.
    pub stored_j: f64,
    /// Mean power delivered by the harvester over the interval, in W.
    pub income_w: f64,
}

/// How the income was found, beside the day itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Name of the scene.
    pub scene: &'static str,
    /// Precision of harvester and budget.
    pub precision: &'static str,
    /// `by-level` or `exact`.
    pub income: &'static str,
    /// Days before this one.
    pub learning_days: u32,
    /// Steps of the harvester and the residual of its ledger, where every step of the day was taken.
    pub whole_day: Option<(u64, Option<f64>)>,
}

impl NodeDay {
    /// What is left over in the account of the store, over the larger of its income and its capacity.
    #[must_use]
    pub fn store_residual(&self) -> f64 {
        let StoreAccount { income, shunted, leaked, actions, standing, .. } = self.account;
        let left = self.end_j - self.start_j - (income - shunted - leaked - actions - standing);
        left.abs() / income.max(self.capacity_j)
    }

    /// Names and values but for the actions.
    fn fields(&self, source: &Source) -> Vec<(String, Value)> {
        let account = &self.account;
        let mut fields: Vec<(&str, Value)> = vec![
            ("scene", source.scene.into()),
            ("precision", source.precision.into()),
            ("income", source.income.into()),
            ("learning_days", source.learning_days.into()),
            ("harvested_energy_j", account.harvested.into()),
            ("mean_harvested_power_w", (account.harvested / f64::from(super::DAY_S)).into()),
            ("income_j", account.income.into()),
            ("shunted_j", account.shunted.into()),
            ("leaked_j", account.leaked.into()),
            ("actions_j", account.actions.into()),
            ("standing_j", account.standing.into()),
            ("store_residual", self.store_residual().into()),
            ("start_charge", (self.start_j / self.capacity_j).into()),
            ("end_charge", (self.end_j / self.capacity_j).into()),
            ("lowest_charge", (self.lowest_j / self.capacity_j).into()),
            ("lowest_voltage_v", self.lowest_v.into()),
            ("lockout_s", account.lockout_s.into()),
            ("lockouts", account.lockouts.into()),
            ("budget_error", self.budget_error.into()),
            ("budget_ledger_residual", self.budget_ledger.into()),
        ];
        if let Some((steps, residual)) = source.whole_day {
            fields.push(("steps", steps.into()));
            fields.push(("energy_residual", residual.into()));
        }
        if account.steps > 0 {
            fields.push(("steps", account.steps.into()));
            fields.push(("diode_loss_j", account.diodes.into()));
        }
        fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// The whole text, line break at its end included. In JSON the actions are a list of objects; in the other
    /// formats their names stand before those of their values.
    #[must_use]
    pub fn text(&self, source: &Source, format: Format) -> String {
        let mut fields = self.fields(source);
        let of_action = |action: &ActionOutcome| {
            [
                ("runs", json!(action.runs)),
                ("wished_runs", json!(action.wished)),
                ("predicted_runs", json!(action.predicted)),
                ("spent_j", json!(action.spent_j)),
            ]
        };
        if format == Format::Json {
            let objects = self.actions.iter().map(|action| {
                let mut object = Map::new();
                object.insert("name".to_owned(), action.name.as_str().into());
                object.extend(of_action(action).map(|(name, value)| (name.to_owned(), value)));
                Value::Object(object)
            });
            fields.push(("actions".to_owned(), Value::Array(objects.collect())));
        } else {
            for action in &self.actions {
                let values = of_action(action);
                fields.extend(values.map(|(name, value)| (format!("{}_{name}", action.name), value)));
            }
        }
        text(fields, format)
    }
}
