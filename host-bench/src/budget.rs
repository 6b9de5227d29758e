//! A day of a sensor node: what it harvests, what is stored, and which actions it runs.
//!
//! The *controller* knows the result of its energy budget on the embedded core, in the precision of the firmware. The
//! *plant* is the harvester, whose power comes from the embedded core ([`income`]), and a storage in double precision.
//! Controller and plant share no code. The controller learns from the plant what an estimator and a voltage
//! measurement would give: the energy harvested since the last update, and the voltage when the node is switched on.
//!
//! If the storage is behind a bridge and every step is taken, harvester, bridge and storage are one trajectory of the
//! core, in the precision of the firmware.

mod controller;
pub(crate) mod income;
pub(crate) mod outcome;
pub(crate) mod picture;
mod plant;

use std::path::Path;

use model_core::scalar::Scalar;

use self::controller::Controller;
use self::income::Income;
use self::outcome::{ActionOutcome, EstimationOutcome, NodeDay, Sample, Source};
use self::plant::{ChargedStorage, LoopedStorage, Plant, StorageAccount, energy_at};
use crate::accuracy::Statements;
use crate::embedded::Midnight;
use crate::method::{Failure, Options, Precision};
use crate::name::Name;
use crate::outcome::Fields;
use crate::scene_file::{self, Action, HOURS, Load, Node, Override, Scene};

const DAY_S: u32 = 86_400;

/// The scene whose storage is simulated with its harvester on the last day, if any, and how.
type InLoop<'a> = Option<(&'a Scene, &'a Options)>;

/// Simulates the node for some days with the same income each, and gives the last. The days before it train the income forecast. With a
/// scene `in_loop`, its harvester and the storage are one trajectory on the last day, and `income` holds for the days before.
pub(crate) fn simulate(
    node: &Node,
    income: &Income,
    learning_days: u32,
    precision: Precision,
    in_loop: InLoop<'_>,
) -> Result<NodeDay, Failure> {
    let days = Days { node, income, learning_days, in_loop };
    match (precision, node.slots_per_day) {
        (Precision::F32, 24) => days.last::<f32, 24>(),
        (Precision::F32, 48) => days.last::<f32, 48>(),
        (Precision::F32, 96) => days.last::<f32, 96>(),
        (Precision::F32, _) => days.last::<f32, 144>(),
        (Precision::F64, 24) => days.last::<f64, 24>(),
        (Precision::F64, 48) => days.last::<f64, 48>(),
        (Precision::F64, 96) => days.last::<f64, 96>(),
        (Precision::F64, _) => days.last::<f64, 144>(),
    }
}

/// The numbers of [`short_day`] for a search over keys.
pub(crate) fn day_numbers(file: &Path, overrides: &[Override]) -> Result<Fields, Failure> {
    let (day, source) = short_day(file, overrides)?;
    Ok(day.numbers(source.stated["accuracy"]["total"].as_f64()))
}

/// The day of a node, by level and in the precision of firmware, after two days.
pub(crate) fn short_day(file: &Path, overrides: &[Override]) -> Result<(NodeDay, Source), Failure> {
    let (scene, node) = scene_file::read_with_node(file, overrides)?;
    let mut statements = Statements::default();
    let options = income::options(&scene, Precision::F32, None);
    let income = income::by_level(&scene, &node, &options, &mut statements)?;
    let day = simulate(&node, &income, 2, Precision::F32, None)?;
    let (precision, stated) = (Precision::F32.name(), statements.fields(&[]));
    let scene = scene.name();
    Ok((day, Source { scene, precision, income: "by-level", learning_days: 2, whole_day: None, stated }))
}

struct Days<'a> {
    node: &'a Node,
    income: &'a Income,
    learning_days: u32,
    in_loop: InLoop<'a>,
}

impl Days<'_> {
    fn last<S: Scalar, const SLOTS: usize>(&self) -> Result<NodeDay, Failure> {
        let Self { node, income, learning_days, .. } = *self;
        let mut plant = ChargedStorage::new(&node.storage, node.standing_power_w, income);
        let mut controller = Controller::<S, SLOTS>::new(node, plant.voltage())?;
        for _ in 0..learning_days {
            day(node, &mut plant, &mut controller)?;
        }
        let smallest_capacitance_f = controller.smallest_capacitance();
        let shown = self.shown(plant, &mut controller)?;
        Ok(NodeDay { smallest_capacitance_f, ..shown })
    }

    fn shown<S: Scalar, const SLOTS: usize>(
        &self,
        mut plant: ChargedStorage<'_>,
        controller: &mut Controller<'_, S, SLOTS>,
    ) -> Result<NodeDay, Failure> {
        let Self { node, in_loop, .. } = *self;
        let Some((scene, options)) = in_loop else { return day(node, &mut plant, controller) };
        let Load::RectifiedStore(load) = scene.load else { return day(node, &mut plant, controller) };
        let midnight = Midnight {
            scene,
            diode_drop_v: load.diode_drop_v,
            storage: &node.storage,
            initial_v: plant.voltage(),
            is_connected: plant.is_supplied(),
            hours: &node.hours,
            options,
        };
        midnight.with_store_in_loop(|looped| {
            let mut plant = LoopedStorage::new(looped, &node.storage, node.standing_power_w);
            day(node, &mut plant, controller)
        })
    }
}

