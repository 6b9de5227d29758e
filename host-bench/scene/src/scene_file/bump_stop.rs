//! `[parameters]`, `[stop]` and `[initial]` of a bump-stop scene.

use super::bounds::{self, Bound, Short};
use super::document::SceneError;
use super::modes::BumpStopModes;
use super::scene::{BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, StopParameters};
use super::section::Section;

/// The values that a number of these tables may have.
fn bound(key: &str) -> Bound {
    let [lowest, highest] = match key {
        "beam_length_m" | "beam_width_m" => return bounds::of(key),
        "length_m" | "position_m" => [1e-4, 10.0],
        "width_m" => [1e-5, 10.0],
        "thickness_m" | "substrate_thickness_m" | "piezo_thickness_m" => [1e-7, 1.0],
        "young_modulus_pa" | "substrate_young_modulus_pa" | "piezo_young_modulus_pa" => [1e5, 1e15],
        "density_kg_per_m3" | "substrate_density_kg_per_m3" | "piezo_density_kg_per_m3" => [1.0, 1e5],
        "piezo_d31_m_per_v" => [-1e-8, 1e-8],
        "piezo_permittivity_f_per_m" => [1e-12, 1e-6],
        // The modes swing: their closed forms have no overdamped branch.
        "damping_ratio" => [0.0, 0.9],
        "beam_modes" => [1.0, 20.0],
        "rod_modes" => [0.0, 20.0],
        "gap_m" | "restitution" => [0.0, 1.0],
        "contact_compliance_m_per_n" => [0.0, 1.0],
        "modal_displacement" | "rod_modal_displacement" => [-1e3, 1e3],
        "modal_velocity" | "rod_modal_velocity" | "voltage_v" => [-1e6, 1e6],
        // A key without a line here must not pass unchecked.
        _ => [f64::NAN, f64::NAN],
    };
    Bound::new(lowest, highest)
}

/// Reads the tables of the harvester.
pub(super) fn model(root: &mut Section<'_>) -> Result<BumpStop, SceneError> {
    let parameters = parameters(root.table("parameters")?)?;
    let stop = match root.optional_table("stop")? {
        Some(section) => Some(stop(section, &parameters)?),
        None => None,
    };
    let rod_modes = stop.as_ref().map_or(0, |stop| stop.rod_modes);
    let mut initial = BumpStopStart::at_rest(parameters.beam_modes, rod_modes);
    if let Some(section) = root.optional_table("initial")? {
        start(section, &parameters, stop.as_ref(), &mut initial)?;
    }
    Ok(BumpStop { parameters, stop, initial })
}

fn parameters(mut section: Section<'_>) -> Result<BumpStopParameters, SceneError> {
    let beam_modes = section.whole_number("beam_modes", &bound("beam_modes"))?;
    let coupling =
        section.choice("coupling", &[("two-way", Coupling::TwoWay), ("one-way", Coupling::OneWay)])?;
    let mut number = |key| section.number(key, &bound(key));
    let parameters = BumpStopParameters {
        beam_length_m: number("beam_length_m")?,
        beam_width_m: number("beam_width_m")?,
        substrate_thickness_m: number("substrate_thickness_m")?,
        substrate_young_modulus_pa: number("substrate_young_modulus_pa")?,
        substrate_density_kg_per_m3: number("substrate_density_kg_per_m3")?,
        piezo_thickness_m: number("piezo_thickness_m")?,
        piezo_young_modulus_pa: number("piezo_young_modulus_pa")?,
        piezo_density_kg_per_m3: number("piezo_density_kg_per_m3")?,
        piezo_d31_m_per_v: number("piezo_d31_m_per_v")?,
        piezo_permittivity_f_per_m: number("piezo_permittivity_f_per_m")?,
        damping_ratio: number("damping_ratio")?,
        beam_modes,
        coupling,
    };
    let frequencies = BumpStopModes::new(&parameters, None).natural_frequencies_hz();
    check("beam_length_m", "bending mode", &frequencies).map_err(|(key, why)| section.refuse(key, why))?;
    section.finish()?;
    Ok(parameters)
}

