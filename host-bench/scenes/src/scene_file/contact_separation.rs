//! `[parameters]` and `[initial]` of a contact-separation scene.

use model_core::part::parasitic::ParasiticCapacitance;
use model_core::scene::contact_separation::Start;

use super::Summary;
use super::document::SceneError;
use super::key::{CoreTable, Kind, Table, Value, between, core, joined, number, of_rows, other};
use super::limits;
use super::section::Section;
use super::triboelectric::{
    FORCE_LAW, ForceLaw, STICK_CHARGE, StickCharge, TriboelectricStart, force_law, natural_frequency, start,
    stick_charge, tables,
};

const START: CoreTable = Start::<f64>::BOUNDS;

/// A contact-separation harvester and the state it starts in.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSeparation {
    /// Table `[parameters]`.
    pub parameters: ContactSeparationParameters,
    /// Table `[initial]`.
    pub initial: TriboelectricStart,
}

model_core::contact_separation_numbers! { of_rows! {
    /// `[parameters]` of a contact-separation scene.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ContactSeparationParameters {
        /// Capacitance in parallel with the load, in F.
        pub parasitic_capacitance_f: f64,
        /// Electrostatic force law.
        pub force_law: ForceLaw,
        /// What the charge does while the mass is held on the dielectric.
        pub stick_charge: StickCharge,
        /// Coefficient of restitution.
        pub restitution: Restitution,
    }
} }

impl ContactSeparationParameters {
    /// Natural frequency in Hz of the mass on its spring, undamped and without the electrostatic force.
    pub fn natural_frequency_hz(&self) -> f64 {
        (self.stiffness_n_per_m / self.mass_kg).sqrt() / std::f64::consts::TAU
    }
}

impl ContactSeparation {
    pub(super) fn summary(&self) -> Summary {
        let from = &self.parameters;
        let TriboelectricStart { position_m, velocity_m_per_s, charge_c } = self.initial;
        let law = match from.force_law {
            ForceLaw::GapField => None,
            ForceLaw::TransferredCharge => Some("force_law = \"transferred-charge\""),
            ForceLaw::None => Some("force_law = \"none\""),
        };
        Summary {
            name: KIND.word,
            rest_m: from.initial_gap_m,
            length_m: from.initial_gap_m,
            range_m: [0.0, f64::INFINITY],
            start: Some([position_m, velocity_m_per_s, charge_c]),
            start_key: "initial.gap_m",
            frequency_keys: "parameters.mass_kg and parameters.stiffness_n_per_m",
            damping_ratio: from.damping_ratio,
            charge_density_c_per_m2: Some(from.charge_density_c_per_m2),
            not_conserved: law.map(|law| [law, "\"gap-field\""]),
        }
    }
}

/// Coefficient of restitution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Restitution {
    /// The same at every speed.
    Constant { coefficient: f64 },
    /// `e(v) = at_speed + (at_rest − at_speed) exp(−|v| / reference_speed)`.
    VelocityDependent {
        /// Coefficient in the limit of no speed, 0 to 1.
        at_rest: f64,
        /// Coefficient in the limit of high speed, 0 to 1.
        at_speed: f64,
        /// Speed in m/s over which it falls by a factor e.
        reference_speed_m_per_s: f64,
    },
}

pub(super) static KIND: Kind = Kind {
    word: "contact-separation",
    meaning: "A sprung mass that hits a charged dielectric",
    keys: &tables(&PARAMETERS, &INITIAL, &limits::CONTACT_SEPARATION),
};

static PARAMETERS: Table = Table::of(&joined::<12>(&[
    &model_core::contact_separation_numbers!(of_rows! { keys }),
    &[
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
    ],
]));

static RESTITUTION: Table = Table::of_kinds(&[&CONSTANT_KIND, &VARIABLE_KIND]);
static CONSTANT_KIND: Kind = Kind {
    word: "constant",
    meaning: "The same at every speed",
    keys: &model_core::constant_restitution_numbers!(of_rows! { keys }),
};
static VARIABLE_KIND: Kind = Kind {
    word: "velocity-dependent",
    meaning: "e(v) = at_speed + (at_rest − at_speed) exp(−|v| / reference_speed)",
    keys: &model_core::variable_restitution_numbers!(of_rows! { keys }),
};

static INITIAL: Table = Table::of(&[
    number("gap_m", "m", core(START, "gap"), "Gap").or_said("`initial_gap_m`"),
    number("velocity_m_per_s", "m/s", core(START, "velocity"), "Velocity, opening positive").or_number(0.0),
    number("charge_c", "C", core(START, "charge"), "Transferred charge")
        .or_said("that of no voltage at the gap"),
]);

pub(super) fn model(root: &mut Section<'_>) -> Result<ContactSeparation, SceneError> {
    let parameters = parameters(root.table("parameters")?)?;
    Ok(ContactSeparation { parameters, initial: start(root, "gap_m", f64::INFINITY)? })
}

fn parameters(mut section: Section<'_>) -> Result<ContactSeparationParameters, SceneError> {
    let parameters =
        model_core::contact_separation_numbers!(of_rows! { read section ContactSeparationParameters {
            parasitic_capacitance_f: section.number("parasitic_capacitance_f")?,
            force_law: force_law(&mut section)?,
            stick_charge: stick_charge(&mut section)?,
            restitution: restitution(section.table("restitution")?)?,
        } });
    natural_frequency(parameters.natural_frequency_hz(), "mass_kg", parameters.mass_kg)
        .map_err(|reason| section.refuse("stiffness_n_per_m", reason))?;
    section.finish()?;
    Ok(parameters)
}

fn restitution(mut section: Section<'_>) -> Result<Restitution, SceneError> {
    let varies = section.kind(&[(&CONSTANT_KIND, false), (&VARIABLE_KIND, true)])?;
    let restitution = if varies {
        model_core::variable_restitution_numbers!(of_rows! { read section Restitution::VelocityDependent {} })
    } else {
        model_core::constant_restitution_numbers!(of_rows! { read section Restitution::Constant {} })
    };
    section.finish()?;
    Ok(restitution)
}
