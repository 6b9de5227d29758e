//! The bounds of the numbers of a scene file.
//!
//! A parameter of the core has the core's bounds; a reader states the bounds of its other keys.

use std::fmt;

use model_core::bounds::Bounds;

/// Names of numbers and their bounds in SI units; a name is a key, or the core's name of a parameter.
pub(super) type Table = &'static [(&'static str, Bounds<f64>)];

/// From `lowest` to `highest`.
pub(super) const fn between(lowest: f64, highest: f64) -> Bounds<f64> {
    Bounds { lowest, highest }
}

/// The values that a key may have, ends included.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound {
    pub(super) range: Bounds<f64>,
    /// Whether 0 and infinity are allowed beside the range.
    or_limits: bool,
}

impl Bound {
    /// The bound of a key by the first of the tables that has it.
    pub(super) fn of(key: &str, tables: &[Table]) -> Self {
        // A key without a row must not pass unchecked.
        let range = row(key, tables).map_or(between(f64::NAN, f64::NAN), |(_, range)| *range);
        Self { range, or_limits: key == "resistance_ohm" }
    }

    /// Whether the value is allowed; not-a-number never is.
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.range.lowest..=self.range.highest).contains(&value)
            || self.or_limits && (value == 0.0 || value == f64::INFINITY)
    }
}

impl From<Bounds<f64>> for Bound {
    fn from(range: Bounds<f64>) -> Self {
        Self { range, or_limits: false }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = if self.or_limits { "0, inf, or " } else { "" };
        let Bounds { lowest, highest } = self.range;
        write!(f, "{limits}a number from {} to {}", Short(lowest), Short(highest))
    }
}

/// The name and the bounds of a key in the first of the tables that has it.
pub(super) fn row(key: &str, tables: &[Table]) -> Option<&'static (&'static str, Bounds<f64>)> {
    let rows = || tables.iter().copied().flatten();
    let alias = alias(key);
    rows().find(|(name, _)| names(name, key)).or_else(|| rows().find(|(name, _)| names(name, alias)))
}

/// Whether a parameter of the core, `part.field`, is the one of a key, `field` or `field_unit`.
fn names(name: &str, key: &str) -> bool {
    let field = name.rsplit('.').next().unwrap_or(name);
    key.strip_prefix(field).is_some_and(|unit| unit.is_empty() || unit.starts_with('_'))
}

/// The core's name of the parameter with the bounds of a key, where the key does not begin with its field.
fn alias(key: &str) -> &str {
    match key {
        "leakage_ohm" => "leakage_resistance",
        "initial_v" => "initial_voltage",
        "highest_v" => "highest_voltage",
        // These have the bounds of what each may at most be; the reader compares the two.
        "turn_off_v" => "turn_on",
        "position_m" => "length",
        "kinetic_friction_active" => "static_friction_active",
        "kinetic_friction_inert" => "static_friction_inert",
        "modal_displacement" | "rod_modal_displacement" => "modal displacement",
        "modal_velocity" | "rod_modal_velocity" => "modal velocity",
        key => key,
    }
}

/// A number as short as it can be written exactly.
pub(super) struct Short(pub(super) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (plain, scientific) = (self.0.to_string(), format!("{:e}", self.0));
        write!(f, "{}", if plain.len() <= scientific.len() { plain } else { scientific })
    }
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
