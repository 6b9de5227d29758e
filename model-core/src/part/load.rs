//! The electrical load at the terminals of the harvester.

use crate::bounds::{ParameterError, bounded};
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// A load resistance by case, for the circuit equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resistance<S> {
    /// 0 Ω: the charge follows the position without delay; there is no electrical state.
    Short,
    /// A resistance above zero, in Ω.
    Finite(S),
    /// Infinite resistance: no current, constant charge.
    Open,
}

impl<S: Scalar> Resistance<S> {
    /// Refuses a finite resistance outside the bounds of a [`Resistor`].
    pub(crate) fn check(&self) -> Result<(), ParameterError<S>> {
        match self {
            Self::Finite(resistance) => Resistor { resistance: *resistance }.check_numbers(),
            Self::Short | Self::Open => Ok(()),
        }
    }

    /// Includes the resistance in a fingerprint.
    pub(crate) fn identify(&self, fingerprint: &mut Fingerprint) {
        match self {
            Self::Short => fingerprint.count(0),
            Self::Finite(resistance) => fingerprint.numbers(&[*resistance]),
            Self::Open => fingerprint.count(1),
        }
    }
}

/// A load resistance at the terminals.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no load of this scene",
    label = "no load resistance",
    note = "a load is a `Resistor`, `OpenCircuit`, `ShortCircuit` or `AnyLoad`",
    note = "a triboelectric harvester goes behind a bridge with `OpenCircuit` as its load: `scene::rectified::Rectified::new(harvester, bridge)`",
    note = "a bump-stop harvester goes behind a bridge with `Choices::behind(bridge)`"
)]
pub(crate) trait Load<S: Scalar>: Copy + core::fmt::Debug + PartialEq {
    /// The resistance.
    fn resistance(&self) -> Resistance<S>;
}

/// A resistor above 0 Ω and below infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Resistor<S> {
    /// Load resistance in Ω, 10⁻⁹ to 10³⁰.
    pub resistance: S,
}

bounded! { Resistor<S>: "resistance" = resistance: 1e-9, 1e30; }

impl<S: Scalar> Load<S> for Resistor<S> {
    #[inline]
    fn resistance(&self) -> Resistance<S> {
        Resistance::Finite(self.resistance)
    }
}

/// Connected terminals: 0 Ω.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShortCircuit;

impl<S: Scalar> Load<S> for ShortCircuit {
    #[inline]
    fn resistance(&self) -> Resistance<S> {
        Resistance::Short
    }
}

/// Terminals open: no current.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OpenCircuit;

impl<S: Scalar> Load<S> for OpenCircuit {
    #[inline]
    fn resistance(&self) -> Resistance<S> {
        Resistance::Open
    }
}

/// Any resistance from 0 Ω to infinity, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AnyLoad<S> {
    /// Load resistance in Ω; 0 is a short circuit, infinity an open circuit.
    pub resistance: S,
}

impl<S: Scalar> Load<S> for AnyLoad<S> {
    #[inline]
    fn resistance(&self) -> Resistance<S> {
        if self.resistance == S::ZERO {
            Resistance::Short
        } else if self.resistance == S::INFINITY {
            Resistance::Open
        } else {
            Resistance::Finite(self.resistance)
        }
    }
}
