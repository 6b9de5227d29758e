//! `preset`: a part by its name.

use model_core::part::preset::Preset;

use super::document::SceneError;
use super::key::{Default, Key, Value, other};
use super::section::Section;

pub(super) const PRESET: Key =
    other("preset", Value::Part, "Name of a commercial part that supplies the missing keys of the table")
        .or(Default::Said("none"));

/// The part that the table names, if it names one.
pub(super) fn preset(section: &mut Section<'_>) -> Result<Option<Preset<f64>>, SceneError> {
    if !section.has("preset") {
        return Ok(None);
    }
    let parts = Preset::all();
    section.choice("preset", &parts.map(|part| (part.name, part))).map(Some)
}
