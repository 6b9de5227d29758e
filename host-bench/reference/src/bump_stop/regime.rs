//! A regime, one state of contact and circuit: its exact propagation, and the guards that end it.

use nalgebra::DMatrix;

use super::propagator::{FORMS, Propagator};
use super::system::{Row, System, value};
use crate::ledger::integral;
use harvester_scene::scene_file::Draw;

/// The change of regime where a guard rises through zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// The contact closes or opens.
    Contact,
    /// The bridge begins to conduct at a voltage of this sign.
    Conducts { sign: i8 },
    /// The bridge begins to block.
    Blocks,
    /// The draw is connected or disconnected.
    Draw { connected: bool },
}

/// A linear quantity that is negative while a regime lasts.
pub(super) struct Guard {
    pub(super) change: Change,
    row: Row,
    rate: Row,
}

impl Guard {
    fn new(change: Change, row: Row, matrix: &DMatrix<f64>) -> Self {
        Self { change, rate: System::rate(&row, matrix), row }
    }

    /// Value and rate.
    pub(super) fn at(&self, vector: &[f64]) -> [f64; 2] {
        [value(&self.row, vector), value(&self.rate, vector)]
    }
}

/// A state of contact and circuit as a linear system.
pub(super) struct Regime {
    pub(super) propagator: Propagator,
    /// Contact force in N, and its rate.
    pub(super) force: Row,
    pub(super) force_rate: Row,
    /// Curvature at the clamp in 1/m, and its rate.
    pub(super) clamp: Row,
    pub(super) clamp_rate: Row,
    /// Rate of the voltage in V/s.
    pub(super) voltage_rate: Row,
    /// Rate of the storage voltage in V/s, and its rate.
    pub(super) storage_rate: Row,
    pub(super) storage_curvature: Row,
    /// Current through the diodes in A.
    pub(super) into_storage: Row,
    /// The guards that end the regime; the contact first.
    pub(super) guards: Vec<Guard>,
}

/// The symmetric form of the product of two linear quantities.
fn product(one: &[f64], other: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(one.len(), one.len(), |row, column| {
        0.5 * (one[row] * other[column] + one[column] * other[row])
    })
}

fn scaled(weight: f64, row: &[f64]) -> Row {
    row.iter().map(|entry| weight * entry).collect()
}

impl Regime {
    /// The regime of this contact force and circuit; the row `release` ends the state of contact.
    pub(super) fn new(system: &System, force: Row, release: Row, circuit: Circuit, step: f64) -> Self {
        let size = system.layout.size();
        let currents = system.currents(circuit);
        let mut matrix = system.matrix(circuit, &currents);
        for (column, weight) in force.iter().enumerate() {
            for (row, push) in system.push.iter().enumerate() {
                matrix[(row, column)] += push * weight;
            }
        }
        let mut one = vec![0.0; size];
        one[system.layout.one()] = 1.0;
        let drop = system.storage.map_or(0.0, |storage| storage.drop);
        let mut forms: [DMatrix<f64>; FORMS] = std::array::from_fn(|_| DMatrix::zeros(size, size));
        forms[integral::VOLTAGE_SQUARED] = product(&system.voltage, &system.voltage);
        forms[integral::VOLTAGE] = product(&system.voltage, &one);
        forms[integral::BASE_WORK] = product(&system.base, &system.base_lever);
        forms[integral::DAMPING] = DMatrix::from_diagonal(&system.damping.clone().into());
        forms[integral::FORCE] = product(&force, &one);
        forms[integral::COUPLING] = product(&system.voltage, &system.current);
        forms[integral::INTO_LOAD] = match system.storage {
            None => product(&system.voltage, &scaled(system.conductance, &system.voltage)),
            Some(_) => product(&system.storage_voltage, &currents.into_storage),
        };
        forms[integral::DIODES] = product(&scaled(drop, &one), &currents.into_storage);
        forms[integral::LEAKED] = product(&system.storage_voltage, &currents.leaked);
        forms[integral::DRAWN] = product(&system.storage_voltage, &currents.drawn);
        let storage_rate = System::rate(&system.storage_voltage, &matrix);
        let [by_force, ..] = system.modes.clamp_residual;
        let clamp: Row = system.clamp.iter().zip(&force).map(|(free, push)| free - by_force * push).collect();
        Self {
            propagator: Propagator::new(&matrix, step, &forms),
            clamp_rate: System::rate(&clamp, &matrix),
            clamp,
            force_rate: System::rate(&force, &matrix),
            force,
            voltage_rate: System::rate(&system.voltage, &matrix),
            storage_curvature: System::rate(&storage_rate, &matrix),
            storage_rate,
            guards: guards(system, release, circuit, &currents, &matrix),
            into_storage: currents.into_storage,
        }
    }

