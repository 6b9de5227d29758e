//! `[parameters]` and `[initial]` of a sliding scene.

use model_core::part::friction::PatchFriction;
use model_core::scene::sliding::{Parameters, Start};

use super::bounds::{self, Short, Table, between};
use super::document::SceneError;
use super::scene::{Model, Sliding, SlidingParameters, SlidingStart};
use super::section::{Section, numbers};

const PARAMETERS: &[Table] = &[Parameters::<f64, ()>::BOUNDS, PatchFriction::<f64>::BOUNDS];
/// Twice the largest patch radius; the radius of the scene is checked beside it.
const INITIAL: &[Table] = &[&[("displacement_m", between(-2.0, 2.0))], Start::<f64>::BOUNDS];

/// Reads the tables of the harvester.
pub(super) fn model(root: &mut Section<'_>) -> Result<Model, SceneError> {
    let parameters = parameters(root.table("parameters")?)?;
    let initial = match root.optional_table("initial")? {
        Some(section) => start(section, &parameters)?,
        None => SlidingStart::default(),
    };
    Ok(Model::Sliding(Sliding { parameters, initial }))
}

fn parameters(mut section: Section<'_>) -> Result<SlidingParameters, SceneError> {
    section.bounded_by(PARAMETERS);
    let p = numbers!(section, SlidingParameters {
        beam_length_m, beam_width_m, beam_thickness_m, young_modulus_pa, density_kg_per_m3, damping_ratio,
        slider_mass_kg, patch_radius_m, static_friction_active, static_friction_inert, kinetic_friction_active,
        kinetic_friction_inert, dielectric_thickness_m, relative_permittivity, charge_density_c_per_m2;
        force_law: section.force_law()?,
        stick_charge: section.stick_charge()?,
        lateral_force: section.required_flag("lateral_force")?,
    });
    // Kinetic friction above the static one leaves no consistent mode: the slider would let go and stop at once.
    let [active, inert] = ["static_friction_active", "static_friction_inert"];
    for (key, kinetic, other, at_rest) in [
        ("kinetic_friction_active", p.kinetic_friction_active, active, p.static_friction_active),
        ("kinetic_friction_inert", p.kinetic_friction_inert, inert, p.static_friction_inert),
    ] {
        if kinetic > at_rest {
            return Err(section.refuse(key, format!("must not be above {other} = {}", Short(at_rest))));
        }
    }
    bounds::natural_frequency(p.natural_frequency_hz(), "young_modulus_pa", p.young_modulus_pa)
        .map_err(|reason| section.refuse("beam_length_m", reason))?;
    section.finish()?;
    Ok(p)
}

fn start(mut section: Section<'_>, parameters: &SlidingParameters) -> Result<SlidingStart, SceneError> {
    section.bounded_by(INITIAL);
    let start = SlidingStart {
        displacement_m: section.optional_number("displacement_m")?,
        velocity_m_per_s: section.optional_number("velocity_m_per_s")?,
        charge_c: section.optional_number("charge_c")?,
    };
    let reach = 2.0 * parameters.patch_radius_m;
    if start.displacement_m.is_some_and(|displacement| displacement.abs() >= reach) {
        let reason = format!("must be within two patch radii, less than {} in magnitude", Short(reach));
        return Err(section.refuse("displacement_m", reason));
    }
    section.finish()?;
    Ok(start)
}
