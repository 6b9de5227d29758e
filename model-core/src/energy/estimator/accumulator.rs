//! The sums of the estimator along the steps, and its estimate.

use crate::clock::Instant;
use crate::integrate::step_control::REMEMBERED_RADIANS;
use crate::observer::{AcceptedStep, Event, Observer, PowerIndex, StorageOutput};
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// Relative error of a power per relative error of the state: a power is a square.
const POWER_PER_STATE: f64 = 2.0;
/// Roundings in the energy of a step, which some tens of operations compute from the state.
const ENERGY_ROUNDINGS: f64 = 32.0;
/// Roundings of a compensated sum with any number of terms (Kahan); the next part is smaller by the number of
/// terms times a rounding.
const SUM_ROUNDINGS: f64 = 2.0;

/// Delivered energy and its errors, summed over steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyAccumulator<S> {
    /// Energy delivered to the load, in J.
    energy: CompensatedSum<S>,
    /// Magnitudes of the estimated local errors of the energy, in J.
    energy_error: CompensatedSum<S>,
    /// Estimated local errors of the state, in the error norm of the scene.
    state_error: CompensatedSum<S>,
    ticks: u64,
}

impl<S: Scalar> EnergyAccumulator<S> {
    #[inline]
    fn add(&mut self, energy: S, ticks: u32) {
        self.energy.add(energy);
        self.ticks = self.ticks.wrapping_add(u64::from(ticks));
    }

    /// Energy delivered to the load, in J.
    pub(super) fn energy(&self) -> S {
        self.energy.value()
    }

    /// Integrated time in s.
    pub(super) fn seconds(&self) -> S {
        Instant::from_ticks(self.ticks).seconds()
    }

    /// Error of the energy by the method's own estimate, in J.
    pub(super) fn step_error(&self, angular_frequency: S) -> S {
        // The state carries the errors of the last `REMEMBERED_RADIANS` radians.
        let radians = (angular_frequency * self.seconds()).max(S::TINY);
        let remembered = S::from_f64(REMEMBERED_RADIANS).min(radians);
        let carried = self.state_error.value() * (remembered / radians);
        self.energy_error.value() + S::from_f64(POWER_PER_STATE) * carried * self.energy().abs()
    }

    /// Error of the energy by rounding, in J.
    pub(super) fn rounding(&self) -> S {
        let of_state = POWER_PER_STATE * REMEMBERED_RADIANS;
        S::EPSILON * S::from_f64(ENERGY_ROUNDINGS + SUM_ROUNDINGS + of_state) * self.energy().abs()
    }
}

impl<S: Scalar> Observer<S> for EnergyAccumulator<S> {
    const READS_OUTPUTS: bool = false;

    // A Cortex-M0 build would outline this function and then store a complete `AcceptedStep` in memory.
    #[inline(always)]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.add(step.energy(PowerIndex::Load), step.ticks);
        // A method without an estimate compiles none of this.
        if step.state_error != S::ZERO {
            self.energy_error.add(step.energy_error.abs());
            self.state_error.add(step.state_error);
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        if let Some(&energy) = event.energies.first()
            && energy != S::ZERO
        {
            self.energy.add(energy);
        }
    }
}

snapshot_fields!(impl [S: Scalar] EnergyAccumulator<S> { energy, energy_error, state_error, ticks });

/// The estimate of the harvest so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Estimate<S> {
    /// Energy delivered to the load over the integrated time, in J. Unknown time contributes nothing.
    pub energy: S,
    /// Mean power over the integrated time, in W; 0 at time zero.
    pub mean_power: S,
    /// Integrated time in s.
    pub seconds: S,
    /// The present state of the storage; `None` for a harvester without one.
    pub storage: Option<StorageOutput<S>>,
    /// The uncertainty of the energy.
    pub uncertainty: Uncertainty<S>,
}

/// The uncertainty of an [`Estimate`] within the model.
///
/// # Error of the steps
///
/// The figure is the sum of two terms: the magnitudes of the local errors of the delivered energy, by the
/// embedded third-order formula, and the effect of the local errors of the state on the energy. The second
/// term is twice the mean state error per radian, because a power is a square, times the 20 radians over
/// which the step control lets state errors add up.
///
/// Over five seconds from rest the figure is 1.2 to 21 times the actual error in contact-separation, where an impact
/// removes part of the errors, and 1.6 to 5.3 times in sliding, where errors of the motion add up. In the first second
/// it can be half of the actual error. The local errors of the energy alone do not predict the actual error.
/// `cargo test -p model-core estimator::the_figure_for_the_step -- --nocapture` prints the ratios.
///
/// # Rounding
///
/// 74 roundings of the energy: those of the energy of a step; those of the compensated sum, whose error does
/// not grow with the number of steps; and one rounding of the state per radian over 20 radians (a state is a
/// pair of numbers, so its rounding does not grow with the steps either). The largest difference between
/// `f32` and `f64` with the same steps was 30 roundings.
///
/// # Not covered
///
/// Chaotic motion (bump-stop in contact), the linear interpolation between samples, and the difference
/// between the model's parameters and the real harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Uncertainty<S> {
    /// Error of the energy in J by the finite step, estimated by the method; `None` for a method without an
    /// estimate (RK4, the modal steps of bump-stop): choose its step on the host.
    pub step: Option<S>,
    /// Error of the energy in J by rounding.
    pub rounding: S,
    /// Number of lost samples.
    pub missing_samples: u32,
    /// Number of samples at the end of the sensor's range.
    pub saturated_samples: u32,
    /// Part of the integrated time, in s, in which the acceleration is interpolated across lost samples or
    /// limited by the sensor's range, or in which the harvester is settling after a start at rest.
    pub uncertain_seconds: S,
    /// Time in s that was not integrated.
    pub unknown_seconds: S,
    /// Total relative uncertainty: the errors by step and rounding over the energy, plus the uncertain and
    /// unknown time over the total time, as if the power in this time were entirely unknown.
    pub relative: S,
}
