//! `[parameters]`, `[tip_mass]`, `[stop]` and `[initial]` of a bump-stop scene.

pub use model_core::part::monomorph::Bimorph;
pub use model_core::scene::bump_stop::AnyCoupling as Coupling;
use model_core::scene::bump_stop::{Restitution, Start, Stop, TipMass};

use super::document::SceneError;
use super::key::{
    Bound, CoreTable, Key, Kind, Short, Table, Value, between, core, joined, number, of_rows, other, whole,
    words,
};
use super::limits;
use super::modes::BumpStopModes;
use super::section::{Section, numbers};
use super::{BEAM_KEYS, Summary};

const ROD: CoreTable = Stop::<f64, ()>::BOUNDS;
const START: CoreTable = Start::<f64, 0, 0>::BOUNDS;

const COUPLINGS: [(&str, Coupling); 2] = [("two-way", Coupling::TwoWay), ("one-way", Coupling::OneWay)];
const TRANSDUCERS: [(&str, Option<Bimorph>); 3] = [
    ("monomorph", None),
    ("bimorph-series", Some(Bimorph::Series)),
    ("bimorph-parallel", Some(Bimorph::Parallel)),
];
const CONTACTS: [(&str, Contact); 3] = [
    ("residual-flexibility", Contact::ResidualFlexibility),
    ("restitution", Contact::Restitution),
    ("displacement-constraint", Contact::DisplacementConstraint),
];

/// A bump-stop harvester and the state it starts in.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpStop {
    /// Table `[parameters]`.
    pub parameters: BumpStopParameters,
    /// Table `[stop]`; `None`: the beam swings freely.
    pub stop: Option<StopParameters>,
    /// Table `[initial]`.
    pub initial: BumpStopStart,
}

impl BumpStop {
    /// Numbers of modes of beam and rod.
    pub fn modes(&self) -> [usize; 2] {
        [self.parameters.beam_modes, self.stop.map_or(0, |stop| stop.rod_modes)]
    }

    pub(super) fn summary(&self) -> Summary {
        let gap = self.stop.as_ref().map(|stop| stop.gap_m);
        Summary {
            name: KIND.word,
            rest_m: 0.0,
            length_m: gap.unwrap_or(0.0),
            range_m: [f64::NEG_INFINITY, gap.unwrap_or(f64::INFINITY)],
            start: None,
            start_key: "initial.modal_displacement.0",
            frequency_keys: BEAM_KEYS,
            damping_ratio: self.parameters.damping_ratio,
            charge_density_c_per_m2: None,
            not_conserved: None,
        }
    }
}

model_core::bump_stop_numbers! { of_rows! {
    /// `[parameters]` of a bump-stop scene: a cantilever of a substrate and one or two piezoelectric layers, all of
    /// its full length and width. The electrodes are taken so that the voltage rises as the tip moves towards the stop.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BumpStopParameters {
        /// Bending modes kept.
        pub beam_modes: usize,
        /// Whether the voltage acts back on the beam.
        pub coupling: Coupling,
        /// `None`: one layer, on one side.
        pub transducer: Option<Bimorph>,
        /// Table `[tip_mass]`; `None`: a free end.
        pub tip_mass: Option<TipMassParameters>,
    }
} }

model_core::tip_mass_numbers! { of_rows! {
    /// `[tip_mass]` of a bump-stop scene: a rigid body at the free end of the beam.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TipMassParameters {}
} }

impl BumpStopParameters {
    /// How many layers there are, and how many of them are in series between the terminals.
    pub fn layers(&self) -> [f64; 2] {
        match self.transducer {
            None => [1.0, 1.0],
            Some(Bimorph::Series) => [2.0, 2.0],
            Some(Bimorph::Parallel) => [2.0, 1.0],
        }
    }
}

/// `[stop]` of a bump-stop scene: an elastic rod that stands on the base, its face beside the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopParameters {
    /// Length of the rod in m.
    pub length_m: f64,
    /// Width of the rod in m.
    pub width_m: f64,
    /// Thickness of the rod in m.
    pub thickness_m: f64,
    /// Young's modulus of the rod in Pa.
    pub young_modulus_pa: f64,
    /// Density of the rod in kg/m³.
    pub density_kg_per_m3: f64,
    /// Distance in m of the point of contact from the clamp, at most the length of the beam.
    pub position_m: f64,
    /// Distance in m between beam and rod, both at rest.
    pub gap_m: f64,
    /// Longitudinal modes of the rod that are kept; 0: a rod without mass.
    pub rod_modes: usize,
    /// How the contact is closed.
    pub contact: Contact,
    /// Compliance in m/N in series with the contact, beside that of the modes left out.
    pub contact_compliance_m_per_n: f64,
    /// Coefficient of restitution, 0 to 1; there under [`Contact::Restitution`], and only there.
    pub restitution: Option<f64>,
}

/// How a contact is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// Through the static compliance of the modes that are left out.
    ResidualFlexibility,
    /// Rigidly, by impacts between the modes that are kept.
    Restitution,
    /// By a force in each time step that makes the gap zero at its end: the paper's method.
    DisplacementConstraint,
}

