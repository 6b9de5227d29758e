//! A sliding scene as plain numbers.

use super::{ForceLaw, StickCharge};

/// A sliding harvester and the state it starts in.
#[derive(Debug, Clone, PartialEq)]
pub struct Sliding {
    /// Table `[parameters]`.
    pub parameters: SlidingParameters,
    /// Table `[initial]`.
    pub initial: SlidingStart,
}

/// `[parameters]` of a sliding scene: a cantilever with a disc at its tip that rubs over two patches,
/// the active one (an electrode under the dielectric, in the middle) and the inert one around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingParameters {
    /// Length of the beam in m.
    pub beam_length_m: f64,
    /// Width of the beam in m.
    pub beam_width_m: f64,
    /// Thickness of the beam in m, in the direction of its bending.
    pub beam_thickness_m: f64,
    /// Young's modulus of the beam in Pa.
    pub young_modulus_pa: f64,
    /// Density of the beam in kg/m³.
    pub density_kg_per_m3: f64,
    /// Damping ratio of the first bending mode.
    pub damping_ratio: f64,
    /// Mass of the slider in kg; its weight presses it on the patches.
    pub slider_mass_kg: f64,
    /// Radius in m of the slider and of the active patch.
    pub patch_radius_m: f64,
    /// Coefficient of static friction on the active patch.
    pub static_friction_active: f64,
    /// Coefficient of static friction on the inert patch.
    pub static_friction_inert: f64,
    /// Coefficient of kinetic friction on the active patch, not above the static one.
    pub kinetic_friction_active: f64,
    /// Coefficient of kinetic friction on the inert patch, not above the static one.
    pub kinetic_friction_inert: f64,
    /// Dielectric thickness in m.
    pub dielectric_thickness_m: f64,
    /// Relative permittivity of the dielectric.
    pub relative_permittivity: f64,
    /// Tribo-charge density in C/m², not negative.
    pub charge_density_c_per_m2: f64,
    /// Electrostatic force law.
    pub force_law: ForceLaw,
    /// What the charge does while the slider sticks.
    pub stick_charge: StickCharge,
    /// Whether the electrostatic force along the patches acts on the slider.
    pub lateral_force: bool,
}

/// `[initial]` of a sliding scene; what is `None` takes its default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlidingStart {
    /// Displacement in m of the slider from the middle of the active patch; by default 0.
    pub displacement_m: Option<f64>,
    /// Velocity in m/s relative to the patches; by default 0.
    pub velocity_m_per_s: Option<f64>,
    /// Transferred charge in C; by default that of no voltage at the displacement.
    pub charge_c: Option<f64>,
}
