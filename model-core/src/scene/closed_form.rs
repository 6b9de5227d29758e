//! Computes the mean power of the regular regime under one sine without a trajectory.
//!
//! The method `closed_form(amplitude, frequency)` of each scene gives the mean power of the periodic motion from rest
//! under the base acceleration `amplitude · sin(2π · frequency · t)`. It takes a bounded number of operations and no
//! state: for a bump-stop beam that does not reach its stop, exactly; for a slider that never sticks and a plate that
//! never touches, by harmonic balance. The requirements of the regime are checked with the result, and [`Validity`]
//! states the margin.

use crate::scalar::Scalar;

/// Mean power of a periodic motion, and its validity.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ClosedForm<S> {
    /// Mean power in the load, in W.
    pub mean_power: S,
    /// Root mean square of the terminal voltage, in V.
    pub rms_voltage: S,
    /// Amplitude of the motion relative to the base, in m: of the gap, of the slider, or of the beam's tip.
    pub amplitude: S,
    /// Whether the motion is in the regime of the formula.
    pub validity: Validity<S>,
}

/// Whether a motion is in the regime of its closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Validity<S> {
    /// The motion is in the regime.
    Holds {
        /// The largest requirement relative to its limit: 0 to 1.
        margin: S,
    },
    /// The motion is not in the regime: it does not exist, or the transient may not reach it. Compute a trajectory.
    NeedsTrajectory {
        /// The requirement that is exceeded most.
        reason: Reason,
        /// The requirement relative to its limit, above 1; infinite if there is no such motion.
        margin: S,
    },
}

/// The reason why a closed form does not hold, with the definition of the margin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Reason {
    /// The plate reaches the dielectric: amplitude over 0.9 of the mean gap.
    Impacts,
    /// A motion with impacts coexists, and the transient from rest may end in it: twice the amplitude over the gap.
    ImpactsInTransient,
    /// The slider leaves the active patch: amplitude over 0.9 of the diameter.
    LeavesOverlap,
    /// The slider sticks at its turning point: static friction over the force on the slider.
    Sticks,
    /// The beam reaches the stop: amplitude of the gap coordinate over the gap.
    ReachesStop,
    /// The motion is not harmonic, as the balance assumes: third harmonic over its limit.
    HigherHarmonics,
    /// The rectifier's voltage changes the motion more than the formula allows.
    StrongCoupling,
    /// The mode is too strongly damped: damping ratio over its limit.
    Overdamped,
    /// The iteration did not converge: residual of the balance over its tolerance.
    NotBalanced,
}

impl<S: Scalar> Validity<S> {
    /// Whether the motion is in the regime.
    #[must_use]
    pub fn holds(&self) -> bool {
        matches!(self, Self::Holds { .. })
    }

    /// The verdict on requirements with margins of at most 1; not-a-number counts as not met.
    pub(super) fn of<const N: usize>(requirements: [(Reason, S); N]) -> Self {
        let mut verdict = Self::Holds { margin: S::ZERO };
        for (reason, margin) in requirements {
            let (Self::Holds { margin: worst } | Self::NeedsTrajectory { margin: worst, .. }) = verdict;
            // `!(margin >= 0)` includes not-a-number.
            let margin = if margin >= S::ZERO { margin } else { S::INFINITY };
            if margin > worst {
                verdict = if margin <= S::ONE {
                    Self::Holds { margin }
                } else {
                    Self::NeedsTrajectory { reason, margin }
                };
            }
        }
        verdict
    }
}

/// `part/limit`; 0 for a part of 0, infinite for another part at a limit of 0.
pub(super) fn ratio<S: Scalar>(part: S, limit: S) -> S {
    if part == S::ZERO { S::ZERO } else { part / limit.max(S::ZERO) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_verdict_is_that_of_the_worst_requirement() {
        let verdict = Validity::<f64>::of([(Reason::Sticks, 0.2), (Reason::Impacts, 0.7)]);
        assert_eq!(verdict, Validity::Holds { margin: 0.7 });
        let verdict = Validity::<f64>::of([(Reason::Sticks, 3.0), (Reason::Impacts, 1.5)]);
        assert_eq!(verdict, Validity::NeedsTrajectory { reason: Reason::Sticks, margin: 3.0 });
        for values in [[f64::NAN, 0.5], [0.5, f64::NAN], [f64::NAN, 5.0]] {
            let verdict = Validity::of(values.map(|value| (Reason::Sticks, value)));
            assert!(!verdict.holds(), "{values:?}");
        }
        assert_eq!((ratio(0.0, 0.0), ratio(1.0, 0.0)), (0.0, f64::INFINITY));
    }
}
