//! Stick of the moving part, on the dielectric or by friction, and the charge in stick.

use core::fmt::Debug;

/// Whether the moving part can stick, and the behaviour of the charge in stick.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say whether the moving part sticks",
    note = "write `.sticking(StickCharge::Frozen)`, `.sticking(StickCharge::Relaxing)` or `.sticking(NeverSticks)`"
)]
pub(crate) trait Sticking: Copy + Debug + PartialEq {
    /// Whether the moving part can stick at all. If not, the code for stick is not compiled.
    const POSSIBLE: bool;

    /// Whether the charge keeps flowing in stick; by default not.
    #[inline]
    fn relaxes(&self) -> bool {
        false
    }
}

/// The behaviour of the charge in stick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
// A `u8` costs a Cortex-M firmware 450 bytes of flash in moves.
#[repr(u32)]
pub enum StickCharge {
    /// The charge transfer ceases, as the paper states: the load is open and receives no energy.
    #[default]
    Frozen,
    /// The charge relaxes through the load, as physics requires.
    Relaxing,
}

impl Sticking for StickCharge {
    const POSSIBLE: bool = true;

    #[inline]
    fn relaxes(&self) -> bool {
        *self == Self::Relaxing
    }
}

/// The moving part never sticks: a mass always rebounds, a slider always slides on. For scenes without stick.
///
/// If the moving part does come to rest, the driver reports an event storm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NeverSticks;

impl Sticking for NeverSticks {
    const POSSIBLE: bool = false;
}
