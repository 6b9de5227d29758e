//! The equations of motion of the contact-separation harvester, for the reference.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (19) to (28), written in the gap `g`, its
//! rate `v` (opening positive) and the load voltage `V` instead of the transferred charge `q`. With
//! `c = ε0 S` and `d_e = d / ε_r`, equations (12), (24) and (25) give
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
//! Nothing here cancels at small `R`, where `V = V_oc − q/C` is a difference of large numbers. To a bridge the
//! harvester is a capacitance `C = c / (g + d_e) + C_p` and a current `j = (σS − q) v / (g + d_e)`.

mod terminals;

use crate::reference::bridge::{Bridge, Harvester};
use crate::reference::store::Store;
use crate::scene_file::{
    ContactSeparationParameters, ContactSeparationStart, ForceLaw, Load, Restitution, StickCharge,
};

/// Vacuum permittivity in F/m.
const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

/// Fastest rate at which the gap changes the capacitance, in 1/s: a gap of a dielectric thickness
/// crossed at the impact speeds of these devices. Only the choice of [`Circuit::QuasiStatic`] uses it.
const FASTEST_RATE: f64 = 1e5;

/// How the voltage follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Circuit {
    /// The voltage is a state.
    Dynamic,
    /// The circuit is so fast that `V = R dq/dt` with the charge of the short circuit, to 1e-11.
    QuasiStatic,
    /// No current: the total charge `Q = q − C_p V` stays, so the voltage follows from the gap. Kept
    /// as `σS − Q`, in C.
    Open {
        /// `σS − Q` in C.
        top_charge: f64,
        /// `Q` in C.
        total_charge: f64,
    },
}

/// Gap in m, velocity in m/s (opening positive), load voltage in V; and what a bridge does.
///
/// The voltage is a state only in [`Circuit::Dynamic`]; else it stays at zero here and
/// [`Physics::voltage`] gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) gap: f64,
    pub(super) velocity: f64,
    pub(super) voltage: f64,
    pub(super) bridge: Bridge,
}

/// Constants of the equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Physics {
    pub(super) mass: f64,
    stiffness: f64,
    /// `c = 2 ζ √(k m)` in N s/m, equation (19).
    damping: f64,
    pub(super) initial_gap: f64,
    /// `ε0 S` in F m.
    permittivity_area: f64,
    /// `σ S` in C.
    tribo_charge: f64,
    /// `d / ε_r` in m.
    dielectric: f64,
    parasitic: f64,
    resistance: f64,
    /// `1 / R` in S; 0 for an open circuit. Not used where `R` is 0.
    conductance: f64,
    pub(super) circuit: Circuit,
    /// What stands behind a bridge.
    pub(super) store: Option<Store>,
    force_law: ForceLaw,
    pub(super) stick_charge: StickCharge,
    restitution: Restitution,
    /// Speed in m/s below which a rebound ends in sticking: `10⁻⁴ ω0 d0`, part of the model.
    pub(super) stick_speed: f64,
}

impl Physics {
    /// The equations for the given parameters, and the motion at time zero.
    pub(super) fn new(
        parameters: &ContactSeparationParameters,
        load: Load,
        start: &ContactSeparationStart,
    ) -> (Self, Motion) {
        let resistance = load.resistance_ohm();
        let p = parameters;
        let angular_frequency = (p.stiffness_n_per_m / p.mass_kg).sqrt();
        let mut physics = Self {
            mass: p.mass_kg,
            stiffness: p.stiffness_n_per_m,
            damping: 2.0 * p.damping_ratio * (p.stiffness_n_per_m * p.mass_kg).sqrt(),
            initial_gap: p.initial_gap_m,
            permittivity_area: VACUUM_PERMITTIVITY * p.electrode_area_m2,
            tribo_charge: p.charge_density_c_per_m2 * p.electrode_area_m2,
            dielectric: p.dielectric_thickness_m / p.relative_permittivity,
            parasitic: p.parasitic_capacitance_f,
            resistance,
            conductance: 1.0 / resistance,
            circuit: Circuit::Dynamic,
            store: Store::of(load),
            force_law: p.force_law,
            stick_charge: p.stick_charge,
            restitution: p.restitution,
            stick_speed: 1e-4 * angular_frequency * p.initial_gap_m,
        };
        let gap = start.gap_m.unwrap_or(p.initial_gap_m);
        let voltage = start.charge_c.map_or(0.0, |charge| physics.voltage_of_charge(gap, charge));
        let slowest_circuit =
            resistance * (physics.permittivity_area / physics.dielectric + physics.parasitic);
        if physics.store.is_some() {
            // While the bridge blocks, the charge of an open circuit, but with the voltage as the state.
        } else if resistance.is_infinite() {
            let top = physics.top_charge(gap, voltage) + physics.parasitic * voltage;
            let total = physics.charge_at_voltage(gap, voltage) - physics.parasitic * voltage;
            physics.circuit = Circuit::Open { top_charge: top, total_charge: total };
        } else if slowest_circuit * FASTEST_RATE < 1e-11 {
            physics.circuit = Circuit::QuasiStatic;
        }
        let voltage = if physics.circuit == Circuit::Dynamic { voltage } else { 0.0 };
        let bridge = physics.store.map_or(Bridge::default(), |store| store.start());
        let still = Motion { gap, velocity: 0.0, voltage, bridge };
        let scale = physics.voltage_scale(&still, angular_frequency);
        physics.store = physics.store.map(|store| Store { scale, ..store });
        let mut motion = Motion { gap, velocity: start.velocity_m_per_s.unwrap_or(0.0), voltage, bridge };
        physics.settle(&mut motion);
        (physics, motion)
    }