fn day<S: Scalar, const SLOTS: usize>(
    node: &Node,
    plant: &mut dyn Plant,
    controller: &mut Controller<'_, S, SLOTS>,
) -> Result<NodeDay, Failure> {
    *plant.account() = StorageAccount::default();
    let predicted = controller.sustainable_rates();
    let mut record = Record::new(node, plant.energy());
    for second in (0..DAY_S).step_by(node.update_s as usize) {
        if plant.is_supplied() {
            controller.wake(plant.voltage());
            if second % node.decision_s == 0 {
                for action in controller.decide() {
                    record.runs_by_hour[action][(second / 3600) as usize] += 1;
                    plant.spend(record.actions[action].energy_j);
                }
            }
        }
        record.lowest_j = record.lowest_j.min(plant.energy());
        let harvested_j = plant.advance(second, node.update_s)?;
        controller.update(node.update_s, harvested_j, plant.was_supplied());
        record.update(second + node.update_s, plant.energy(), harvested_j);
        if plant.was_supplied() {
            let error = (controller.stored_j() - plant.energy()).abs();
            record.budget_error_j = record.budget_error_j.max(error);
        }
    }
    Ok(record.day(&predicted, *plant.account(), controller.ledger_residual()))
}

struct Record<'a> {
    node: &'a Node,
    /// What it does to know its income, and its other actions.
    actions: Vec<&'a Action>,
    /// Least stored energy in J.
    lowest_j: f64,
    /// Largest error in J of the controller's estimate of the stored energy.
    budget_error_j: f64,
    runs_by_hour: Vec<[u32; HOURS]>,
    samples: Vec<Sample>,
}

impl<'a> Record<'a> {
    fn new(node: &'a Node, start_j: f64) -> Self {
        Self {
            node,
            lowest_j: start_j,
            budget_error_j: 0.0,
            runs_by_hour: vec![[0; HOURS]; node.all_actions().count()],
            actions: node.all_actions().collect(),
            samples: vec![Sample { second: 0, stored_j: start_j, income_w: 0.0 }],
        }
    }

    /// Takes in the end of an update interval.
    fn update(&mut self, second: u32, stored_j: f64, harvested_j: f64) {
        self.lowest_j = self.lowest_j.min(stored_j);
        let income_w = harvested_j / f64::from(self.node.update_s);
        self.samples.push(Sample { second, stored_j, income_w });
    }

    /// The day, with the rate of each action in 1/s that was predicted, the account of the storage, and the residual of the budget.
    fn day(self, predicted: &[f64], account: StorageAccount, budget_ledger: Option<f64>) -> NodeDay {
        let storage = &self.node.storage;
        let actions = self.actions.iter().zip(predicted).zip(self.runs_by_hour);
        let mut actions = actions.map(|((action, rate), by_hour)| {
            let runs: u32 = by_hour.iter().sum();
            ActionOutcome {
                name: Name::new(action.name.as_str()),
                runs,
                wished: f64::from(DAY_S) / action.every_s,
                predicted: rate * f64::from(DAY_S),
                sustainable_period_s: (*rate > 0.0).then(|| 1.0 / rate),
                spent_j: f64::from(runs) * action.energy_j,
                by_hour,
            }
        });
        let estimation = self.node.estimation.iter().zip(actions.by_ref());
        let estimation: Vec<EstimationOutcome> =
            estimation.map(|(estimation, outcome)| EstimationOutcome::new(estimation, outcome)).collect();
        let at_node: f64 = estimation.iter().map(|estimation| estimation.outcome.spent_j).sum();
        let capacity_j = energy_at(storage, storage.highest_v);
        let [start_j, end_j] =
            [self.samples.first(), self.samples.last()].map(|sample| sample.map_or(0.0, |end| end.stored_j));
        NodeDay {
            account,
            estimation_j: at_node / storage.discharging_efficiency,
            estimation,
            asleep_power_w: self.node.asleep_power_w,
            standing_power_w: self.node.standing_power_w,
            figures: self.node.figures.clone(),
            actions: actions.collect(),
            start_j,
            end_j,
            lowest_j: self.lowest_j,
            capacity_j,
            turn_off_j: energy_at(storage, storage.turn_off_v),
            lowest_v: storage.reservoir().voltage_v(self.lowest_j),
            budget_error: self.budget_error_j / capacity_j,
            budget_ledger,
            samples: self.samples,
            smallest_capacitance_f: None,
        }
    }
}
