//! The contact-separation harvester: gap and velocity of the mass.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (19) to (28). With the permittivity times area `c`, the effective
//! spacing `D = g + d/ε_r` and the voltage `V`, the transferred charge is `q = (σS g − c V)/D`. The terminals show the
//! capacitance `c/D + C_p` and the current `(σS − q) v / D`.

use harvester_scene::scene_file::{ContactSeparationParameters, ForceLaw, Restitution};

use super::{Base, NEVER, VACUUM_PERMITTIVITY};
use crate::Stop;
use crate::load::{After, Port, Transducer};

#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactSeparation {
    base: Base,
    mass: f64,
    /// `c/m` in 1/s and `k/m` in 1/s².
    damping: f64,
    stiffness: f64,
    initial_gap: f64,
    /// `ε0 S` in F m.
    permittivity_area: f64,
    /// `σ S` in C.
    tribo_charge: f64,
    /// `d/ε_r` in m.
    dielectric: f64,
    /// Spacing in m below which `1/D` is continued.
    least_spacing: f64,
    parasitic: f64,
    force_law: ForceLaw,
    restitution: Restitution,
}

/// Charges and force at a gap and a voltage.
struct Field {
    /// `1/D` in 1/m, and its derivative by the gap.
    per_spacing: f64,
    slope: f64,
    /// `σS − q` in C.
    top: f64,
    /// `c/D + C_p` in F.
    capacitance: f64,
    /// The charge in C of which `charge²/(2c)` is the attraction.
    attracting: f64,
}

impl ContactSeparation {
    pub(crate) fn new(from: &ContactSeparationParameters, base: Base) -> Self {
        let stiffness = from.stiffness_n_per_m / from.mass_kg;
        Self {
            base,
            mass: from.mass_kg,
            damping: 2.0 * from.damping_ratio * stiffness.sqrt(),
            stiffness,
            initial_gap: from.initial_gap_m,
            permittivity_area: VACUUM_PERMITTIVITY * from.electrode_area_m2,
            tribo_charge: from.charge_density_c_per_m2 * from.electrode_area_m2,
            dielectric: from.dielectric_thickness_m / from.relative_permittivity,
            least_spacing: 0.3 * from.dielectric_thickness_m / from.relative_permittivity,
            parasitic: from.parasitic_capacitance_f,
            force_law: from.force_law,
            restitution: from.restitution,
        }
    }

    #[inline]
    fn field(&self, gap: f64, voltage: f64) -> Field {
        let c = self.permittivity_area;
        let (per_spacing, slope) = self.per_spacing(gap);
        let top = (self.tribo_charge * self.dielectric + c * voltage) * per_spacing;
        let capacitance = c * per_spacing + self.parasitic;
        let attracting = match self.force_law {
            // The share C/(C + C_p) of the transferred charge.
            ForceLaw::TransferredCharge => (self.tribo_charge - top) * c * per_spacing / capacitance,
            ForceLaw::GapField => top,
            ForceLaw::None => 0.0,
        };
        Field { per_spacing, slope, top, capacitance, attracting }
    }

    /// `1/D` and its derivative by the gap. A step that ends in an impact looks beyond it, where the function goes on as
    /// its Taylor polynomial of second order: it has a pole a dielectric thickness beyond.
    #[inline]
    fn per_spacing(&self, gap: f64) -> (f64, f64) {
        let spacing = gap + self.dielectric;
        if spacing >= self.least_spacing {
            let per_spacing = spacing.recip();
            return (per_spacing, -per_spacing * per_spacing);
        }
        let most = self.least_spacing.recip();
        let depth = spacing * most - 1.0;
        (most * (1.0 - depth + depth * depth), most * most * (2.0 * depth - 1.0))
    }

    fn restitution(&self, speed: f64) -> f64 {
        match self.restitution {
            Restitution::Constant { coefficient } => coefficient,
            Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
                at_speed + (at_rest - at_speed) * (-speed / reference_speed_m_per_s).exp()
            }
        }
    }

    fn force(&self, field: &Field) -> f64 {
        field.attracting * field.attracting / (2.0 * self.permittivity_area)
    }
}

