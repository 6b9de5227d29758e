//! The estimator for harvesters behind a bridge: its sums, its snapshots, and the refusal of foreign snapshots.

use crate::common::harvesters::{
    Bump, Contact, bump, bump_parameters_into, contact_parameters, sine_samples,
};
use crate::common::{adaptive, finished};
use model_core::energy::{Estimator, PowerMeter};
use model_core::excitation::{AfterLastSample, Sampled};
use model_core::integrate::{AnyStepControl, TrBdf2};
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, PowerDraw};
use model_core::part::load::AnyLoad;
use model_core::part::storage::{AnyStorage, Capacitor, StorageCapacitor};
use model_core::scene::bump_stop::{self, AnyChoices, Stepper};
use model_core::scene::contact_separation::Start;
use model_core::scene::rectified::{FullBridge, Rectified, STATES};
use model_core::scene::{Harvester, Simulation};
use model_core::snapshot::SnapshotError;

type Bridge = FullBridge<f32, AnyStorage<f32>>;
type Bridged = Rectified<f32, Contact<f32>, AnyStorage<f32>>;
type Hybrid = Simulation<Bridged, TrBdf2, AnyStepControl<f32>, STATES, 1>;

const RATE: f32 = 400.0;

fn draw() -> AnyDraw<f32> {
    AnyDraw::Power(PowerDraw { power: 3e-6, lockout: Lockout { turn_on: 2.5, turn_off: 2.0 } })
}

fn bridge(diode_drop: f32, capacitance: f32, draw: AnyDraw<f32>) -> Bridge {
    let storage = StorageCapacitor {
        capacitor: Capacitor { capacitance, leakage_resistance: 1e12 },
        initial_voltage: 2.4,
        draw,
    };
    FullBridge { diode_drop, storage: AnyStorage::Capacitor(storage) }
}

fn scene(bridge: Bridge) -> Bridged {
    let mut parameters = contact_parameters::<f32>();
    parameters.choices.load = AnyLoad { resistance: f32::INFINITY };
    Rectified::new(parameters.build().expect("in bounds"), bridge).expect("in bounds")
}

fn hybrid(bridge: Bridge) -> Hybrid {
    Simulation::new(scene(bridge), TrBdf2, adaptive(5e-2))
}

fn modal(bridge: Bridge) -> Stepper<f32, AnyChoices<f32, Bridge>, 4, 1> {
    let parameters = bump_parameters_into(bridge);
    Stepper::new(parameters.build().expect("in bounds"), 9e-6, 80e-6).expect("in bounds")
}

fn estimator<H: Harvester<f32>>(harvester: H, rate: f32) -> Estimator<f32, H> {
    Estimator::new(harvester, crate::estimator::settings(rate.into())).expect("in bounds")
}

/// Pushes `count` samples of a sine, from sample number `from` on.
fn feed<H: Harvester<f32>>(estimator: &mut Estimator<f32, H>, sine: [f64; 3], from: u32, count: u32) {
    for sample in &sine_samples(sine[0], sine[1], sine[2], from + count)[from as usize..] {
        finished(estimator.push_acceleration(*sample, u32::MAX));
    }
}

const SHAKEN: [f64; 3] = [1.962, 20.0, 400.0];
const HIT: [f64; 3] = [20.0, 220.0, 3520.0];

#[test]
fn what_enters_the_store_is_what_a_power_meter_counts_shared_charge_included() {
    let bridge = bridge(0.3, 1e-6, draw());
    let mut estimator = estimator(hybrid(bridge), RATE);
    feed(&mut estimator, SHAKEN, 0, 1200);
    // The same samples, as a trace, advanced to where the estimator stands.
    let simulation = hybrid(bridge);
    let samples = sine_samples::<f32>(SHAKEN[0], SHAKEN[1], SHAKEN[2], 1201);
    let trace = Sampled::new(&samples, RATE, AfterLastSample::Silence).expect("valid");
    let mut state = simulation.start(&Start::default(), &trace).expect("in bounds");
    let mut meter = PowerMeter::<f32>::new();
    let until = estimator.known_until();
    simulation.advance(&mut state, &trace, until, u32::MAX, &mut meter).expect("runs");
    let (found, expected) = (estimator.estimate(), meter.delivered_energy());
    assert!(expected > 1e-6);
    assert!((found.energy / expected - 1.0).abs() < 2e-2, "{} {expected}", found.energy);
    let storage = found.storage.expect("there is one");
    assert!(
        (storage.voltage - simulation.scene().storage_voltage(state.mode, &state.point.state)).abs() < 2e-2
    );
}

