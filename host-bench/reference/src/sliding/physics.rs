//! Charges, forces and energies of the sliding harvester.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (1) to (18), in the tip displacement `x`, its rate `v`
//! and the load voltage `V` instead of the transferred charge `q`. With the capacitance of full overlap
//! `c = ε0 ε_r S / d`, equations (12), (14) and (15) give
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
//! These forms do not cancel at small `R`, where `V = V_oc − q/C` is a difference of large numbers. At its
//! terminals the harvester is a capacitance `c s1` and a current `j = −(ds1/dx) v (σS + c V)`.
//!
//! The lateral force along the patches, which the paper leaves out, follows from the energy of the overlap
//! `W = (q − σS s2)² / (2 c s1) = c s1 V² / 2`: at constant charge `−dW/dx = (ds1/dx) V (σS + c V / 2)`. The
//! gap between the surfaces is infinitely thin: its energy vanishes, its pressure does not.

use std::f64::consts::PI;

use crate::triboelectric::{Branch, CircuitKind, Harvester, LoadCircuit, Motion, VACUUM_PERMITTIVITY};
use harvester_scene::scene_file::modes::Cantilever;
use harvester_scene::scene_file::{ForceLaw, GRAVITY, Load, SlidingParameters, TriboelectricStart};

/// Coefficients of friction on the active and on the inert patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Friction {
    pub(super) active: f64,
    pub(super) inert: f64,
}

impl Friction {
    /// The mean weighted with the areas, equations (5) and (11).
    pub(super) fn at(&self, overlap: &Overlap) -> f64 {
        self.active * overlap.active + self.inert * overlap.inert
    }
}

/// Constants of the equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Physics {
    pub(super) beam: Cantilever,
    pub(super) damping_ratio: f64,
    /// Radius of the patches in m.
    pub(super) radius: f64,
    /// `m g` in N.
    weight: f64,
    pub(super) static_friction: Friction,
    kinetic_friction: Friction,
    /// `σ S` in C.
    pub(super) tribo_charge: f64,
    /// `c = ε0 ε_r S / d` in F.
    pub(super) capacitance: f64,
    /// `ε0 S` in F m.
    permittivity_area: f64,
    relative_permittivity: f64,
    pub(super) load: LoadCircuit,
    /// Transferred charge in C of an open circuit.
    open_charge: f64,
    pub(super) force_law: ForceLaw,
    /// Whether the lateral force acts on the slider.
    pub(super) lateral_force: bool,
}

impl Physics {
    /// The equations for the given parameters, and the motion at time zero.
    pub(crate) fn new(
        parameters: &SlidingParameters,
        load: Load,
        start: &TriboelectricStart,
    ) -> (Self, Motion) {
        let p = parameters;
        let area = std::f64::consts::PI * p.patch_radius_m * p.patch_radius_m;
        let permittivity_area = VACUUM_PERMITTIVITY * area;
        let capacitance = permittivity_area * p.relative_permittivity / p.dielectric_thickness_m;
        let mut physics = Self {
            beam: Cantilever::new(p),
            damping_ratio: p.damping_ratio,
            radius: p.patch_radius_m,
            weight: p.slider_mass_kg * GRAVITY,
            static_friction: Friction { active: p.static_friction_active, inert: p.static_friction_inert },
            kinetic_friction: Friction { active: p.kinetic_friction_active, inert: p.kinetic_friction_inert },
            tribo_charge: p.charge_density_c_per_m2 * area,
            capacitance,
            permittivity_area,
            relative_permittivity: p.relative_permittivity,
            load: LoadCircuit::new(load, p.stick_charge, capacitance, start.charge_c),
            open_charge: 0.0,
            force_law: p.force_law,
            lateral_force: p.lateral_force,
        };
        let position = start.position_m.unwrap_or(0.0);
        let mut motion = Motion {
            position,
            velocity: start.velocity_m_per_s.unwrap_or(0.0),
            voltage: 0.0,
            branch: Branch { direction: 0.0, side: if position < 0.0 { -1.0 } else { 1.0 } },
            bridge: physics.load.bridge(),
        };
        let overlap = physics.overlap(&motion);
        let relaxed = physics.tribo_charge * overlap.inert;
        physics.open_charge = start.charge_c.unwrap_or(relaxed);
        if physics.load.kind == CircuitKind::Dynamic {
            motion.voltage = (relaxed - physics.open_charge) / (physics.capacitance * overlap.active);
        }
        let scale = physics.voltage_scale(&motion);
        if let Some(storage) = &mut physics.load.storage {
            storage.scale = scale;
        }
        (physics, motion)
    }

