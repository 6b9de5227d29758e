//! `[parameters]` and `[initial]` of a sliding scene.

use model_core::part::friction::PatchFriction;
use model_core::scene::sliding::{Parameters, Start};

use super::bounds::{self, CoreTable, Short, between};
use super::document::SceneError;
use super::key::{Kind, Table, Value, core, number, other};
use super::limits;
use super::scene::{Model, Sliding, SlidingParameters, SlidingStart};
use super::section::{Section, numbers};
use super::triboelectric::{FORCE_LAW, STICK_CHARGE, force_law, stick_charge};

const P: CoreTable = Parameters::<f64, ()>::BOUNDS;
const FRICTION: CoreTable = PatchFriction::<f64>::BOUNDS;
const START: CoreTable = Start::<f64>::BOUNDS;

/// The scene.
pub(super) static KIND: Kind = Kind {
    word: "sliding",
    meaning: "A charged disc at the tip of a cantilever that rubs over an electrode and an inert patch",
    keys: &[
        other("parameters", Value::Table(&PARAMETERS), "The harvester"),
        other("initial", Value::Table(&INITIAL), "The state at the start")
            .or_said("at rest, without voltage"),
        other("limits", Value::Table(&limits::SLIDING), "The limits of the model")
            .or_said("the defaults below"),
    ],
};

static PARAMETERS: Table = Table::of(&[
    number("beam_length_m", "m", core(P, "beam_length"), "Length of the cantilever")
        .limit("natural frequency 1e-3 to 1e4 Hz"),
    number("beam_width_m", "m", core(P, "beam_width"), "Width of the cantilever"),
    number("beam_thickness_m", "m", core(P, "beam_thickness"), "Thickness of the cantilever"),
    number("young_modulus_pa", "Pa", core(P, "young_modulus"), "Young's modulus of the cantilever"),
    number("density_kg_per_m3", "kg/m³", core(P, "density"), "Density of the cantilever"),
    number("damping_ratio", "1", core(P, "damping_ratio"), "Damping ratio, without friction"),
    number("slider_mass_kg", "kg", core(P, "slider_mass"), "Mass at the tip"),
    number("patch_radius_m", "m", core(P, "patch_radius"), "Radius of the slider and of each patch"),
    number(
        "static_friction_active",
        "1",
        core(FRICTION, "static_friction_active"),
        "Static friction on the electrode",
    ),
    number(
        "static_friction_inert",
        "1",
        core(FRICTION, "static_friction_inert"),
        "Static friction on the inert patch",
    ),
    // These have the bounds of what each may at most be; the reader compares the two.
    number(
        "kinetic_friction_active",
        "1",
        core(FRICTION, "static_friction_active"),
        "Kinetic friction on the electrode",
    )
    .limit("at most `static_friction_active`"),
    number(
        "kinetic_friction_inert",
        "1",
        core(FRICTION, "static_friction_inert"),
        "Kinetic friction on the inert patch",
    )
    .limit("at most `static_friction_inert`"),
    number("dielectric_thickness_m", "m", core(P, "dielectric_thickness"), "Thickness of the dielectric"),
    number(
        "relative_permittivity",
        "1",
        core(P, "relative_permittivity"),
        "Relative permittivity of the dielectric",
    ),
    number("charge_density_c_per_m2", "C/m²", core(P, "charge_density"), "Density of the tribo-charge"),
    FORCE_LAW,
    STICK_CHARGE,
    other("lateral_force", Value::Flag, "Whether the field's force along the patch acts on the slider"),
]);

static INITIAL: Table = Table::of(&[
    // Twice the largest patch radius; the radius of the scene is checked beside it.
    number("displacement_m", "m", between(-2.0, 2.0), "Displacement of the slider")
        .limit("magnitude below two patch radii")
        .or_number(0.0),
    number("velocity_m_per_s", "m/s", core(START, "velocity"), "Velocity of the slider").or_number(0.0),
    number("charge_c", "C", core(START, "charge"), "Transferred charge")
        .or_said("that of no voltage at the displacement"),
]);

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
    let p = numbers!(section, SlidingParameters {
        beam_length_m, beam_width_m, beam_thickness_m, young_modulus_pa, density_kg_per_m3, damping_ratio,
        slider_mass_kg, patch_radius_m, static_friction_active, static_friction_inert, kinetic_friction_active,
        kinetic_friction_inert, dielectric_thickness_m, relative_permittivity, charge_density_c_per_m2;
        force_law: force_law(&mut section)?,
        stick_charge: stick_charge(&mut section)?,
        lateral_force: section.flag("lateral_force")?,
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
