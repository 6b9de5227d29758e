//! A day of a sensor node: what it harvests, what is in its store, and what it decides to do.
//!
//! Two sides that share no code. The *node* knows what its energy budget on the embedded core tells it, in the
//! precision of the firmware. The *world* is the harvester, whose power comes from the embedded core (see
//! [`income`]), and a store in double precision (see `store`). The node learns of the world what its estimator
//! would tell it: the energy harvested since the last update; and the voltage of the store when it is switched on.
//!
//! Where the store is behind a bridge and every step is taken, harvester, bridge and store are one trajectory of the
//! core, in the precision of the firmware: see `world`.

pub mod income;
mod node;
pub mod outcome;
pub mod picture;
mod store;
mod world;

use model_core::scalar::Scalar;

use self::income::Income;
use self::node::Controller;
use self::outcome::{ActionOutcome, NodeDay, Sample};
use self::store::Store;
use self::world::{LoopedStore, Plant};
use crate::embedded::with_store_in_loop;
use crate::method::{Failure, Options, Precision};
use crate::scene_file::{HOURS, Load, Node, Scene};

/// Seconds in a day.
pub(crate) const DAY_S: u32 = 86_400;

/// How the last day is simulated.
#[derive(Debug, Clone, Copy)]
pub struct InLoop<'a> {
    /// The scene, its load a rectified store.
    pub scene: &'a Scene,
    /// How it is run.
    pub options: &'a Options,
}

/// Simulates the node for some days after one another, each with the same income, and tells of the last. The days
/// before it teach the slots of the day. With a scene `in_loop`, its harvester and the store are one trajectory on
/// the last day, and `income` is that of the days before.
///
/// # Errors
/// [`Failure::Input`] if the core refuses the node, and as a run of the scene.
pub fn simulate(
    node: &Node,
    income: &Income,
    learning_days: u32,
    precision: Precision,
    in_loop: Option<InLoop<'_>>,
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

struct Days<'a> {
    node: &'a Node,
    income: &'a Income,
    learning_days: u32,
    in_loop: Option<InLoop<'a>>,
}

impl Days<'_> {
    fn last<S: Scalar, const SLOTS: usize>(&self) -> Result<NodeDay, Failure> {
        let Self { node, income, learning_days, in_loop } = *self;
        let mut store = Store::new(&node.storage, node.standing_power_w, income);
        let mut controller = Controller::<S, SLOTS>::new(node, store.voltage())?;
        for _ in 0..learning_days {
            day(node, &mut store, &mut controller)?;
        }
        let Some(InLoop { scene, options }) = in_loop else { return day(node, &mut store, &mut controller) };
        let Load::RectifiedStore(load) = scene.load else { return day(node, &mut store, &mut controller) };
        let (storage, drop) = (&node.storage, load.diode_drop_v);
        let midnight = (store.voltage(), store.is_supplied());
        with_store_in_loop(scene, drop, storage, midnight, &node.hours, options, |looped| {
            day(node, &mut LoopedStore::new(looped, storage, node.standing_power_w), &mut controller)
        })
    }
}

fn day<S: Scalar, const SLOTS: usize>(
    node: &Node,
    world: &mut dyn Plant,
    controller: &mut Controller<'_, S, SLOTS>,
) -> Result<NodeDay, Failure> {
    world.begin_account();
    let start_j = world.energy();
    let predicted = controller.rates();
    let mut runs_by_hour = vec![[0; HOURS]; node.actions.len()];
    let mut samples = vec![Sample { second: 0, stored_j: start_j, income_w: 0.0 }];
    let mut budget_error_j: f64 = 0.0;
    let mut lowest_j = start_j;
    for second in (0..DAY_S).step_by(node.update_s as usize) {
        if world.is_supplied() {
            controller.wake(world.voltage());
            if second % node.decision_s == 0 {
                for action in controller.decide() {
                    runs_by_hour[action][(second / 3600) as usize] += 1;
                    world.spend(node.actions[action].energy_j);
                }
            }
        }
        lowest_j = lowest_j.min(world.energy());
        let harvested_j = world.advance(second, node.update_s)?;
        lowest_j = lowest_j.min(world.energy());
        controller.update(node.update_s, harvested_j, world.was_supplied());
        if world.was_supplied() {
            budget_error_j = budget_error_j.max((controller.stored_j() - world.energy()).abs());
        }
        samples.push(Sample {
            second: second + node.update_s,
            stored_j: world.energy(),
            income_w: harvested_j / f64::from(node.update_s),
        });
    }
    let actions = node.actions.iter().zip(predicted).zip(runs_by_hour).map(|((action, rate), by_hour)| {
        let runs: u32 = by_hour.iter().sum();
        ActionOutcome {
            name: action.name.clone(),
            runs,
            wished: f64::from(DAY_S) / action.every_s,
            predicted: rate * f64::from(DAY_S),
            spent_j: f64::from(runs) * action.energy_j,
            by_hour,
        }
    });
    let voltage_at = |energy: f64| (2.0 * energy / node.storage.capacitance_f).sqrt();
    let energy_at = |voltage: f64| 0.5 * node.storage.capacitance_f * voltage * voltage;
    let capacity_j = energy_at(node.storage.highest_v);
    Ok(NodeDay {
        account: *world.account(),
        actions: actions.collect(),
        start_j,
        end_j: world.energy(),
        lowest_j,
        capacity_j,
        turn_off_j: energy_at(node.storage.turn_off_v),
        lowest_v: voltage_at(lowest_j),
        budget_error: budget_error_j / capacity_j,
        budget_ledger: controller.ledger_residual(),
        samples,
    })
}