    pub(super) fn overlap(&self, motion: &Motion) -> Overlap {
        Overlap::at(motion.position, self.radius, motion.branch.side)
    }

    /// The voltage in V that sets the charge: the load voltage, except where that is lost in rounding.
    pub(super) fn electrostatic_voltage(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        self.load.kind.voltage(motion.voltage, || {
            (self.tribo_charge * overlap.inert - self.open_charge) / (self.capacitance * overlap.active)
        })
    }

    /// Derivative of [`Self::electrostatic_voltage`] in the direction of `change`.
    fn electrostatic_voltage_along(&self, motion: &Motion, overlap: &Overlap, change: &Motion) -> f64 {
        self.load.kind.voltage(change.voltage, || {
            let total = self.total_charge(self.electrostatic_voltage(motion, overlap));
            -(overlap.slope * change.position) * total / (self.capacitance * overlap.active)
        })
    }

    /// Load voltage in V.
    pub(super) fn voltage_at(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        match self.load.kind {
            CircuitKind::QuasiStatic => {
                -self.load.resistance * self.tribo_charge * overlap.slope * motion.velocity
            }
            CircuitKind::Dynamic | CircuitKind::Open => self.electrostatic_voltage(motion, overlap),
        }
    }

    /// Transferred charge `q` in C.
    pub(super) fn charge_at(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        if self.load.kind == CircuitKind::Open {
            return self.open_charge;
        }
        let voltage = self.electrostatic_voltage(motion, overlap);
        self.tribo_charge * overlap.inert - self.capacitance * overlap.active * voltage
    }

    /// Charge `σS + c V` of full overlap in C; the slider carries the part `s1` of it.
    pub(super) fn total_charge(&self, voltage: f64) -> f64 {
        self.tribo_charge + self.capacitance * voltage
    }

