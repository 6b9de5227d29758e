//! `[load]`.

use super::bounds;
use super::document::SceneError;
use super::scene::Load;
use super::section::Section;

/// Reads `[load]`.
pub(super) fn load(mut section: Section<'_>) -> Result<Load, SceneError> {
    let available =
        section.choice("kind", &[("resistor", true), ("rectified-store", false), ("dc-bus", false)])?;
    if !available {
        return Err(
            section.refuse("kind", "this load is not available in this version; must be \"resistor\"")
        );
    }
    let resistance_ohm = section.number("resistance_ohm", &bounds::of("resistance_ohm"))?;
    section.finish()?;
    Ok(Load::Resistor { resistance_ohm })
}
