//! `[parameters]`, `[tip_mass]`, `[stop]` and `[initial]` of a bump-stop scene.

use model_core::scene::bump_stop::{Parameters, Restitution, Start, Stop, TipMass};

use super::bounds::{Bound, Short, Table, between};
use super::document::SceneError;
use super::modes::BumpStopModes;
use super::scene::{
    BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, Model, StopParameters, TipMassParameters,
};
use super::section::{Section, numbers};

const PARAMETERS: &[Table] = &[Parameters::<f64, ()>::BOUNDS, &[("beam_modes", between(1.0, 20.0))]];
/// The core has one cross section for the width and the thickness of the rod.
const STOP: &[Table] = &[
    Stop::<f64, ()>::BOUNDS,
    Restitution::<f64>::BOUNDS,
    &[
        ("width_m", between(1e-5, 10.0)),
        ("thickness_m", between(1e-7, 1.0)),
        ("rod_modes", between(0.0, 20.0)),
    ],
];

/// Natural frequencies in Hz of the modes that can be stepped.
const FREQUENCY: model_core::bounds::Bounds<f64> = between(1e-2, 1e8);

/// Reads the tables of the harvester.
pub(super) fn model(root: &mut Section<'_>) -> Result<Model, SceneError> {
    let mut parameters = parameters(root.table("parameters")?)?;
    if let Some(section) = root.optional_table("tip_mass")? {
        parameters.tip_mass = Some(tip_mass(section, &parameters)?);
    }
    let stop = match root.optional_table("stop")? {
        Some(section) => Some(stop(section, &parameters)?),
        None => None,
    };
    let rod_modes = stop.as_ref().map_or(0, |stop| stop.rod_modes);
    let mut initial = BumpStopStart::at_rest(parameters.beam_modes, rod_modes);
    if let Some(section) = root.optional_table("initial")? {
        start(section, &parameters, stop.as_ref(), &mut initial)?;
    }
    Ok(Model::BumpStop(BumpStop { parameters, stop, initial }))
}

fn parameters(mut section: Section<'_>) -> Result<BumpStopParameters, SceneError> {
    let couplings = [("two-way", Coupling::TwoWay), ("one-way", Coupling::OneWay)];
    section.bounded_by(PARAMETERS);
    let parameters = numbers!(section, BumpStopParameters {
        beam_length_m, beam_width_m, substrate_thickness_m, substrate_young_modulus_pa,
        substrate_density_kg_per_m3, piezo_thickness_m, piezo_young_modulus_pa, piezo_density_kg_per_m3,
        piezo_d31_m_per_v, piezo_permittivity_f_per_m, damping_ratio;
        beam_modes: section.whole_number("beam_modes")?,
        coupling: section.choice("coupling", &couplings)?,
        tip_mass: None,
    });
    let [frequencies, _] = BumpStopModes::new(&parameters, None).natural_frequencies_hz();
    check(&section, "beam_length_m", "bending mode", &frequencies)?;
    section.finish()?;
    Ok(parameters)
}

/// Reads the tip mass of a beam that has none so far.
fn tip_mass(mut section: Section<'_>, beam: &BumpStopParameters) -> Result<TipMassParameters, SceneError> {
    section.bounded_by(&[TipMass::<f64>::BOUNDS]);
    let body = TipMassParameters {
        mass_kg: section.number("mass_kg")?,
        rotary_inertia_kg_m2: section.number_or("rotary_inertia_kg_m2", Some(0.0))?,
        offset_m: section.number_or("offset_m", Some(0.0))?,
    };
    let mass = BumpStopModes::new(beam, None).beam_mass;
    let length = beam.beam_length_m;
    let [masses, inertias, lengths] = TipMass::<f64>::LARGEST_RATIOS;
    for (key, value, largest, of) in [
        ("mass_kg", body.mass_kg, masses * mass, format!("{masses:e} masses of the beam")),
        (
            "rotary_inertia_kg_m2",
            body.rotary_inertia_kg_m2,
            inertias * mass * length * length,
            format!("{inertias:e} masses of the beam times the square of its length"),
        ),
        ("offset_m", body.offset_m, lengths * length, format!("{lengths} lengths of the beam")),
    ] {
        if value > largest {
            let reason = format!("must be at most {}, {of}", Short(largest));
            return Err(section.refuse(key, reason));
        }
    }
    let with = BumpStopParameters { tip_mass: Some(body), ..*beam };
    let [frequencies, _] = BumpStopModes::new(&with, None).natural_frequencies_hz();
    check(&section, "mass_kg", "bending mode", &frequencies)?;
    section.finish()?;
    Ok(body)
}

