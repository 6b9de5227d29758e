//! One state of contact: its exact propagation, and the guard that ends it.

use nalgebra::DMatrix;

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
}

/// A state of contact as a linear system.
#[derive(Debug)]
pub(super) struct Regime {
    pub(super) propagator: Propagator,
    /// Contact force in N, and its rate.
    pub(super) force: Row,
    pub(super) force_rate: Row,
    /// The state ends when this rises above zero.
    guard: Row,
    guard_rate: Row,
}

/// Half the product of two linear quantities and its mirror image: a symmetric form.
fn product(one: &[f64], other: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(one.len(), one.len(), |row, column| {
        0.5 * (one[row] * other[column] + one[column] * other[row])
    })
}

impl Regime {
    /// With this contact force; `guard` is the row that ends it.
    pub(super) fn new(system: &System, force: Row, guard: Row, step: f64) -> Self {
        let size = system.layout.size();
        let matrix = DMatrix::from_fn(size, size, |row, column| {
            system.free[(row, column)] + system.push[row] * force[column]
        });
        let mut one = vec![0.0; size];
        one[system.layout.one()] = 1.0;
        let mut forms: [DMatrix<f64>; FORMS] = std::array::from_fn(|_| DMatrix::zeros(size, size));
        forms[form::VOLTAGE_SQUARED] = product(&system.voltage, &system.voltage);
        forms[form::VOLTAGE] = product(&system.voltage, &one);
        forms[form::BASE_WORK] = product(&system.base, &system.base_lever);
        forms[form::DAMPING] = DMatrix::from_diagonal(&system.damping.clone().into());
        forms[form::FORCE] = product(&force, &one);
        forms[form::COUPLING] = product(&system.voltage, &system.current);
        let guard_rate = System::rate(&guard, &matrix);
        let force_rate = System::rate(&force, &matrix);
        Self { propagator: Propagator::new(&matrix, step, &forms), force, force_rate, guard, guard_rate }
    }

    /// Guard and its rate.
    pub(super) fn guard(&self, vector: &[f64]) -> [f64; 2] {
        [value(&self.guard, vector), value(&self.guard_rate, vector)]
    }

    /// The first tick within `ticks` at which the guard has risen above zero, given the vectors at both
    /// ends.
    ///
    /// A grid step is a tenth of the shortest period, so the guard has at most one turn in it.
    pub(super) fn first_rise(&self, start: &[f64], end: &[f64], ticks: u64) -> Option<u64> {
        let ([before, rate_before], [after, rate_after]) = (self.guard(start), self.guard(end));
        let risen = |vector: &[f64]| self.guard(vector)[0] > 0.0;
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
                let top = self.propagator.first_past(start, ticks, |vector| self.guard(vector)[1] <= 0.0);
                let mut vector = Vec::new();
                self.propagator.advance(start, top, &mut vector);
                risen(&vector).then(|| self.propagator.first_past(start, top, risen))
            }
            // A valley: the crossing up behind its bottom.
            (false, true) if after > 0.0 => {
                if before < 0.0 {
                    return Some(self.propagator.first_past(start, ticks, risen));
                }
                let bottom = self.propagator.first_past(start, ticks, |vector| self.guard(vector)[1] > 0.0);
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
