//! Calls of the estimator and of both tiers of the node, in any order and with any arguments.

use arbtest::arbitrary::Unstructured;
use model_core::energy::estimator::{EstimatorError, Interpolation, Sample, SampleFormat, Settings};
use model_core::energy::{Estimator, ResponseMap};
use model_core::excitation::LineBank;
use model_core::integrate::{Adaptive, ExponentialRadau, TrBdf2};
use model_core::node::{
    Bursts, Converter, MapNode, MapParameters, Outage, Regular, Sensor, Status, Task, Tier, Tolerances,
    VoltageNode, VoltageParameters,
};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::AnyContact;
use model_core::scene::{Harvester, Simulation};
use model_core::snapshot;

use super::change::{any, below};
use super::images::storage;
use super::maps::real;
use crate::fuzz;
use crate::harvesters::{bump, contact, slide};

pub(super) type OneNode = MapNode<&'static [u8], 20, 32, 2>;

pub(super) fn mass() -> impl Harvester<f32> + Copy {
    Simulation::new(contact(), ExponentialRadau, Adaptive::new(5e-2).expect("in bounds"))
}

pub(super) fn cantilever() -> impl Harvester<f64> + Copy {
    Simulation::new(slide(), TrBdf2, Adaptive::new(5e-2).expect("in bounds"))
}

pub(super) fn beam() -> impl Harvester<f32> + Copy {
    bump::<f32, 4, 1>(AnyContact::ResidualFlexibility)
}

pub(super) fn estimator<S: Scalar, H: Harvester<S> + Copy>(harvester: H) -> Estimator<S, H> {
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
    Estimator::new(harvester, settings).expect("in bounds")
}

pub(super) fn voltage_node() -> VoltageNode<1> {
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
    parameters.build().expect("in bounds")
}

