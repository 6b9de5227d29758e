//! `[parameters]` and `[initial]` of a sliding scene.

use super::bounds::{self, Short};
use super::document::SceneError;
use super::scene::{SlidingParameters, SlidingStart};
use super::section::Section;

/// Reads `[parameters]`.
pub(super) fn parameters(mut section: Section<'_>) -> Result<SlidingParameters, SceneError> {
    let force_law = section.force_law()?;
    let stick_charge = section.stick_charge()?;
    let lateral_force = section.required_flag("lateral_force")?;
    let mut number = |key| section.number(key, &bounds::of(key));
    let parameters = SlidingParameters {
        beam_length_m: number("beam_length_m")?,
        beam_width_m: number("beam_width_m")?,
        beam_thickness_m: number("beam_thickness_m")?,
        young_modulus_pa: number("young_modulus_pa")?,
        density_kg_per_m3: number("density_kg_per_m3")?,
        damping_ratio: number("damping_ratio")?,
        slider_mass_kg: number("slider_mass_kg")?,
        patch_radius_m: number("patch_radius_m")?,
        static_friction_active: number("static_friction_active")?,
        static_friction_inert: number("static_friction_inert")?,
        kinetic_friction_active: number("kinetic_friction_active")?,
        kinetic_friction_inert: number("kinetic_friction_inert")?,
        dielectric_thickness_m: number("dielectric_thickness_m")?,
        relative_permittivity: number("relative_permittivity")?,
        charge_density_c_per_m2: number("charge_density_c_per_m2")?,
        force_law,
        stick_charge,
        lateral_force,
    };
    together(&parameters).map_err(|(key, reason)| section.refuse(key, reason))?;
    section.finish()?;
    Ok(parameters)
}

/// What the parameters must keep together; each is within its own bound.
///
/// Returns the key to blame and the reason.
fn together(parameters: &SlidingParameters) -> Result<(), (&'static str, String)> {
    let p = parameters;
    // A slider that is held by less than what brakes it would let go and stop at once, for ever.
    for (key, kinetic, other, at_rest) in [
        (
            "kinetic_friction_active",
            p.kinetic_friction_active,
            "static_friction_active",
            p.static_friction_active,
        ),
        (
            "kinetic_friction_inert",
            p.kinetic_friction_inert,
            "static_friction_inert",
            p.static_friction_inert,
        ),
    ] {
        if kinetic > at_rest {
            return Err((key, format!("must not be above {other} = {}", Short(at_rest))));
        }
    }
    let with = format!("young_modulus_pa = {}", Short(p.young_modulus_pa));
    bounds::natural_frequency(p.natural_frequency_hz(), &with).map_err(|reason| ("beam_length_m", reason))
}

/// Reads `[initial]`.
pub(super) fn start(
    mut section: Section<'_>,
    parameters: &SlidingParameters,
) -> Result<SlidingStart, SceneError> {
    let mut number = |key| section.optional_number(key, &bounds::of(key));
    let start = SlidingStart {
        displacement_m: number("displacement_m")?,
        velocity_m_per_s: number("velocity_m_per_s")?,
        charge_c: number("charge_c")?,
    };
    let reach = 2.0 * parameters.patch_radius_m;
    if start.displacement_m.is_some_and(|displacement| displacement.abs() >= reach) {
        return Err(section.refuse(
            "displacement_m",
            format!("must be within two patch radii, less than {} in magnitude", Short(reach)),
        ));
    }
    section.finish()?;
    Ok(start)
}