fn stop(mut section: Section<'_>, beam: &BumpStopParameters) -> Result<StopParameters, SceneError> {
    let contacts = [
        ("residual-flexibility", Contact::ResidualFlexibility),
        ("restitution", Contact::Restitution),
        ("displacement-constraint", Contact::DisplacementConstraint),
    ];
    section.bounded_by(STOP);
    let stop = numbers!(section, StopParameters {
        length_m, width_m, thickness_m, young_modulus_pa, density_kg_per_m3, position_m, gap_m;
        rod_modes: section.whole_number("rod_modes")?,
        contact: section.choice("contact", &contacts)?,
        contact_compliance_m_per_n: section.optional_number("contact_compliance_m_per_n")?.unwrap_or(0.0),
        restitution: section.optional_number("restitution")?,
    });
    let refuse = |key: &str, reason: String| Err(section.refuse(key, reason));
    match (stop.contact, stop.restitution) {
        (Contact::Restitution, None) => {
            let reason = format!(
                "is missing with contact = \"restitution\"; must be {}",
                section.bound("restitution")
            );
            return refuse("restitution", reason);
        }
        (Contact::Restitution, Some(_)) | (_, None) => {}
        (_, Some(_)) => {
            return refuse("restitution", "must be given only with contact = \"restitution\"".to_owned());
        }
    }
    if stop.contact_compliance_m_per_n != 0.0 && stop.contact != Contact::ResidualFlexibility {
        let reason = "must be 0 unless contact = \"residual-flexibility\": the other contacts are rigid";
        return refuse("contact_compliance_m_per_n", reason.to_owned());
    }
    if stop.position_m > beam.beam_length_m {
        let length = Short(beam.beam_length_m);
        return refuse("position_m", format!("must not be above parameters.beam_length_m = {length}"));
    }
    let [_, frequencies] = BumpStopModes::new(beam, Some(&stop)).natural_frequencies_hz();
    check(&section, "length_m", "rod mode", &frequencies)?;
    section.finish()?;
    Ok(stop)
}

/// Refuses a body with a mode of a frequency that cannot be stepped; `key` is blamed.
fn check(section: &Section<'_>, key: &str, what: &str, frequencies: &[f64]) -> Result<(), SceneError> {
    let bound = Bound::from(FREQUENCY);
    match (1..).zip(frequencies).find(|(_, frequency)| !bound.contains(**frequency)) {
        Some((number, frequency)) => {
            let reason = format!("the frequency of {what} {number} is {frequency:.3e} Hz, must be {bound}");
            Err(section.refuse(key, reason))
        }
        None => Ok(()),
    }
}

fn start(
    mut section: Section<'_>,
    beam: &BumpStopParameters,
    stop: Option<&StopParameters>,
    start: &mut BumpStopStart,
) -> Result<(), SceneError> {
    section.bounded_by(&[Start::<f64, 0, 0>::BOUNDS]);
    for (key, place) in [
        ("modal_displacement", &mut start.modal_displacement),
        ("modal_velocity", &mut start.modal_velocity),
        ("rod_modal_displacement", &mut start.rod_modal_displacement),
        ("rod_modal_velocity", &mut start.rod_modal_velocity),
    ] {
        if let Some(values) = section.optional_numbers(key, place.len(), "mode")? {
            *place = values;
        }
    }
    start.voltage_v = section.optional_number("voltage_v")?.unwrap_or(0.0);
    if let Some(stop) = stop {
        let modes = BumpStopModes::new(beam, Some(stop));
        let closed = modes.approach(&start.modal_displacement, &start.rod_modal_displacement);
        if closed > stop.gap_m {
            let beam_given = section.has("modal_displacement");
            let key = if beam_given { "modal_displacement" } else { "rod_modal_displacement" };
            let reason = format!(
                "starts in penetration: beam and rod are {closed:.6e} m closer than at rest, must be at most \
                 stop.gap_m = {}",
                Short(stop.gap_m)
            );
            return Err(section.refuse(key, reason));
        }
    }
    section.finish()
}