pub(super) fn node() -> OneNode {
    let bytes: &[u8] = include_bytes!("../../src/simulated_node/contact-separation.bin");
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

/// Calls an estimator; whether at least half of the calls are taken. Its sums stay finite, and its image survives.
fn call_estimator<S: Scalar, H: Harvester<S> + Copy>(
    bytes: &mut Unstructured<'_>,
    fresh: &Estimator<S, H>,
) -> bool {
    let mut estimator = *fresh;
    let (mut sequence, mut taken) = (0_u32, 0);
    const CALLS: usize = 40;
    for _ in 0..CALLS {
        let budget = [1, 5, 50][below(bytes, 3)];
        let value = S::from_f64(f64::from(real(bytes)));
        let sample = match below(bytes, 8) {
            0 => Sample::Missing,
            1 => Sample::Saturated(value),
            _ => Sample::Good(value),
        };
        let count = if below(bytes, 4) == 0 { any::<u32>(bytes) } else { below(bytes, 6) as u32 };
        let called = match below(bytes, 12) {
            0 => estimator.push_count(any(bytes), budget).map(|_| ()),
            1 => estimator.push_acceleration(value, budget).map(|_| ()),
            2 => estimator.push_missing(count, budget).map(|_| ()),
            3 | 4 => {
                sequence = sequence.wrapping_add(count);
                estimator.push_at(sequence, sample, budget).map(|_| ())
            }
            5 => estimator.set_rate(value, S::from_f64(f64::from(real(bytes)))),
            6 => {
                estimator.set_storage_voltage(value);
                Ok(())
            }
            7 => {
                let mut image = vec![0; 4096];
                let length = estimator.save(&mut image).expect("room");
                let state = *estimator.state();
                estimator.restore(&image[..length]).expect("its own image");
                assert_eq!(format!("{:?}", estimator.state()), format!("{state:?}"));
                Ok(())
            }
            8 if below(bytes, 4) == 0 => {
                estimator.clear();
                Ok(())
            }
            9 => estimator.push(sample, budget).map(|_| ()),
            _ => estimator.resume(budget).map(|_| ()),
        };
        taken += usize::from(!matches!(
            called,
            Err(EstimatorError::Parameter(_) | EstimatorError::OutOfOrder { .. })
        ));
        let estimate = estimator.estimate();
        assert!(estimate.energy.is_finite(), "{estimate:?} {:?}", estimator.state());
    }
    2 * taken >= CALLS
}

#[test]
fn samples_into_an_estimator() {
    let (mass, cantilever, beam) = (estimator(mass()), estimator(cantilever()), estimator(beam()));
    fuzz("samples into an estimator", 1000, |bytes| match below(bytes, 3) {
        0 => call_estimator(bytes, &mass),
        1 => call_estimator(bytes, &cantilever),
        _ => call_estimator(bytes, &beam),
    });
}

/// Calls a node; whether half of the calls wake it. Its clock goes back no further than the one of the calls, and its image is
/// restored. `judge` looks at each state.
fn call_node<N: Tier<State: core::fmt::Debug>>(
    bytes: &mut Unstructured<'_>,
    node: &N,
    judge: impl Fn(&N::State),
) -> bool {
    let mut state = node.start(any(bytes));
    let mut image = vec![0; snapshot::image_size::<N>()];
    let (mut again_in, mut is_read, mut regular) = (0, true, 0);
    const CALLS: usize = 60;
    for _ in 0..CALLS {
        let before = N::second(&state);
        let code = match below(bytes, 8) {
            0 => None,
            1 => Some(any(bytes)),
            2 => Some(below(bytes, 4096) as u32),
            _ => Some(2400 + below(bytes, 80) as u32).filter(|_| is_read),
        };
        let second = match below(bytes, 8) {
            0 => any(bytes),
            1 => before.wrapping_sub(below(bytes, 5000) as u32),
            2 => before.saturating_add(below(bytes, 200_000) as u32),
            _ => before.saturating_add(again_in),
        };
        let wake = match below(bytes, 16) {
            0 => {
                let gap = [
                    Outage::OnUntil(second),
                    Outage::OffUntil(second),
                    Outage::LockedOutUntil(second),
                    Outage::Unknown,
                ][below(bytes, 4)];
                node.wake_after(&mut state, gap, code)
            }
            1 => {
                node.samples_lost(&mut state);
                continue;
            }
            2 => {
                snapshot::save_image(node, &state, any(bytes), &mut image).expect("room");
                let restored = snapshot::newest_image(node, [&image, &[]]);
                state = restored.unwrap_or_else(|error| panic!("its own image: {error}, {state:?}")).state;
                continue;
            }
            _ => node.wake(&mut state, second, code),
        };
        assert!(N::second(&state) >= before.min(second), "from {before} to {}", N::second(&state));
        assert!(wake.again_in <= 86_400, "{wake:?}");
        regular += 1;
        (again_in, is_read) = (wake.again_in, wake.read);
        if let (Task::Burst { samples }, true) = (wake.task, below(bytes, 4) > 0) {
            let loud = [0.0, 21.0, 2000.0, 4e4][below(bytes, 4)];
            let vibration = |n: u32| (1024.0 + loud * (1.2378 * f64::from(n)).sin()).round() as i16;
            let taken: Vec<i16> = (0..samples.min(2000)).map(vibration).collect();
            let _progress = node.samples(&mut state, &taken);
        } else if below(bytes, 16) == 0 {
            let _progress = node.samples(&mut state, &[any(bytes), i16::MAX, i16::MIN]);
        }
        judge(&state);
    }
    2 * regular >= CALLS
}

fn judge_books(now: Status) {
    assert!(now.energy.is_finite() && now.energy_bound >= 0.0 && now.endurance >= 0.0, "{now:?}");
    assert!(now.power.is_finite() && now.power_bound >= 0.0, "{now:?}");
}

#[test]
fn a_node_by_the_voltage() {
    let node = voltage_node();
    fuzz("calls of a node, voltage", 1250, |bytes| {
        call_node(bytes, &node, |state| judge_books(node.status(state)))
    });
}

#[test]
fn a_node_by_a_map() {
    let node = node();
    fuzz("calls of a node, map", 1250, |bytes| {
        call_node(bytes, &node, |state| judge_books(node.status(state)))
    });
}
