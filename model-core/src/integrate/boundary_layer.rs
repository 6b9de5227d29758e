//! The boundary layer of a circuit that is much faster than the motion.

use crate::scalar::Scalar;

/// Roundings of the state within which a rate counts as settled.
const ROUNDINGS: f64 = 4.0;

/// The fast part of a circuit's response to a disturbance: the rate of its state relaxes to the rate at which the state
/// follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryLayer<S> {
    /// Rate of the relaxation in 1/s.
    pub relaxation: S,
    /// The rate of the circuit's state that follows the motion.
    pub following: S,
    /// The scale of the state, whose rounding disturbs the rate.
    pub scale: S,
}

impl<S: Scalar> BoundaryLayer<S> {
    /// What a rate exceeds `following` by; 0 if that is no more than the rounding of the state.
    #[inline]
    pub(crate) fn excess(&self, rate: S) -> S {
        let excess = rate - self.following;
        let rounding = S::EPSILON * S::from_f64(ROUNDINGS) * self.scale * self.relaxation;
        if excess.abs() > rounding { excess } else { S::ZERO }
    }

    /// The rate with which a step of `step` s starts, from the rate `before` just after a disturbance.
    ///
    /// A step `h` much longer than the layer starts with the rate beyond the layer. The weight of `following` is of third
    /// order in `h · relaxation / 10`, so that both limits are exact.
    #[inline(always)]
    pub(crate) fn settled(&self, before: S, step: S) -> S {
        let thickness = S::from_f64(0.1) * step * self.relaxation;
        let weight = thickness * thickness * thickness;
        // Above this weight `before` is negligible, and the weight might overflow.
        if weight > S::from_f64(1e9) {
            self.following
        } else {
            (before + weight * self.following) / (S::ONE + weight)
        }
    }
}
