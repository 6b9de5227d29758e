//! Images of arbitrary content: refused, or a state that has the same bytes and can be used.
//!
//! The checksum and the fingerprint of these images are valid, so that the states themselves are judged.

use arbtest::arbitrary::Unstructured;
use model_core::energy::estimator::Sample;
use model_core::energy::{
    Action, Budget, BudgetParameters, BudgetState, Capacitor, IncomeParameters, StorageParameters,
};
use model_core::node::{Outage, Progress, Task, Tier, VoltageNode};
use model_core::scalar::Scalar;
use model_core::snapshot::{self, Configuration, SnapshotError};

use super::calls::{OneNode, beam, cantilever, estimator, mass, node, voltage_node};
use super::change::{self, any, below};
use crate::fuzz;
use crate::harvesters::sine_samples;

/// Bytes before the state, of which eight are magic number, version and length.
const HEAD: usize = 12;
/// Bytes of the checksum.
const TAIL: usize = 4;

/// CRC-32 of IEEE 802.3, bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    let shifted = |remainder: u32, _| (remainder >> 1) ^ (0xedb8_8320 & (remainder & 1).wrapping_neg());
    let with = |remainder, &byte: &u8| (0..8).fold(remainder ^ u32::from(byte), shifted);
    !bytes.iter().fold(u32::MAX, with)
}

