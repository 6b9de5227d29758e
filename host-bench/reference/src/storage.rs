//! The storage behind a full bridge: a capacitor with its leakage and its draw, or a bus.

use harvester_scene::outcome::StoreOutcome;
use harvester_scene::scene_file::{Draw, Load, Lockout, RectifiedStore};

/// A storage capacitor, or a bus as a capacitor of infinite size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Storage {
    /// Capacitance in F; infinite for a bus.
    pub(super) capacitance: f64,
    /// Forward voltage in V of the two diodes that conduct at a time.
    pub(super) drop: f64,
    /// Conductance of the leakage in S.
    pub(super) leakage: f64,
    pub(super) draw: Draw,
    /// Voltage in V at the start.
    pub(super) initial: f64,
    /// Size in V of the terminal voltage, where it is known; voltages far below it are rounding.
    pub(super) scale: f64,
}

impl Storage {
    /// The storage behind the bridge, if the load is a bridge.
    pub(super) fn of(load: Load) -> Option<Self> {
        let store = match load {
            Load::Resistor { .. } => return None,
            Load::RectifiedStore(store) => store,
            Load::DcBus { voltage_v, diode_drop_v } => RectifiedStore {
                capacitance_f: f64::INFINITY,
                diode_drop_v,
                leakage_ohm: f64::INFINITY,
                initial_v: voltage_v,
                draw: Draw::None,
            },
        };
        Some(Self {
            capacitance: store.capacitance_f,
            drop: 2.0 * store.diode_drop_v,
            leakage: store.leakage_ohm.recip(),
            draw: store.draw,
            initial: store.initial_v,
            scale: 0.0,
        })
    }

    /// Whether the storage is a bus, which has no stored energy.
    pub(super) fn is_bus(&self) -> bool {
        self.capacitance.is_infinite()
    }

    /// `1/C` in 1/F; 0 for a bus.
    pub(super) fn elastance(&self) -> f64 {
        self.capacitance.recip()
    }

    /// Thresholds of the draw; `None` if the draw is always connected, or if there is none.
    pub(super) fn lockout(&self) -> Option<Lockout> {
        self.draw.lockout()
    }

    /// Whether the draw is connected by a voltage in V at the start: from the turn-on voltage.
    pub(super) fn starts_connected(&self, voltage: f64) -> bool {
        self.lockout().is_none_or(|lockout| voltage >= lockout.turn_on_v)
    }

    /// Energy in J at a voltage in V; 0 for a bus.
    pub(super) fn energy(&self, voltage: f64) -> f64 {
        if self.is_bus() { 0.0 } else { 0.5 * self.capacitance * voltage * voltage }
    }

    /// Outcome of a run that ended at this voltage in V, with the energies in J lost in the diodes, leaked and drawn.
    pub(super) fn outcome(&self, voltage: f64, [diodes, leaked, drawn]: [f64; 3]) -> StoreOutcome {
        StoreOutcome {
            mean_store_current_a: None,
            store_voltage_v: Some(voltage),
            stored_energy_j: (!self.is_bus()).then(|| self.energy(voltage)),
            diode_loss_j: Some(diodes),
            leaked_energy_j: Some(leaked),
            drawn_energy_j: Some(drawn),
            cycles: None,
        }
    }
}
