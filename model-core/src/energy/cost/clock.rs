//! Current of an external real-time clock.

use super::Evidence::Confirmed;
use super::Figure;
use crate::scalar::Scalar;

/// An external real-time clock as data. It keeps the time while the rest of a node has no supply.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Clock<S> {
    /// Name of the part and its oscillator.
    pub name: &'static str,
    /// Supply voltage of the figure in V.
    pub supply: S,
    /// Supply current in A.
    pub current: Figure<S>,
}

impl<S: Scalar> Clock<S> {
    /// Power in W.
    #[must_use]
    pub fn power(&self) -> S {
        self.current.value * self.supply
    }

    /// All clocks.
    #[must_use]
    pub fn all() -> [Self; 3] {
        [Self::ab18x5_crystal(), Self::ab18x5_calibrated(), Self::ab18x5_rc()]
    }

    /// Abracon AB18X5 with its crystal oscillator. It has a switch for the supply of a processor and 256 bytes of RAM.
    #[must_use]
    pub fn ab18x5_crystal() -> Self {
        Self::ab18x5("AB18X5 crystal", 55e-9)
    }

    /// Abracon AB18X5 with its RC oscillator, which the crystal calibrates from time to time.
    #[must_use]
    pub fn ab18x5_calibrated() -> Self {
        Self::ab18x5("AB18X5 calibrated", 22e-9)
    }

    /// Abracon AB18X5 with its RC oscillator.
    #[must_use]
    pub fn ab18x5_rc() -> Self {
        Self::ab18x5("AB18X5 RC", 14e-9)
    }

    fn ab18x5(name: &'static str, current: f64) -> Self {
        Self {
            name,
            supply: S::from_f64(3.0),
            current: Figure::new(current, Confirmed, "AB18X5 data sheet, Abracon drawing 453568, features"),
        }
    }
}
