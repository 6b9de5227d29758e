//! The electrostatic force along the plane of sliding.

use core::fmt::Debug;

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
