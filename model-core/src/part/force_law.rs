//! The names of the electrostatic force laws; every triboelectric scene has its own formulas.
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

/// No force: the charges do not act on the motion. For scenes in which the force changes nothing that matters.
///
/// Not passive: the energy of the load is created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoForce;

/// A force law chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyForceLaw {
    /// [`TransferredCharge`].
    TransferredCharge,
    /// [`GapField`].
    GapField,
    /// [`NoForce`].
    None,
}
