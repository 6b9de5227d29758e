//! Currents and their derivatives, what is shared at once, and a storage in stick against steps of Runge and
//! Kutta.

use super::super::stick::StorageInStick;
use super::*;
use harvester_scene::scene_file::{Load, Lockout, RectifiedStore, StickCharge};

fn storage(draw: Draw) -> Storage {
    let load =
        RectifiedStore { capacitance_f: 2e-9, diode_drop_v: 0.25, leakage_ohm: 3e9, initial_v: 3.0, draw };
    Storage::of(Load::RectifiedStore(load)).expect("a storage")
}

const LOCKOUT: Lockout = Lockout { turn_on_v: 2.5, turn_off_v: 1.0 };

fn draws() -> [Draw; 4] {
    [
        Draw::None,
        Draw::Resistor { resistance_ohm: 1e9, lockout: None },
        Draw::Current { current_a: 2e-9, lockout: LOCKOUT },
        Draw::Power { power_w: 5e-9, lockout: LOCKOUT },
    ]
}

fn stick(
    storage: &Storage,
    start: Bridge,
    [terminal, capacitance]: [f64; 2],
    stick_charge: StickCharge,
) -> StorageInStick<'_> {
    StorageInStick { storage, start, terminal, stick_charge, capacitance }
}

#[test]
fn port_and_storage_move_together_while_the_bridge_conducts() {
    for draw in draws() {
        for sign in [1.0, -1.0] {
            let storage = storage(draw);
            let bridge = Bridge { gain: 0.1, sign, connected: true };
            let port = ElectricalPort { voltage: sign * 3.6, driven: sign * 4e-9, capacitance: 0.5e-9 };
            let current = storage.current(&port, &bridge);
            let harvester = (port.driven - current) / port.capacitance;
            assert!((sign * harvester / storage.gain_rate(&port, &bridge) - 1.0).abs() < 1e-12);
            for changes in [[1e-13, 0.0, 0.0], [0.0, 1e-14, 0.0], [0.0, 0.0, 1e-5]] {
                let moved = |way: f64| {
                    let [driven, capacitance, gain] = changes.map(|change| way * change);
                    let port = ElectricalPort {
                        driven: port.driven + driven,
                        capacitance: port.capacitance + capacitance,
                        ..port
                    };
                    storage.gain_rate(&port, &Bridge { gain: bridge.gain + gain, ..bridge })
                };
                let difference = 0.5 * (moved(1.0) - moved(-1.0));
                let along = storage.gain_rate_along(&port, &bridge, changes);
                assert!((difference - along).abs() <= 1e-6 * along.abs() + 1e-15, "{difference} {along}");
            }
        }
    }
}

/// Half a nanofarad at 6 V against a threshold of 3.5 V: the charge is kept, and what energy is lost is lost in
/// the diodes.
#[test]
fn a_charge_above_the_threshold_is_shared() {
    let storage = storage(Draw::None);
    let port = ElectricalPort { voltage: -6.0, driven: -1e-9, capacitance: 0.5e-9 };
    let mut bridge = storage.start();
    let (voltage, shared) = storage.find_regime(port, &mut bridge, 0.0);
    assert!((bridge.gain - 0.5).abs() < 1e-14 && (voltage + 4.0).abs() < 1e-14, "{bridge:?} {voltage}");
    assert_eq!(bridge.sign, -1.0);
    let given = 0.5 * port.capacitance * (36.0 - voltage * voltage);
    assert!((shared[integral::INTO_LOAD] + shared[integral::DIODES] - given).abs() < 1e-12 * given);
    assert!((shared[integral::INTO_LOAD] - storage.gained(&bridge)).abs() < 1e-12 * given);
    // No current flows back.
    let back = ElectricalPort { driven: 1.0, voltage, ..port };
    let (after, _) = storage.find_regime(back, &mut bridge, 0.0);
    assert_eq!((bridge.sign, after), (0.0, voltage));
}