    /// `V_oc − q / C`, equations (12), (24) and (25).
    fn voltage_of_charge(&self, gap: f64, charge: f64) -> f64 {
        ((self.tribo_charge - charge) * gap - charge * self.dielectric) / self.permittivity_area
    }

    /// Charge `σS − q` of the moving electrode, in C.
    fn top_charge(&self, gap: f64, voltage: f64) -> f64 {
        (self.tribo_charge * self.dielectric + self.permittivity_area * voltage) / (gap + self.dielectric)
    }

    /// Transferred charge `q` in C.
    fn charge_at_voltage(&self, gap: f64, voltage: f64) -> f64 {
        (self.tribo_charge * gap - self.permittivity_area * voltage) / (gap + self.dielectric)
    }

    /// `c + C_p (g + d_e)` in F m.
    fn total_capacitance_length(&self, gap: f64) -> f64 {
        self.permittivity_area + self.parasitic * (gap + self.dielectric)
    }

    /// The voltage that sets the charges: that of the load, except where its drop is lost in rounding.
    fn electrostatic_voltage(&self, motion: &Motion) -> f64 {
        match self.circuit {
            Circuit::Dynamic => motion.voltage,
            Circuit::QuasiStatic => 0.0,
            Circuit::Open { top_charge, total_charge } => {
                (top_charge * motion.gap - total_charge * self.dielectric)
                    / self.total_capacitance_length(motion.gap)
            }
        }
    }

    /// Load voltage in V.
    pub(super) fn voltage(&self, motion: &Motion) -> f64 {
        match self.circuit {
            Circuit::QuasiStatic => {
                let spacing = motion.gap + self.dielectric;
                self.resistance * self.tribo_charge * self.dielectric * motion.velocity / (spacing * spacing)
            }
            Circuit::Dynamic | Circuit::Open { .. } => self.electrostatic_voltage(motion),
        }
    }

    /// Transferred charge `q` in C.
    pub(super) fn charge(&self, motion: &Motion) -> f64 {
        self.charge_at_voltage(motion.gap, self.electrostatic_voltage(motion))
    }

