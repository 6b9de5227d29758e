//! The core's bridge, and what it charges, of a scene's load.

use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, PowerDraw, ResistiveDraw};
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{AnyStorage, Capacitor, DcBus, StorageCapacitor};
use model_core::scalar::Scalar;

use harvester_scene::scene_file::{self, Draw, Load};

/// The bridge; `None` where the load is a resistor.
pub(super) fn bridge<S: Scalar>(load: Load) -> Option<FullBridge<S, AnyStorage<S>>> {
    let number = S::from_f64;
    match load {
        Load::Resistor { .. } => None,
        Load::RectifiedStore(store) => Some(FullBridge {
            diode_drop: number(store.diode_drop_v),
            storage: AnyStorage::Capacitor(StorageCapacitor {
                capacitor: Capacitor {
                    capacitance: number(store.capacitance_f),
                    leakage_resistance: number(store.leakage_ohm),
                },
                initial_voltage: initial_voltage(store.initial_v, store.draw.lockout()),
                draw: draw(store.draw),
            }),
        }),
        Load::DcBus { voltage_v, diode_drop_v } => Some(FullBridge {
            diode_drop: number(diode_drop_v),
            storage: AnyStorage::DcBus(DcBus { voltage: number(voltage_v) }),
        }),
    }
}

/// The start voltage in V; of a draw that it does not connect, below the rounded turn-on voltage.
fn initial_voltage<S: Scalar>(initial_v: f64, lockout: Option<scene_file::Lockout>) -> S {
    let below = lockout.filter(|lockout| initial_v < lockout.turn_on_v);
    let most = below.map(|lockout| S::from_f64(lockout.turn_on_v) * (S::ONE - S::EPSILON));
    most.map_or(S::from_f64(initial_v), |most| S::from_f64(initial_v).min(most))
}

fn draw<S: Scalar>(draw: Draw) -> AnyDraw<S> {
    let number = S::from_f64;
    let thresholds = |lockout: scene_file::Lockout| Lockout {
        turn_on: number(lockout.turn_on_v),
        turn_off: number(lockout.turn_off_v),
    };
    match draw {
        Draw::None => AnyDraw::None,
        Draw::Resistor { resistance_ohm, lockout } => AnyDraw::Resistor(ResistiveDraw {
            resistance: number(resistance_ohm),
            lockout: lockout.map(thresholds),
        }),
        Draw::Current { current_a, lockout } => {
            AnyDraw::Current(CurrentDraw { current: number(current_a), lockout: thresholds(lockout) })
        }
        Draw::Power { power_w, lockout } => {
            AnyDraw::Power(PowerDraw { power: number(power_w), lockout: thresholds(lockout) })
        }
    }
}
