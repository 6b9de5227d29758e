//! What a reading of the voltage says of the stored energy: of a capacitor, or of a battery beside one.

use core::fmt::Debug;

use crate::energy::battery::{PIECES, piece_at};
use crate::node::real;
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// The element that holds the energy of a node, in codes of its converter: a [`CapacitorElement`] or a [`BatteryElement`].
pub trait Element: Copy + Debug + PartialEq {
    /// Whether an hour of readings may say next to nothing.
    const IS_FLAT: bool;

    /// Stored energy in J at a code.
    fn energy(&self, code: u32) -> f32;

    /// Square of the derivative of the energy by the code, over the constant that the node's variances have beside it, at a stored
    /// energy in J.
    fn square_of_slope(&self, energy: f32) -> f32;

    /// Voltage in V at a stored energy in J, of a capacitor of this capacitance in F.
    fn voltage(&self, energy: f32, capacitance: f32) -> f32;

    /// Includes it in a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);
}

/// A capacitor, whose energy goes with the square of the code.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CapacitorElement {
    /// Energy over the square of the code.
    pub(super) per_code: f32,
}

impl Element for CapacitorElement {
    const IS_FLAT: bool = false;

    #[inline]
    fn energy(&self, code: u32) -> f32 {
        self.per_code * real(code * code)
    }

    /// The constant is four times the energy over the square of the code.
    #[inline]
    fn square_of_slope(&self, energy: f32) -> f32 {
        energy
    }

    #[inline]
    fn voltage(&self, energy: f32, capacitance: f32) -> f32 {
        Scalar::sqrt(2.0 * Scalar::max(energy, 0.0) / capacitance)
    }

    #[inline]
    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.numbers(&[self.per_code]);
    }
}

/// A battery beside a capacitor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BatteryElement {
    /// Energy in J and square of the code at the begin of each piece of the curve, and energy over the square of the code.
    pub(super) pieces: [[f32; 3]; PIECES],
    /// What the open-circuit voltage is above that of a reading, in codes.
    pub(super) drop: f32,
    /// Voltage of a code in V.
    pub(super) cell: f32,
}

impl Element for BatteryElement {
    const IS_FLAT: bool = true;

    fn energy(&self, code: u32) -> f32 {
        let open = real(code) + self.drop;
        let square = open * open;
        let [energy, begin, per_code] = piece_at(&self.pieces, 1, square);
        Scalar::max(energy + per_code * (square - begin), 0.0)
    }

    /// The constant is 4.
    fn square_of_slope(&self, energy: f32) -> f32 {
        let [from, begin, per_code] = piece_at(&self.pieces, 0, energy);
        per_code * Scalar::max(per_code * begin + (energy - from), 0.0)
    }

    fn voltage(&self, energy: f32, _: f32) -> f32 {
        let [from, begin, per_code] = piece_at(&self.pieces, 0, energy);
        self.cell * Scalar::sqrt(Scalar::max(begin + (energy - from) / per_code, 0.0))
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        for piece in &self.pieces {
            fingerprint.numbers(piece);
        }
        fingerprint.numbers(&[self.drop]);
    }
}