    /// Electrostatic force in N that presses the slider on the patches: equation (16), or the field in the gap,
    /// `(σS − q)² / (2 ε0 S1)`.
    fn pressing_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let charge = self.charge_at(motion, overlap);
                let area = self.permittivity_area * self.relative_permittivity * overlap.active;
                charge * charge / (2.0 * area)
            }
            ForceLaw::GapField => {
                let total = self.total_charge(self.electrostatic_voltage(motion, overlap));
                overlap.active * total * total / (2.0 * self.permittivity_area)
            }
            ForceLaw::None => 0.0,
        }
    }

    /// Derivative of [`Self::pressing_force`] in the direction of `change`.
    fn pressing_force_along(&self, motion: &Motion, overlap: &Overlap, change: &Motion) -> f64 {
        let covered = overlap.slope * change.position;
        let total = self.total_charge(self.electrostatic_voltage(motion, overlap));
        let charged =
            overlap.active * self.capacitance * self.electrostatic_voltage_along(motion, overlap, change);
        match self.force_law {
            ForceLaw::TransferredCharge => {
                let charge = self.charge_at(motion, overlap);
                let charge_change = match self.load.kind {
                    CircuitKind::Open => 0.0,
                    _ => -total * covered - charged,
                };
                let area = self.permittivity_area * self.relative_permittivity * overlap.active;
                charge * charge_change / area
                    - self.pressing_force(motion, overlap) * covered / overlap.active
            }
            ForceLaw::GapField => total * (0.5 * covered * total + charged) / self.permittivity_area,
            ForceLaw::None => 0.0,
        }
    }

    /// Normal force `N = m g + F_e` in N.
    pub(super) fn normal_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        self.weight + self.pressing_force(motion, overlap)
    }

    /// Kinetic friction in N against the direction of slip, equation (5).
    pub(super) fn friction(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        motion.branch.direction * self.kinetic_friction.at(overlap) * self.normal_force(motion, overlap)
    }

    /// Derivative of [`Self::friction`] in the direction of `change`.
    pub(super) fn friction_along(&self, motion: &Motion, overlap: &Overlap, change: &Motion) -> f64 {
        let Friction { active, inert } = self.kinetic_friction;
        let coefficient_change = (active - inert) * (overlap.slope * change.position);
        let pressing_change = self.pressing_force_along(motion, overlap, change);
        motion.branch.direction
            * (coefficient_change * self.normal_force(motion, overlap)
                + self.kinetic_friction.at(overlap) * pressing_change)
    }

    /// Lateral force in N in the direction of the displacement, whether it acts or not: it conserves energy.
    pub(super) fn field_force(&self, motion: &Motion, overlap: &Overlap) -> f64 {
        let voltage = self.voltage_at(motion, overlap);
        overlap.slope * voltage * (self.tribo_charge + 0.5 * self.capacitance * voltage)
    }

    /// Derivative in the direction of `change` of the lateral force that acts.
    pub(super) fn lateral_force_along(&self, motion: &Motion, overlap: &Overlap, change: &Motion) -> f64 {
        if !self.lateral_force {
            return 0.0;
        }
        let slope_change = overlap.curvature * change.position;
        let voltage = self.voltage_at(motion, overlap);
        let voltage_change = match self.load.kind {
            CircuitKind::QuasiStatic => {
                -self.load.resistance
                    * self.tribo_charge
                    * (slope_change * motion.velocity + overlap.slope * change.velocity)
            }
            _ => self.electrostatic_voltage_along(motion, overlap, change),
        };
        slope_change * voltage * (self.tribo_charge + 0.5 * self.capacitance * voltage)
            + overlap.slope * voltage_change * self.total_charge(voltage)
    }

    /// Friction in N, in the direction of the displacement, that holds a slider at rest under the base
    /// acceleration in m/s²: equation (2) without velocity and acceleration, `M (ω² x + κ a)` less the lateral force.
    pub(super) fn holding_friction(&self, motion: &Motion, base: f64) -> f64 {
        let lateral = if self.lateral_force { self.field_force(motion, &self.overlap(motion)) } else { 0.0 };
        let beam = &self.beam;
        let spring = beam.angular_frequency * beam.angular_frequency * motion.position;
        beam.modal_mass * (spring + beam.participation * base) - lateral
    }

    /// Whether there is no friction at all.
    pub(super) fn is_frictionless(&self) -> bool {
        // Kinetic friction is never above the static one.
        self.static_friction.active == 0.0 && self.static_friction.inert == 0.0
    }

    /// Size in V of the load voltage, for tolerances; never zero.
    pub(super) fn voltage_scale(&self, start: &Motion) -> f64 {
        // An open circuit shows charge over capacitance, a loaded one at most R times the current.
        let current = self.beam.angular_frequency * self.tribo_charge;
        let driven = (self.tribo_charge / self.capacitance).min(self.load.resistance * current);
        let driven =
            self.load.storage.map_or(driven, |storage| storage.voltage_scale(driven, self.tribo_charge));
        driven.max(self.voltage(start).abs()).max(1e-60)
    }
}

// Overlap of two equal discs: how much of the active patch the slider covers.
//
// Equations (6) and (7) of Fu, Ouyang and Davis: with `c = |x| / 2r` the covered part of the area is `s1 = (2/π)(arccos c − c
// √(1−c²))`, the area of the lens over that of a disc, and the rest is `s2 = 1 − s1`. Both have a kink at `x = 0`. So they are taken on
// one *side* of it, in `y = ± x`, and go on smoothly where `y` is slightly negative: a motion is cut where it passes the middle.

/// Parts of the area and their change with the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    /// Part on the active patch, `S1 / S`.
    pub(super) active: f64,
    /// Part on the inert patch, `S2 / S`.
    pub(super) inert: f64,
    /// `d(S1/S)/dx` in 1/m.
    pub(super) slope: f64,
    /// `d²(S1/S)/dx²` in 1/m².
    pub(super) curvature: f64,
}

impl Overlap {
    /// At the displacement `x` in m of discs of the given radius in m; `side` is 1 or −1, the sign of the
    /// displacements that the motion has until it is cut.
    pub(super) fn at(displacement: f64, radius: f64, side: f64) -> Self {
        // The iteration of an implicit step may look past the end of the overlap; what it finds there is
        // finite, and a motion that gets there is refused.
        const END: f64 = 1.0 - 1e-12;
        let ratio = (side * displacement / (2.0 * radius)).min(END);
        let root = ((1.0 - ratio) * (1.0 + ratio)).sqrt();
        Self {
            active: 2.0 / PI * (ratio.acos() - ratio * root),
            // Not as 1 − active, which cancels near the middle.
            inert: 2.0 / PI * (ratio.asin() + ratio * root),
            slope: -side * 2.0 * root / (PI * radius),
            curvature: ratio / (root * PI * radius * radius),
        }
    }
}

#[cfg(test)]
mod tests;
