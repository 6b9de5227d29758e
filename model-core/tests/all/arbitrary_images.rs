//! Images of arbitrary content: refused, or a state that has the same bytes and can be used.
//!
//! The checksum and the fingerprint of these images are valid, so that the states themselves are judged.

use crate::common::harvesters::{bump, contact, sine_samples, slide};
use crate::common::{Random, finished};
use model_core::energy::estimator::{Interpolation, Sample, SampleFormat, Settings};
use model_core::energy::{
    Action, Budget, BudgetParameters, BudgetState, Capacitor, Estimator, IncomeParameters, ResponseMap,
    StorageParameters,
};
use model_core::excitation::LineBank;
use model_core::integrate::{Adaptive, ExponentialRadau, TrBdf2};
use model_core::node::{
    Bursts, Converter, Gap, MapNode, MapParameters, MapState, Progress, Regular, Sensor, Task, Tier,
    Tolerances, VoltageNode, VoltageParameters,
};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::AnyContact;
use model_core::scene::{Harvester, Simulation};
use model_core::snapshot::{self, Configuration, SnapshotError};

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

/// Changes some bytes: single bits, extremes, and pieces copied from elsewhere.
fn mutate(random: &mut Random, bytes: &mut [u8]) {
    for _ in 0..1 + random.next() % 6 {
        let place = random.next() as usize % bytes.len();
        let length = (1 + random.next() as usize % 8).min(bytes.len() - place);
        match random.next() % 5 {
            0 => bytes[place] ^= 1 << (random.next() % 8),
            1 => bytes[place] = random.next() as u8,
            2 => bytes[place..place + length].fill([0, 0xff, 0x7f, 0x80][random.next() as usize % 4]),
            3 => bytes[place..place + length].fill_with(|| random.next() as u8),
            _ => {
                let from = random.next() as usize % (bytes.len() - length + 1);
                bytes.copy_within(from..from + length, place);
            }
        }
    }
}

/// Restores `count` changed images of a state. Whatever is accepted has the same bytes when it is saved, and is used.
fn judge<C: Configuration>(configuration: &C, state: &C::State, count: u32, mut used: impl FnMut(C::State)) {
    let mut image = vec![0; snapshot::image_size::<C>()];
    snapshot::save_image(configuration, state, 7, &mut image).expect("room");
    let content = image.len() - TAIL;
    assert_eq!(checksum(&image[..content]).to_le_bytes(), image[content..]);
    let mut random = Random(count.into());
    let mut accepted = 0;
    for number in 0..count {
        let mut changed = image.clone();
        if number % 16 == 0 {
            changed[HEAD..content].fill_with(|| random.next() as u8);
        } else {
            mutate(&mut random, &mut changed[HEAD..content]);
        }
        // A change of the content without that of the checksum is always refused.
        let is_same = changed == image;
        assert_eq!(snapshot::newest_image(configuration, [&changed, &[]]).is_ok(), is_same);
        let sum = checksum(&changed[..content]);
        changed[content..].copy_from_slice(&sum.to_le_bytes());
        match snapshot::newest_image(configuration, [&changed, &[]]) {
            Ok(found) => {
                let mut again = vec![0; image.len()];
                snapshot::save_image(configuration, &found.state, found.sequence, &mut again).expect("room");
                assert_eq!(again, changed, "an accepted state has its bytes");
                used(found.state);
                accepted += 1;
            }
            Err(error) => assert_eq!(error, SnapshotError::NoState),
        }
    }
    println!("{accepted} of {count} accepted");
    assert!(accepted > count / 20, "{accepted} of {count}");
}

/// Number of images of each kind; `HARVESTER_FUZZ` multiplies it.
fn count(usual: u32) -> u32 {
    let factor = std::env::var("HARVESTER_FUZZ").ok().and_then(|text| text.parse().ok());
    usual * factor.unwrap_or(1)
}

