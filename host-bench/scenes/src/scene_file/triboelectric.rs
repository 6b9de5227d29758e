//! The choices that both triboelectric scenes have.

use super::document::SceneError;
use super::key::{Bound, Key, Short, Table, Value, other, words};
use super::section::Section;
pub use model_core::scene::contact_separation::{AnyForceLaw as ForceLaw, StickCharge};

/// `[initial]` of a triboelectric scene; what is `None` takes its default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TriboelectricStart {
    /// Gap in m, by default the unstretched one; or displacement in m of the slider from the middle of the active patch, by default 0.
    pub position_m: Option<f64>,
    /// Velocity in m/s, opening positive, or relative to the patches; by default 0.
    pub velocity_m_per_s: Option<f64>,
    /// Transferred charge in C; by default that of no voltage at the position.
    pub charge_c: Option<f64>,
}

/// Reads `[initial]`, if it is there; its position has the key `position`, and must be less than `reach` in magnitude.
pub(super) fn start(
    root: &mut Section<'_>,
    position: &'static str,
    reach: f64,
) -> Result<TriboelectricStart, SceneError> {
    let Some(mut section) = root.optional_table("initial")? else { return Ok(TriboelectricStart::default()) };
    let start = TriboelectricStart {
        position_m: section.optional_number(position)?,
        velocity_m_per_s: section.optional_number("velocity_m_per_s")?,
        charge_c: section.optional_number("charge_c")?,
    };
    if start.position_m.is_some_and(|position| position.abs() >= reach) {
        let reason = format!("must be within two patch radii, less than {} in magnitude", Short(reach));
        return Err(section.refuse(position, reason));
    }
    section.finish()?;
    Ok(start)
}

/// The keys of a harvester: its parameters, its start and the limits of its model.
pub(super) const fn tables(
    parameters: &'static Table,
    initial: &'static Table,
    limits: &'static Table,
) -> [Key; 3] {
    [
        other("parameters", Value::Table(parameters), "The harvester"),
        other("initial", Value::Table(initial), "The state at the start").or_said("at rest, without voltage"),
        other("limits", Value::Table(limits), "The limits of the model").or_said("the defaults below"),
    ]
}

const FORCE_LAWS: [(&str, ForceLaw); 3] = [
    ("transferred-charge", ForceLaw::TransferredCharge),
    ("gap-field", ForceLaw::GapField),
    ("none", ForceLaw::None),
];
const STICK_CHARGES: [(&str, StickCharge); 2] =
    [("frozen", StickCharge::Frozen), ("relaxing", StickCharge::Relaxing)];

pub(super) const FORCE_LAW: Key = other(
    "force_law",
    Value::Words(&words(&FORCE_LAWS)),
    "Electrostatic force: inferred from the paper's results, of the field (conserves energy), or none (what the load takes is created)",
);
pub(super) const STICK_CHARGE: Key = other(
    "stick_charge",
    Value::Words(&words(&STICK_CHARGES)),
    "Charge while the body sticks: it stays as it was, or flows on through the load",
);

pub(super) fn force_law(section: &mut Section<'_>) -> Result<ForceLaw, SceneError> {
    section.choice("force_law", &FORCE_LAWS)
}

pub(super) fn stick_charge(section: &mut Section<'_>) -> Result<StickCharge, SceneError> {
    section.choice("stick_charge", &STICK_CHARGES)
}

/// Refuses a natural frequency in Hz that no triboelectric harvester may have; `with` names a parameter that makes
/// it, beside the key that is blamed. The error is the reason.
pub(super) fn natural_frequency(frequency: f64, with: &str, value: f64) -> Result<(), String> {
    let bound = Bound::from(model_core::scene::NATURAL_FREQUENCY);
    if bound.contains(frequency) {
        return Ok(());
    }
    let value = Short(value);
    Err(format!("the natural frequency with {with} = {value} is {frequency:.3e} Hz, must be {bound}"))
}
