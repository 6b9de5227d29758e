//! The sliding harvester: displacement and velocity of the slider.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (1) to (18). With the parts `s1` and `s2 = 1 − s1` of the slider
//! on the active and the inert patch, the capacitance `c` of full overlap and the voltage `V`, the transferred charge is
//! `q = σS s2 − c s1 V`. The terminals show the capacitance `c s1` and the current `−(ds1/dx) v (σS + c V)`.

use std::f64::consts::PI;

use harvester_scene::scene_file::modes::Cantilever;
use harvester_scene::scene_file::{ForceLaw, GRAVITY, SlidingParameters};

use super::{Base, VACUUM_PERMITTIVITY};
use crate::Stop;
use crate::load::{After, Port, Transducer};

/// The branch on which friction and overlap are smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Branch {
    /// Direction of slip, 1 or −1.
    direction: f64,
    /// Side of the middle, 1 or −1.
    side: f64,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Sliding {
    base: Base,
    /// `2ζω` in 1/s and `ω²` in 1/s².
    damping: f64,
    stiffness: f64,
    /// `M` in kg and `κ`.
    modal_mass: f64,
    participation: f64,
    radius: f64,
    /// `m g` in N.
    weight: f64,
    /// Coefficients of static friction on the active and on the inert patch.
    static_friction: [f64; 2],
    kinetic_friction: [f64; 2],
    /// `σ S` in C.
    tribo_charge: f64,
    /// `c` in F.
    capacitance: f64,
    /// Twice the permittivity times area in F m of the pressing force.
    pressing: f64,
    force_law: ForceLaw,
}

struct Overlap {
    active: f64,
    inert: f64,
    /// `ds1/dx` in 1/m.
    slope: f64,
    /// `√(1 − (x/2r)²)`.
    root: f64,
}

impl Overlap {
    #[inline]
    fn at(displacement: f64, radius: f64, side: f64) -> Self {
        // A step that is rejected later may look beyond the end of the overlap.
        let ratio = (side * displacement / (2.0 * radius)).min(1.0 - 1e-12);
        let root = (1.0 - ratio * ratio).sqrt();
        let inert = 2.0 / PI * (ratio.asin() + ratio * root);
        Self { active: 1.0 - inert, inert, slope: -side * 2.0 * root / (PI * radius), root }
    }

    #[inline]
    fn mean(&self, [active, inert]: [f64; 2]) -> f64 {
        active * self.active + inert * self.inert
    }
}

/// Pressing force in N, and the charge in C of which it is the square.
struct Pressing {
    force: f64,
    charge: f64,
}

impl Sliding {
    pub(crate) fn new(from: &SlidingParameters, base: Base) -> Self {
        let beam = Cantilever::new(from);
        let permittivity_area = VACUUM_PERMITTIVITY * PI * from.patch_radius_m * from.patch_radius_m;
        let relative = match from.force_law {
            ForceLaw::TransferredCharge => from.relative_permittivity,
            ForceLaw::GapField | ForceLaw::None => 1.0,
        };
        Self {
            base,
            damping: 2.0 * from.damping_ratio * beam.angular_frequency,
            stiffness: beam.angular_frequency * beam.angular_frequency,
            modal_mass: beam.modal_mass,
            participation: beam.participation,
            radius: from.patch_radius_m,
            weight: from.slider_mass_kg * GRAVITY,
            static_friction: [from.static_friction_active, from.static_friction_inert],
            kinetic_friction: [from.kinetic_friction_active, from.kinetic_friction_inert],
            tribo_charge: from.charge_density_c_per_m2 * PI * from.patch_radius_m * from.patch_radius_m,
            capacitance: permittivity_area * from.relative_permittivity / from.dielectric_thickness_m,
            pressing: 2.0 * permittivity_area * relative,
            force_law: from.force_law,
        }
    }

    #[inline]
    fn overlap(&self, branch: Branch, motion: &[f64]) -> Overlap {
        Overlap::at(motion[0], self.radius, branch.side)
    }

    /// `q²/(2 ε0 ε_r S1)`, or `(σS − q)²/(2 ε0 S1)` with `σS − q = s1 (σS + c V)`.
    #[inline]
    fn pressing(&self, overlap: &Overlap, voltage: f64) -> Pressing {
        let charged = self.capacitance * voltage;
        let charge = match self.force_law {
            ForceLaw::TransferredCharge => self.tribo_charge * overlap.inert - overlap.active * charged,
            ForceLaw::GapField => overlap.active * (self.tribo_charge + charged),
            ForceLaw::None => 0.0,
        };
        Pressing { force: charge * charge / (self.pressing * overlap.active), charge }
    }

    /// Force in N that holds the slider at rest.
    fn holding(&self, time: f64, motion: &[f64]) -> f64 {
        self.modal_mass * (self.stiffness * motion[0] + self.participation * self.base.at(time))
    }

    fn side(motion: &[f64], direction: f64) -> f64 {
        if motion[0] == 0.0 { direction } else { motion[0].signum() }
    }

