//! `[parameters]` and `[initial]` of a contact-separation scene.

use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{ConstantRestitution, VelocityDependentRestitution};
use model_core::scene::contact_separation::{Parameters, Start};

use super::bounds::{self, CoreTable};
use super::document::SceneError;
use super::key::{Key, Kind, Table, Value, core, number, other};
use super::limits;
use super::scene::{
    ContactSeparation, ContactSeparationParameters, ContactSeparationStart, Model, Restitution,
};
use super::section::{Section, numbers};
use super::triboelectric::{FORCE_LAW, STICK_CHARGE, force_law, stick_charge};

const P: CoreTable = Parameters::<f64, ()>::BOUNDS;
const CONSTANT: CoreTable = ConstantRestitution::<f64>::BOUNDS;
const VARIABLE: CoreTable = VelocityDependentRestitution::<f64>::BOUNDS;
const START: CoreTable = Start::<f64>::BOUNDS;

/// The scene.
pub(super) static KIND: Kind = Kind {
    word: "contact-separation",
    meaning: "A sprung mass that hits a charged dielectric",
    keys: &[
        other("parameters", Value::Table(&PARAMETERS), "The harvester"),
        other("initial", Value::Table(&INITIAL), "The state at the start")
            .or_said("at rest, without voltage"),
        other("limits", Value::Table(&limits::CONTACT_SEPARATION), "The limits of the model")
            .or_said("the defaults below"),
    ],
};

static PARAMETERS: Table = Table::of(&[
    number("mass_kg", "kg", core(P, "mass"), "Moving mass"),
    number("stiffness_n_per_m", "N/m", core(P, "stiffness"), "Stiffness of the spring")
        .limit("natural frequency 1e-3 to 1e4 Hz"),
    number("damping_ratio", "1", core(P, "damping_ratio"), "Damping ratio, c / (2 √(k m))"),
    number("initial_gap_m", "m", core(P, "initial_gap"), "Gap at which the spring is unstretched"),
    number("electrode_area_m2", "m²", core(P, "electrode_area"), "Area of the electrode"),
    number("dielectric_thickness_m", "m", core(P, "dielectric_thickness"), "Thickness of the dielectric"),
    number(
        "relative_permittivity",
        "1",
        core(P, "relative_permittivity"),
        "Relative permittivity of the dielectric",
    ),
    number("charge_density_c_per_m2", "C/m²", core(P, "charge_density"), "Density of the tribo-charge"),
    number(
        "parasitic_capacitance_f",
        "F",
        core(ParasiticCapacitance::<f64>::BOUNDS, "parasitic_capacitance"),
        "Capacitance in parallel with the load",
    )
    .or_number(0.0),
    FORCE_LAW,
    STICK_CHARGE,
    other("restitution", Value::Table(&RESTITUTION), "Coefficient of restitution of the impacts"),
]);

static RESTITUTION: Table = Table::of_kinds(&[&CONSTANT_KIND, &VARIABLE_KIND]);
static CONSTANT_KIND: Kind = Kind {
    word: "constant",
    meaning: "The same at every speed",
    keys: &[number(
        "coefficient",
        "1",
        core(CONSTANT, "restitution.coefficient"),
        "Coefficient of restitution",
    )],
};
static VARIABLE_KIND: Kind = Kind {
    word: "velocity-dependent",
    meaning: "e(v) = at_speed + (at_rest − at_speed) exp(−|v| / reference_speed)",
    keys: &[
        number("at_rest", "1", core(VARIABLE, "restitution.at_rest"), "Coefficient in the limit of no speed"),
        number(
            "at_speed",
            "1",
            core(VARIABLE, "restitution.at_speed"),
            "Coefficient in the limit of high speed",
        ),
        number(
            "reference_speed_m_per_s",
            "m/s",
            core(VARIABLE, "restitution.reference_speed"),
            "Speed over which the coefficient falls by a factor e",
        ),
    ],
};

static INITIAL: Table = Table::of(INITIAL_KEYS);
const INITIAL_KEYS: &[Key] = &[
    number("gap_m", "m", core(START, "gap"), "Gap").or_said("`initial_gap_m`"),
    number("velocity_m_per_s", "m/s", core(START, "velocity"), "Velocity, opening positive").or_number(0.0),
    number("charge_c", "C", core(START, "charge"), "Transferred charge")
        .or_said("that of no voltage at the gap"),
];

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
    let parameters = numbers!(section, ContactSeparationParameters {
        mass_kg, stiffness_n_per_m, damping_ratio, initial_gap_m, electrode_area_m2, dielectric_thickness_m,
        relative_permittivity, charge_density_c_per_m2, parasitic_capacitance_f;
        force_law: force_law(&mut section)?,
        stick_charge: stick_charge(&mut section)?,
        restitution: restitution(section.table("restitution")?)?,
    });
    bounds::natural_frequency(parameters.natural_frequency_hz(), "mass_kg", parameters.mass_kg)
        .map_err(|reason| section.refuse("stiffness_n_per_m", reason))?;
    section.finish()?;
    Ok(parameters)
}

fn restitution(mut section: Section<'_>) -> Result<Restitution, SceneError> {
    let varies = section.kind(&[(&CONSTANT_KIND, false), (&VARIABLE_KIND, true)])?;
    let restitution = if varies {
        numbers!(section, Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s; })
    } else {
        numbers!(section, Restitution::Constant { coefficient; })
    };
    section.finish()?;
    Ok(restitution)
}

fn start(mut section: Section<'_>) -> Result<ContactSeparationStart, SceneError> {
    let start = ContactSeparationStart {
        gap_m: section.optional_number("gap_m")?,
        velocity_m_per_s: section.optional_number("velocity_m_per_s")?,
        charge_c: section.optional_number("charge_c")?,
    };
    section.finish()?;
    Ok(start)
}
