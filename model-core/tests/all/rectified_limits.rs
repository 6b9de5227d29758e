//! Both triboelectric scenes behind a full bridge in limiting cases and against closed forms.

use crate::bridge::{adaptive, begin, behind, pad, run, sine};
use model_core::clock::Instant;
use model_core::energy::RunMeter;
use model_core::hybrid::Driver;
use model_core::integrate::{ExponentialRadau, TrBdf2};
use model_core::observer::PowerIndex;
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, PowerDraw, ResistiveDraw};
use model_core::part::force_law::AnyForceLaw;
use model_core::part::storage::{Capacitor, DcBus, StorageCapacitor};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::contact_separation as contact;

/// A bus beyond the reach of the harvester is an open circuit, bit for bit.
#[test]
fn a_bus_out_of_reach_is_an_open_circuit() {
    let driver = Driver::new(TrBdf2, adaptive(1e-4));
    let law = AnyForceLaw::TransferredCharge;
    let (bus, vibration) = (DcBus { voltage: 1e6_f32 }, sine::<f32>(0.2, 20.0));
    let end = Instant::from_whole_seconds(2);
    let open = pad::<f32>(f64::INFINITY, law);
    let mut state = begin(&open, &vibration, &driver);
    let alone = driver.advance(&open, &mut state, &vibration, end, u32::MAX, &mut ()).expect("runs");
    let scene = behind(open, bus, 0.3);
    let mut found = begin(&scene, &vibration, &driver);
    let bridged = driver.advance(&scene, &mut found, &vibration, end, u32::MAX, &mut ()).expect("runs");
    assert!(alone.work.events > 10);
    assert_eq!(bridged.work, alone.work);
    assert_eq!(found.point.state[..3], state.point.state);
    assert_eq!(found.point.remainder[..3], state.point.remainder);
}

/// A storage with a draw and a harvester at rest: how long it lasts is known in closed form.
#[test]
fn a_draw_empties_the_store_on_time_and_comes_back_at_the_higher_voltage() {
    let lockout = Lockout { turn_on: 3.0, turn_off: 2.0 };
    let (capacitance, full) = (1e-6, 3.0_f64);
    let draws = [
        (
            AnyDraw::Power(PowerDraw { power: 5e-6, lockout }),
            capacitance * (full * full - 4.0) / (2.0 * 5e-6),
        ),
        (AnyDraw::Current(CurrentDraw { current: 2e-6, lockout }), capacitance * (full - 2.0) / 2e-6),
        (
            AnyDraw::Resistor(ResistiveDraw { resistance: 1e6, lockout: Some(lockout) }),
            1e6 * capacitance * (full / 2.0).ln(),
        ),
    ];
    let driver = Driver { pause_at_events: true, ..Driver::new(TrBdf2, adaptive(1e-6)) };
    let still = sine::<f64>(0.0, 20.0);
    for (draw, seconds) in draws {
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance: f64::INFINITY },
            initial_voltage: full,
            draw,
        };
        let scene = behind(pad::<f64>(f64::INFINITY, AnyForceLaw::GapField), storage, 0.3);
        let mut state = begin(&scene, &still, &driver);
        assert!(state.mode.connected);
        let mut meter = RunMeter::new();
        let end = Instant::from_whole_seconds(3);
        driver.advance(&scene, &mut state, &still, end, u32::MAX, &mut meter).expect("runs");
        let found = state.clock.seconds::<f64>();
        println!("{draw:?}: {found} s, expected {seconds} s");
        assert!(!state.mode.connected && (found / seconds - 1.0).abs() < 1e-6, "{draw:?}");
        let drawn = meter.integrals().integral(PowerIndex::Draw);
        assert!(
            (drawn / (0.5 * capacitance * (full * full - 4.0)) - 1.0).abs() < 1e-6,
            "{draw:?}: {drawn:e}"
        );
    }
    // Charged from below: connected at each rise to the upper voltage, and not before.
    let draw = PowerDraw { power: 2e-4, lockout };
    let storage = StorageCapacitor {
        capacitor: Capacitor { capacitance: 2e-8, leakage_resistance: f64::INFINITY },
        initial_voltage: 2.5,
        draw,
    };
    let scene = behind(pad::<f32>(f64::INFINITY, AnyForceLaw::TransferredCharge), single(storage), 0.3);
    let vibration = sine::<f32>(0.2, 20.0);
    let driver = Driver { pause_at_events: true, ..Driver::new(TrBdf2, adaptive::<f32>(1e-4)) };
    let mut state = begin(&scene, &vibration, &driver);
    assert!(!state.mode.connected);
    let mut toggles = 0;
    let end = Instant::from_whole_seconds(4);
    while state.clock < end {
        let before = state.mode.connected;
        driver.advance(&scene, &mut state, &vibration, end, u32::MAX, &mut ()).expect("runs");
        if state.mode.connected != before {
            toggles += 1;
            let level = if before { 2.0 } else { 3.0 };
            let voltage = scene.storage_voltage(state.mode, &state.point.state);
            assert!((voltage - level).abs() < 1e-5, "{voltage} {level}");
        }
    }
    println!("{toggles} toggles");
    assert!(toggles > 10);
}