    /// A slider at rest sticks where static friction can hold it; otherwise it slips where it is driven.
    fn stopped(&self, time: f64, motion: &[f64], voltage: f64) -> After<Branch> {
        if self.reserve(time, motion, voltage) >= 0.0 {
            return After::Stuck;
        }
        After::On(self.released(time, motion, voltage))
    }
}

impl Transducer for Sliding {
    type Branch = Branch;
    const GUARDS: usize = 2;

    fn base(&self) -> &Base {
        &self.base
    }

    fn start(&self, motion: &mut [f64]) -> After<Branch> {
        self.stopped(0.0, motion, 0.0)
    }

    fn released(&self, time: f64, motion: &[f64], _: f64) -> Branch {
        let direction = if self.holding(time, motion) > 0.0 { -1.0 } else { 1.0 };
        Branch { direction, side: Self::side(motion, direction) }
    }

    fn sizes(&self, motion: &mut [f64]) -> [f64; 2] {
        motion[0] = self.radius;
        motion[1] = self.radius * self.stiffness.sqrt();
        [self.tribo_charge, self.capacitance]
    }

    #[inline]
    fn flow(&self, branch: Branch, base: f64, motion: &[f64], voltage: f64, rates: &mut [f64]) -> Port {
        let [displacement, velocity] = [motion[0], motion[1]];
        let overlap = self.overlap(branch, motion);
        let normal = self.weight + self.pressing(&overlap, voltage).force;
        let friction = branch.direction * overlap.mean(self.kinetic_friction) * normal;
        rates[0] = velocity;
        rates[1] = -self.damping * velocity
            - self.stiffness * displacement
            - self.participation * base
            - friction / self.modal_mass;
        let total = self.tribo_charge + self.capacitance * voltage;
        Port { driven: -overlap.slope * velocity * total, capacitance: self.capacitance * overlap.active }
    }

    #[inline]
    fn port(&self, branch: Branch, motion: &[f64], voltage: f64) -> Port {
        let overlap = self.overlap(branch, motion);
        let total = self.tribo_charge + self.capacitance * voltage;
        Port { driven: -overlap.slope * motion[1] * total, capacitance: self.capacitance * overlap.active }
    }

    #[inline]
    fn flow_along(
        &self,
        branch: Branch,
        (motion, voltage): (&[f64], f64),
        (change, d_voltage): (&[f64], f64),
        rates: &mut [f64],
    ) -> [Port; 2] {
        let (velocity, [d_displacement, d_velocity]) = (motion[1], [change[0], change[1]]);
        let overlap = self.overlap(branch, motion);
        let Pressing { force, charge } = self.pressing(&overlap, voltage);
        let total = self.tribo_charge + self.capacitance * voltage;
        let d_total = self.capacitance * d_voltage;
        let d_active = overlap.slope * d_displacement;
        let d_charge = match self.force_law {
            ForceLaw::TransferredCharge => -total * d_active - overlap.active * d_total,
            ForceLaw::GapField => total * d_active + overlap.active * d_total,
            ForceLaw::None => 0.0,
        };
        let d_force =
            2.0 * charge * d_charge / (self.pressing * overlap.active) - force * d_active / overlap.active;
        let [active, inert] = self.kinetic_friction;
        let d_friction = branch.direction
            * ((active - inert) * d_active * (self.weight + force)
                + overlap.mean(self.kinetic_friction) * d_force);
        rates[0] = d_velocity;
        rates[1] =
            -self.damping * d_velocity - self.stiffness * d_displacement - d_friction / self.modal_mass;
        let d_slope = branch.side * motion[0] * d_displacement
            / (2.0 * PI * self.radius * self.radius * self.radius * overlap.root);
        let d_driven =
            -(d_slope * velocity + overlap.slope * d_velocity) * total - overlap.slope * velocity * d_total;
        [
            Port {
                driven: -overlap.slope * velocity * total,
                capacitance: self.capacitance * overlap.active,
            },
            Port { driven: d_driven, capacitance: self.capacitance * d_active },
        ]
    }

    /// The velocity in the direction of slip, and the displacement on the present side.
    #[inline]
    fn guards(&self, branch: Branch, motion: &[f64]) -> [f64; 2] {
        [branch.direction * motion[1], branch.side * motion[0]]
    }

    fn jump(
        &self,
        guard: usize,
        time: f64,
        branch: Branch,
        motion: &mut [f64],
        voltage: f64,
    ) -> After<Branch> {
        if guard == 0 {
            motion[1] = 0.0;
            return self.stopped(time, motion, voltage);
        }
        motion[0] = 0.0;
        After::On(Branch { side: -branch.side, ..branch })
    }

    /// Static friction, less what holds the slider.
    fn reserve(&self, time: f64, motion: &[f64], voltage: f64) -> f64 {
        let overlap = Overlap::at(motion[0], self.radius, Self::side(motion, 1.0));
        let normal = self.weight + self.pressing(&overlap, voltage).force;
        overlap.mean(self.static_friction) * normal - self.holding(time, motion).abs()
    }

    fn check(&self, motion: &[f64]) -> Result<(), Stop> {
        if motion[0].abs() < 2.0 * self.radius { Ok(()) } else { Err(Stop::OutOfRange) }
    }
}
