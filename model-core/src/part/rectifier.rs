//! A full bridge of diodes between a harvester and its storage.
//!
//! A diode conducts with a constant drop or blocks, and two diodes conduct at a time. The bridge blocks while the
//! harvester's voltage is within `±(V_s + 2 V_D)`, and clamps the voltage to one of these limits while it conducts, until
//! the current falls to 0.

use super::storage::StorageElement;
use crate::bounds::{ParameterError, bounded};
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// A full bridge and the storage that it charges.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FullBridge<S, R> {
    /// Forward voltage `V_D` in V of each of the two diodes that conduct at a time, 0 to 100.
    pub diode_drop: S,
    /// The storage.
    pub storage: R,
}

/// The regimes of a full bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BridgeRegime {
    /// No current.
    Blocked,
    /// Conducting, the harvester's voltage above zero.
    Forward,
    /// Conducting, the harvester's voltage below zero.
    Backward,
}

impl BridgeRegime {
    /// Sign of the terminal voltage in conduction; 0 if the bridge blocks.
    #[must_use]
    #[inline]
    pub fn sign<S: Scalar>(self) -> S {
        match self {
            Self::Blocked => S::ZERO,
            Self::Forward => S::ONE,
            Self::Backward => -S::ONE,
        }
    }
}

bounded! { FullBridge<S, R>: "diode_drop" = diode_drop: 0.0, 100.0; }

impl<S: Scalar, R: StorageElement<S>> FullBridge<S, R> {
    /// Terminal voltage in V from which the bridge conducts, at a storage voltage in V.
    #[inline]
    pub(crate) fn threshold(&self, storage_voltage: S) -> S {
        storage_voltage + self.diode_drop + self.diode_drop
    }

    /// Includes all parameters of the bridge and its storage in a fingerprint.
    pub(crate) fn identify(&self, fingerprint: &mut Fingerprint) {
        let storage = &self.storage;
        fingerprint.numbers(&[
            self.diode_drop,
            storage.elastance(),
            storage.initial_voltage(),
            storage.leakage(S::ONE),
        ]);
        // A draw is identified by its currents at two voltages at which it can be connected.
        let level = storage.lockout().map_or(S::ONE, |lockout| lockout.turn_on);
        fingerprint.numbers(&[level, level + level].map(|voltage| storage.drawn(voltage)));
        if let Some(lockout) = storage.lockout() {
            fingerprint.numbers(&[lockout.turn_on, lockout.turn_off]);
        }
    }

    /// Checks the parameters of the bridge and its storage.
    ///
    /// # Errors
    /// The field, its value and its bounds.
    pub(crate) fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        self.storage.check()
    }
}
