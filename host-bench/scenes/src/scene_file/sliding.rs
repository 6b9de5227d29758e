//! `[parameters]` and `[initial]` of a sliding scene.

use model_core::part::friction::PatchFriction;
use model_core::scene::sliding::Start;

use super::document::SceneError;
use super::key::{CoreTable, Key, Kind, Short, Table, Value, between, core, joined, number, of_rows, other};
use super::limits;
use super::section::Section;
use super::triboelectric::{
    FORCE_LAW, ForceLaw, STICK_CHARGE, StickCharge, TriboelectricStart, force_law, natural_frequency, start,
    stick_charge, tables,
};
use super::{BEAM_KEYS, Summary};

const FRICTION: CoreTable = PatchFriction::<f64>::BOUNDS;
const START: CoreTable = Start::<f64>::BOUNDS;

/// A sliding harvester and the state it starts in.
#[derive(Debug, Clone, PartialEq)]
pub struct Sliding {
    /// Table `[parameters]`.
    pub parameters: SlidingParameters,
    /// Table `[initial]`.
    pub initial: TriboelectricStart,
}

model_core::sliding_numbers! { of_rows! {
    /// `[parameters]` of a sliding scene: a cantilever with a disc at its tip that rubs over two patches,
    /// the active one (an electrode under the dielectric, in the middle) and the inert one around it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SlidingParameters {
        /// Coefficient of static friction on the active patch.
        pub static_friction_active: f64,
        /// Coefficient of static friction on the inert patch.
        pub static_friction_inert: f64,
        /// Coefficient of kinetic friction on the active patch, not above the static one.
        pub kinetic_friction_active: f64,
        /// Coefficient of kinetic friction on the inert patch, not above the static one.
        pub kinetic_friction_inert: f64,
        /// Electrostatic force law.
        pub force_law: ForceLaw,
        /// What the charge does while the slider sticks.
        pub stick_charge: StickCharge,
        /// Whether the electrostatic force along the patches acts on the slider.
        pub lateral_force: bool,
    }
} }

impl Sliding {
    pub(super) fn summary(&self) -> Summary {
        let from = &self.parameters;
        let TriboelectricStart { position_m, velocity_m_per_s, charge_c } = self.initial;
        let radius = from.patch_radius_m;
        // The normal force has no work: it acts on the friction, which only takes energy.
        let not_conserved = (!from.lateral_force).then_some(["lateral_force = false", "true"]);
        Summary {
            name: KIND.word,
            rest_m: 0.0,
            length_m: radius,
            range_m: [-1.95 * radius, 1.95 * radius],
            start: Some([position_m, velocity_m_per_s, charge_c]),
            start_key: "initial.displacement_m",
            frequency_keys: BEAM_KEYS,
            damping_ratio: from.damping_ratio,
            charge_density_c_per_m2: Some(from.charge_density_c_per_m2),
            not_conserved,
        }
    }
}

pub(super) static KIND: Kind = Kind {
    word: "sliding",
    meaning: "A charged disc at the tip of a cantilever that rubs over an electrode and an inert patch",
    keys: &tables(&PARAMETERS, &INITIAL, &limits::SLIDING),
};

const NUMBERS: [Key; 11] = model_core::sliding_numbers!(of_rows! { keys });
static PARAMETERS: Table = Table::of(&joined::<18>(&[
    NUMBERS.split_at(8).0,
    &[
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
    ],
    NUMBERS.split_at(8).1,
    &[
        FORCE_LAW,
        STICK_CHARGE,
        other("lateral_force", Value::Flag, "Whether the field's force along the patch acts on the slider"),
    ],
]));

static INITIAL: Table = Table::of(&[
    // Twice the largest patch radius; the radius of the scene is checked beside it.
    number("displacement_m", "m", between(-2.0, 2.0), "Displacement of the slider")
        .limit("magnitude below two patch radii")
        .or_number(0.0),
    number("velocity_m_per_s", "m/s", core(START, "velocity"), "Velocity of the slider").or_number(0.0),
    number("charge_c", "C", core(START, "charge"), "Transferred charge")
        .or_said("that of no voltage at the displacement"),
]);

pub(super) fn model(root: &mut Section<'_>) -> Result<Sliding, SceneError> {
    let parameters = parameters(root.table("parameters")?)?;
    let initial = start(root, "displacement_m", 2.0 * parameters.patch_radius_m)?;
    Ok(Sliding { parameters, initial })
}

fn parameters(mut section: Section<'_>) -> Result<SlidingParameters, SceneError> {
    let p = model_core::sliding_numbers!(of_rows! { read section SlidingParameters {
        static_friction_active: section.number("static_friction_active")?,
        static_friction_inert: section.number("static_friction_inert")?,
        kinetic_friction_active: section.number("kinetic_friction_active")?,
        kinetic_friction_inert: section.number("kinetic_friction_inert")?,
        force_law: force_law(&mut section)?,
        stick_charge: stick_charge(&mut section)?,
        lateral_force: section.flag("lateral_force")?,
    } });
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
    natural_frequency(p.natural_frequency_hz(), "young_modulus_pa", p.young_modulus_pa)
        .map_err(|reason| section.refuse("beam_length_m", reason))?;
    section.finish()?;
    Ok(p)
}
