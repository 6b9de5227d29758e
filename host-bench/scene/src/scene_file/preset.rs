//! `preset`: a part by its name.

use super::document::SceneError;
use super::key::{Default, Key, Value, other};
use super::section::Section;
use crate::market::Preset;

pub(super) const PRESET: Key = other(
    "preset",
    Value::Part(Preset::words),
    "Name of a commercial part that supplies the missing keys of the table",
)
.or(Default::Said("none"));

/// The part that the table names, if it names one.
pub(super) fn preset(section: &mut Section<'_>) -> Result<Option<Preset>, SceneError> {
    section.has("preset").then(|| section.part("preset", Preset::words, Preset::named)).transpose()
}
