//! The equations of motion of the sliding harvester, for the reference.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (1) to (18), in the tip displacement `x`, its
//! rate `v` and the load voltage `V` instead of the transferred charge `q`. With the capacitance of full
//! overlap `c = ε0 ε_r S / d`, equations (12), (14) and (15) give
//!
//! ```text
//! q = σS s2 − c s1 V          σS − q = s1 (σS + c V)
//! ```
//!
//! and, with the time derivative of the first, `s2' = −s1'` and `q' = V / R` of (13),
//!
//! ```text
//! V' = [ −(ds1/dx) v (σS + c V) − V / R ] / (c s1)
//! ```
//!
//! Nothing here cancels at small `R`, where `V = V_oc − q/C` is a difference of large numbers. To a bridge the
//! harvester is a capacitance `c s1` and a current `j = −(ds1/dx) v (σS + c V)`.
//!
//! The force along the patches, which the paper leaves out, follows from the energy of the overlap
//! `W = (q − σS s2)² / (2 c s1) = c s1 V² / 2`: at constant charge
//! `−dW/dx = (ds1/dx) V (σS + c V / 2)`. The gap between the surfaces is taken as infinitely thin: its
//! energy vanishes, its pressure does not.

mod terminals;

use super::overlap::Overlap;
use crate::reference::Cantilever;
use crate::reference::bridge::{Bridge, Harvester};
use crate::reference::store::Store;
use crate::scene_file::{ForceLaw, GRAVITY, Load, SlidingParameters, SlidingStart, StickCharge};

/// Vacuum permittivity in F/m.
const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

/// Fastest rate at which the motion changes the overlap, in 1/s: far above that of the fastest beam
/// that a scene may have. Only the choice of [`Circuit::QuasiStatic`] uses it.
const FASTEST_RATE: f64 = 1e5;

/// How the voltage follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Circuit {
    /// The voltage is a state.
    Dynamic,
    /// The circuit is so fast that `V = R dq/dt` with the charge of the short circuit, to 1e-11.
    QuasiStatic,
    /// No current: the charge stays, so the voltage follows from the displacement.
    Open {
        /// Transferred charge `q` in C.
        charge: f64,
    },
}

/// Displacement in m, velocity in m/s, load voltage in V; the side of the middle, and what a bridge does.
///
/// The voltage is a state only in [`Circuit::Dynamic`]; else it stays at zero here and
/// [`Physics::voltage`] gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) displacement: f64,
    pub(super) velocity: f64,
    pub(super) voltage: f64,
    /// 1 or −1: on which side of the middle the overlap is taken.
    pub(super) side: f64,
    pub(super) bridge: Bridge,
}

/// Coefficients of friction on the active and on the inert patch.
#[derive(Debug, Clone, Copy)]
struct Friction {
    active: f64,
    inert: f64,
}

impl Friction {
    /// Weighed with the areas, equations (5) and (11).
    fn at(&self, overlap: &Overlap) -> f64 {
        self.active * overlap.active + self.inert * overlap.inert
    }
}

/// Constants of the equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Physics {
    pub(super) beam: Cantilever,
    damping_ratio: f64,
    pub(super) radius: f64,
    /// `m g` in N.
    weight: f64,
    at_rest: Friction,
    sliding: Friction,
    /// `σ S` in C.
    tribo_charge: f64,
    /// `c = ε0 ε_r S / d` in F.
    capacitance: f64,
    /// `ε0 S` in F m.
    permittivity_area: f64,
    relative_permittivity: f64,
    resistance: f64,
    /// `1 / R` in S; 0 for an open circuit. Not used where `R` is 0.
    conductance: f64,
    pub(super) circuit: Circuit,
    /// What stands behind a bridge.
    pub(super) store: Option<Store>,
    force_law: ForceLaw,
    pub(super) stick_charge: StickCharge,
    lateral_force: bool,
}

