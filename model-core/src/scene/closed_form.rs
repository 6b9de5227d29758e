//! Mean power without a trajectory: what a scene delivers in its regular regime under one sine.
//!
//! Each scene has a method `closed_form(amplitude, frequency)` that gives the mean power of the periodic motion
//! which the base's acceleration `amplitude · sin(2π · frequency · t)` leads to from rest, in a bounded number of
//! operations and without a state: a bump-stop beam that stays clear of its stop, exactly; a slider that never
//! sticks and a plate that never touches, by harmonic balance. What the regime requires is checked with the
//! result, and [`Validity`] says by how much it is met or missed.

use crate::scalar::Scalar;

/// Mean power of a periodic motion, and whether it can be believed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClosedForm<S> {
    /// Mean power in the load, in W.
    pub mean_power: S,
    /// Root mean square of the terminal voltage, in V.
    pub rms_voltage: S,
    /// Amplitude of the motion relative to the base, in m: of the gap, of the slider, of the beam's tip.
    pub amplitude: S,
    /// Whether the motion is in the regime of the formula.
    pub validity: Validity<S>,
}

/// Whether a motion is in the regime in which its closed form holds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Validity<S> {
    /// It is.
    Holds {
        /// The requirement that is nearest to being missed, as a part of its limit: 0 to 1.
        margin: S,
    },
    /// It is not: the numbers are those of a motion that does not exist or is not the one that is reached,
    /// and only a trajectory tells.
    NeedsTrajectory {
        /// The requirement that is missed by most.
        reason: Reason,
        /// What is required to be at most 1; infinite where there is no such motion at all.
        margin: S,
    },
}

/// Why a closed form does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The plate reaches the dielectric: amplitude over the mean gap, which must be at most a part of 1.
    Impacts,
    /// A motion with impacts exists beside the one without, and the transient from rest may end in it:
    /// twice the amplitude over the gap.
    ImpactsInTransient,
    /// The slider leaves the active patch: amplitude over a part of its diameter.
    LeavesOverlap,
    /// The slider sticks where it turns round: static friction over the force on it.
    Sticks,
    /// The beam reaches the stop: amplitude of the gap coordinate over the gap.
    ReachesStop,
    /// The motion is not one harmonic, as the balance takes it to be: amplitude of the third over its limit.
    HigherHarmonics,
    /// The rectifier's voltage bends the motion more than the formula allows for.
    StrongCoupling,
    /// The mode does not swing: damping ratio over its limit.
    Overdamped,
    /// The balance was not found in the iterations allowed: what was left of it over what is tolerated.
    NotBalanced,
}

impl<S: Scalar> Validity<S> {
    /// Whether it does.
    #[must_use]
    pub fn holds(&self) -> bool {
        matches!(self, Self::Holds { .. })
    }

    /// The verdict on requirements that are each met up to a margin of 1; not-a-number is not met.
    pub(super) fn of<const N: usize>(requirements: [(Reason, S); N]) -> Self {
        let mut verdict = Self::Holds { margin: S::ZERO };
        for (reason, margin) in requirements {
            let (Self::Holds { margin: worst } | Self::NeedsTrajectory { margin: worst, .. }) = verdict;
            // Written so that not-a-number is as bad as can be.
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

/// `part/limit`; nothing is within any limit, and all else beyond a limit of zero.
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
