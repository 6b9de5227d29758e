//! `[parameters]` and `[initial]` of a contact-separation scene.

use std::f64::consts::TAU;

use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{ConstantRestitution, VelocityDependentRestitution};
use model_core::scene::contact_separation::{Parameters, Start};

use super::bounds::{self, Table};
use super::document::SceneError;
use super::scene::{
    ContactSeparation, ContactSeparationParameters, ContactSeparationStart, Model, Restitution,
};
use super::section::{Section, numbers};

const PARAMETERS: &[Table] = &[Parameters::<f64, ()>::BOUNDS, ParasiticCapacitance::<f64>::BOUNDS];
const RESTITUTION: &[Table] =
    &[ConstantRestitution::<f64>::BOUNDS, VelocityDependentRestitution::<f64>::BOUNDS];

/// Reads the tables of the harvester.
pub(super) fn model(root: &mut Section<'_>) -> Result<Model, SceneError> {
    let parameters = parameters(root.table("parameters")?)?;
    let initial = match root.optional_table("initial")? {
        Some(section) => start(section)?,
        None => ContactSeparationStart::default(),
    };
    Ok(Model::ContactSeparation(ContactSeparation { parameters, initial }))
}

fn parameters(mut section: Section<'_>) -> Result<ContactSeparationParameters, SceneError> {
    section.bounded_by(PARAMETERS);
    let parameters = numbers!(section, ContactSeparationParameters {
        mass_kg, stiffness_n_per_m, damping_ratio, initial_gap_m, electrode_area_m2, dielectric_thickness_m,
        relative_permittivity, charge_density_c_per_m2;
        parasitic_capacitance_f: section.optional_number("parasitic_capacitance_f")?.unwrap_or(0.0),
        force_law: section.force_law()?,
        stick_charge: section.stick_charge()?,
        restitution: restitution(section.table("restitution")?)?,
    });
    let frequency = (parameters.stiffness_n_per_m / parameters.mass_kg).sqrt() / TAU;
    bounds::natural_frequency(frequency, "mass_kg", parameters.mass_kg)
        .map_err(|reason| section.refuse("stiffness_n_per_m", reason))?;
    section.finish()?;
    Ok(parameters)
}

fn restitution(mut section: Section<'_>) -> Result<Restitution, SceneError> {
    section.bounded_by(RESTITUTION);
    let varies = section.choice("kind", &[("constant", false), ("velocity-dependent", true)])?;
    let restitution = if varies {
        numbers!(section, Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s; })
    } else {
        numbers!(section, Restitution::Constant { coefficient; })
    };
    section.finish()?;
    Ok(restitution)
}

fn start(mut section: Section<'_>) -> Result<ContactSeparationStart, SceneError> {
    section.bounded_by(&[Start::<f64>::BOUNDS]);
    let start = ContactSeparationStart {
        gap_m: section.optional_number("gap_m")?,
        velocity_m_per_s: section.optional_number("velocity_m_per_s")?,
        charge_c: section.optional_number("charge_c")?,
    };
    section.finish()?;
    Ok(start)
}
