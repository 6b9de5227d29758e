//! The choices that both triboelectric scenes have.

use super::document::SceneError;
use super::key::{Bound, Key, Short, Value, other, words};
use super::section::Section;

/// Electrostatic force law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceLaw {
    /// The transferred charge as that of a capacitor, equations (16) and (28) of Fu, Ouyang and Davis:
    /// on the overlap in sliding, on the total capacitance in contact-separation. Gives the paper's
    /// trends; not passive in contact-separation.
    TransferredCharge,
    /// The field in the gap between the surfaces: the law that conserves energy.
    GapField,
    /// No force on the motion: what the load takes is created.
    None,
}

/// What the charge does while the mass is held on the dielectric, or the slider sticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StickCharge {
    /// It stays as it was: the load is open.
    Frozen,
    /// It goes on flowing through the load.
    Relaxing,
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

/// The electrostatic force law.
pub(super) fn force_law(section: &mut Section<'_>) -> Result<ForceLaw, SceneError> {
    section.choice("force_law", &FORCE_LAWS)
}

/// What the charge does in stick.
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