fn storage<S: Scalar>() -> StorageParameters<S> {
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

fn arbitrary_budgets<S: Scalar>() {
    let (budget, state) = budget::<S>();
    let action = Action::new("transmit", S::from_f64(1e-4), S::from_f64(0.1)).expect("in bounds");
    judge(&budget, &state, count(4000), |mut state| {
        let _ = (budget.can_afford(&state, &action, 40_000), budget.can_run_now(&state, &action, 40_000));
        let _ = budget.sustainable_rate(&state, &action);
        for interval in [60, 1, 90_000] {
            budget.update(&mut state, interval, S::from_f64(1e-4), S::ZERO);
            budget.gap(&mut state, interval);
        }
        budget.correct(&mut state, S::from_f64(1e-3), S::ZERO);
        assert!(state.certain_energy() <= state.energy() && state.energy() <= S::from_f64(1e-3));
    });
}

#[test]
fn a_budget_of_arbitrary_bytes_is_refused_or_works() {
    arbitrary_budgets::<f32>();
    arbitrary_budgets::<f64>();
}

#[test]
fn a_node_by_the_voltage_of_arbitrary_bytes_is_refused_or_works() {
    let parameters = VoltageParameters {
        storage: storage(),
        converter: Converter { bits: 12, full_scale: 5.0, noise: 1e-3 },
        standing_power: 0.3e-6,
        reading: 1e-6,
        intervals: [60, 300],
        tolerances: Tolerances { standing: 0.1, ..Tolerances::EXACT },
        largest_power: 100e-6,
        reserve: 1e-4,
        actions: [Regular { energy: 50e-6, every: 60 }],
    };
    let node = parameters.build().expect("in bounds");
    let (mut state, mut now) = (node.start(0), 0);
    for minute in 0..100 {
        now += 60;
        node.wake(&mut state, now, Some(2400 + minute));
    }
    judge(&node, &state, count(6000), |mut state| {
        let now = VoltageNode::<1>::second(&state);
        node.wake_after(&mut state, Gap::LockedOutUntil(now.saturating_add(7200)), Some(2000));
        for (minute, code) in [2400, 2401, 0, 4095, 1000].into_iter().enumerate() {
            let now = now.saturating_add(7260 + 60 * minute as u32);
            let wake = node.wake(&mut state, now, Some(code));
            assert!(wake.again_in <= 3600, "{wake:?}");
        }
        let [stored, bound] = node.stored(&state);
        assert!(stored.is_finite() && bound.is_finite(), "{stored} {bound}");
    });
}

fn arbitrary_estimators<S: Scalar, H: Harvester<S> + Copy>(harvester: H, usual: u32) {
    let settings = Settings {
        rate: S::from_f64(400.0),
        format: SampleFormat::accelerations(S::from_f64(60.0), S::ZERO),
        longest_gap: 3,
        settling_seconds: S::from_f64(0.1),
        rate_tolerance: S::ZERO,
        jitter: S::ZERO,
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: Some(S::from_f64(1.0)),
    };
    let fresh = Estimator::new(harvester, settings).expect("in bounds");
    let mut estimator = fresh;
    for sample in sine_samples::<S>(4.0, 20.0, 400.0, 200) {
        finished(estimator.push(Sample::Good(sample), u32::MAX));
    }
    // Two lost samples and one are left in the queue.
    finished(estimator.push_missing(2, u32::MAX));
    assert!(!estimator.push(Sample::Good(S::ONE), 1).expect("runs").finished);
    judge(&fresh, estimator.state(), count(usual), |state| {
        let mut restored = fresh;
        restored.set_state(state);
        // A few hundred attempted steps, and errors.
        for _ in 0..4 {
            let _progress = restored.resume(40);
            let _progress = restored.push_acceleration(S::ONE, 40);
            let _progress = restored.push_missing(1, 40);
        }
        let estimate = restored.estimate();
        assert!(estimate.energy.is_finite(), "{estimate:?} {:?}", restored.state());
    });
}

#[test]
fn an_estimator_of_arbitrary_bytes_is_refused_or_works() {
    let control = Adaptive::new(5e-2).expect("in bounds");
    arbitrary_estimators::<f32, _>(Simulation::new(contact(), ExponentialRadau, control), 1500);
    let control = Adaptive::new(5e-2).expect("in bounds");
    arbitrary_estimators::<f64, _>(Simulation::new(slide(), TrBdf2, control), 1500);
    arbitrary_estimators::<f32, _>(bump::<f32, 4, 1>(AnyContact::ResidualFlexibility), 1000);
}

type OneNode = MapNode<&'static [u8], 20, 32, 2>;
type OneState = MapState<32, 2>;

fn node() -> OneNode {
    let bytes: &[u8] = include_bytes!("../../../host-bench/src/simulated_node/contact-separation.bin");
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let parameters = MapParameters {
        voltage: VoltageParameters {
            storage: storage(),
            converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
            standing_power: 0.3e-6,
            reading: 1e-6,
            intervals: [60, 300],
            tolerances: Tolerances { standing: 0.2, action: 0.02, ..Tolerances::EXACT },
            largest_power: 100e-6,
            reserve: 1e-4,
            actions: [Regular { energy: 50e-6, every: 60 }, Regular { energy: 100e-6, every: 300 }],
        },
        sensor: Sensor { rate: 100.0, start_up: 4, blocks: 1, clipped: 32_000 },
        bursts: Bursts { energy: 20e-6, worth: 1.0, shortest: 60, check: 3600 },
        gain: 1.0,
        gain_drift: 0.1,
    };
    let map = ResponseMap::new(bytes, fingerprint).expect("a map");
    let bank = LineBank::new(100.0, 20.13, 0.1, 9.806_65 / 1024.0).expect("in bounds");
    MapNode::new(map, bank, parameters).expect("in bounds")
}

/// Wakes a node some times in a vibration of 0.2 m/s², whose storage is read as `code`; `rest` samples of each burst are
/// not taken.
fn wake_some_times(node: &OneNode, state: &mut OneState, times: u32, code: u32, rest: usize) {
    let shaking = |n: usize| (1024.0 + 21.0 * (1.2378 * n as f64).sin()).round() as i16;
    let samples: Vec<i16> = (0..644).map(shaking).collect();
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

#[test]
fn a_node_of_arbitrary_bytes_is_refused_or_works() {
    let node = node();
    let mut idle = node.start(30_000);
    wake_some_times(&node, &mut idle, 400, 2458, 0);
    assert!(idle.bursts() > 1);
    // In the middle of a burst, with a block that has begun.
    let mut sampling = node.start(30_000);
    sampling.ask_for_burst();
    wake_some_times(&node, &mut sampling, 1, 2458, 400);
    for state in [idle, sampling] {
        judge(&node, &state, count(3000), |mut state| {
            let before = OneNode::second(&state);
            wake_some_times(&node, &mut state, 40, 2500, 0);
            node.wake_after(&mut state, Gap::OffUntil(before.saturating_add(7200)), Some(2000));
            wake_some_times(&node, &mut state, 40, 2100, 0);
            node.wake_after(&mut state, Gap::Unknown, Some(2300));
            wake_some_times(&node, &mut state, 40, 2310, 0);
            assert!(OneNode::second(&state) >= before);
        });
    }
}
