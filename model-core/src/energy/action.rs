//! What a node can do, and the most that it takes.

use crate::part::bounds::{Bounds, ParameterError};
use crate::scalar::Scalar;

/// Something that a node can do, on top of its standing load.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Action<S> {
    name: &'static str,
    energy: S,
    duration: S,
}

impl<S: Scalar> Action<S> {
    /// An action that takes at most `energy` joules at the load and at most `duration` seconds.
    ///
    /// # Errors
    /// `energy` or `duration` negative, infinite or not a number.
    pub fn new(name: &'static str, energy: S, duration: S) -> Result<Self, ParameterError<S>> {
        Bounds::new(0.0, 1e9).check("energy", energy)?;
        Bounds::new(0.0, 1e9).check("duration", duration)?;
        Ok(Self { name, energy, duration })
    }

    /// Its name, for a log.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Upper bound of what it takes at the load, in joules.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Upper bound of how long it takes, in seconds.
    #[must_use]
    pub fn duration(&self) -> S {
        self.duration
    }
}