impl Physics {
    /// The equations for the given parameters, and the motion at time zero.
    pub(super) fn new(parameters: &SlidingParameters, load: Load, start: &SlidingStart) -> (Self, Motion) {
        let resistance = load.resistance_ohm();
        let p = parameters;
        let area = std::f64::consts::PI * p.patch_radius_m * p.patch_radius_m;
        let permittivity_area = VACUUM_PERMITTIVITY * area;
        let mut physics = Self {
            beam: Cantilever::new(p),
            damping_ratio: p.damping_ratio,
            radius: p.patch_radius_m,
            weight: p.slider_mass_kg * GRAVITY,
            at_rest: Friction { active: p.static_friction_active, inert: p.static_friction_inert },
            sliding: Friction { active: p.kinetic_friction_active, inert: p.kinetic_friction_inert },
            tribo_charge: p.charge_density_c_per_m2 * area,
            capacitance: permittivity_area * p.relative_permittivity / p.dielectric_thickness_m,
            permittivity_area,
            relative_permittivity: p.relative_permittivity,
            resistance,
            conductance: 1.0 / resistance,
            circuit: Circuit::Dynamic,
            store: Store::of(load),
            force_law: p.force_law,
            stick_charge: p.stick_charge,
            lateral_force: p.lateral_force,
        };
        let displacement = start.displacement_m.unwrap_or(0.0);
        let side = if displacement < 0.0 { -1.0 } else { 1.0 };
        let bridge = physics.store.map_or(Bridge::default(), |store| store.start());
        let velocity = start.velocity_m_per_s.unwrap_or(0.0);
        let mut motion = Motion { displacement, velocity, voltage: 0.0, side, bridge };
        let relaxed = physics.charge(&motion);
        let charge = start.charge_c.unwrap_or(relaxed);
        if resistance.is_infinite() && physics.store.is_none() {
            physics.circuit = Circuit::Open { charge };
        } else if resistance * physics.capacitance * FASTEST_RATE < 1e-11 {
            physics.circuit = Circuit::QuasiStatic;
        } else {
            motion.voltage = (relaxed - charge) / (physics.capacitance * physics.overlap(&motion).active);
        }
        let scale = physics.voltage_scale(&motion);
        physics.store = physics.store.map(|store| Store { scale, ..store });
        physics.settle(&mut motion);
        (physics, motion)
    }

    fn overlap(&self, motion: &Motion) -> Overlap {
        Overlap::at(motion.displacement, self.radius, motion.side)
    }

    /// The voltage that sets the charge: that of the load, except where its drop is lost in rounding.
    fn electrostatic_voltage(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        match self.circuit {
            Circuit::Dynamic => motion.voltage,
            Circuit::QuasiStatic => 0.0,
            Circuit::Open { charge } => {
                (self.tribo_charge * overlap.inert - charge) / (self.capacitance * overlap.active)
            }
        }
    }

    fn voltage_at(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        match self.circuit {
            Circuit::QuasiStatic => -self.resistance * self.tribo_charge * overlap.slope * motion.velocity,
            Circuit::Dynamic | Circuit::Open { .. } => self.electrostatic_voltage(motion, overlap),
        }
    }

    /// Load voltage in V; while the charge is frozen the load does not see it.
    pub(super) fn voltage(&self, motion: &Motion) -> f64 {
        self.voltage_at(motion, &self.overlap(motion))
    }

    fn charge_at(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        if let Circuit::Open { charge } = self.circuit {
            return charge;
        }
        let voltage = self.electrostatic_voltage(motion, overlap);
        self.tribo_charge * overlap.inert - self.capacitance * overlap.active * voltage
    }

    /// Transferred charge `q` in C.
    pub(super) fn charge(&self, motion: &Motion) -> f64 {
        self.charge_at(motion, &self.overlap(motion))
    }

