//! A bump-stop harvester behind a full bridge, and a run of it.

use model_core::clock::Instant;
use model_core::energy::RunMeter;
use model_core::excitation::{Excitation, Sine};
use model_core::part::draw::{AnyDraw, ResistiveDraw};
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{AnyStorage, Capacitor, DcBus, StorageCapacitor, StorageElement};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{AnyChoices, Parts, StateOf, Stepper};

/// A bridge chosen at run time.
pub(crate) type AnyBridge<S> = FullBridge<S, AnyStorage<S>>;
/// A harvester behind one.
pub(crate) type Bridged<S> = AnyChoices<S, AnyBridge<S>>;

/// The baseline, into any load.
pub(crate) use crate::common::harvesters::bump_parameters_into as baseline;

/// A storage without leakage: farads, volts at the start, what is drawn, volts of each diode.
pub(crate) fn storage<S: Scalar>(
    capacitance: f64,
    voltage: f64,
    draw: AnyDraw<S>,
    drop: f64,
) -> AnyBridge<S> {
    let number = S::from_f64;
    let storage = AnyStorage::Capacitor(StorageCapacitor {
        capacitor: Capacitor { capacitance: number(capacitance), leakage_resistance: S::INFINITY },
        initial_voltage: number(voltage),
        draw,
    });
    FullBridge { diode_drop: number(drop), storage }
}

/// A bus.
pub(crate) fn bus(voltage: f64, drop: f64) -> AnyBridge<f64> {
    FullBridge { diode_drop: drop, storage: AnyStorage::DcBus(DcBus { voltage }) }
}

/// A resistor that is always connected.
pub(crate) fn resistor<S: Scalar>(resistance: f64) -> AnyDraw<S> {
    AnyDraw::Resistor(ResistiveDraw { resistance: S::from_f64(resistance), lockout: None })
}

/// 20 m/s² at a frequency in Hz.
pub(crate) fn vibration<S: Scalar>(frequency: f64) -> Sine<S, S::Build> {
    Sine::new(S::from_f64(20.0), S::from_f64(frequency), S::ZERO).expect("valid")
}

pub(crate) fn seconds(seconds: f64) -> Instant {
    Instant::from_seconds(seconds).expect("a time")
}

pub(crate) fn close(what: &str, value: f64, expected: f64, relative: f64) {
    println!("{what}: {value} for {expected}, {:.1e} of {relative:.0e}", value / expected - 1.0);
    assert!((value / expected - 1.0).abs() < relative, "{what}: {value} is not {expected} within {relative}");
}

/// Advances to a time in s.
pub(crate) fn advance<S, R, E, const B: usize, const Q: usize, const ALL: usize>(
    stepper: &Stepper<S, AnyChoices<S, FullBridge<S, R>>, B, Q, ALL>,
    state: &mut StateOf<S, AnyChoices<S, FullBridge<S, R>>, B, Q>,
    excitation: &E,
    to: f64,
) where
    S: Scalar,
    R: StorageElement<S>,
    E: Excitation<S>,
{
    stepper.advance(state, excitation, seconds(to), u32::MAX, &mut ()).expect("runs");
}

/// The same, and what a meter sees on the way.
pub(crate) fn measured<P, E, const B: usize, const Q: usize>(
    stepper: &Stepper<f64, P, B, Q, 1>,
    state: &mut StateOf<f64, P, B, Q>,
    excitation: &E,
    to: f64,
) -> RunMeter<f64>
where
    P: Parts<f64>,
    E: Excitation<f64>,
{
    let mut meter = RunMeter::new();
    stepper.advance(state, excitation, seconds(to), u32::MAX, &mut meter).expect("runs");
    meter
}