impl Transducer for ContactSeparation {
    type Branch = ();
    const GUARDS: usize = 1;

    fn base(&self) -> &Base {
        &self.base
    }

    fn start(&self, motion: &mut [f64]) -> After<()> {
        motion[0] = self.initial_gap;
        After::On(())
    }

    fn released(&self, _: f64, _: &[f64], _: f64) {}

    fn sizes(&self, motion: &mut [f64]) -> [f64; 2] {
        motion[0] = self.initial_gap;
        motion[1] = self.initial_gap * self.stiffness.sqrt();
        let closed = self.dielectric / (self.initial_gap + self.dielectric);
        [self.tribo_charge * closed, self.permittivity_area / self.initial_gap + self.parasitic]
    }

    #[inline]
    fn flow(&self, (): (), base: f64, motion: &[f64], voltage: f64, rates: &mut [f64]) -> Port {
        let [gap, velocity] = [motion[0], motion[1]];
        let field = self.field(gap, voltage);
        rates[0] = velocity;
        rates[1] = -self.damping * velocity
            - self.stiffness * (gap - self.initial_gap)
            - base
            - self.force(&field) / self.mass;
        Port { driven: field.top * velocity * field.per_spacing, capacitance: field.capacitance }
    }

    #[inline]
    fn port(&self, (): (), motion: &[f64], voltage: f64) -> Port {
        let field = self.field(motion[0], voltage);
        Port { driven: field.top * motion[1] * field.per_spacing, capacitance: field.capacitance }
    }

    #[inline]
    fn flow_along(
        &self,
        (): (),
        (motion, voltage): (&[f64], f64),
        (change, d_voltage): (&[f64], f64),
        rates: &mut [f64],
    ) -> [Port; 2] {
        let (velocity, [d_gap, d_velocity]) = (motion[1], [change[0], change[1]]);
        let Field { per_spacing, slope, top, capacitance, attracting } = self.field(motion[0], voltage);
        let c = self.permittivity_area;
        let d_per_spacing = slope * d_gap;
        let d_top = c * d_voltage * per_spacing + top * d_per_spacing / per_spacing;
        let d_capacitance = c * d_per_spacing;
        let d_attracting = match self.force_law {
            ForceLaw::TransferredCharge => {
                let transferred = self.tribo_charge - top;
                (c * (transferred * d_per_spacing - d_top * per_spacing) - attracting * d_capacitance)
                    / capacitance
            }
            ForceLaw::GapField => d_top,
            ForceLaw::None => 0.0,
        };
        rates[0] = d_velocity;
        rates[1] =
            -self.damping * d_velocity - self.stiffness * d_gap - attracting * d_attracting / (c * self.mass);
        let driven = top * velocity * per_spacing;
        let d_driven = (d_top * velocity + top * d_velocity) * per_spacing + top * velocity * d_per_spacing;
        [Port { driven, capacitance }, Port { driven: d_driven, capacitance: d_capacitance }]
    }

    #[inline]
    fn guards(&self, (): (), motion: &[f64]) -> [f64; 2] {
        [motion[0], NEVER]
    }

    fn jump(&self, _: usize, time: f64, (): (), motion: &mut [f64], voltage: f64) -> After<()> {
        let speed = -motion[1].min(0.0);
        motion[0] = 0.0;
        motion[1] = self.restitution(speed) * speed;
        let slow = 1e-4 * self.stiffness.sqrt() * self.initial_gap;
        if motion[1] < slow && self.reserve(time, motion, voltage) > 0.0 {
            motion[1] = 0.0;
            return After::Stuck;
        }
        After::On(())
    }

    /// The force with which the dielectric presses on the mass.
    fn reserve(&self, time: f64, motion: &[f64], voltage: f64) -> f64 {
        let force = self.force(&self.field(motion[0], voltage));
        self.mass * (self.base.at(time) - self.stiffness * self.initial_gap) + force
    }

    fn check(&self, motion: &[f64]) -> Result<(), Stop> {
        if motion[0].is_finite() { Ok(()) } else { Err(Stop::OutOfRange) }
    }
}
