//! The electrostatic force in addition to the slider's weight, and its part along the plane of sliding.

use core::fmt::Debug;

use crate::forward;
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

/// Whether the field also exerts a force along the plane: `F_lat = −∂W/∂x` at constant charge, with `W = (q − σ S2)²
/// d / (2 ε0 ε_r S1)` the energy of the overlap capacitor.
///
/// The paper omits it, because it is about 10⁻⁴ of the elastic force. The energy delivered to the load then has no
/// source; with the lateral force the total energy ledger closes.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say whether the field pulls along the plane",
    note = "a lateral force is `NoLateralForce`, `FieldLateralForce` or an `AnyLateralForce`"
)]
pub(crate) trait LateralForce: Copy + Debug + PartialEq {
    /// Whether the lateral force acts.
    fn acts(&self) -> bool;
}

/// No lateral force: the paper's model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoLateralForce;

impl LateralForce for NoLateralForce {
    #[inline]
    fn acts(&self) -> bool {
        false
    }
}

/// The lateral force of the field: energy is conserved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FieldLateralForce;

impl LateralForce for FieldLateralForce {
    #[inline]
    fn acts(&self) -> bool {
        true
    }
}

/// A lateral force or none, chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyLateralForce {
    /// As [`NoLateralForce`].
    None,
    /// As [`FieldLateralForce`].
    Field,
}

impl LateralForce for AnyLateralForce {
    #[inline]
    fn acts(&self) -> bool {
        *self == Self::Field
    }
}
