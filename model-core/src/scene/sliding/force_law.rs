//! The electrostatic force in addition to the slider's weight.

use core::fmt::Debug;

use crate::any::forward;
use crate::part::force_law::{AnyForceLaw, GapField, NoForce, TransferredCharge};
use crate::scalar::Scalar;

/// The charged surface, in the units of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface<S> {
    /// Tribo-charge `σS` in charge units.
    pub tribo_charge: S,
    /// `√ε_r` of the dielectric.
    pub root_permittivity: S,
}

/// A law of the attraction between slider and active patch.
///
/// Each law is `F_e / M = e² / s1` with a charge `e` that is linear in the transferred charge.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no electrostatic force law of this scene",
    note = "a force law is `GapField`, `TransferredCharge`, `NoForce` or an `AnyForceLaw`"
)]
pub(crate) trait ForceLaw<S: Scalar>: Copy + Debug + PartialEq {
    /// `e` in charge units, and its derivative by the transferred charge.
    fn acting_charge(&self, transferred: S, surface: &Surface<S>) -> [S; 2];
}

/// `F_e = q² / (2 ε0 ε_r S1)`: equation (16) as inferred from the paper's results.
///
/// Of the forms tried only this one, with or without the factor `ε_r`, reproduces the paper's fall of the amplitude
/// and the shift of the peak to the left and back with growing resistance.
impl<S: Scalar> ForceLaw<S> for TransferredCharge {
    #[inline]
    fn acting_charge(&self, transferred: S, _surface: &Surface<S>) -> [S; 2] {
        [transferred, S::ONE]
    }
}

/// `F_e = (σS − q)² / (2 ε0 S1)`: the field between slider and patch acts on the charge of the face.
///
/// Its trends with the resistance are opposite to those of the paper.
impl<S: Scalar> ForceLaw<S> for GapField {
    #[inline]
    fn acting_charge(&self, transferred: S, surface: &Surface<S>) -> [S; 2] {
        let root = surface.root_permittivity;
        [root * (surface.tribo_charge - transferred), -root]
    }
}

impl<S: Scalar> ForceLaw<S> for NoForce {
    #[inline]
    fn acting_charge(&self, _transferred: S, _surface: &Surface<S>) -> [S; 2] {
        [S::ZERO; 2]
    }
}

impl<S: Scalar> ForceLaw<S> for AnyForceLaw {
    forward! {
        match { Self::TransferredCharge => TransferredCharge, Self::GapField => GapField, Self::None => NoForce }
        #[inline] fn acting_charge(&self, transferred: S, surface: &Surface<S>) -> [S; 2];
    }
}
