//! The names of the two electrostatic force laws; every triboelectric scene has its own formulas.
//!
//! The formulas of Fu, Ouyang and Davis (2020) for the electrostatic force are missing from the available copy.
//! [`TransferredCharge`] is inferred from the paper's results, which it reproduces; [`GapField`] follows from
//! electrostatics. The `force_law` module of each scene states the formulas.

/// The force of a capacitor charged with the transferred charge: the law inferred from the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TransferredCharge;

/// The force of the field between the surfaces: energy-consistent electrostatics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GapField;

/// A force law chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyForceLaw {
    /// [`TransferredCharge`].
    TransferredCharge,
    /// [`GapField`].
    GapField,
}
