//! The open terminals, for an external circuit.

use super::flow::Flow;
use super::mode::Mode;
use super::{Parts, STATES, Sliding, Sticking, VELOCITY};
use crate::part::load::Load;
use crate::scalar::Scalar;
use crate::scene::electrical_port::{ElectricalPort, PortVoltage, port_items};

impl<S: Scalar, P: Parts<S>> ElectricalPort<S> for Sliding<S, P> {
    port_items!();

    fn typical_voltage(&self) -> S {
        self.field * self.surface.tribo_charge
    }

    /// `V = (σ S2 − q) d / (ε0 ε_r S1)`.
    #[inline]
    fn port_voltage(&self, mode: Mode, displacement: S, charge: S) -> PortVoltage<S> {
        let ahead = mode.is_ahead(displacement);
        let circuit = self.circuit(ahead, displacement, charge);
        let slope = self.active_by_displacement(ahead, displacement);
        // With s2 = 1 − s1 the voltage is field ((t − q)/s1 − t), so the derivative of its first part is that part
        // times −s1'/s1.
        let per_active = self.field * circuit.per_active;
        let growth = -slope * circuit.per_active;
        let first = per_active * (self.surface.tribo_charge - charge);
        let bend = self.active_curvature(ahead, displacement) * circuit.per_active;
        PortVoltage {
            value: self.field * circuit.voltage,
            by_position: first * growth,
            by_charge: -per_active,
            curvature: first * (S::from_f64(2.0) * growth * growth - bend),
            by_both: -per_active * growth,
            magnitude: per_active * self.surface.tribo_charge.max(charge.abs()),
        }
    }

    #[inline]
    fn charge_is_frozen(&self, mode: Mode) -> bool {
        Self::STICKS && matches!(mode, Mode::Stick) && !self.sticking.relaxes()
    }

    #[inline]
    fn is_clear(&self, mode: Mode, state: &[S; STATES]) -> bool {
        matches!(mode, Mode::Stick) || state[VELOCITY].abs() > self.velocity_margin
    }
}
