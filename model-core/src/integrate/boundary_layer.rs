//! The boundary layer of a circuit that is much faster than the motion.

use crate::scalar::Scalar;

/// The fast part of a circuit's response to a disturbance: the rate of its state relaxes to the rate at which the state
/// follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryLayer<S> {
    /// Rate of the relaxation in 1/s.
    pub relaxation: S,
    /// The rate of the circuit's state that follows the motion.
    pub following: S,
}

impl<S: Scalar> BoundaryLayer<S> {
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
