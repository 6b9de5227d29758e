//! An action of a node with upper bounds of its energy and duration.

use crate::bounds::{Bounds, ParameterError};
use crate::scalar::Scalar;

/// An action of a node on top of its standing load, such as a measurement or a transmission.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Action<S> {
    name: &'static str,
    energy: S,
    duration: S,
}

impl<S: Scalar> Action<S> {
    /// An action that takes at most `energy` in J at the load and at most `duration` in s. `name` is for logs.
    ///
    /// # Errors
    /// An `energy` or a `duration` that is not from 0 to 10⁹.
    pub fn new(name: &'static str, energy: S, duration: S) -> Result<Self, ParameterError<S>> {
        Bounds::new(0.0, 1e9).check("energy", energy)?;
        Bounds::new(0.0, 1e9).check("duration", duration)?;
        Ok(Self { name, energy, duration })
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Upper bound of the energy at the load in J.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Upper bound of the duration in s.
    #[must_use]
    pub fn duration(&self) -> S {
        self.duration
    }
}