    /// The first tick within `ticks` at which a guard is above zero after a rise, given the vectors at both ends.
    ///
    /// A grid step is a tenth of the shortest period, so the guard turns at most once in it.
    pub(super) fn first_rise(&self, guard: &Guard, start: &[f64], end: &[f64], ticks: u64) -> Option<u64> {
        let ([before, rate_before], [after, rate_after]) = (guard.at(start), guard.at(end));
        let risen = |vector: &[f64]| guard.at(vector)[0] > 0.0;
        match (rate_before > 0.0, rate_after > 0.0) {
            // The guard falls.
            (false, false) => None,
            // The guard rises from zero: the first tick.
            (true, true) if after > 0.0 && before >= 0.0 => Some(1),
            (true, _) if after > 0.0 => Some(self.propagator.first_past(start, ticks, risen)),
            (true, true) => None,
            // A maximum: the rise before it, if it is above zero; the tangents at both ends bound it.
            (true, false) => {
                let step = ticks as f64 * self.propagator.tick();
                if (before + rate_before * step).max(after - rate_after * step) <= 0.0 {
                    return None;
                }
                let top = self.propagator.first_past(start, ticks, |vector| guard.at(vector)[1] <= 0.0);
                let mut vector = Vec::new();
                self.propagator.advance(start, top, &mut vector);
                risen(&vector).then(|| self.propagator.first_past(start, top, risen))
            }
            // A minimum: the rise after it.
            (false, true) if after > 0.0 => {
                if before < 0.0 {
                    return Some(self.propagator.first_past(start, ticks, risen));
                }
                let bottom = self.propagator.first_past(start, ticks, |vector| guard.at(vector)[1] > 0.0);
                let mut vector = Vec::new();
                self.propagator.advance(start, bottom, &mut vector);
                let rest = ticks - bottom;
                if rest == 0 || risen(&vector) {
                    return Some(bottom);
                }
                Some(bottom + self.propagator.first_past(&vector, rest, risen))
            }
            (false, true) => None,
        }
    }
}

/// The guards of a regime: the contact, and behind a bridge the diodes and the lock-out of the draw.
fn guards(
    system: &System,
    release: Row,
    circuit: Circuit,
    currents: &Currents,
    matrix: &DMatrix<f64>,
) -> Vec<Guard> {
    let mut guards = vec![Guard::new(Change::Contact, release, matrix)];
    let Some(storage) = &system.storage else { return guards };
    if circuit.sign == 0 {
        for sign in [1, -1] {
            let pairs = system.voltage.iter().zip(&system.storage_voltage);
            let mut row: Row = pairs.map(|(v, storage)| f64::from(sign) * v - storage).collect();
            row[system.layout.one()] -= storage.drop;
            guards.push(Guard::new(Change::Conducts { sign }, row, matrix));
        }
    } else {
        guards.push(Guard::new(Change::Blocks, scaled(-1.0, &currents.into_storage), matrix));
    }
    if let Some(lockout) = storage.lockout() {
        let (sign, threshold) =
            if circuit.connected { (-1.0, lockout.turn_off_v) } else { (1.0, lockout.turn_on_v) };
        let mut row = scaled(sign, &system.storage_voltage);
        row[system.layout.one()] -= sign * threshold;
        guards.push(Guard::new(Change::Draw { connected: !circuit.connected }, row, matrix));
    }
    guards
}

// The circuit in each of its regimes: a resistor, or a full bridge that blocks or conducts.
//
// `i = Σ θ r'` is the current of the beam, `C` the capacitance of the piezoelectric layer, `C_s` that of the
// storage, and `i_out` the current that leaks and is drawn from the storage:
//
// ```text
// resistor     C v' = i − v/R
// blocked      C v' = i,                         C_s V_s' = −i_out      while |v| < V_s + 2 V_D
// conducting   v = s (V_s + 2 V_D), so with C v' = i − s i_D and C_s V_s' = i_D − i_out
//              (C + C_s) V_s' = s i − i_out,     v' = s V_s'
//              i_D = (C_s s i + C i_out) / (C + C_s)                    while i_D > 0
// ```
//
// The voltages are continuous. The current of a constant power is not linear in the vector. It is a straight
// line in time, tangent to `P/V_s` and set again so often that the error is below rounding.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Circuit {
    /// Sign of the voltage of the harvester while the bridge conducts; 0 while it blocks, or if there is none.
    pub(super) sign: i8,
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
