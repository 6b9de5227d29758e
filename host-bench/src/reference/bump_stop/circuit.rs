//! The circuit in each of its regimes: a resistor, or a full bridge that blocks or conducts.
//!
//! With `i = Σ θ r'` the current of the beam, `C` the capacitance of the piezo and `C_s` that of the store, from
//! which `i_out` leaks and is drawn:
//!
//! ```text
//! resistor     C v' = i − v/R
//! blocked      C v' = i,                         C_s V_s' = −i_out      while |v| < V_s + 2 V_D
//! conducting   v = s (V_s + 2 V_D), so with C v' = i − s i_D and C_s V_s' = i_D − i_out
//!              (C + C_s) V_s' = s i − i_out,     v' = s V_s'
//!              i_D = (C_s s i + C i_out) / (C + C_s)                    while i_D > 0
//! ```
//!
//! The voltages are continuous. A node that draws a constant power draws a current that is no linear quantity;
//! it is a straight line in time, tangent to `P/V_s` and set anew so often that nothing else can be seen.

use nalgebra::DMatrix;

use super::system::{Row, System};
use crate::scene_file::Draw;

/// What a bridge does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bridge {
    /// It blocks, or there is none.
    Blocked,
    /// It conducts, the voltage of the harvester positive or negative.
    Conducting { negative: bool },
}

impl Bridge {
    /// Sign of the voltage while the bridge conducts, else 0.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Blocked => 0.0,
            Self::Conducting { negative: false } => 1.0,
            Self::Conducting { negative: true } => -1.0,
        }
    }
}

/// Regime of the circuit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Circuit {
    pub(super) bridge: Bridge,
    /// Whether the draw is connected.
    pub(super) connected: bool,
}

impl Circuit {
    /// Number of regimes.
    pub(super) const COUNT: usize = 6;

    /// Number of this one.
    pub(super) fn index(self) -> usize {
        let bridge = match self.bridge {
            Bridge::Blocked => 0,
            Bridge::Conducting { negative } => 1 + usize::from(negative),
        };
        2 * bridge + usize::from(self.connected)
    }
}

/// Currents in A of a regime of the circuit, as rows.
#[derive(Debug)]
pub(super) struct Currents {
    /// Through the diodes.
    pub(super) into_store: Row,
    pub(super) leaked: Row,
    pub(super) drawn: Row,
}

/// Adds `weight` times a row to another.
fn add(to: &mut [f64], weight: f64, row: &[f64]) {
    for (entry, other) in to.iter_mut().zip(row) {
        *entry += weight * other;
    }
}

impl System {
    /// The currents behind the bridge; zero without one.
    pub(super) fn currents(&self, circuit: Circuit) -> Currents {
        let zero = || vec![0.0; self.layout.size()];
        let (mut into_store, mut leaked, mut drawn) = (zero(), zero(), zero());
        let Some(store) = &self.store else { return Currents { into_store, leaked, drawn } };
        add(&mut leaked, store.leakage, &self.store_voltage);
        if circuit.connected {
            match store.draw {
                Draw::None => {}
                Draw::Resistor { resistance_ohm, .. } => {
                    add(&mut drawn, resistance_ohm.recip(), &self.store_voltage);
                }
                Draw::Current { current_a, .. } => drawn[self.layout.one()] = current_a,
                Draw::Power { .. } => drawn[self.layout.draw()[0]] = 1.0,
            }
        }
        // The parts of C_s and C in their sum; a bus is all of it.
        let ratio = self.modes.capacitance * store.elastance();
        let part = (1.0 + ratio).recip();
        let sign = circuit.bridge.sign();
        if sign != 0.0 {
            add(&mut into_store, part * sign, &self.current);
            add(&mut into_store, part * ratio, &leaked);
            add(&mut into_store, part * ratio, &drawn);
        }
        Currents { into_store, leaked, drawn }
    }

    /// The matrix of free motion with the circuit in this regime.
    pub(super) fn matrix(&self, circuit: Circuit, currents: &Currents) -> DMatrix<f64> {
        let mut matrix = self.free.clone();
        let Some(store) = &self.store else { return matrix };
        let Currents { into_store, leaked, drawn } = currents;
        let mut rate = vec![0.0; self.layout.size()];
        add(&mut rate, store.elastance(), into_store);
        add(&mut rate, -store.elastance(), leaked);
        add(&mut rate, -store.elastance(), drawn);
        // The entries of the vector are voltages divided by their weights in these rows.
        let electric = self.layout.voltage();
        let place = self.layout.store();
        let sign = circuit.bridge.sign();
        for (column, rate) in rate.iter().enumerate() {
            matrix[(place, column)] = rate / self.store_voltage[place];
            if sign != 0.0 {
                matrix[(electric, column)] = sign * rate / self.voltage[electric];
            }
        }
        matrix
    }
}
