//! The bounds of the numbers of a scene file, and how a message writes them.

use std::fmt;

use model_core::bounds::Bounds;

use super::key::{Key, Value};

/// The core's names of parameters and their bounds in SI units.
pub(super) type CoreTable = &'static [(&'static str, Bounds<f64>)];

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
    /// The bound of each number of a key's value; nothing is within that of a key which is no number.
    pub(super) fn of(key: &Key) -> Self {
        let (range, or_limits) = match key.value {
            Value::NumberOrLimits(range) => (range, true),
            Value::Number(range)
            | Value::Whole(range)
            | Value::Numbers(range, _)
            | Value::Points(range, _)
            | Value::Column(range)
            | Value::ColumnOrFalse(range) => (range, false),
            _ => return Self::default(),
        };
        Self { range, or_limits }
    }

    /// Whether the value is allowed; not-a-number never is.
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.range.lowest..=self.range.highest).contains(&value)
            || self.or_limits && (value == 0.0 || value == f64::INFINITY)
    }
}

impl Default for Bound {
    /// Nothing is within.
    fn default() -> Self {
        between(f64::NAN, f64::NAN).into()
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

/// A number as short as it can be written exactly.
pub(crate) struct Short(pub(crate) f64);

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
