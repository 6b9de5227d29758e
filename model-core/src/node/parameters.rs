//! Parameters that both kinds of node have.

use crate::bounds::{ParameterError, first_outside};

/// An action that a node carries out regularly if its storage allows it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regular {
    /// Energy in J at the load, with the standing power of its time, 0 to 10⁶: what it takes at most.
    pub energy: f32,
    /// Time from one to the next in s, 1 to 10⁷.
    pub every: u32,
}

impl Regular {
    /// The first number outside its bounds, of the action with this index.
    pub(super) const fn outside(&self, index: usize) -> Option<ParameterError<f32>> {
        let [energy, every] = NAMES[if index < NAMES.len() { index } else { NAMES.len() - 1 }];
        let rows = [(energy, self.energy, 0.0, 1e6), (every, self.every as f32, 1.0, 1e7)];
        first_outside(&rows)
    }
}

/// An analogue-to-digital converter on the storage's voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Converter {
    /// Resolution in bits, 4 to 16. Code `k` means that `k · full_scale / 2^bits` is the nearest voltage.
    pub bits: u32,
    /// Full scale in V, by the divider before it, 0.01 to 1000.
    pub full_scale: f32,
    /// Standard deviation of the noise of a reading in V, independent from reading to reading, 0 to `full_scale`.
    pub noise: f32,
}

/// Names of the numbers of the first actions in errors; the last ones stand for all others.
const NAMES: [[&str; 2]; 5] = [
    ["actions.0.energy", "actions.0.every"],
    ["actions.1.energy", "actions.1.every"],
    ["actions.2.energy", "actions.2.every"],
    ["actions.3.energy", "actions.3.every"],
    ["actions.energy", "actions.every"],
];
