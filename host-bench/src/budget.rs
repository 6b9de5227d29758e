//! A day of a sensor node: what it harvests, what is in its store, and what it decides to do.
//!
//! Two sides that share no code. The *node* knows what its energy budget on the embedded core tells it, in the
//! precision of the firmware. The *world* is the harvester, whose power comes from the embedded core (see
//! [`income`]), and a store in double precision (see [`store`]). The node learns of the world what its estimator
//! would tell it: the energy harvested since the last update; and the voltage of the store when it is switched on.

pub mod income;
mod node;
pub mod outcome;
pub mod picture;
mod store;

use model_core::scalar::Scalar;

use self::income::Income;
use self::node::Mind;
use self::outcome::{ActionOutcome, NodeDay, Sample};
use self::store::Store;
use crate::method::{Failure, Precision};
use crate::scene_file::{HOURS, Node};

/// Seconds in a day.
pub(crate) const DAY_S: u32 = 86_400;

/// Simulates the node for some days after one another, each with the same income, and tells of the last. The days
/// before it teach the slots of the day.
///
/// # Errors
/// [`Failure::Input`] if the core refuses the node.
pub fn simulate(
    node: &Node,
    income: &Income,
    learning_days: u32,
    precision: Precision,
) -> Result<NodeDay, Failure> {
    match (precision, node.slots_per_day) {
        (Precision::F32, 24) => last_day::<f32, 24>(node, income, learning_days),
        (Precision::F32, 48) => last_day::<f32, 48>(node, income, learning_days),
        (Precision::F32, 96) => last_day::<f32, 96>(node, income, learning_days),
        (Precision::F32, _) => last_day::<f32, 144>(node, income, learning_days),
        (Precision::F64, 24) => last_day::<f64, 24>(node, income, learning_days),
        (Precision::F64, 48) => last_day::<f64, 48>(node, income, learning_days),
        (Precision::F64, 96) => last_day::<f64, 96>(node, income, learning_days),
        (Precision::F64, _) => last_day::<f64, 144>(node, income, learning_days),
    }
}

fn last_day<S: Scalar, const SLOTS: usize>(
    node: &Node,
    income: &Income,
    learning_days: u32,
) -> Result<NodeDay, Failure> {
    let mut store = Store::new(&node.storage, node.standing_power_w);
    let mut mind = Mind::<S, SLOTS>::new(node, store.voltage())?;
    for _ in 0..learning_days {
        day(node, income, &mut store, &mut mind);
    }
    Ok(day(node, income, &mut store, &mut mind))
}

fn day<S: Scalar, const SLOTS: usize>(
    node: &Node,
    income: &Income,
    store: &mut Store,
    mind: &mut Mind<'_, S, SLOTS>,
) -> NodeDay {
    store.begin_account();
    let start_j = store.energy();
    let predicted = mind.rates();
    let mut runs_by_hour = vec![[0; HOURS]; node.actions.len()];
    let mut samples = vec![Sample { second: 0, stored_j: start_j, income_w: 0.0 }];
    let mut budget_error_j: f64 = 0.0;
    let mut lowest_j = start_j;
    for second in (0..DAY_S).step_by(node.update_s as usize) {
        if store.is_supplied() {
            mind.wake(store.voltage());
            if second % node.decision_s == 0 {
                for action in mind.decide() {
                    runs_by_hour[action][(second / 3600) as usize] += 1;
                    store.spend(node.actions[action].energy_j);
                }
            }
        }
        lowest_j = lowest_j.min(store.energy());
        let harvested_j = store.advance(second, node.update_s, income);
        lowest_j = lowest_j.min(store.energy());
        mind.update(node.update_s, harvested_j, store.was_supplied());
        if store.was_supplied() {
            budget_error_j = budget_error_j.max((mind.stored_j() - store.energy()).abs());
        }
        samples.push(Sample {
            second: second + node.update_s,
            stored_j: store.energy(),
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
    NodeDay {
        account: *store.account(),
        actions: actions.collect(),
        start_j,
        end_j: store.energy(),
        lowest_j,
        capacity_j: store.capacity(),
        turn_off_j: store.turn_off(),
        lowest_v: store.voltage_at(lowest_j),
        budget_error: budget_error_j / store.capacity(),
        budget_ledger: mind.ledger_residual(),
        samples,
    }
}
