//! The circuit in each of its regimes: a resistor, or a full bridge that blocks or conducts.
//!
//! `i = Σ θ r'` is the current of the beam, `C` the capacitance of the piezoelectric layer, `C_s` that of the
//! storage, and `i_out` the current that leaks and is drawn from the storage:
//!
//! ```text
//! resistor     C v' = i − v/R
//! blocked      C v' = i,                         C_s V_s' = −i_out      while |v| < V_s + 2 V_D
//! conducting   v = s (V_s + 2 V_D), so with C v' = i − s i_D and C_s V_s' = i_D − i_out
//!              (C + C_s) V_s' = s i − i_out,     v' = s V_s'
//!              i_D = (C_s s i + C i_out) / (C + C_s)                    while i_D > 0
//! ```
//!
//! The voltages are continuous. The current of a constant power is not linear in the vector. It is a straight
//! line in time, tangent to `P/V_s` and set again so often that the error is below rounding.

use nalgebra::DMatrix;

use super::system::{Row, System};
use harvester_scene::scene_file::Draw;

/// Regime of the circuit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Circuit {
    /// Sign of the voltage of the harvester while the bridge conducts; 0 while it blocks, or if there is none.
    pub(super) sign: i8,
    /// Whether the draw is connected.
    pub(super) connected: bool,
}

impl Circuit {
    /// Number of regimes.
    pub(super) const COUNT: usize = 6;

    /// Number of this regime.
    pub(super) fn index(self) -> usize {
        let bridge = match self.sign {
            0 => 0,
            sign => 1 + usize::from(sign < 0),
        };
        2 * bridge + usize::from(self.connected)
    }
}

/// Currents in A of a regime of the circuit, as rows.
#[derive(Debug)]
pub(super) struct Currents {
    /// Through the diodes.
    pub(super) into_storage: Row,
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
        let (mut into_storage, mut leaked, mut drawn) = (zero(), zero(), zero());
        let Some(storage) = &self.storage else { return Currents { into_storage, leaked, drawn } };
        add(&mut leaked, storage.leakage, &self.storage_voltage);
        if circuit.connected {
            match storage.draw {
                Draw::None => {}
                Draw::Resistor { resistance_ohm, .. } => {
                    add(&mut drawn, resistance_ohm.recip(), &self.storage_voltage);
                }
                Draw::Current { current_a, .. } => drawn[self.layout.one()] = current_a,
                Draw::Power { .. } => drawn[self.layout.draw()[0]] = 1.0,
            }
        }
        // The parts of C_s and C in their sum; a bus takes the whole sum.
        let ratio = self.modes.capacitance * storage.elastance();
        let part = (1.0 + ratio).recip();
        let sign = f64::from(circuit.sign);
        if sign != 0.0 {
            add(&mut into_storage, part * sign, &self.current);
            add(&mut into_storage, part * ratio, &leaked);
            add(&mut into_storage, part * ratio, &drawn);
        }
        Currents { into_storage, leaked, drawn }
    }

    /// The matrix of free motion with the circuit in this regime.
    pub(super) fn matrix(&self, circuit: Circuit, currents: &Currents) -> DMatrix<f64> {
        let mut matrix = self.free.clone();
        let Some(storage) = &self.storage else { return matrix };
        let Currents { into_storage, leaked, drawn } = currents;
        let mut rate = vec![0.0; self.layout.size()];
        add(&mut rate, storage.elastance(), into_storage);
        add(&mut rate, -storage.elastance(), leaked);
        add(&mut rate, -storage.elastance(), drawn);
        // The entries of the vector are voltages divided by their weights in these rows.
        let electric = self.layout.voltage();
        let place = self.layout.storage();
        let sign = f64::from(circuit.sign);
        for (column, rate) in rate.iter().enumerate() {
            matrix[(place, column)] = rate / self.storage_voltage[place];
            if sign != 0.0 {
                matrix[(electric, column)] = sign * rate / self.voltage[electric];
            }
        }
        matrix
    }
}
