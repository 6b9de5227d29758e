//! What it takes to follow a harvester on a node, over gaps in its samples and power-downs.

use super::{Harvester, ParameterError};
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::StepControl;
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot};

/// What a storage holds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StorageReading<S> {
    /// Its voltage in volts.
    pub voltage: S,
    /// Its energy in joules.
    pub energy: S,
}

/// A hybrid harvester that can be followed from samples: it can start at rest, its state has a snapshot, and it
/// can be told from any other.
pub trait Resumable<S: Scalar, const N: usize, const P: usize>: Harvester<S, N, P, Mode: Snapshot> {
    /// The harvester at rest under `excitation` at time zero.
    ///
    /// `before` is the state in which it was last seen, where it was: what a storage held it still holds.
    ///
    /// # Errors
    /// If parameters within their bounds leave no such start.
    fn at_rest<E: Excitation<S>, C: StepControl<S>>(
        &self,
        before: Option<&HybridState<S, Self::Mode, N, P>>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Self::Mode, N, P>, ParameterError<S>>;

    /// Takes everything that tells this harvester from another into a fingerprint: all parameters and choices
    /// on which the meaning of a state depends.
    fn identify(&self, fingerprint: &mut Fingerprint);

    /// The storage at `state`; `None` without one.
    fn storage(&self, _state: &HybridState<S, Self::Mode, N, P>) -> Option<StorageReading<S>> {
        None
    }

    /// Puts the storage to a voltage in volts, at or above 0, under a base acceleration in m/s²: for what is drawn
    /// from it, or read of it, from outside. Without a storage nothing changes.
    fn set_storage_voltage(
        &self,
        _state: &mut HybridState<S, Self::Mode, N, P>,
        _volts: S,
        _acceleration: S,
    ) {
    }
}