/// `[initial]` of a bump-stop scene.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpStopStart {
    /// Modal displacements of the beam in √kg·m, one for each mode.
    pub modal_displacement: Vec<f64>,
    /// Modal velocities of the beam in √kg·m/s, one for each mode.
    pub modal_velocity: Vec<f64>,
    /// Modal displacements of the rod in √kg·m, one for each mode.
    pub rod_modal_displacement: Vec<f64>,
    /// Modal velocities of the rod in √kg·m/s, one for each mode.
    pub rod_modal_velocity: Vec<f64>,
    /// Voltage in V; behind a short circuit there is none.
    pub voltage_v: f64,
}

impl BumpStopStart {
    /// At rest, without voltage.
    pub fn at_rest(beam_modes: usize, rod_modes: usize) -> Self {
        Self {
            modal_displacement: vec![0.0; beam_modes],
            modal_velocity: vec![0.0; beam_modes],
            rod_modal_displacement: vec![0.0; rod_modes],
            rod_modal_velocity: vec![0.0; rod_modes],
            voltage_v: 0.0,
        }
    }
}

pub(super) static KIND: Kind = Kind {
    word: "bump-stop",
    meaning: "A piezoelectric cantilever that hits a rod",
    keys: &[
        other(
            "parameters",
            Value::Table(&PARAMETERS),
            "The cantilever: a substrate and its piezoelectric layers",
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

static PARAMETERS: Table = Table::of(&joined::<14>(&[
    &model_core::bump_stop_numbers!(of_rows! { keys }),
    &[
        whole("beam_modes", "", between(1.0, 20.0), "Bending modes that are kept"),
        other(
            "coupling",
            Value::Words(&words(&COUPLINGS)),
            "Whether the voltage acts back on the cantilever",
        ),
        other("transducer", Value::Words(&words(&TRANSDUCERS)), "Piezoelectric layers, each as in `piezo_…`")
            .or_said("monomorph"),
    ],
]));

const BODY: [Key; 3] = model_core::tip_mass_numbers!(of_rows! { keys });
static TIP_MASS: Table = Table::of(&[BODY[0], BODY[1].or_number(0.0), BODY[2].or_number(0.0)]);

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

/// A list with a number for each mode; unit and the core's name of the bounds.
const fn of_modes(name: &'static str, [unit, bounds]: [&'static str; 2], meaning: &'static str) -> Key {
    other(name, Value::Numbers(core(START, bounds), "mode"), meaning).unit(unit).or_said("0")
}

const DISPLACEMENT: [&str; 2] = ["√kg·m", "modal displacement"];
const VELOCITY: [&str; 2] = ["√kg·m/s", "modal velocity"];

static INITIAL: Table = Table::of(&[
    of_modes("modal_displacement", DISPLACEMENT, "Modal displacements of the cantilever, one for each mode"),
    of_modes("modal_velocity", VELOCITY, "Modal velocities of the cantilever, one for each mode"),
    of_modes("rod_modal_displacement", DISPLACEMENT, "Modal displacements of the rod, one for each mode"),
    of_modes("rod_modal_velocity", VELOCITY, "Modal velocities of the rod, one for each mode"),
    number("voltage_v", "V", core(START, "voltage"), "Voltage").or_number(0.0),
]);

/// Natural frequencies in Hz of the modes that can be stepped.
const FREQUENCY: model_core::bounds::Bounds<f64> = between(1e-2, 1e8);

pub(super) fn model(root: &mut Section<'_>) -> Result<BumpStop, SceneError> {
    let mut parameters = parameters(root.table("parameters")?)?;
    if let Some(section) = root.optional_table("tip_mass")? {
        parameters.tip_mass = Some(tip_mass(section, &parameters)?);
    }
    let stop = root.optional_table("stop")?.map(|section| stop(section, &parameters)).transpose()?;
    let rod_modes = stop.as_ref().map_or(0, |stop| stop.rod_modes);
    let mut initial = BumpStopStart::at_rest(parameters.beam_modes, rod_modes);
    if let Some(section) = root.optional_table("initial")? {
        start(section, &parameters, stop.as_ref(), &mut initial)?;
    }
    Ok(BumpStop { parameters, stop, initial })
}

fn parameters(mut section: Section<'_>) -> Result<BumpStopParameters, SceneError> {
    let parameters = model_core::bump_stop_numbers!(of_rows! { read section BumpStopParameters {
        beam_modes: section.whole_number("beam_modes")?,
        coupling: section.choice("coupling", &COUPLINGS)?,
        transducer: if section.has("transducer") {
            section.choice("transducer", &TRANSDUCERS)?
        } else {
            None
        },
        tip_mass: None,
    } });
    let [frequencies, _] = BumpStopModes::new(&parameters, None).natural_frequencies_hz();
    check(&section, "beam_length_m", "bending mode", &frequencies)?;
    section.finish()?;
    Ok(parameters)
}

/// Reads the tip mass of a beam that has none so far.
fn tip_mass(mut section: Section<'_>, beam: &BumpStopParameters) -> Result<TipMassParameters, SceneError> {
    let body = model_core::tip_mass_numbers!(of_rows! { read section TipMassParameters {} });
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
