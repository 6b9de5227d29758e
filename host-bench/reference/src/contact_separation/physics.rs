//! Charges, forces and energies of the contact-separation harvester.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (19) to (28), written in the gap `g`, its rate `v` (opening positive) and the
//! load voltage `V` instead of the transferred charge `q`. With `c = ε0 S` and `d_e = d / ε_r`, equations (12), (24) and (25) give
//!
//! ```text
//! q = (σS g − c V) / (g + d_e)          σS − q = (σS d_e + c V) / (g + d_e)
//! ```
//!
//! and, with the time derivative of the first and `q' = V/R + C_p V'` of (23),
//!
//! ```text
//! V' = [ (σS − q) v − (g + d_e) V / R ] / [ c + C_p (g + d_e) ]
//! ```
//!
//! These forms do not cancel at small `R`, where `V = V_oc − q/C` is a difference of large numbers. At its terminals the harvester is a
//! capacitance `C = c / (g + d_e) + C_p` and a current `j = (σS − q) v / (g + d_e)`.

use crate::triboelectric::{CircuitKind, Harvester, LoadCircuit, Motion, VACUUM_PERMITTIVITY};
use harvester_scene::scene_file::{
    ContactSeparationParameters, ForceLaw, Load, Restitution, TriboelectricStart,
};

/// Constants of the equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Physics {
    pub(super) mass: f64,
    pub(super) stiffness: f64,
    /// `ω = √(k/m)` in rad/s.
    pub(super) angular_frequency: f64,
    /// `c = 2 ζ √(k m)` in N s/m, equation (19).
    pub(super) damping: f64,
    pub(super) initial_gap: f64,
    /// `ε0 S` in F m.
    pub(super) permittivity_area: f64,
    /// `σ S` in C.
    pub(super) tribo_charge: f64,
    /// Effective thickness `d / ε_r` of the dielectric in m; the gap stays above minus this.
    pub(super) dielectric: f64,
    /// Capacitance in F at closed gap, `c / d_e + C_p`.
    pub(super) closed_capacitance: f64,
    /// Parasitic capacitance in F.
    pub(super) parasitic: f64,
    pub(super) load: LoadCircuit,
    /// Charges `σS − Q` and `Q` in C of an open circuit, of which the total charge `Q = q − C_p V` is constant.
    open_charges: [f64; 2],
    pub(super) force_law: ForceLaw,
    restitution: Restitution,
    /// Speed in m/s below which a rebound ends in stick: `10⁻⁴ ω0 d0`, part of the model.
    pub(super) stick_speed: f64,
}

impl Physics {
    /// The equations for the given parameters, and the motion at time zero.
    pub(crate) fn new(
        parameters: &ContactSeparationParameters,
        load: Load,
        start: &TriboelectricStart,
    ) -> (Self, Motion) {
        let p = parameters;
        let angular_frequency = (p.stiffness_n_per_m / p.mass_kg).sqrt();
        let permittivity_area = VACUUM_PERMITTIVITY * p.electrode_area_m2;
        let dielectric = p.dielectric_thickness_m / p.relative_permittivity;
        let closed_capacitance = permittivity_area / dielectric + p.parasitic_capacitance_f;
        let mut physics = Self {
            mass: p.mass_kg,
            stiffness: p.stiffness_n_per_m,
            angular_frequency,
            damping: 2.0 * p.damping_ratio * (p.stiffness_n_per_m * p.mass_kg).sqrt(),
            initial_gap: p.initial_gap_m,
            permittivity_area,
            tribo_charge: p.charge_density_c_per_m2 * p.electrode_area_m2,
            dielectric,
            closed_capacitance,
            parasitic: p.parasitic_capacitance_f,
            load: LoadCircuit::new(load, p.stick_charge, closed_capacitance, start.charge_c),
            open_charges: [0.0; 2],
            force_law: p.force_law,
            restitution: p.restitution,
            stick_speed: 1e-4 * angular_frequency * p.initial_gap_m,
        };
        let gap = start.position_m.unwrap_or(p.initial_gap_m);
        // V_oc − q / C, equations (12), (24) and (25).
        let voltage = start.charge_c.map_or(0.0, |charge| {
            ((physics.tribo_charge - charge) * gap - charge * dielectric) / permittivity_area
        });
        physics.open_charges = [
            physics.top_charge(gap, voltage) + physics.parasitic * voltage,
            physics.charge_at_voltage(gap, voltage) - physics.parasitic * voltage,
        ];
        let voltage = if physics.load.kind == CircuitKind::Dynamic { voltage } else { 0.0 };
        let bridge = physics.load.bridge();
        let mut motion = Motion { position: gap, voltage, bridge, ..Motion::default() };
        let scale = physics.voltage_scale(&motion);
        if let Some(storage) = &mut physics.load.storage {
            storage.scale = scale;
        }
        motion.velocity = start.velocity_m_per_s.unwrap_or(0.0);
        (physics, motion)
    }

    /// Charge `σS − q` of the moving electrode, in C.
    pub(super) fn top_charge(&self, gap: f64, voltage: f64) -> f64 {
        (self.tribo_charge * self.dielectric + self.permittivity_area * voltage) / (gap + self.dielectric)
    }

