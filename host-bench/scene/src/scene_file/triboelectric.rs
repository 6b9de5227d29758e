//! The choices that both triboelectric scenes have.

use super::document::SceneError;
use super::key::{Key, Value, other, words};
use super::scene::{ForceLaw, StickCharge};
use super::section::Section;

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
    "Electrostatic force: the paper's, the field's (conserves energy), or none (what the load takes is created)",
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
