//! The modes of the hybrid automaton.

/// The modes of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The mass moves freely above the dielectric.
    Free,
    /// The mass sticks to the dielectric: gap and velocity are zero.
    Stick,
}
