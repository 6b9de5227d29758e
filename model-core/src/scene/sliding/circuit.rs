//! The circuit and the forces at a displacement and a charge.

use super::force_law::ForceLaw;
use super::force_law::LateralForce;
use super::state::Mode;
use super::{CHARGE, Friction, Parts, STATES, Sliding, Sticking};
use crate::part::disc_overlap::DiscOverlap;
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;

/// The electrical quantities at a displacement and a charge: charges in charge units, voltages relative to the
/// voltage of one charge unit at full overlap.
pub(super) struct Circuit<S> {
    pub(super) overlap: DiscOverlap<S>,
    /// `1/s1`.
    pub(super) per_active: S,
    /// Transferred charge: the state, or in a short circuit a function of the displacement.
    pub(super) transferred: S,
    pub(super) voltage: S,
}

/// Fourth power of the longest `ξ` of Simpson's rule, in roundings: its error is then below a rounding of the slope.
const SHORT: f64 = 64.0;
/// Largest `ξ` of Simpson's rule: the slope of the overlap has a branch point at 1.
const CURVED: f64 = 0.8;

/// Derivatives of the circuit by the displacement.
pub(super) struct Slope<S> {
    /// `ds1/dx` in 1/m.
    pub(super) active: S,
    /// `∂V/∂x` at constant charge.
    pub(super) voltage: S,
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// `1/2r` on the side `ahead`, `−1/2r` on the other. The sign is exact in every product, and the compiler finds it once a step.
    #[inline]
    pub(super) fn per_diameter(&self, ahead: bool) -> S {
        if ahead { self.per_diameter } else { -self.per_diameter }
    }

    /// `ξ = x/2r` on the side `ahead`, `−ξ` on the other.
    #[inline]
    pub(super) fn xi(&self, ahead: bool, displacement: S) -> S {
        self.per_diameter(ahead) * displacement
    }

    /// Parts of the slider's face on the patches, by the formula of the side `ahead`.
    #[inline]
    pub(super) fn overlap(&self, ahead: bool, displacement: S) -> DiscOverlap<S> {
        DiscOverlap::at(self.xi(ahead, displacement))
    }

    #[inline(always)]
    pub(super) fn circuit(&self, ahead: bool, displacement: S, charge: S) -> Circuit<S> {
        self.circuit_of(self.overlap(ahead, displacement), charge)
    }

    /// The circuit for a known overlap.
    #[inline]
    pub(super) fn circuit_of(&self, overlap: DiscOverlap<S>, charge: S) -> Circuit<S> {
        let per_active = S::ONE / overlap.active;
        let relaxed = self.surface.tribo_charge * overlap.inert;
        if self.is_shorted() {
            return Circuit { overlap, per_active, transferred: relaxed, voltage: S::ZERO };
        }
        Circuit { overlap, per_active, transferred: charge, voltage: (relaxed - charge) * per_active }
    }

    /// `ds1/dx` in 1/m, by the formula of the side `ahead`.
    #[inline]
    pub(super) fn active_by_displacement(&self, ahead: bool, displacement: S) -> S {
        self.per_diameter(ahead) * DiscOverlap::active_by_xi(self.xi(ahead, displacement))
    }

    /// The change of `s2` over a short displacement, by Simpson's rule for its slope; `None` if the displacement is long.
    ///
    /// A difference of overlaps would have the rounding of an overlap.
    #[inline]
    pub(super) fn short_rise(&self, ahead: bool, from: S, displacement: S) -> Option<S> {
        let middle = self.xi(ahead, from + S::from_f64(0.5) * displacement);
        let length = self.xi(ahead, displacement);
        let square = length * length;
        if !(square * square <= S::EPSILON * S::from_f64(SHORT) && middle.abs() <= S::from_f64(CURVED)) {
            return None;
        }
        let ends = [from, from + displacement].map(|at| DiscOverlap::active_by_xi(self.xi(ahead, at)));
        let slope = ends[0] + ends[1] + S::from_f64(4.0) * DiscOverlap::active_by_xi(middle);
        Some(-length * slope * S::from_f64(1.0 / 6.0))
    }

    /// `d²s1/dx²` in 1/m², by the formula of the side `ahead`.
    #[inline]
    pub(super) fn active_curvature(&self, ahead: bool, displacement: S) -> S {
        // d²s1/dξ² = (16/π²) ξ / −(ds1/dξ), with a pole at |ξ| = 1.
        let xi = self.xi(ahead, displacement);
        let by_xi = DiscOverlap::active_by_xi(xi).abs().max(S::from_f64(1e-3));
        S::from_f64(16.0 / (core::f64::consts::PI * core::f64::consts::PI)) * xi / by_xi
            * self.per_diameter
            * self.per_diameter
    }

    #[inline]
    pub(super) fn slope(&self, ahead: bool, displacement: S, circuit: &Circuit<S>) -> Slope<S> {
        let active = self.active_by_displacement(ahead, displacement);
        // V = (t s2 − q)/s1, and t s2 − q + t s1 = t − q.
        let opposite = self.surface.tribo_charge - circuit.transferred;
        let voltage = -active * opposite * circuit.per_active * circuit.per_active;
        Slope { active, voltage: if self.is_shorted() { S::ZERO } else { voltage } }
    }

    /// The rate of a charge that follows the displacement, `dq/dt = −t (ds1/dx) v`.
    #[inline]
    pub(super) fn following_current(&self, ahead: bool, displacement: S, velocity: S) -> S {
        -self.surface.tribo_charge * self.active_by_displacement(ahead, displacement) * velocity
    }

