//! `[parameters]`, `[tip_mass]`, `[stop]` and `[initial]` of a bump-stop scene.

use model_core::scene::bump_stop::{Parameters, Restitution, Start, Stop, TipMass};

use super::bounds::{Bound, CoreTable, Short, between};
use super::document::SceneError;
use super::key::{Kind, Table, Value, core, number, other, whole, words};
use super::limits;
use super::modes::BumpStopModes;
use super::scene::{
    BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, Model, StopParameters, TipMassParameters,
};
use super::section::{Section, numbers};

const P: CoreTable = Parameters::<f64, ()>::BOUNDS;
const ROD: CoreTable = Stop::<f64, ()>::BOUNDS;
const BODY: CoreTable = TipMass::<f64>::BOUNDS;
const START: CoreTable = Start::<f64, 0, 0>::BOUNDS;

const COUPLINGS: [(&str, Coupling); 2] = [("two-way", Coupling::TwoWay), ("one-way", Coupling::OneWay)];
const CONTACTS: [(&str, Contact); 3] = [
    ("residual-flexibility", Contact::ResidualFlexibility),
    ("restitution", Contact::Restitution),
    ("displacement-constraint", Contact::DisplacementConstraint),
];

/// The scene.
pub(super) static KIND: Kind = Kind {
    word: "bump-stop",
    meaning: "A piezoelectric cantilever that hits a rod",
    keys: &[
        other(
            "parameters",
            Value::Table(&PARAMETERS),
            "The cantilever: a substrate and one piezoelectric layer",
        ),
        other("tip_mass", Value::Table(&TIP_MASS), "A rigid body at the free end of the cantilever")
            .or_said("a free end"),
        other("stop", Value::Table(&STOP), "The rod that the cantilever hits")
            .or_said("the cantilever swings freely"),
        other("initial", Value::Table(&INITIAL), "The state at the start")
            .or_said("at rest, without voltage"),
        other("limits", Value::Table(&limits::BUMP_STOP), "The limits of the model")
            .or_said("the defaults below"),
    ],
};

static PARAMETERS: Table = Table::of(&[
    number(
        "beam_length_m",
        "m",
        core(P, "beam_length"),
        "Flexible length: to the tip mass where there is one",
    )
    .limit("mode frequencies 1e-2 to 1e8 Hz"),
    number("beam_width_m", "m", core(P, "beam_width"), "Width of the cantilever"),
    number("substrate_thickness_m", "m", core(P, "substrate_thickness"), "Thickness of the substrate"),
    number(
        "substrate_young_modulus_pa",
        "Pa",
        core(P, "substrate_young_modulus"),
        "Young's modulus of the substrate",
    ),
    number("substrate_density_kg_per_m3", "kg/m³", core(P, "substrate_density"), "Density of the substrate"),
    number("piezo_thickness_m", "m", core(P, "piezo_thickness"), "Thickness of the piezoelectric layer"),
    number(
        "piezo_young_modulus_pa",
        "Pa",
        core(P, "piezo_young_modulus"),
        "Young's modulus of the layer, short circuit",
    ),
    number(
        "piezo_density_kg_per_m3",
        "kg/m³",
        core(P, "piezo_density"),
        "Density of the piezoelectric layer",
    ),
    number(
        "piezo_d31_m_per_v",
        "m/V",
        core(P, "piezo_d31"),
        "Piezoelectric constant d31; its sign does not matter",
    ),
    number(
        "piezo_permittivity_f_per_m",
        "F/m",
        core(P, "piezo_permittivity"),
        "Permittivity ε33 at constant strain",
    ),
    number(
        "damping_ratio",
        "1",
        core(P, "damping_ratio"),
        "Damping ratio of every mode of cantilever and rod",
    ),
    whole("beam_modes", "", between(1.0, 20.0), "Bending modes that are kept"),
    other("coupling", Value::Words(&words(&COUPLINGS)), "Whether the voltage acts back on the cantilever"),
]);

static TIP_MASS: Table = Table::of(&[
    number("mass_kg", "kg", core(BODY, "tip_mass.mass"), "Mass")
        .limit("at most 1e6 masses of the beam; mode frequencies 1e-2 to 1e8 Hz"),
    number(
        "rotary_inertia_kg_m2",
        "kg·m²",
        core(BODY, "tip_mass.rotary_inertia"),
        "Moment of inertia about the body's own centre of mass, in the plane of bending",
    )
    .limit("at most 1e6 masses of the beam times the square of its length")
    .or_number(0.0),
    number("offset_m", "m", core(BODY, "tip_mass.offset"), "Centre of mass beyond the end of the cantilever")
        .limit("at most 10 lengths of the beam")
        .or_number(0.0),
]);