#[test]
fn a_store_that_is_drawn_from_outside_takes_up_what_the_harvester_holds_above_it() {
    let quiet = bridge(0.3, 1e-6, AnyDraw::None);
    let mut estimator = estimator(hybrid(quiet), RATE);
    feed(&mut estimator, SHAKEN, 0, 900);
    let reading = |estimator: &Estimator<f32, Hybrid>| estimator.estimate().storage.expect("there is one");
    let mut taken = 0.0;
    // Drawn down and put up, wherever in its period the bridge is.
    for round in 0..40 {
        let before = reading(&estimator);
        let volts = before.voltage + if round % 2 == 0 { -0.3 } else { 0.25 };
        estimator.set_storage_voltage(volts);
        let after = reading(&estimator);
        assert!((after.voltage - volts).abs() < 1e-6, "{} {volts}", after.voltage);
        taken += f64::from(before.energy()) - f64::from(after.energy());
        feed(&mut estimator, SHAKEN, 900 + 7 * round, 7);
    }
    let (estimate, storage) = (estimator.estimate(), reading(&estimator));
    let held = f64::from(storage.energy()) - 0.5e-6 * 2.4 * 2.4 + taken;
    // What came in is what is held and was taken, but for 30 pJ of leakage.
    assert!((f64::from(estimate.energy) / held - 1.0).abs() < 1e-3, "{} {held}", estimate.energy);
    // What is no voltage changes nothing.
    for nothing in [f32::NAN, -1.0, f32::INFINITY] {
        estimator.set_storage_voltage(nothing);
        assert_eq!(reading(&estimator), storage);
    }
}

fn resumes<H: Harvester<f32> + Copy>(harvester: H, foreign: &[H], sine: [f64; 3], stops: [u32; 3]) {
    let mut whole = estimator(harvester, sine[2] as f32);
    let mut from = 0;
    for stop in stops {
        feed(&mut whole, sine, from, stop - from);
        from = stop;
        let mut snapshot = [0; 512];
        whole.save(&mut snapshot).expect("there is room");
        let mut awake = estimator(harvester, sine[2] as f32);
        awake.restore(&snapshot).expect("its own");
        feed(&mut awake, sine, stop, 50);
        let mut uninterrupted = whole;
        feed(&mut uninterrupted, sine, stop, 50);
        assert_eq!(awake.harvester_state(), uninterrupted.harvester_state());
        assert_eq!(awake.estimate(), uninterrupted.estimate());
        for (index, &other) in foreign.iter().enumerate() {
            let refused = estimator(other, sine[2] as f32).restore(&snapshot);
            assert_eq!(refused, Err(SnapshotError::ForeignModel), "{index}");
        }
    }
}

/// Another drop, another storage, no draw, and one that takes the same current at the turn-on voltage only.
fn foreign() -> [Bridge; 4] {
    let lockout = Lockout { turn_on: 2.5, turn_off: 2.0 };
    let current = AnyDraw::Current(CurrentDraw { current: 3e-6 / 2.5, lockout });
    [
        bridge(0.31, 1e-6, draw()),
        bridge(0.3, 2e-6, draw()),
        bridge(0.3, 1e-6, AnyDraw::None),
        bridge(0.3, 1e-6, current),
    ]
}

#[test]
fn a_hybrid_harvester_behind_a_bridge_resumes_with_its_bits_and_takes_no_foreign_image() {
    let others = foreign().map(hybrid);
    resumes(hybrid(bridge(0.3, 1e-6, draw())), &others, SHAKEN, [3, 500, 1003]);
}

#[test]
fn a_modal_harvester_behind_a_bridge_resumes_with_its_bits_and_takes_no_foreign_image() {
    let others = foreign().map(modal);
    resumes(modal(bridge(0.3, 1e-6, draw())), &others, HIT, [5, 700, 1501]);
    // A resistor in its place is another harvester altogether.
    let plain: Bump<f32, 4, 1> = bump(bump_stop::AnyContact::ResidualFlexibility);
    let mut snapshot = [0; 512];
    estimator(plain, 3520.0).save(&mut snapshot).expect("there is room");
    assert!(estimator(modal(bridge(0.3, 1e-6, draw())), 3520.0).restore(&snapshot).is_err());
}