    /// Electrostatic force on the mass in N, attractive positive: equation (28), or the field in the gap.
    pub(super) fn force(&self, motion: &Motion) -> f64 {
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let shared =
                    self.charge(motion) * self.permittivity_area / self.total_capacitance_length(motion.gap);
                shared * shared / (2.0 * self.permittivity_area)
            }
            ForceLaw::GapField => self.field_force(motion),
        }
    }

    /// `(σS − q)² / (2 ε0 S)` in N, attractive positive: the force that conserves energy.
    pub(super) fn field_force(&self, motion: &Motion) -> f64 {
        let top = self.top_charge(motion.gap, self.electrostatic_voltage(motion));
        top * top / (2.0 * self.permittivity_area)
    }

    /// Rates of gap, velocity and voltage under the base acceleration in m/s², equations (19), (23).
    pub(super) fn rates(&self, motion: &Motion, base: f64) -> [f64; 3] {
        let acceleration = -(self.damping * motion.velocity
            + self.stiffness * (motion.gap - self.initial_gap)
            + self.force(motion))
            / self.mass
            - base;
        let voltage_rate = match self.circuit {
            // The terminals follow the store.
            Circuit::Dynamic if motion.bridge.sign != 0.0 => motion.bridge.sign * self.gain_rate(motion),
            Circuit::Dynamic => {
                let spacing = motion.gap + self.dielectric;
                (self.top_charge(motion.gap, motion.voltage) * motion.velocity
                    - spacing * motion.voltage * self.conductance)
                    / self.total_capacitance_length(motion.gap)
            }
            Circuit::QuasiStatic | Circuit::Open { .. } => 0.0,
        };
        [motion.velocity, acceleration, voltage_rate]
    }

    /// Derivative of [`Self::rates`] in the direction of `change`.
    pub(super) fn rates_along(&self, motion: &Motion, change: &Motion) -> [f64; 3] {
        let c = self.permittivity_area;
        let spacing = motion.gap + self.dielectric;
        let total = self.total_capacitance_length(motion.gap);
        let voltage = self.electrostatic_voltage(motion);
        let voltage_change = match self.circuit {
            Circuit::Dynamic => change.voltage,
            Circuit::QuasiStatic => 0.0,
            Circuit::Open { top_charge, .. } => (top_charge - voltage * self.parasitic) / total * change.gap,
        };
        let top = self.top_charge(motion.gap, voltage);
        let top_change = (c * voltage_change - top * change.gap) / spacing;
        let force_change = match self.force_law {
            ForceLaw::TransferredCharge => {
                let shared = self.charge_at_voltage(motion.gap, voltage) * c / total;
                let shared_change = (-top_change * c - shared * self.parasitic * change.gap) / total;
                shared * shared_change / c
            }
            ForceLaw::GapField => top * top_change / c,
        };
        let acceleration_change =
            -(self.damping * change.velocity + self.stiffness * change.gap + force_change) / self.mass;
        let voltage_rate_change = match self.circuit {
            Circuit::Dynamic if motion.bridge.sign != 0.0 => {
                motion.bridge.sign * self.gain_rate_along(motion, change)
            }
            Circuit::Dynamic => {
                let rate = self.rates(motion, 0.0)[2];
                (top_change * motion.velocity + top * change.velocity
                    - (change.gap * motion.voltage + spacing * change.voltage) * self.conductance
                    - rate * self.parasitic * change.gap)
                    / total
            }
            Circuit::QuasiStatic | Circuit::Open { .. } => 0.0,
        };
        [change.velocity, acceleration_change, voltage_rate_change]
    }

    /// Rate of the load voltage in V/s; between two of its zeros the voltage has its peaks.
    pub(super) fn voltage_slope(&self, motion: &Motion, base: f64) -> f64 {
        let [_, acceleration, voltage_rate] = self.rates(motion, base);
        let spacing = motion.gap + self.dielectric;
        match self.circuit {
            Circuit::Dynamic => voltage_rate,
            Circuit::QuasiStatic => {
                self.resistance * self.tribo_charge * self.dielectric / (spacing * spacing)
                    * (acceleration - 2.0 * motion.velocity * motion.velocity / spacing)
            }
            Circuit::Open { top_charge, .. } => {
                (top_charge - self.voltage(motion) * self.parasitic)
                    / self.total_capacitance_length(motion.gap)
                    * motion.velocity
            }
        }
    }

    /// Power in W that enters a resistor at this voltage, from the square of the voltage.
    pub(super) fn load_power(&self, voltage_squared: f64) -> f64 {
        if self.resistance > 0.0 { voltage_squared * self.conductance } else { 0.0 }
    }

    /// Power in W of the damper.
    pub(super) fn damper_power(&self, motion: &Motion) -> f64 {
        self.damping * motion.velocity * motion.velocity
    }

    /// Effective thickness `d / ε_r` of the dielectric in m: the gap may not fall to minus this.
    pub(super) fn dielectric(&self) -> f64 {
        self.dielectric
    }

    /// Energy of mass and spring in J.
    pub(super) fn mechanical_energy(&self, motion: &Motion) -> f64 {
        let stretch = motion.gap - self.initial_gap;
        0.5 * (self.mass * motion.velocity * motion.velocity + self.stiffness * stretch * stretch)
    }

    /// Energy of the fields in gap, dielectric and parasitic capacitance, in J.
    pub(super) fn electrical_energy(&self, motion: &Motion) -> f64 {
        let voltage = self.electrostatic_voltage(motion);
        let top = self.top_charge(motion.gap, voltage);
        let bottom = self.charge_at_voltage(motion.gap, voltage);
        (top * top * motion.gap + bottom * bottom * self.dielectric) / (2.0 * self.permittivity_area)
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

    /// Force in N with which the dielectric presses on a held mass, equation (22).
    pub(super) fn contact_force(&self, held: &Motion, base: f64) -> f64 {
        self.mass * base + self.force(held) - self.stiffness * self.initial_gap
    }

    /// Time constant in s of the circuit at closed gap, `R (C(0) + C_p)`; infinite for an open circuit.
    pub(super) fn closed_time_constant(&self) -> f64 {
        self.resistance * (self.permittivity_area / self.dielectric + self.parasitic)
    }

    /// A voltage in V of the size that the load sees, for tolerances; never zero.
    pub(super) fn voltage_scale(&self, start: &Motion, angular_frequency: f64) -> f64 {
        // What opening the gap from its relaxed state by its own size moves.
        let charge = self.tribo_charge * self.dielectric / (self.initial_gap + self.dielectric);
        let capacitance = self.permittivity_area / self.initial_gap + self.parasitic;
        // An open circuit shows charge over capacitance, a loaded one less: R times the current.
        let driven = (charge / capacitance).min(self.resistance * angular_frequency * charge);
        let driven = self.store.map_or(driven, |store| store.voltage_scale(driven, charge));
        driven.max(self.voltage(start).abs()).max(1e-60)
    }

    /// A charge in C of the size that passes the terminals, for tolerances.
    pub(super) fn charge_scale(&self) -> f64 {
        self.tribo_charge
    }
}

#[cfg(test)]
mod tests;
