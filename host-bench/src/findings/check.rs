//! Measured values and what is asserted of them.

use crate::scene_file::Scene;

/// What is asserted of measured values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// Each is above this.
    Above(f64),
    /// Each is this or above.
    AtLeast(f64),
    /// Each is this.
    Is(f64),
    /// Each is below this.
    Below(f64),
    /// Each is from the first to the second.
    Within(f64, f64),
    /// Each is smaller than the one before.
    Falls,
    /// Each is larger than the one before.
    Rises,
    /// Nothing: the values are printed only.
    Reported,
    /// A run reaches its end: the quantity says how it stopped.
    Completes,
}

/// Measured values of one quantity, and what is asserted of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    pub(super) number: &'static str,
    /// The quantity with its unit.
    pub quantity: String,
    pub values: Vec<f64>,
    pub bound: Bound,
    /// Scenes of runs from which its experiment takes values, where other starts may lead elsewhere.
    pub(super) scenes: Vec<Scene>,
}

/// A check of the finding with this number.
pub(super) fn check(
    number: &'static str,
    quantity: impl Into<String>,
    values: impl Into<Vec<f64>>,
    bound: Bound,
) -> Check {
    Check { number, quantity: quantity.into(), values: values.into(), bound, scenes: Vec::new() }
}

impl Check {
    pub(super) fn of(self, scenes: impl IntoIterator<Item = Scene>) -> Self {
        Self { scenes: scenes.into_iter().collect(), ..self }
    }

    /// Whether the assertion holds; not-a-number and an empty list meet none, and one value neither falls nor rises.
    pub fn holds(&self) -> bool {
        let each = |holds: &dyn Fn(f64) -> bool| self.values.iter().all(|value| holds(*value));
        let steps = |holds: &dyn Fn(f64, f64) -> bool| {
            self.values.len() > 1 && self.values.windows(2).all(|pair| holds(pair[0], pair[1]))
        };
        if self.values.is_empty() {
            return false;
        }
        match self.bound {
            Bound::Above(limit) => each(&|value| value > limit),
            Bound::AtLeast(limit) => each(&|value| value >= limit),
            Bound::Is(wanted) => each(&|value| value == wanted),
            Bound::Below(limit) => each(&|value| value < limit),
            Bound::Within(from, to) => each(&|value| (from..=to).contains(&value)),
            Bound::Falls => steps(&|before, after| after < before),
            Bound::Rises => steps(&|before, after| after > before),
            Bound::Reported => true,
            Bound::Completes => false,
        }
    }

    /// Whether each value that the assertion is about is a number.
    pub fn is_measured(&self) -> bool {
        let numbers = || self.values.iter().all(|value| !value.is_nan());
        !self.values.is_empty() && (self.bound == Bound::Reported || numbers())
    }

    /// The assertion as text; empty if there is none.
    pub fn assertion(&self) -> String {
        match self.bound {
            Bound::Above(limit) => format!("> {}", digits(limit)),
            Bound::AtLeast(limit) => format!(">= {}", digits(limit)),
            Bound::Is(wanted) => format!("= {}", digits(wanted)),
            Bound::Below(limit) => format!("< {}", digits(limit)),
            Bound::Within(from, to) => format!("{} to {}", digits(from), digits(to)),
            Bound::Falls => "falls".to_owned(),
            Bound::Rises => "rises".to_owned(),
            Bound::Reported => String::new(),
            Bound::Completes => "runs to its end".to_owned(),
        }
    }

    /// The values as text, to four digits.
    pub fn shown(&self) -> String {
        self.values.iter().map(|value| digits(*value)).collect::<Vec<_>>().join(", ")
    }
}

/// A number to four significant digits, to three with an exponent.
fn digits(value: f64) -> String {
    let rounded = |places: usize| format!("{value:.places$e}").parse().unwrap_or(value);
    let is_plain = value == 0.0 || !value.is_finite() || (1e-3..1e6).contains(&value.abs());
    if is_plain { format!("{}", rounded(3)) } else { format!("{:e}", rounded(2)) }
}