fn stop(mut section: Section<'_>, beam: &BumpStopParameters) -> Result<StopParameters, SceneError> {
    let rod_modes = section.whole_number("rod_modes", &bound("rod_modes"))?;
    let contact = section.choice(
        "contact",
        &[
            ("residual-flexibility", Contact::ResidualFlexibility),
            ("restitution", Contact::Restitution),
            ("displacement-constraint", Contact::DisplacementConstraint),
        ],
    )?;
    let mut optional = |key| section.optional_number(key, &bound(key));
    let compliance = optional("contact_compliance_m_per_n")?.unwrap_or(0.0);
    let restitution = optional("restitution")?;
    let mut number = |key| section.number(key, &bound(key));
    let stop = StopParameters {
        length_m: number("length_m")?,
        width_m: number("width_m")?,
        thickness_m: number("thickness_m")?,
        young_modulus_pa: number("young_modulus_pa")?,
        density_kg_per_m3: number("density_kg_per_m3")?,
        position_m: number("position_m")?,
        gap_m: number("gap_m")?,
        rod_modes,
        contact,
        contact_compliance_m_per_n: compliance,
        restitution,
    };
    let refuse = |key: &str, reason: String| Err(section.refuse(key, reason));
    match (contact, restitution) {
        (Contact::Restitution, None) => {
            let wanted = bound("restitution");
            return refuse(
                "restitution",
                format!("is missing with contact = \"restitution\"; must be {wanted}"),
            );
        }
        (Contact::Restitution, Some(_)) | (_, None) => {}
        (_, Some(_)) => {
            return refuse("restitution", "must be given only with contact = \"restitution\"".to_owned());
        }
    }
    if compliance != 0.0 && contact != Contact::ResidualFlexibility {
        let reason = "must be 0 unless contact = \"residual-flexibility\": the other contacts are rigid";
        return refuse("contact_compliance_m_per_n", reason.to_owned());
    }
    if stop.position_m > beam.beam_length_m {
        let length = Short(beam.beam_length_m);
        return refuse("position_m", format!("must not be above parameters.beam_length_m = {length}"));
    }
    let frequencies = BumpStopModes::new(beam, Some(&stop)).natural_frequencies_hz();
    let rod = frequencies.get(beam.beam_modes..).unwrap_or_default();
    check("length_m", "rod mode", rod).map_err(|(key, why)| section.refuse(key, why))?;
    section.finish()?;
    Ok(stop)
}

/// Whether all frequencies of one body can be stepped; blames `key`.
fn check(key: &'static str, what: &str, frequencies: &[f64]) -> Result<(), (&'static str, String)> {
    let bound = Bound::new(1e-2, 1e8);
    match frequencies.iter().enumerate().find(|(_, frequency)| !bound.contains(**frequency)) {
        Some((index, frequency)) => Err((
            key,
            format!("the frequency of {what} {} is {frequency:.3e} Hz, must be {bound}", index + 1),
        )),
        None => Ok(()),
    }
}

fn start(
    mut section: Section<'_>,
    beam: &BumpStopParameters,
    stop: Option<&StopParameters>,
    start: &mut BumpStopStart,
) -> Result<(), SceneError> {
    for (key, place) in [
        ("modal_displacement", &mut start.modal_displacement),
        ("modal_velocity", &mut start.modal_velocity),
        ("rod_modal_displacement", &mut start.rod_modal_displacement),
        ("rod_modal_velocity", &mut start.rod_modal_velocity),
    ] {
        if let Some(values) = section.optional_numbers(key, &bound(key), place.len(), "mode")? {
            *place = values;
        }
    }
    start.voltage_v = section.optional_number("voltage_v", &bound("voltage_v"))?.unwrap_or(0.0);
    if let Some(stop) = stop {
        let modes = BumpStopModes::new(beam, Some(stop));
        let closed = modes.approach(&start.modal_displacement, &start.rod_modal_displacement);
        if closed > stop.gap_m {
            let key = if section.has("modal_displacement") {
                "modal_displacement"
            } else {
                "rod_modal_displacement"
            };
            return Err(section.refuse(
                key,
                format!(
                    "starts in penetration: beam and rod are {closed:.6e} m closer than at rest, must be at most \
                     stop.gap_m = {}",
                    Short(stop.gap_m)
                ),
            ));
        }
    }
    section.finish()
}
