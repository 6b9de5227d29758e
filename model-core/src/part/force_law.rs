//! The names of the two electrostatic force laws, which every triboelectric scene has in its own form.
//!
//! The formulas of Fu, Ouyang and Davis (2020) for the electrostatic force did not survive in print.
//! [`TransferredCharge`] is inferred from the paper's findings, which it reproduces; [`GapField`] is
//! what electrostatics says. Which formula each stands for is said where a scene implements its
//! `ForceLaw` for them.

/// The force of a capacitor charged with the transferred charge: the paper's law as inferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TransferredCharge;

/// The force of the field between the surfaces: the energy-consistent electrostatics.
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
