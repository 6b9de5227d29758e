//! One state of contact and circuit: its exact propagation, and the guards that end it.

use nalgebra::DMatrix;

use super::circuit::{Bridge, Circuit, Currents};
use super::propagator::{FORMS, Propagator};
use super::system::{Row, System, value};

/// Places of the integrals among the quadratic forms.
pub(super) mod form {
    /// `∫ v² dt` in V² s.
    pub(in super::super) const VOLTAGE_SQUARED: usize = 0;
    /// `∫ v dt` in V s.
    pub(in super::super) const VOLTAGE: usize = 1;
    /// Work of the base in J.
    pub(in super::super) const BASE_WORK: usize = 2;
    /// Loss in the damping of beam and rod in J.
    pub(in super::super) const DAMPING: usize = 3;
    /// `∫ F dt` in N s.
    pub(in super::super) const FORCE: usize = 4;
    /// `∫ v Σ θ r' dt` in J: what the beam gives to the charge.
    pub(in super::super) const COUPLING: usize = 5;
    /// Energy in J into the resistor, or into the store or bus behind the diodes.
    pub(in super::super) const LOAD: usize = 6;
    /// Loss in the diodes in J.
    pub(in super::super) const DIODES: usize = 7;
    /// Energy in J that leaks from the store.
    pub(in super::super) const LEAKED: usize = 8;
    /// Energy in J that the node draws.
    pub(in super::super) const DRAWN: usize = 9;
}

/// What happens where a guard rises through zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// The contact closes or opens.
    Contact,
    /// The bridge begins to conduct.
    Conducts { negative: bool },
    /// It begins to block.
    Blocks,
    /// The draw is connected or disconnected.
    Draw { connected: bool },
}

/// A linear quantity that is negative while a regime lasts.
#[derive(Debug)]
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
#[derive(Debug)]
pub(super) struct Regime {
    pub(super) propagator: Propagator,
    /// Contact force in N, and its rate.
    pub(super) force: Row,
    pub(super) force_rate: Row,
    /// Rate of the voltage in V/s.
    pub(super) voltage_rate: Row,
    /// Rate of the voltage of the store in V/s, and the rate of that.
    pub(super) store_rate: Row,
    pub(super) store_curvature: Row,
    /// Current through the diodes in A.
    pub(super) into_store: Row,
    /// What ends it; the contact first.
    pub(super) guards: Vec<Guard>,
}

/// Half the product of two linear quantities and its mirror image: a symmetric form.
fn product(one: &[f64], other: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(one.len(), one.len(), |row, column| {
        0.5 * (one[row] * other[column] + one[column] * other[row])
    })
}

/// A row times a number.
fn scaled(weight: f64, row: &[f64]) -> Row {
    row.iter().map(|entry| weight * entry).collect()
}

impl Regime {
    /// With this contact force and circuit; `release` is the row that ends the state of contact.
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
        let drop = system.store.map_or(0.0, |store| store.drop);
        let mut forms: [DMatrix<f64>; FORMS] = std::array::from_fn(|_| DMatrix::zeros(size, size));
        forms[form::VOLTAGE_SQUARED] = product(&system.voltage, &system.voltage);
        forms[form::VOLTAGE] = product(&system.voltage, &one);
        forms[form::BASE_WORK] = product(&system.base, &system.base_lever);
        forms[form::DAMPING] = DMatrix::from_diagonal(&system.damping.clone().into());
        forms[form::FORCE] = product(&force, &one);
        forms[form::COUPLING] = product(&system.voltage, &system.current);
        forms[form::LOAD] = match system.store {
            None => product(&system.voltage, &scaled(system.conductance, &system.voltage)),
            Some(_) => product(&system.store_voltage, &currents.into_store),
        };
        forms[form::DIODES] = product(&scaled(drop, &one), &currents.into_store);
        forms[form::LEAKED] = product(&system.store_voltage, &currents.leaked);
        forms[form::DRAWN] = product(&system.store_voltage, &currents.drawn);
        let store_rate = System::rate(&system.store_voltage, &matrix);
        Self {
            propagator: Propagator::new(&matrix, step, &forms),
            force_rate: System::rate(&force, &matrix),
            force,
            voltage_rate: System::rate(&system.voltage, &matrix),
            store_curvature: System::rate(&store_rate, &matrix),
            store_rate,
            guards: guards(system, release, circuit, &currents, &matrix),
            into_store: currents.into_store,
        }
    }

    /// The first tick within `ticks` at which a guard has risen above zero, given the vectors at both
    /// ends.
    ///
    /// A grid step is a tenth of the shortest period, so the guard has at most one turn in it.
    pub(super) fn first_rise(&self, guard: &Guard, start: &[f64], end: &[f64], ticks: u64) -> Option<u64> {
        let ([before, rate_before], [after, rate_after]) = (guard.at(start), guard.at(end));
        let risen = |vector: &[f64]| guard.at(vector)[0] > 0.0;
        match (rate_before > 0.0, rate_after > 0.0) {
            // Falls all the way.
            (false, false) => None,
            // Rises from zero: at once.
            (true, true) if after > 0.0 && before >= 0.0 => Some(1),
            (true, _) if after > 0.0 => Some(self.propagator.first_past(start, ticks, risen)),
            (true, true) => None,
            // A hill: the crossing up, if its top is above zero; a tangent from each end bounds it.
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
            // A valley: the crossing up behind its bottom.
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

/// What ends a regime: the contact, and behind a bridge its diodes and the lock-out of the draw.
fn guards(
    system: &System,
    release: Row,
    circuit: Circuit,
    currents: &Currents,
    matrix: &DMatrix<f64>,
) -> Vec<Guard> {
    let mut guards = vec![Guard::new(Change::Contact, release, matrix)];
    let Some(store) = &system.store else { return guards };
    if circuit.bridge == Bridge::Blocked {
        for negative in [false, true] {
            let sign = if negative { -1.0 } else { 1.0 };
            let mut row: Row =
                system.voltage.iter().zip(&system.store_voltage).map(|(v, store)| sign * v - store).collect();
            row[system.layout.one()] -= store.drop;
            guards.push(Guard::new(Change::Conducts { negative }, row, matrix));
        }
    } else {
        guards.push(Guard::new(Change::Blocks, scaled(-1.0, &currents.into_store), matrix));
    }
    if let Some(lockout) = store.lockout() {
        let (sign, threshold) =
            if circuit.connected { (-1.0, lockout.turn_off_v) } else { (1.0, lockout.turn_on_v) };
        let mut row = scaled(sign, &system.store_voltage);
        row[system.layout.one()] -= sign * threshold;
        guards.push(Guard::new(Change::Draw { connected: !circuit.connected }, row, matrix));
    }
    guards
}
