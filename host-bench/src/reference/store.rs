//! What stands behind a full bridge: a storage capacitor with its leakage and its draw, or a bus.

use crate::outcome::StoreOutcome;
use crate::scene_file::{Draw, Load, Lockout, RectifiedStore};

/// A store, or a bus as one that is so large that nothing moves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Store {
    /// Capacitance in F; infinite for a bus.
    pub(super) capacitance: f64,
    /// Voltage in V over the two diodes that conduct at a time.
    pub(super) drop: f64,
    /// Conductance of the leakage in S.
    pub(super) leakage: f64,
    /// What the node draws.
    pub(super) draw: Draw,
    /// Voltage in V at the start.
    pub(super) initial: f64,
    /// A voltage in V of the size that the terminals see, where it is known; what is far below is rounding.
    pub(super) scale: f64,
}

impl Store {
    /// The one behind the bridge, if the load is a bridge.
    pub(super) fn of(load: Load) -> Option<Self> {
        match load {
            Load::Resistor { .. } => None,
            Load::RectifiedStore(RectifiedStore {
                capacitance_f,
                diode_drop_v,
                leakage_ohm,
                initial_v,
                draw,
            }) => Some(Self {
                capacitance: capacitance_f,
                drop: 2.0 * diode_drop_v,
                leakage: leakage_ohm.recip(),
                draw,
                initial: initial_v,
                scale: 0.0,
            }),
            Load::DcBus { voltage_v, diode_drop_v } => Some(Self {
                capacitance: f64::INFINITY,
                drop: 2.0 * diode_drop_v,
                leakage: 0.0,
                draw: Draw::None,
                initial: voltage_v,
                scale: 0.0,
            }),
        }
    }

    /// `1/C` in 1/F; 0 for a bus.
    pub(super) fn elastance(&self) -> f64 {
        self.capacitance.recip()
    }

    /// When the draw is connected; `None`: always, or never if there is none.
    pub(super) fn lockout(&self) -> Option<Lockout> {
        match self.draw {
            Draw::None => None,
            Draw::Resistor { lockout, .. } => lockout,
            Draw::Current { lockout, .. } | Draw::Power { lockout, .. } => Some(lockout),
        }
    }

    /// Whether the draw is connected at the start: from the turn-on voltage.
    pub(super) fn starts_connected(&self) -> bool {
        self.lockout().is_none_or(|lockout| self.initial >= lockout.turn_on_v)
    }

    /// Energy in J at a voltage in V; that of a bus, which has no end, counts as 0.
    pub(super) fn energy(&self, voltage: f64) -> f64 {
        if self.capacitance.is_infinite() { 0.0 } else { 0.5 * self.capacitance * voltage * voltage }
    }

    /// What a run has to say about it, from its voltage in V at the end and the losses in J of the diodes
    /// and the leakage, and what was drawn.
    pub(super) fn outcome(&self, voltage: f64, [diodes, leaked, drawn]: [f64; 3]) -> StoreOutcome {
        StoreOutcome {
            store_voltage_v: Some(voltage),
            stored_energy_j: self.capacitance.is_finite().then(|| self.energy(voltage)),
            diode_loss_j: Some(diodes),
            leaked_energy_j: Some(leaked),
            drawn_energy_j: Some(drawn),
        }
    }
}