    /// Derivative of [`Self::top_charge`] in the direction of `change`.
    pub(super) fn top_charge_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let voltage_change = self.electrostatic_voltage_along(motion, change);
        let top = self.top_charge(motion.position, self.electrostatic_voltage(motion));
        (self.permittivity_area * voltage_change - top * change.position)
            / (motion.position + self.dielectric)
    }

    /// Transferred charge `q` in C.
    pub(super) fn charge_at_voltage(&self, gap: f64, voltage: f64) -> f64 {
        (self.tribo_charge * gap - self.permittivity_area * voltage) / (gap + self.dielectric)
    }

    /// `c + C_p (g + d_e)` in F m.
    pub(super) fn total_capacitance_length(&self, gap: f64) -> f64 {
        self.permittivity_area + self.parasitic * (gap + self.dielectric)
    }

    /// The voltage in V that sets the charges: the load voltage, except where that is lost in rounding.
    pub(super) fn electrostatic_voltage(&self, motion: &Motion) -> f64 {
        self.load.kind.voltage(motion.voltage, || {
            let [top_charge, total_charge] = self.open_charges;
            (top_charge * motion.position - total_charge * self.dielectric)
                / self.total_capacitance_length(motion.position)
        })
    }

    /// Derivative of [`Self::electrostatic_voltage`] in the direction of `change`.
    pub(super) fn electrostatic_voltage_along(&self, motion: &Motion, change: &Motion) -> f64 {
        self.load.kind.voltage(change.voltage, || {
            let [top_charge, _] = self.open_charges;
            (top_charge - self.electrostatic_voltage(motion) * self.parasitic)
                / self.total_capacitance_length(motion.position)
                * change.position
        })
    }

    /// Electrostatic force on the mass in N, attractive positive: equation (28), or the field in the gap.
    pub(super) fn force(&self, motion: &Motion) -> f64 {
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let charge = self.charge_at_voltage(motion.position, self.electrostatic_voltage(motion));
                let total = self.total_capacitance_length(motion.position);
                let shared = charge * self.permittivity_area / total;
                shared * shared / (2.0 * self.permittivity_area)
            }
            ForceLaw::GapField => self.field_force(motion),
            ForceLaw::None => 0.0,
        }
    }

    /// Derivative of [`Self::force`] in the direction of `change`.
    pub(super) fn force_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let (c, gap) = (self.permittivity_area, motion.position);
        let voltage = self.electrostatic_voltage(motion);
        let top_change = self.top_charge_along(motion, change);
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let total = self.total_capacitance_length(gap);
                let shared = self.charge_at_voltage(gap, voltage) * c / total;
                let shared_change = (-top_change * c - shared * self.parasitic * change.position) / total;
                shared * shared_change / c
            }
            ForceLaw::GapField => self.top_charge(gap, voltage) * top_change / c,
            ForceLaw::None => 0.0,
        }
    }

    /// `(σS − q)² / (2 ε0 S)` in N, attractive positive: the force that conserves energy.
    pub(super) fn field_force(&self, motion: &Motion) -> f64 {
        let top = self.top_charge(motion.position, self.electrostatic_voltage(motion));
        top * top / (2.0 * self.permittivity_area)
    }

    /// Energy of mass and spring in J.
    pub(super) fn mechanical_energy(&self, motion: &Motion) -> f64 {
        let stretch = motion.position - self.initial_gap;
        0.5 * (self.mass * motion.velocity * motion.velocity + self.stiffness * stretch * stretch)
    }

    /// Energy of the fields in gap, dielectric and parasitic capacitance, in J.
    pub(super) fn electrical_energy(&self, motion: &Motion) -> f64 {
        let voltage = self.electrostatic_voltage(motion);
        let top = self.top_charge(motion.position, voltage);
        let bottom = self.charge_at_voltage(motion.position, voltage);
        (top * top * motion.position + bottom * bottom * self.dielectric) / (2.0 * self.permittivity_area)
            + 0.5 * self.parasitic * voltage * voltage
    }

    /// Coefficient of restitution at an impact speed in m/s, equation (21).
    pub(super) fn restitution(&self, speed: f64) -> f64 {
        match self.restitution {
            Restitution::Constant { coefficient } => coefficient,
            Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
                at_speed + (at_rest - at_speed) * (-speed.abs() / reference_speed_m_per_s).exp()
            }
        }
    }

    /// Size in V of the load voltage, for tolerances; never zero.
    pub(super) fn voltage_scale(&self, start: &Motion) -> f64 {
        // The charge that an opening from the relaxed state by the initial gap moves.
        let charge = self.tribo_charge * self.dielectric / (self.initial_gap + self.dielectric);
        let capacitance = self.permittivity_area / self.initial_gap + self.parasitic;
        // An open circuit shows charge over capacitance, a loaded one at most R times the current.
        let driven = (charge / capacitance).min(self.load.resistance * self.angular_frequency * charge);
        let driven = self.load.storage.map_or(driven, |storage| storage.voltage_scale(driven, charge));
        driven.max(self.voltage(start).abs()).max(1e-60)
    }
}

#[cfg(test)]
mod tests;