    /// Rate in 1/s at which the charge relaxes at a displacement; 0 without a resistor.
    #[inline]
    pub(super) fn relaxation(&self, circuit: &Circuit<S>) -> S {
        self.circuit_rate * circuit.per_active
    }

    /// Normal force per modal mass `(m g + F_e)/M` in m/s²: coefficients of 1, `Δq` and `Δq²`.
    #[inline]
    pub(super) fn normal(&self, circuit: &Circuit<S>) -> [S; 3] {
        let [acting, by_charge] = self.force_law.acting_charge(circuit.transferred, &self.surface);
        let per_charge = acting * circuit.per_active;
        let constant = self.weight_per_mass + acting * per_charge;
        if self.is_shorted() {
            return [constant, S::ZERO, S::ZERO];
        }
        [constant, (per_charge + per_charge) * by_charge, by_charge * by_charge * circuit.per_active]
    }

    /// Derivative of the normal force per modal mass by the displacement.
    #[inline]
    pub(super) fn normal_by_displacement(&self, circuit: &Circuit<S>, slope: &Slope<S>) -> S {
        let [acting, by_charge] = self.force_law.acting_charge(circuit.transferred, &self.surface);
        let per_charge = acting * circuit.per_active;
        let at_charge = -per_charge * per_charge * slope.active;
        // In a short circuit the charge follows: dq/dx = −t ds1/dx.
        let along = -self.surface.tribo_charge * slope.active * (per_charge + per_charge) * by_charge;
        if self.is_shorted() { at_charge + along } else { at_charge }
    }

    /// The limit of static friction per modal mass in m/s², and its derivative by the charge.
    #[inline]
    pub(super) fn static_friction(&self, circuit: &Circuit<S>) -> [S; 2] {
        let coefficient = self.friction.static_coefficient(circuit.overlap.active);
        let [normal, by_charge, _] = self.normal(circuit);
        [coefficient * normal, coefficient * by_charge]
    }

    /// Lateral force of the field per modal mass, `d (ds1/dx) V (V + 2t)` in these units.
    #[inline]
    pub(super) fn field_force(&self, circuit: &Circuit<S>, active_by_displacement: S) -> S {
        let tribo = self.surface.tribo_charge;
        self.dielectric * active_by_displacement * circuit.voltage * (circuit.voltage + tribo + tribo)
    }

    /// Lateral force on the slider per modal mass, and its derivative by the charge.
    #[inline]
    pub(super) fn lateral(&self, ahead: bool, displacement: S, circuit: &Circuit<S>) -> [S; 2] {
        if !self.lateral_force.acts() {
            return [S::ZERO; 2];
        }
        let slope = self.active_by_displacement(ahead, displacement);
        let twice = S::from_f64(2.0) * (circuit.voltage + self.surface.tribo_charge);
        let by_charge = -self.dielectric * slope * twice * circuit.per_active;
        [self.field_force(circuit, slope), by_charge]
    }

    /// Derivative of the lateral force per modal mass by the displacement.
    #[inline]
    pub(super) fn lateral_by_displacement(
        &self,
        ahead: bool,
        displacement: S,
        circuit: &Circuit<S>,
        slope: &Slope<S>,
    ) -> S {
        if !self.lateral_force.acts() {
            return S::ZERO;
        }
        let curvature = self.active_curvature(ahead, displacement);
        let tribo = self.surface.tribo_charge;
        let voltage = circuit.voltage;
        self.dielectric
            * (curvature * voltage * (voltage + tribo + tribo)
                + S::from_f64(2.0) * slope.active * slope.voltage * (voltage + tribo))
    }

    /// Terminal voltage in V and load current in A.
    ///
    /// With a resistor both come from the rate of the charge, because the voltage as a difference is a small part of
    /// `V_oc` at a small resistance.
    #[inline(always)]
    pub(super) fn voltage_and_current(&self, mode: Mode, state: &[S; STATES], rate: &[S; STATES]) -> (S, S) {
        if Self::STICKS && matches!(mode, Mode::Stick) && !self.sticking.relaxes() {
            return (S::ZERO, S::ZERO);
        }
        let [displacement, velocity, charge] = *state;
        let ahead = mode.is_ahead(displacement);
        match self.load.resistance() {
            Resistance::Finite(resistance) => {
                let current = self.charge_unit * rate[CHARGE];
                (resistance * current, current)
            }
            Resistance::Short => {
                (S::ZERO, self.charge_unit * self.following_current(ahead, displacement, velocity))
            }
            // Behind a bridge the charge of an open harvester moves.
            Resistance::Open => {
                let voltage = self.field * self.circuit(ahead, displacement, charge).voltage;
                (voltage, self.charge_unit * rate[CHARGE])
            }
        }
    }

    /// Mechanical and electrical energy in J.
    #[inline(always)]
    pub(super) fn energies(&self, mode: Mode, [displacement, velocity, charge]: [S; STATES]) -> [S; 2] {
        let circuit = self.circuit(mode.is_ahead(displacement), displacement, charge);
        let elastic = self.stiffness_per_mass * displacement * displacement;
        let mechanical = S::from_f64(0.5) * self.modal_mass * (velocity * velocity + elastic);
        // (q − σS2)² d / (2 ε0 ε_r S1) is M d V² s1 in these units.
        let electrical =
            self.modal_mass * self.dielectric * circuit.voltage * circuit.voltage * circuit.overlap.active;
        [mechanical, electrical]
    }
}
