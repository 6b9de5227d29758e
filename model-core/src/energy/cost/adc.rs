//! Energy of a reading of an analogue-to-digital converter.

use super::Evidence::Estimated;
use super::Figure;
use crate::scalar::Scalar;

/// An analogue-to-digital converter as data.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adc<S> {
    /// Name.
    pub name: &'static str,
    /// Energy of a reading in J, the start of its reference included.
    pub reading: Figure<S>,
    /// Time of a reading in s.
    pub duration: Figure<S>,
}

impl<S: Scalar> Adc<S> {
    /// A converter of 12 bits in a processor, with its reference.
    #[must_use]
    pub fn twelve_bits() -> Self {
        let assumed = "an ADC of 12 bits with its reference";
        Self {
            name: "12 bits",
            reading: Figure::new(0.15e-6, Estimated, assumed),
            duration: Figure::new(50e-6, Estimated, assumed),
        }
    }
}