    /// Electrostatic force in N that presses the slider on the patches: equation (16), or the field in
    /// the gap, `(σS − q)² / (2 ε0 S1)`.
    fn pressing_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let charge = self.charge_at(motion, overlap);
                let area = self.permittivity_area * self.relative_permittivity * overlap.active;
                charge * charge / (2.0 * area)
            }
            ForceLaw::GapField => {
                let density = self.tribo_charge_and(self.electrostatic_voltage(motion, overlap));
                overlap.active * density * density / (2.0 * self.permittivity_area)
            }
        }
    }

    /// `σS + c V` in C, of which the overlap carries its part on the slider.
    fn tribo_charge_and(&self, voltage: f64) -> f64 {
        self.tribo_charge + self.capacitance * voltage
    }

    /// Normal force `N = m g + F_e` in N.
    fn normal_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        self.weight + self.pressing_force(motion, overlap)
    }

    /// Electrostatic force in N along the patches, in the direction of the displacement, that conserves
    /// energy; whether it acts or not.
    fn field_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        let voltage = self.voltage_at(motion, overlap);
        overlap.slope * voltage * (self.tribo_charge + 0.5 * self.capacitance * voltage)
    }

    /// Whether there is no friction at all.
    pub(super) fn is_frictionless(&self) -> bool {
        // Kinetic friction is never above the static one.
        self.at_rest.active == 0.0 && self.at_rest.inert == 0.0
    }

    /// Largest static friction in N, equation (11).
    pub(super) fn most_static_friction(&self, motion: &Motion) -> f64 {
        let overlap = self.overlap(motion);
        self.at_rest.at(&overlap) * self.normal_force(motion, &overlap)
    }

    /// Friction in N that would hold a slider at rest under the base acceleration in m/s², in the
    /// direction of the displacement: the equation of motion (2) without velocity and acceleration,
    /// `M (ω² x + κ a)` less the force along the patches.
    pub(super) fn holding_friction(&self, motion: &Motion, base: f64) -> f64 {
        let lateral = if self.lateral_force { self.field_force(motion, &self.overlap(motion)) } else { 0.0 };
        let beam = &self.beam;
        let spring = beam.angular_frequency * beam.angular_frequency * motion.displacement;
        beam.modal_mass * (spring + beam.participation * base) - lateral
    }

    /// Rates of displacement, velocity and voltage of a slider that slips in `direction` (1 or −1, or 0
    /// without friction) under the base acceleration in m/s², equations (2), (5) and (13).
    pub(super) fn rates(&self, motion: &Motion, direction: f64, base: f64) -> [f64; 3] {
        let overlap = self.overlap(motion);
        let friction = direction * self.sliding.at(&overlap) * self.normal_force(motion, &overlap);
        let damper = 2.0 * self.damping_ratio * self.beam.angular_frequency * motion.velocity;
        let acceleration = -damper - (self.holding_friction(motion, base) + friction) / self.beam.modal_mass;
        let voltage_rate = match self.circuit {
            Circuit::Dynamic => self.voltage_rate(motion, &overlap),
            Circuit::QuasiStatic | Circuit::Open { .. } => 0.0,
        };
        [motion.velocity, acceleration, voltage_rate]
    }

    /// `V'` in V/s where the voltage follows from the charge.
    fn voltage_rate(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        if motion.bridge.sign != 0.0 {
            // The terminals follow the store.
            return motion.bridge.sign * self.gain_rate(motion);
        }
        let voltage = self.electrostatic_voltage(motion, overlap);
        let current = voltage * self.conductance;
        (-overlap.slope * motion.velocity * self.tribo_charge_and(voltage) - current)
            / (self.capacitance * overlap.active)
    }

    /// Derivative of [`Self::rates`] in the direction of `change`.
    pub(super) fn rates_along(&self, motion: &Motion, direction: f64, change: &Motion) -> [f64; 3] {
        let overlap = self.overlap(motion);
        let covered = overlap.slope * change.displacement;
        let slope_change = overlap.curvature * change.displacement;
        let c = self.capacitance;
        let voltage = self.electrostatic_voltage(motion, &overlap);
        let total = self.tribo_charge_and(voltage);
        let voltage_change = match self.circuit {
            Circuit::Dynamic => change.voltage,
            Circuit::QuasiStatic => 0.0,
            Circuit::Open { .. } => -covered * total / (c * overlap.active),
        };
        let pressing = self.pressing_force(motion, &overlap);
        let pressing_change = match self.force_law {
            ForceLaw::TransferredCharge => {
                let charge = self.charge_at(motion, &overlap);
                let charge_change = match self.circuit {
                    Circuit::Open { .. } => 0.0,
                    _ => -total * covered - c * overlap.active * voltage_change,
                };
                let area = self.permittivity_area * self.relative_permittivity * overlap.active;
                charge * charge_change / area - pressing * covered / overlap.active
            }
            ForceLaw::GapField => {
                total * (0.5 * covered * total + overlap.active * c * voltage_change) / self.permittivity_area
            }
        };
        let coefficient_change = (self.sliding.active - self.sliding.inert) * covered;
        let friction_change = direction
            * (coefficient_change * (self.weight + pressing) + self.sliding.at(&overlap) * pressing_change);
        let lateral_change = if self.lateral_force {
            let seen = self.voltage_at(motion, &overlap);
            let seen_change = match self.circuit {
                Circuit::QuasiStatic => {
                    -self.resistance
                        * self.tribo_charge
                        * (slope_change * motion.velocity + overlap.slope * change.velocity)
                }
                _ => voltage_change,
            };
            slope_change * seen * (self.tribo_charge + 0.5 * c * seen)
                + overlap.slope * seen_change * self.tribo_charge_and(seen)
        } else {
            0.0
        };
        let omega = self.beam.angular_frequency;
        let acceleration_change = -2.0 * self.damping_ratio * omega * change.velocity
            - omega * omega * change.displacement
            - (friction_change - lateral_change) / self.beam.modal_mass;
        let voltage_rate_change = match self.circuit {
            Circuit::Dynamic if motion.bridge.sign != 0.0 => {
                motion.bridge.sign * self.gain_rate_along(motion, change)
            }
            Circuit::Dynamic => {
                let rate = self.voltage_rate(motion, &overlap);
                (-slope_change * motion.velocity * total
                    - overlap.slope * change.velocity * total
                    - (overlap.slope * motion.velocity * c + self.conductance) * change.voltage)
                    / (c * overlap.active)
                    - rate * covered / overlap.active
            }
            Circuit::QuasiStatic | Circuit::Open { .. } => 0.0,
        };
        [change.velocity, acceleration_change, voltage_rate_change]
    }

    /// Rate of the load voltage in V/s; between two of its zeros the voltage has its peaks.
    pub(super) fn voltage_slope(&self, motion: &Motion, direction: f64, base: f64) -> f64 {
        let overlap = self.overlap(motion);
        match self.circuit {
            Circuit::QuasiStatic => {
                let [_, acceleration, _] = self.rates(motion, direction, base);
                -self.resistance
                    * self.tribo_charge
                    * (overlap.curvature * motion.velocity * motion.velocity + overlap.slope * acceleration)
            }
            Circuit::Dynamic | Circuit::Open { .. } => self.voltage_rate(motion, &overlap),
        }
    }

    /// Power in W that enters a resistor at this voltage, from the square of the voltage.
    pub(super) fn load_power(&self, voltage_squared: f64) -> f64 {
        if self.resistance > 0.0 { voltage_squared * self.conductance } else { 0.0 }
    }

    /// Powers in W of a slider that slips: of the base into it, of it into the damper and into friction,
    /// and of the force along the patches into it, whether that acts or not.
    pub(super) fn powers(&self, motion: &Motion, direction: f64, base: f64) -> [f64; 4] {
        let overlap = self.overlap(motion);
        let (beam, velocity) = (&self.beam, motion.velocity);
        let damper = 2.0 * self.damping_ratio * beam.angular_frequency * beam.modal_mass * velocity;
        let friction = direction * self.sliding.at(&overlap) * self.normal_force(motion, &overlap);
        [
            -beam.participation * beam.modal_mass * base * velocity,
            damper * velocity,
            friction * velocity,
            self.field_force(motion, &overlap) * velocity,
        ]
    }

    /// Energy of mass and spring in J.
    pub(super) fn mechanical_energy(&self, motion: &Motion) -> f64 {
        let speed_like = self.beam.angular_frequency * motion.displacement;
        0.5 * self.beam.modal_mass * (motion.velocity * motion.velocity + speed_like * speed_like)
    }

    /// Energy in J of the field in the overlap, beyond that of the short circuit.
    pub(super) fn electrical_energy(&self, motion: &Motion) -> f64 {
        let overlap = self.overlap(motion);
        let voltage = self.electrostatic_voltage(motion, &overlap);
        0.5 * self.capacitance * overlap.active * voltage * voltage
    }

    /// Whether the force along the patches acts on the slider.
    pub(super) fn has_lateral_force(&self) -> bool {
        self.lateral_force
    }

    /// Time constant in s of the circuit at a displacement, `R C(x)`.
    pub(super) fn time_constant(&self, motion: &Motion) -> f64 {
        self.resistance * self.capacitance * self.overlap(motion).active
    }

    /// A charge in C of the size that passes the terminals, for tolerances.
    pub(super) fn charge_scale(&self) -> f64 {
        self.tribo_charge
    }

    /// A voltage in V of the size that the load sees, for tolerances; never zero.
    pub(super) fn voltage_scale(&self, start: &Motion) -> f64 {
        // An open circuit shows charge over capacitance, a loaded one less: R times the current.
        let current = self.beam.angular_frequency * self.tribo_charge;
        let driven = (self.tribo_charge / self.capacitance).min(self.resistance * current);
        let driven = self.store.map_or(driven, |store| store.voltage_scale(driven, self.tribo_charge));
        driven.max(self.voltage(start).abs()).max(1e-60)
    }
}

#[cfg(test)]
mod tests;
