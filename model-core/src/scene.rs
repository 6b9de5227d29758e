//! Harvesters.
//!
//! A scene is parameters, checked once, and a handful of pure functions: see
//! [`crate::hybrid::Automaton`]. What a meter needs of any of them is [`Harvester`].

pub mod bump_stop;
pub mod closed_form;
pub mod contact_separation;
mod coupled;
mod electrical_port;
pub mod rectified;
mod resumable;
pub mod sliding;

use crate::hybrid::{Automaton, Guard};
use crate::integrate::Point;
use crate::scalar::Scalar;

pub use crate::part::bounds::{Bounds, ParameterError};
pub use resumable::{Resumable, StorageReading};

/// The powers that every scene can integrate along with its state, and their places in the list.
///
/// A scene offers two lists: the first entry alone, which is what a sensor node pays for, and the
/// whole account, from which the energy ledger is drawn up.
pub mod account {
    use crate::scalar::Scalar;

    /// Power delivered to the load, in watts; behind a rectifier, the power that enters the storage.
    pub const LOAD: usize = 0;
    /// Square of the terminal voltage, in V².
    pub const VOLTAGE_SQUARED: usize = 1;
    /// Terminal voltage, in volts.
    pub const VOLTAGE: usize = 2;
    /// Magnitude of the load current, in amperes.
    pub const CURRENT_MAGNITUDE: usize = 3;
    /// Power that the moving base puts in, in watts.
    pub const BASE: usize = 4;
    /// Its magnitude.
    pub const BASE_MAGNITUDE: usize = 5;
    /// Power lost to damping and friction, in watts.
    pub const DISSIPATION: usize = 6;
    /// Power that the mechanics give up to the electrostatic force of the scene's force law.
    pub const ELECTROSTATIC_WORK: usize = 7;
    /// Power that the electrostatic field takes from the motion.
    ///
    /// The same as `ELECTROSTATIC_WORK` where the force law is the field's own; under an inferred force law
    /// the difference is what that law creates or destroys.
    pub const FIELD_WORK: usize = 8;
    /// Power lost in the diodes of a rectifier.
    pub const DIODES: usize = 9;
    /// Power that leaks from the storage behind a rectifier.
    pub const LEAKED: usize = 10;
    /// Power that the node draws from it.
    pub const DRAWN: usize = 11;
    /// Number of entries in the whole account.
    pub const WHOLE: usize = 12;

    /// The first `P` entries of a whole account. Those beyond are not computed: the compiler drops what is
    /// not read.
    #[inline(always)]
    pub(super) fn first<S: Scalar, const P: usize>(whole: &[S; WHOLE]) -> [S; P] {
        core::array::from_fn(|i| whole.get(i).copied().unwrap_or(S::ZERO))
    }
}

/// Energy stored in a harvester, in joules.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoredEnergy<S> {
    /// Kinetic and elastic.
    pub mechanical: S,
    /// In the electric field and the capacitances.
    pub electrical: S,
}

/// What a meter can read from a harvester, whatever it is.
pub trait Harvester<S: Scalar, const N: usize, const P: usize>: Automaton<S, N, P> {
    /// The coordinate whose extremes are reported, with its rate: a gap, a displacement.
    fn coordinate(&self, point: &Point<S, N, P>) -> Guard<S>;

    /// Voltage at the terminals, in volts.
    fn voltage(&self, mode: Self::Mode, point: &Point<S, N, P>) -> S;

    /// Stored energy.
    fn stored_energy(&self, mode: Self::Mode, point: &Point<S, N, P>) -> StoredEnergy<S>;

    /// Whether the moving part is held in `mode`.
    fn is_stick(&self, mode: Self::Mode) -> bool;

    /// Whether guard number `guard` of `mode` is an impact.
    fn is_impact(&self, mode: Self::Mode, guard: usize) -> bool;

    /// Voltage in V of the storage behind a rectifier, and what rounding took from it: a step brings a large
    /// storage less than a rounding of its voltage. Zeros where there is none.
    #[inline(always)]
    fn compensated_storage_voltage(&self, _mode: Self::Mode, _point: &Point<S, N, P>) -> [S; 2] {
        [S::ZERO; 2]
    }

    /// Energy in J that the storage gains from one such voltage to another; `None` where there is none, and
    /// for a bus, which has no end.
    #[inline(always)]
    fn storage_gain(&self, _from: [S; 2], _to: [S; 2]) -> Option<S> {
        None
    }
}
