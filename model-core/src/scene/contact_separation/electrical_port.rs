//! The open terminals, for an external circuit.

use super::flow::Flow;
use super::mode::Mode;
use super::{ContactSeparation, GAP, Parts, STATES, Sticking};
use crate::part::load::Load;
use crate::scalar::Scalar;
use crate::scene::electrical_port::{ElectricalPort, PortVoltage, port_items};

impl<S: Scalar, P: Parts<S>> ElectricalPort<S> for ContactSeparation<S, P> {
    port_items!();

    fn typical_voltage(&self) -> S {
        self.field * self.tribo_charge * self.initial_gap
    }

    /// `V = (σ S g − Q (g + d_e)) / (ε0 S + C_p (g + d_e))`.
    #[inline]
    fn port_voltage(&self, _mode: Mode, gap: S, charge: S) -> PortVoltage<S> {
        let circuit = self.circuit(gap, charge);
        let sharing = self.field * circuit.sharing;
        let by_gap = self.field * circuit.voltage_by_gap;
        // ∂V/∂g = field (σ S (1 + c d_e) − Q) s², with s = 1/(1 + c (g + d_e)).
        PortVoltage {
            value: self.field * circuit.voltage,
            by_position: by_gap,
            by_charge: self.field * circuit.voltage_by_charge,
            curvature: -S::from_f64(2.0) * circuit.parasitic * circuit.sharing * by_gap,
            by_both: -sharing * circuit.sharing,
            magnitude: sharing * self.tribo_charge.max(charge.abs()) * (gap + self.dielectric),
        }
    }

    #[inline]
    fn charge_is_frozen(&self, mode: Mode) -> bool {
        P::Sticking::POSSIBLE && mode == Mode::Stick && !self.sticking.relaxes()
    }

    #[inline]
    fn is_clear(&self, mode: Mode, state: &[S; STATES]) -> bool {
        mode == Mode::Stick || state[GAP] > self.release_margin()
    }
}
