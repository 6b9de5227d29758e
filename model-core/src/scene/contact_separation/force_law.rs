//! The electrostatic force between the electrodes.

use core::fmt::Debug;

use super::circuit::Circuit;
use crate::forward;
use crate::part::force_law::{AnyForceLaw, GapField, NoForce, TransferredCharge};
use crate::scalar::Scalar;

/// An electrostatic force law: attraction per mass, and its derivatives.
///
/// Charges are in charge units `√(2 ε0 S m)`, so a charge squared is a force per mass in m/s².
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no electrostatic force law of this scene",
    note = "a force law is `GapField`, `TransferredCharge`, `NoForce` or an `AnyForceLaw`"
)]
pub(crate) trait ForceLaw<S: Scalar>: Copy + Debug + PartialEq {
    /// Attraction per mass in m/s².
    fn attraction(&self, circuit: &Circuit<S>, tribo_charge: S) -> S;

    /// Derivatives of the attraction per mass by the gap and by the total charge.
    fn derivatives(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 2];

    /// The force per mass in m/s², minus the attraction: coefficients of 1, `ΔQ` and `ΔQ²`.
    fn expansion(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 3];
}

/// `−(constant + slope ΔQ)²`.
#[inline]
fn minus_square<S: Scalar>(constant: S, slope: S) -> [S; 3] {
    let product = constant * slope;
    [-(constant * constant), -(product + product), -(slope * slope)]
}

/// `F_e = q² / (2 ε0 S) · (C / (C + C_p))²`, from `W = q² / (2 (C + C_p))` at fixed charge: equations (26) to (28) as
/// inferred from the paper's results.
///
/// Of the forms tried, only this one shows the paper's loss of amplitude, shift to the left and widening with the
/// resistance. It is **not passive**: the charge lags the motion, so the force delivers more energy on approach than
/// it takes on departure. The sum of the mechanical and the electrical ledger does not close, although each closes by itself.
impl<S: Scalar> ForceLaw<S> for TransferredCharge {
    #[inline]
    fn attraction(&self, circuit: &Circuit<S>, _tribo_charge: S) -> S {
        let shared = circuit.transferred * circuit.sharing;
        shared * shared
    }

    #[inline]
    fn derivatives(&self, circuit: &Circuit<S>, _tribo_charge: S) -> [S; 2] {
        let shared = circuit.transferred * circuit.sharing;
        let twice = shared + shared;
        // The sharing factor 1/(1 + c (g + d_e)) falls with the gap by c times its square.
        let by_gap = circuit.sharing * (circuit.transferred_by_gap - circuit.parasitic * shared);
        [twice * by_gap, twice * circuit.sharing * circuit.transferred_by_charge]
    }

    #[inline]
    fn expansion(&self, circuit: &Circuit<S>, _tribo_charge: S) -> [S; 3] {
        let Circuit { transferred, transferred_by_charge, sharing, .. } = *circuit;
        minus_square(transferred * sharing, transferred_by_charge * sharing)
    }
}

/// `F_e = (σS − q)² / (2 ε0 S)`: the field in the gap, energy-consistent electrostatics. With this law the total energy ledger closes.
impl<S: Scalar> ForceLaw<S> for GapField {
    #[inline]
    fn attraction(&self, circuit: &Circuit<S>, tribo_charge: S) -> S {
        let opposite = tribo_charge - circuit.transferred;
        opposite * opposite
    }

    #[inline]
    fn derivatives(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 2] {
        let opposite = tribo_charge - circuit.transferred;
        let twice = -(opposite + opposite);
        [twice * circuit.transferred_by_gap, twice * circuit.transferred_by_charge]
    }

    #[inline]
    fn expansion(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 3] {
        minus_square(tribo_charge - circuit.transferred, -circuit.transferred_by_charge)
    }
}

impl<S: Scalar> ForceLaw<S> for NoForce {
    #[inline]
    fn attraction(&self, _circuit: &Circuit<S>, _tribo_charge: S) -> S {
        S::ZERO
    }

    #[inline]
    fn derivatives(&self, _circuit: &Circuit<S>, _tribo_charge: S) -> [S; 2] {
        [S::ZERO; 2]
    }

    #[inline]
    fn expansion(&self, _circuit: &Circuit<S>, _tribo_charge: S) -> [S; 3] {
        [S::ZERO; 3]
    }
}

impl<S: Scalar> ForceLaw<S> for AnyForceLaw {
    forward! {
        match { Self::TransferredCharge => TransferredCharge, Self::GapField => GapField, Self::None => NoForce }
        #[inline] fn attraction(&self, circuit: &Circuit<S>, tribo_charge: S) -> S;
        #[inline] fn derivatives(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 2];
        #[inline] fn expansion(&self, circuit: &Circuit<S>, tribo_charge: S) -> [S; 3];
    }
}