static STOP: Table = Table::of(&[
    number("length_m", "m", core(ROD, "stop.length"), "Length of the rod")
        .limit("mode frequencies 1e-2 to 1e8 Hz"),
    // The core has one cross section for the width and the thickness of the rod.
    number("width_m", "m", between(1e-5, 10.0), "Width of the rod"),
    number("thickness_m", "m", between(1e-7, 1.0), "Thickness of the rod"),
    number("young_modulus_pa", "Pa", core(ROD, "stop.young_modulus"), "Young's modulus of the rod"),
    number("density_kg_per_m3", "kg/m³", core(ROD, "stop.density"), "Density of the rod"),
    number("position_m", "m", core(ROD, "stop.length"), "Contact's distance from the clamp")
        .limit("at most `beam_length_m`"),
    number("gap_m", "m", core(ROD, "stop.gap"), "Gap between cantilever and rod, both at rest"),
    whole(
        "rod_modes",
        "",
        between(0.0, 20.0),
        "Longitudinal modes of the rod that are kept; 0: a rod without mass",
    ),
    other("contact", Value::Words(&words(&CONTACTS)), "How the contact is closed"),
    number("contact_compliance_m_per_n", "m/N", core(ROD, "stop.contact_compliance"), "Compliance in series")
        .limit("0 unless `contact = \"residual-flexibility\"`")
        .or_number(0.0),
    number("restitution", "1", core(Restitution::<f64>::BOUNDS, "restitution"), "Coefficient of restitution")
        .limit("only with `contact = \"restitution\"`, and then required")
        .or_said("none"),
]);

static INITIAL: Table = Table::of(&[
    other(
        "modal_displacement",
        Value::Numbers(core(START, "modal displacement"), "mode"),
        "Modal displacements of the cantilever, one for each mode",
    )
    .unit("√kg·m")
    .or_said("0"),
    other(
        "modal_velocity",
        Value::Numbers(core(START, "modal velocity"), "mode"),
        "Modal velocities of the cantilever, one for each mode",
    )
    .unit("√kg·m/s")
    .or_said("0"),
    other(
        "rod_modal_displacement",
        Value::Numbers(core(START, "modal displacement"), "mode"),
        "Modal displacements of the rod, one for each mode",
    )
    .unit("√kg·m")
    .or_said("0"),
    other(
        "rod_modal_velocity",
        Value::Numbers(core(START, "modal velocity"), "mode"),
        "Modal velocities of the rod, one for each mode",
    )
    .unit("√kg·m/s")
    .or_said("0"),
    number("voltage_v", "V", core(START, "voltage"), "Voltage").or_number(0.0),
]);

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
    let parameters = numbers!(section, BumpStopParameters {
        beam_length_m, beam_width_m, substrate_thickness_m, substrate_young_modulus_pa,
        substrate_density_kg_per_m3, piezo_thickness_m, piezo_young_modulus_pa, piezo_density_kg_per_m3,
        piezo_d31_m_per_v, piezo_permittivity_f_per_m, damping_ratio;
        beam_modes: section.whole_number("beam_modes")?,
        coupling: section.choice("coupling", &COUPLINGS)?,
        tip_mass: None,
    });
    let [frequencies, _] = BumpStopModes::new(&parameters, None).natural_frequencies_hz();
    check(&section, "beam_length_m", "bending mode", &frequencies)?;
    section.finish()?;
    Ok(parameters)
}

/// Reads the tip mass of a beam that has none so far.
fn tip_mass(mut section: Section<'_>, beam: &BumpStopParameters) -> Result<TipMassParameters, SceneError> {
    let body = TipMassParameters {
        mass_kg: section.number("mass_kg")?,
        rotary_inertia_kg_m2: section.number("rotary_inertia_kg_m2")?,
        offset_m: section.number("offset_m")?,
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
    let stop = numbers!(section, StopParameters {
        length_m, width_m, thickness_m, young_modulus_pa, density_kg_per_m3, position_m, gap_m,
        contact_compliance_m_per_n;
        rod_modes: section.whole_number("rod_modes")?,
        contact: section.choice("contact", &CONTACTS)?,
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
    for (key, place) in [
        ("modal_displacement", &mut start.modal_displacement),
        ("modal_velocity", &mut start.modal_velocity),
        ("rod_modal_displacement", &mut start.rod_modal_displacement),
        ("rod_modal_velocity", &mut start.rod_modal_velocity),
    ] {
        if let Some(values) = section.optional_numbers(key, place.len())? {
            *place = values;
        }
    }
    start.voltage_v = section.number("voltage_v")?;
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
