//! The result of a closed form, and whether the motion is in its regime: the beam does not reach its stop.

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
    /// Amplitude of the tip relative to the base, in m.
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
    /// A motion with contact coexists, and the transient from rest may end in it: twice the amplitude over the gap.
    ImpactsInTransient,
    /// The beam reaches the stop: amplitude of the gap coordinate over the gap.
    ReachesStop,
    /// The rectifier's voltage acts too strongly on the motion for it to be harmonic: `|Q_v|/C_p` over its limit.
    StrongCoupling,
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
        let verdict = Validity::<f64>::of([(Reason::NotBalanced, 0.2), (Reason::ReachesStop, 0.7)]);
        assert_eq!(verdict, Validity::Holds { margin: 0.7 });
        let verdict = Validity::<f64>::of([(Reason::NotBalanced, 3.0), (Reason::ReachesStop, 1.5)]);
        assert_eq!(verdict, Validity::NeedsTrajectory { reason: Reason::NotBalanced, margin: 3.0 });
        for values in [[f64::NAN, 0.5], [0.5, f64::NAN], [f64::NAN, 5.0]] {
            let verdict = Validity::of(values.map(|value| (Reason::NotBalanced, value)));
            assert!(!verdict.holds(), "{values:?}");
        }
        assert_eq!((ratio(0.0, 0.0), ratio(1.0, 0.0)), (0.0, f64::INFINITY));
    }
}
