//! Currents and their derivatives, what is shared at once, and a store at rest against steps of Runge and Kutta.

use super::*;
use crate::scene_file::{Load, Lockout, RectifiedStore, StickCharge};

fn store(draw: Draw) -> Store {
    let load =
        RectifiedStore { capacitance_f: 2e-9, diode_drop_v: 0.25, leakage_ohm: 3e9, initial_v: 3.0, draw };
    Store::of(Load::RectifiedStore(load)).expect("a store")
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

#[test]
fn terminals_and_store_move_together_while_the_bridge_conducts() {
    for draw in draws() {
        for sign in [1.0, -1.0] {
            let store = store(draw);
            let bridge = Bridge { gain: 0.1, sign, connected: true };
            let terminals = Terminals { voltage: sign * 3.6, driven: sign * 4e-9, capacitance: 0.5e-9 };
            let current = store.current(&terminals, &bridge);
            let harvester = (terminals.driven - current) / terminals.capacitance;
            assert!((sign * harvester / store.gain_rate(&terminals, &bridge) - 1.0).abs() < 1e-12);
            for changes in [[1e-13, 0.0, 0.0], [0.0, 1e-14, 0.0], [0.0, 0.0, 1e-5]] {
                let moved = |way: f64| {
                    let [driven, capacitance, gain] = changes.map(|change| way * change);
                    let terminals = Terminals {
                        driven: terminals.driven + driven,
                        capacitance: terminals.capacitance + capacitance,
                        ..terminals
                    };
                    store.gain_rate(&terminals, &Bridge { gain: bridge.gain + gain, ..bridge })
                };
                let difference = 0.5 * (moved(1.0) - moved(-1.0));
                let along = store.gain_rate_along(&terminals, &bridge, changes);
                assert!((difference - along).abs() <= 1e-6 * along.abs() + 1e-15, "{difference} {along}");
            }
        }
    }
}

/// Half a nanofarad at 6 V against a threshold of 3.5 V: the charge is kept, and what energy is lost is lost in
/// the diodes.
#[test]
fn a_charge_above_the_threshold_is_shared() {
    let store = store(Draw::None);
    let terminals = Terminals { voltage: -6.0, driven: -1e-9, capacitance: 0.5e-9 };
    let mut bridge = store.start();
    let (voltage, shared) = store.settle(terminals, &mut bridge, 0.0);
    assert!((bridge.gain - 0.5).abs() < 1e-14 && (voltage + 4.0).abs() < 1e-14, "{bridge:?} {voltage}");
    assert_eq!(bridge.sign, -1.0);
    let given = 0.5 * terminals.capacitance * (36.0 - voltage * voltage);
    assert!((shared.into_store + shared.diode_loss - given).abs() < 1e-12 * given);
    assert!((shared.into_store - store.gained(&bridge)).abs() < 1e-12 * given);
    // No current flows back.
    let back = Terminals { driven: 1.0, voltage, ..terminals };
    let (after, _) = store.settle(back, &mut bridge, 0.0);
    assert_eq!((bridge.sign, after), (0.0, voltage));
}

#[test]
fn a_store_at_rest_loses_what_leaves_it() {
    for draw in draws() {
        for sign in [0.0, -1.0] {
            let store = store(draw);
            let start = Bridge { sign, ..store.start() };
            let capacitance = 0.5e-9;
            let rest = Rest::new(&store, start, -3.5, capacitance, StickCharge::Relaxing);
            let (span, count) = (0.7, 20_000);
            let step = span / f64::from(count);
            let total = if sign == 0.0 { store.capacitance } else { store.capacitance + capacitance };
            let rate = |voltage: f64| {
                let bridge = Bridge { gain: voltage - store.initial, ..start };
                let [out, _] = store.outflow(&bridge);
                let [drawn, _] = store.drawn(voltage, true);
                [-out / total, store.leakage * voltage * voltage, drawn * voltage]
            };
            let (mut voltage, mut leaked, mut drawn) = (store.initial, 0.0, 0.0);
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
                (store.voltage(&end) - voltage).abs() < 1e-12,
                "{draw:?} {}",
                store.voltage(&end) - voltage
            );
            let integrals = rest.integrals(span);
            assert!((integrals.leaked / leaked - 1.0).abs() < 1e-11);
            assert!((integrals.drawn - drawn).abs() <= 1e-11 * drawn);
            assert!((store.gained(&end) - integrals.stored()).abs() < 1e-12 * store.energy(3.0));
            // While the bridge conducts the harvester's charge goes the same way.
            let terminal = if sign == 0.0 { 3.5 } else { voltage + 0.5 };
            assert!((rest.terminal(span) + terminal).abs() < 1e-12);
            let given = 0.5 * capacitance * (3.5 * 3.5 - terminal * terminal);
            let passed = integrals.into_store + integrals.diode_loss;
            assert!((passed - given).abs() < 1e-12 * store.energy(3.0));
        }
    }
}

#[test]
fn what_happens_at_rest_is_found() {
    let store = store(Draw::Current { current_a: 2e-9, lockout: LOCKOUT });
    let start = store.start();
    let frozen = Rest::new(&store, start, -3.2, 0.5e-9, StickCharge::Frozen);
    let (off, switch) = frozen.switch(10.0).expect("the draw is disconnected");
    assert_eq!(switch, Switch::Draw { connected: false });
    assert!((store.voltage(&frozen.bridge(off)) - LOCKOUT.turn_off_v).abs() < 1e-12);
    assert_eq!(frozen.switch(0.99 * off), None);
    assert_eq!(frozen.integrals(off).voltage_squared, 0.0);
    // The terminals wait at 3.2 V until the store has fallen to 2.7 V.
    let relaxing = Rest::new(&store, start, -3.2, 0.5e-9, StickCharge::Relaxing);
    let (on, switch) = relaxing.switch(10.0).expect("the bridge conducts");
    assert_eq!(switch, Switch::Conducts { sign: -1.0 });
    assert!(on < off && (store.voltage(&relaxing.bridge(on)) - 2.7).abs() < 1e-12);
}
