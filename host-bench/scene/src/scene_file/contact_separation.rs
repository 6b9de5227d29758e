//! `[parameters]` and `[initial]` of a contact-separation scene.

use super::bounds;
use super::document::SceneError;
use super::scene::{ContactSeparationParameters, ContactSeparationStart, ForceLaw, Restitution, StickCharge};
use super::section::Section;

/// Reads `[parameters]`.
pub(super) fn parameters(mut section: Section<'_>) -> Result<ContactSeparationParameters, SceneError> {
    let mut number = |key| section.number(key, &bounds::of(key));
    let mut parameters = ContactSeparationParameters {
        mass_kg: number("mass_kg")?,
        stiffness_n_per_m: number("stiffness_n_per_m")?,
        damping_ratio: number("damping_ratio")?,
        initial_gap_m: number("initial_gap_m")?,
        electrode_area_m2: number("electrode_area_m2")?,
        dielectric_thickness_m: number("dielectric_thickness_m")?,
        relative_permittivity: number("relative_permittivity")?,
        charge_density_c_per_m2: number("charge_density_c_per_m2")?,
        parasitic_capacitance_f: 0.0,
        force_law: ForceLaw::TransferredCharge,
        stick_charge: StickCharge::Frozen,
        restitution: Restitution::Constant { coefficient: 1.0 },
    };
    let parasitic = "parasitic_capacitance_f";
    parameters.parasitic_capacitance_f =
        section.optional_number(parasitic, &bounds::of(parasitic))?.unwrap_or(0.0);
    parameters.force_law = section.force_law()?;
    parameters.stick_charge = section.stick_charge()?;
    parameters.restitution = restitution(section.table("restitution")?)?;
    bounds::together(&parameters).map_err(|(key, reason)| section.refuse(key, reason))?;
    section.finish()?;
    Ok(parameters)
}

fn restitution(mut section: Section<'_>) -> Result<Restitution, SceneError> {
    let varies = section.choice("kind", &[("constant", false), ("velocity-dependent", true)])?;
    let mut number = |key| section.number(key, &bounds::of(key));
    let restitution = if varies {
        Restitution::VelocityDependent {
            at_rest: number("at_rest")?,
            at_speed: number("at_speed")?,
            reference_speed_m_per_s: number("reference_speed_m_per_s")?,
        }
    } else {
        Restitution::Constant { coefficient: number("coefficient")? }
    };
    section.finish()?;
    Ok(restitution)
}

/// Reads `[initial]`.
pub(super) fn start(mut section: Section<'_>) -> Result<ContactSeparationStart, SceneError> {
    let mut number = |key| section.optional_number(key, &bounds::of(key));
    let start = ContactSeparationStart {
        gap_m: number("gap_m")?,
        velocity_m_per_s: number("velocity_m_per_s")?,
        charge_c: number("charge_c")?,
    };
    section.finish()?;
    Ok(start)
}
