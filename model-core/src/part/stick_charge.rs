//! What becomes of the charge while the moving part is held: on the dielectric, or by friction.

use core::fmt::Debug;

/// Whether the moving part can be held, and what its charge does meanwhile.
pub trait Sticking: Copy + Debug + PartialEq {
    /// Whether the moving part can be held at all; if not, the code for it is not there.
    const POSSIBLE: bool;

    /// Whether the charge keeps flowing while the moving part is held.
    fn relaxes(&self) -> bool;
}

/// While the moving part is held, charge transfer ceases (the paper's statement): the load is open
/// and delivers nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrozenCharge;

impl Sticking for FrozenCharge {
    const POSSIBLE: bool = true;

    #[inline]
    fn relaxes(&self) -> bool {
        false
    }
}

/// While the moving part is held, the charge relaxes through the load, as it physically must.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RelaxingCharge;

impl Sticking for RelaxingCharge {
    const POSSIBLE: bool = true;

    #[inline]
    fn relaxes(&self) -> bool {
        true
    }
}

/// The moving part is never held: a mass always rebounds, a slider always slides on. For scenes
/// that are known not to stick.
///
/// If it comes to rest all the same, the driver reports an event storm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NeverSticks;

impl Sticking for NeverSticks {
    const POSSIBLE: bool = false;

    #[inline]
    fn relaxes(&self) -> bool {
        false
    }
}

/// What the charge does while the moving part is held, chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyStickCharge {
    /// As [`FrozenCharge`].
    Frozen,
    /// As [`RelaxingCharge`].
    Relaxing,
}

impl Sticking for AnyStickCharge {
    const POSSIBLE: bool = true;

    #[inline]
    fn relaxes(&self) -> bool {
        *self == Self::Relaxing
    }
}