fn single(storage: StorageCapacitor<f64, PowerDraw<f64>>) -> StorageCapacitor<f32, PowerDraw<f32>> {
    let Lockout { turn_on, turn_off } = storage.draw.lockout;
    StorageCapacitor {
        capacitor: Capacitor {
            capacitance: storage.capacitor.capacitance as f32,
            leakage_resistance: f32::INFINITY,
        },
        initial_voltage: storage.initial_voltage as f32,
        draw: PowerDraw {
            power: storage.draw.power as f32,
            lockout: Lockout { turn_on: turn_on as f32, turn_off: turn_off as f32 },
        },
    }
}

/// A draw whose time constant is a thousandth of a period empties the storage again and again: its voltage is the draw's
/// resistance times the current, and goes through zero with the velocity. Without diode drops the two thresholds are then one.
/// The draw receives what a resistor at the terminals would, by both force laws and in both precisions.
#[test]
fn a_storage_that_its_draw_empties_is_a_resistor_at_the_terminals() {
    fn delivered<S: Scalar>(law: AnyForceLaw, tolerance: f64) -> [f64; 2]
    where
        Polynomial: Mathematics<S>,
    {
        let ohms = 1e4;
        let number = S::from_f64;
        let emptied = StorageCapacitor {
            capacitor: Capacitor { capacitance: number(1e-9), leakage_resistance: number(1e15) },
            initial_voltage: S::ONE,
            draw: AnyDraw::Resistor(ResistiveDraw { resistance: number(ohms), lockout: None }),
        };
        let driver = Driver::new(ExponentialRadau, adaptive::<S>(tolerance));
        let (vibration, seconds) = (sine::<S>(0.2, 20.0), 1.0);
        let scene = behind(pad::<S>(f64::INFINITY, law), emptied, 0.0);
        let mut meter = RunMeter::new();
        run(&scene, &contact::Start::default(), &vibration, &driver, seconds, &mut meter);
        let bare = pad::<S>(ohms, law);
        let mut state = begin(&bare, &vibration, &driver);
        let mut alone = RunMeter::new();
        let end = Instant::from_seconds(seconds).expect("in range");
        driver.advance(&bare, &mut state, &vibration, end, u32::MAX, &mut alone).expect("runs");
        [meter.integrals().integral(PowerIndex::Draw), alone.integrals().integral(PowerIndex::Load)]
            .map(Scalar::to_f64)
    }
    for law in [AnyForceLaw::GapField, AnyForceLaw::TransferredCharge] {
        let found = [delivered::<f64>(law, 6e-4), delivered::<f64>(law, 5e-2), delivered::<f32>(law, 6e-4)];
        for [drawn, alone] in found {
            // At the start the storage holds 0.5 nJ.
            println!("{law:?}: {:e} J drawn, {alone:e} J in the resistor", drawn - 0.5e-9);
            assert!(((drawn - 0.5e-9) / alone - 1.0).abs() < 0.05);
        }
    }
}
