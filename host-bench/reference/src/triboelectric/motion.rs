//! The state of a triboelectric harvester.

use super::bridge::Bridge;

/// Position, velocity, voltage, and the state of the bridge.
///
/// The voltage is a state only where it follows the motion by a rate. Otherwise it is zero here, and the
/// physics computes it from position and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Motion {
    /// Gap or displacement in m.
    pub(crate) position: f64,
    /// Velocity in m/s.
    pub(crate) velocity: f64,
    /// Load voltage in V.
    pub(crate) voltage: f64,
    /// Branch of the sliding equations; contact-separation has one branch and does not use it.
    pub(crate) branch: Branch,
    pub(crate) bridge: Bridge,
}

/// Branch on which friction and overlap are smooth functions of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Branch {
    /// Direction of slip, 1 or −1; 0 without friction.
    pub(crate) direction: f64,
    /// Side of the middle on which the overlap is taken, 1 or −1.
    pub(crate) side: f64,
}

/// Mode of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The mass flies, or the slider slips.
    Flow,
    /// The mass sticks to the dielectric, or the slider to the patches.
    Stick,
}

impl Motion {
    /// Number of states: position, velocity, voltage and, with a storage, its gain.
    pub(crate) const STATES: usize = 4;

    /// The states.
    pub(crate) fn states(&self) -> [f64; Self::STATES] {
        [self.position, self.velocity, self.voltage, self.bridge.gain]
    }

    /// A motion with these states, or the first three of them, in the same regime.
    pub(crate) fn with(&self, states: &[f64]) -> Self {
        let gain = states.get(3).copied().unwrap_or(self.bridge.gain);
        let bridge = Bridge { gain, ..self.bridge };
        Self { position: states[0], velocity: states[1], voltage: states[2], bridge, ..*self }
    }
}
