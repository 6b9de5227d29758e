//! The modes of the hybrid automaton.

use crate::scalar::Scalar;

/// The modes of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The slider slides.
    Sliding {
        /// Whether the velocity is positive; friction acts against it.
        forward: bool,
        /// Whether the displacement is positive: the side of the overlap's corner.
        ahead: bool,
    },
    /// The slider sticks by friction.
    Stick,
}

impl Mode {
    /// The sliding mode at `displacement`; at the corner itself, on the side of the motion.
    #[inline(always)]
    pub(super) fn sliding<S: Scalar>(forward: bool, displacement: S) -> Self {
        let ahead = if displacement == S::ZERO { forward } else { displacement > S::ZERO };
        Self::Sliding { forward, ahead }
    }

    /// The side of the overlap's corner: in a slide that of the mode, since a step may end slightly beyond the
    /// corner.
    #[inline(always)]
    pub(super) fn is_ahead<S: Scalar>(self, displacement: S) -> bool {
        match self {
            Self::Sliding { ahead, .. } => ahead,
            Self::Stick => displacement >= S::ZERO,
        }
    }
}