/// Restores changed images of a state. Whatever is accepted has the same bytes when it is saved, and is used.
fn judge<C: Configuration>(
    name: &'static str,
    inputs: u64,
    (configuration, state): (&C, &C::State),
    mut used: impl FnMut(&mut Unstructured<'_>, C::State),
) {
    let mut image = vec![0; snapshot::image_size::<C>()];
    snapshot::save_image(configuration, state, 7, &mut image).expect("room");
    let content = image.len() - TAIL;
    assert_eq!(checksum(&image[..content]).to_le_bytes(), image[content..]);
    fuzz(name, inputs, |bytes| {
        let mut changed = image.clone();
        if below(bytes, 32) == 0 {
            changed[HEAD..content].fill_with(|| any(bytes));
        } else {
            change::image(bytes, &mut changed[HEAD..content]);
        }
        // A change of the content without that of the checksum is always refused.
        assert_eq!(snapshot::newest_image(configuration, [&changed, &[]]).is_ok(), changed == image);
        let sum = checksum(&changed[..content]);
        changed[content..].copy_from_slice(&sum.to_le_bytes());
        match snapshot::newest_image(configuration, [&changed, &[]]) {
            Ok(found) => {
                let mut again = vec![0; image.len()];
                snapshot::save_image(configuration, &found.state, found.sequence, &mut again).expect("room");
                assert_eq!(again, changed, "an accepted state has its bytes");
                used(bytes, found.state);
                true
            }
            Err(error) => {
                assert_eq!(error, SnapshotError::NoState);
                false
            }
        }
    });
}

/// 220 µF up to 4.5 V.
pub(super) fn storage<S: Scalar>() -> StorageParameters<S> {
    StorageParameters {
        capacitor: Capacitor { capacitance: S::from_f64(220e-6), leakage_resistance: S::from_f64(10e6) },
        charging_efficiency: S::from_f64(0.8),
        discharging_efficiency: S::from_f64(0.9),
        highest_voltage: S::from_f64(4.5),
        lock_out_voltage: S::from_f64(1.8),
        turn_on_voltage: S::from_f64(2.4),
    }
}

fn budget<S: Scalar>() -> (Budget<S, 12>, BudgetState<S, 12>) {
    let income = IncomeParameters { time_constant: S::from_f64(3600.0), day_weight: S::from_f64(0.5) };
    let parameters = BudgetParameters { storage: storage(), income, standing_power: S::from_f64(1e-6) };
    let budget: Budget<S, 12> = parameters.build().expect("in bounds");
    let mut state = budget.start(30_000);
    budget.correct_by_voltage(&mut state, S::from_f64(3.0), S::from_f64(2e-3));
    for minute in 0..900_u32 {
        budget.update(&mut state, 60, S::from_f64(1e-6) * S::from_u32(minute % 100), S::from_f64(1e-5));
    }
    budget.spend(&mut state, S::from_f64(1e-5));
    (budget, state)
}

fn budgets<S: Scalar>(name: &'static str) {
    let (budget, state) = budget::<S>();
    let action = Action::new("transmit", S::from_f64(1e-4), S::from_f64(0.1)).expect("in bounds");
    judge(name, 2000, (&budget, &state), |bytes, mut state| {
        let _ = (budget.can_afford(&state, &action, 40_000), budget.can_run_now(&state, &action, 40_000));
        let _ = budget.sustainable_rate(&state, &action);
        for interval in [60, 1, 90_000, any(bytes)] {
            budget.update(&mut state, interval, S::from_f64(1e-4), S::ZERO);
            budget.gap(&mut state, interval);
        }
        budget.correct(&mut state, S::from_f64(1e-3), S::ZERO);
        assert!(state.certain_energy() <= state.energy() && state.energy() <= S::from_f64(1e-3));
    });
}

#[test]
fn budgets_in_single_precision() {
    budgets::<f32>("images of a budget, f32");
}

#[test]
fn budgets_in_double_precision() {
    budgets::<f64>("images of a budget, f64");
}

macro_rules! estimators {
    ($($test:ident, $name:literal, $scalar:ty, $harvester:expr, $inputs:literal;)*) => {$(
        #[test]
        fn $test() {
            let fresh = estimator::<$scalar, _>($harvester);
            let mut used = fresh;
            for sample in sine_samples(4.0, 20.0, 400.0, 200) {
                assert!(used.push(Sample::Good(sample), u32::MAX).expect("runs").finished);
            }
            // Two lost samples and one are left in the queue.
            assert!(used.push_missing(2, u32::MAX).expect("runs").finished);
            assert!(!used.push(Sample::Good(1.0), 1).expect("runs").finished);
            judge($name, $inputs, (&fresh, used.state()), |bytes, state| {
                let mut restored = fresh;
                restored.set_state(state);
                // A few hundred attempted steps, and errors.
                for _ in 0..4 {
                    let _progress = restored.resume(40);
                    let _progress = restored.push_acceleration(1.0, 40);
                    let _progress = restored.push_missing(any(bytes), 40);
                }
                let estimate = restored.estimate();
                assert!(estimate.energy.is_finite(), "{estimate:?} {:?}", restored.state());
            });
        }
    )*};
}

estimators! {
    estimators_of_a_mass, "images of an estimator, contact-separation", f32, mass(), 1250;
    estimators_of_a_cantilever, "images of an estimator, sliding", f64, cantilever(), 1250;
    estimators_of_a_beam, "images of an estimator, bump-stop", f32, beam(), 750;
}

#[test]
fn nodes_by_the_voltage() {
    let node = voltage_node();
    let (mut state, mut now) = (node.start(0), 0);
    for minute in 0..100 {
        now += 60;
        node.wake(&mut state, now, Some(2400 + minute));
    }
    judge("images of a node, voltage", 4000, (&node, &state), |_, mut state| {
        let now = VoltageNode::<1>::second(&state);
        node.wake_after(&mut state, Outage::LockedOutUntil(now.saturating_add(7200)), Some(2000));
        for (minute, code) in [2400, 2401, 0, 4095, 1000].into_iter().enumerate() {
            let now = now.saturating_add(7260 + 60 * minute as u32);
            let wake = node.wake(&mut state, now, Some(code));
            assert!(wake.again_in <= 3600, "{wake:?}");
        }
        let now = node.status(&state);
        assert!(now.energy.is_finite() && now.energy_bound >= 0.0, "{now:?}");
    });
}

fn nodes(name: &'static str, state: <OneNode as Configuration>::State) {
    let node = node();
    judge(name, 1250, (&node, &state), |_, mut state| {
        let before = OneNode::second(&state);
        wake_some_times(&node, &mut state, 40, 2500, 0);
        node.wake_after(&mut state, Outage::OffUntil(before.saturating_add(7200)), Some(2000));
        wake_some_times(&node, &mut state, 40, 2100, 0);
        node.wake_after(&mut state, Outage::Unknown, Some(2300));
        wake_some_times(&node, &mut state, 40, 2310, 0);
        assert!(OneNode::second(&state) >= before);
    });
}

#[test]
fn idle_nodes() {
    let (node, mut state) = (node(), node().start(30_000));
    wake_some_times(&node, &mut state, 400, 2458, 0);
    assert!(state.bursts() > 1);
    nodes("images of a node, idle", state);
}

/// In the middle of a burst, with a block that has begun.
#[test]
fn sampling_nodes() {
    let (node, mut state) = (node(), node().start(30_000));
    state.ask_for_burst();
    wake_some_times(&node, &mut state, 1, 2458, 400);
    nodes("images of a node, sampling", state);
}

/// Wakes a node some times in a vibration of 0.2 m/s², whose storage is read as `code`; `rest` samples of each burst are
/// not taken.
fn wake_some_times(
    node: &OneNode,
    state: &mut <OneNode as Configuration>::State,
    times: u32,
    code: u32,
    rest: usize,
) {
    let vibration = |n: usize| (1024.0 + 21.0 * (1.2378 * n as f64).sin()).round() as i16;
    let samples: Vec<i16> = (0..644).map(vibration).collect();
    let mut now = OneNode::second(state);
    let mut wake = node.wake(state, now, Some(code));
    for _ in 0..times {
        if let Task::Burst { .. } = wake.task {
            let taken = &samples[..samples.len() - rest];
            if let Progress::More(_) = node.samples(state, taken) {
                return;
            }
        }
        now = now.saturating_add(wake.again_in);
        wake = node.wake(state, now, wake.read.then_some(code));
    }
}