#[test]
fn a_storage_in_stick_loses_what_leaves_it() {
    for draw in draws() {
        for sign in [0.0, -1.0] {
            let storage = storage(draw);
            let start = Bridge { sign, ..storage.start() };
            let capacitance = 0.5e-9;
            let rest = stick(&storage, start, [-3.5, capacitance], StickCharge::Relaxing);
            let (span, count) = (0.7, 20_000);
            let step = span / f64::from(count);
            let total = if sign == 0.0 { storage.capacitance } else { storage.capacitance + capacitance };
            let rate = |voltage: f64| {
                let bridge = Bridge { gain: voltage - storage.initial, ..start };
                let [out, _] = storage.outflow(&bridge);
                let [drawn, _] = storage.drawn(voltage, true);
                [-out / total, storage.leakage * voltage * voltage, drawn * voltage]
            };
            let (mut voltage, mut leaked, mut drawn) = (storage.initial, 0.0, 0.0);
            for _ in 0..count {
                let [first, ..] = rate(voltage);
                let middle = rate(voltage + 0.5 * step * first);
                let again = rate(voltage + 0.5 * step * middle[0]);
                let last = rate(voltage + step * again[0]);
                let start = rate(voltage);
                let mean = |index: usize| {
                    (start[index] + 2.0 * (middle[index] + again[index]) + last[index]) * step / 6.0
                };
                voltage += mean(0);
                leaked += mean(1);
                drawn += mean(2);
            }
            let end = rest.bridge(span);
            assert!(
                (storage.voltage(&end) - voltage).abs() < 1e-12,
                "{draw:?} {}",
                storage.voltage(&end) - voltage
            );
            let integrals = rest.integrals(span);
            assert!((integrals[integral::LEAKED] / leaked - 1.0).abs() < 1e-11);
            assert!((integrals[integral::DRAWN] - drawn).abs() <= 1e-11 * drawn);
            assert!(
                (storage.gained(&end)
                    - (integrals[integral::INTO_LOAD]
                        - integrals[integral::LEAKED]
                        - integrals[integral::DRAWN]))
                    .abs()
                    < 1e-12 * storage.energy(3.0)
            );
            // While the bridge conducts the harvester's charge goes the same way.
            let terminal = if sign == 0.0 { 3.5 } else { voltage + 0.5 };
            assert!((rest.terminal(span) + terminal).abs() < 1e-12);
            let given = 0.5 * capacitance * (3.5 * 3.5 - terminal * terminal);
            let passed = integrals[integral::INTO_LOAD] + integrals[integral::DIODES];
            assert!((passed - given).abs() < 1e-12 * storage.energy(3.0));
        }
    }
}

#[test]
fn switches_in_stick_are_found() {
    let storage = storage(Draw::Current { current_a: 2e-9, lockout: LOCKOUT });
    let start = storage.start();
    let frozen = stick(&storage, start, [-3.2, 0.5e-9], StickCharge::Frozen);
    let (off, switch) = frozen.switch(10.0).expect("the draw is disconnected");
    assert_eq!(switch, Switch::Draw { connected: false });
    assert!((storage.voltage(&frozen.bridge(off)) - LOCKOUT.turn_off_v).abs() < 1e-12);
    assert_eq!(frozen.switch(0.99 * off), None);
    assert_eq!(frozen.integrals(off)[integral::VOLTAGE_SQUARED], 0.0);
    // The terminals wait at 3.2 V until the storage has fallen to 2.7 V.
    let relaxing = stick(&storage, start, [-3.2, 0.5e-9], StickCharge::Relaxing);
    let (on, switch) = relaxing.switch(10.0).expect("the bridge conducts");
    assert_eq!(switch, Switch::Conducts { sign: -1.0 });
    assert!(on < off && (storage.voltage(&relaxing.bridge(on)) - 2.7).abs() < 1e-12);
}
