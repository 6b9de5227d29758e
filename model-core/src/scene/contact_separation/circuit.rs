//! Charge and voltage at a gap: the parallel-plate capacitor with its parasitic capacitance.

use super::{ContactSeparation, Parts};
use crate::part::parasitic::Parasitic;
use crate::scalar::Scalar;

/// The electrical quantities at a gap and a total charge; charges in units of `√(2 ε0 S m)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Circuit<S> {
    /// Transferred charge `q = Q + C_p V`.
    pub transferred: S,
    /// Derivative of the transferred charge by the gap.
    pub transferred_by_gap: S,
    /// Derivative of the transferred charge by the total charge.
    pub transferred_by_charge: S,
    /// `1 / (1 + C_p/C)`: part of a charge on the harvester's own capacitance.
    pub sharing: S,
    /// `C_p / (ε0 S)` in 1/m.
    pub parasitic: S,
    /// Voltage in units of one charge unit over `ε0 S`, in m times charge units.
    pub voltage: S,
    /// Derivative of the voltage by the gap.
    pub voltage_by_gap: S,
    /// Derivative of the voltage by the total charge.
    pub voltage_by_charge: S,
}

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// The electrical quantities at a gap and a charge; in a short circuit the charge follows the gap.
    #[inline]
    pub(super) fn circuit(&self, gap: S, charge: S) -> Circuit<S> {
        let distance = gap + self.dielectric;
        let present = <P::Parasitic as Parasitic<S>>::PRESENT;
        let parasitic = if present { self.parasitic } else { S::ZERO };
        let sharing = if present { S::ONE / (S::ONE + parasitic * distance) } else { S::ONE };
        if self.is_shorted() {
            let relaxed = self.relaxed_charge(gap);
            let by_gap = (self.tribo_charge - relaxed) / distance.max(S::from_f64(0.5) * self.dielectric);
            return Circuit {
                transferred: relaxed,
                transferred_by_gap: by_gap,
                transferred_by_charge: S::ZERO,
                sharing,
                parasitic,
                voltage: S::ZERO,
                voltage_by_gap: S::ZERO,
                voltage_by_charge: S::ZERO,
            };
        }
        let voltage = (self.tribo_charge * gap - charge * distance) * sharing;
        let transferred =
            if present { (charge + parasitic * self.tribo_charge * gap) * sharing } else { charge };
        let voltage_by_gap = (self.tribo_charge - transferred) * sharing;
        Circuit {
            transferred,
            transferred_by_gap: parasitic * voltage_by_gap,
            transferred_by_charge: sharing,
            sharing,
            parasitic,
            voltage,
            voltage_by_gap,
            voltage_by_charge: -distance * sharing,
        }
    }
}
