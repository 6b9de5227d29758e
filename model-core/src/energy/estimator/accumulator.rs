//! What the estimator adds up along the steps, and what it says of it.

use crate::clock::Instant;
use crate::integrate::step_control::REMEMBERED_RADIANS;
use crate::observer::{AcceptedStep, Event, Observer, PowerIndex, StorageOutput};
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// A power is a square: a small error of the state moves it twice as much.
const POWER_PER_STATE: f64 = 2.0;
/// Roundings in the energy of a step: some tens of operations lie between a state and it.
const ENERGY_ROUNDINGS: f64 = 32.0;
/// Roundings that a compensated sum makes, however many its terms (Kahan): the next part is smaller by their
/// number times a rounding.
const SUM_ROUNDINGS: f64 = 2.0;

/// Delivered energy and the errors made in it, added up over steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyAccumulator<S> {
    /// Energy delivered to the load, in joules.
    energy: CompensatedSum<S>,
    /// Magnitudes of the estimated local errors of that, in joules.
    energy_error: CompensatedSum<S>,
    /// Estimated local errors of the state, relative to what it is measured by.
    state_error: CompensatedSum<S>,
    ticks: u64,
}

impl<S: Scalar> EnergyAccumulator<S> {
    /// Nothing yet.
    pub(super) const EMPTY: Self = Self {
        energy: CompensatedSum::ZERO,
        energy_error: CompensatedSum::ZERO,
        state_error: CompensatedSum::ZERO,
        ticks: 0,
    };

    #[inline]
    fn add(&mut self, energy: S, ticks: u32) {
        self.energy.add(energy);
        self.ticks = self.ticks.wrapping_add(u64::from(ticks));
    }

    /// Energy delivered to the load, in joules.
    pub(super) fn energy(&self) -> S {
        self.energy.value()
    }

    /// Integrated time in seconds.
    pub(super) fn seconds(&self) -> S {
        Instant::from_ticks(self.ticks).seconds()
    }

    /// Error of the energy by the method's own estimate, in joules.
    pub(super) fn step_error(&self, angular_frequency: S) -> S {
        // The state carries what was made within the radians for which it is remembered.
        let radians = (angular_frequency * self.seconds()).max(S::TINY);
        let remembered = S::from_f64(REMEMBERED_RADIANS).min(radians);
        let carried = self.state_error.value() * (remembered / radians);
        self.energy_error.value() + S::from_f64(POWER_PER_STATE) * carried * self.energy().abs()
    }

    /// Error of the energy by rounding, in joules.
    pub(super) fn rounding(&self) -> S {
        let of_state = POWER_PER_STATE * REMEMBERED_RADIANS;
        S::EPSILON * S::from_f64(ENERGY_ROUNDINGS + SUM_ROUNDINGS + of_state) * self.energy().abs()
    }
}

impl<S: Scalar> Observer<S> for EnergyAccumulator<S> {
    const READS_OUTPUTS: bool = false;

    // A Cortex-M0 build outlines this otherwise, and then fills a whole `AcceptedStep` in memory.
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

/// What is known of the harvest so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate<S> {
    /// Energy delivered to the load over the integrated time, in joules. Of unknown time it holds nothing.
    pub energy: S,
    /// Mean power over the integrated time, in watts; 0 before any.
    pub mean_power: S,
    /// Integrated time in seconds.
    pub seconds: S,
    /// The storage as it is now; `None` for a harvester without one.
    pub storage: Option<StorageOutput<S>>,
    /// How far this can be trusted.
    pub uncertainty: Uncertainty<S>,
}

/// How far an [`Estimate`] can be trusted: as a model's numbers.
///
/// # By the step
///
/// The sum of two. The magnitudes of the local errors of the delivered energy, by the embedded third-order
/// formula; and what the local errors of the state do to the energy: twice their mean per radian, for a
/// power is a square, times the 20 radians for which the step control takes a motion to remember them.
/// Measured in `f64` on the shipped scenes from rest, 5 s of their sine at 400 samples per second, relative
/// to the energy; the actual error is the difference to a tolerance of 10⁻⁶, `e` the local errors of the
/// energy:
///
/// | scene | tolerance | actual | `Σ|e|` | `|Σe|` | `√Σe²` | figure | figure / actual |
/// | --- | --- | --- | --- | --- | --- | --- | --- |
/// | contact-separation, 100 MΩ | 1e-1 | 6.8e-3 | 3.2e-2 | 2.5e-2 | 1.6e-3 | 1.4e-1 | 21 |
/// | | 1e-2 | 3.6e-3 | 3.7e-3 | 2.5e-3 | 8.6e-5 | 1.8e-2 | 5.1 |
/// | | 1e-3 | 2.5e-4 | 4.1e-4 | 2.8e-4 | 5.7e-6 | 2.0e-3 | 7.9 |
/// | | 1e-4 | 2.4e-5 | 4.3e-5 | 3.0e-5 | 3.3e-7 | 2.1e-4 | 8.6 |
/// | contact-separation, 1 MΩ | 1e-1 | 8.2e-3 | 5.4e-3 | 4.9e-3 | 1.8e-4 | 1.2e-1 | 14 |
/// | | 1e-2 | 3.3e-3 | 5.5e-4 | 5.1e-4 | 1.2e-5 | 1.5e-2 | 4.7 |
/// | | 1e-3 | 1.4e-3 | 5.2e-5 | 4.7e-5 | 6.1e-7 | 1.7e-3 | 1.2 |
/// | | 1e-4 | 1.3e-4 | 4.1e-6 | 3.6e-6 | 1.8e-8 | 1.7e-4 | 1.3 |
/// | sliding, 100 MΩ | 1e-1 | 9.2e-2 | 2.6e-2 | 1.3e-2 | 8.9e-4 | 1.5e-1 | 1.6 |
/// | | 1e-2 | 5.0e-3 | 3.6e-3 | 1.7e-3 | 7.3e-5 | 1.8e-2 | 3.7 |
/// | | 1e-3 | 4.1e-4 | 3.9e-4 | 1.8e-4 | 4.3e-6 | 2.0e-3 | 4.9 |
/// | | 1e-4 | 3.8e-5 | 3.9e-5 | 1.8e-5 | 2.4e-7 | 2.0e-4 | 5.3 |
/// | sliding, 1 MΩ | 1e-1 | 6.6e-2 | 1.3e-2 | 3.5e-3 | 6.9e-4 | 1.3e-1 | 1.9 |
/// | | 1e-2 | 4.2e-3 | 9.3e-4 | 9.2e-5 | 1.6e-5 | 1.5e-2 | 3.4 |
/// | | 1e-3 | 3.9e-4 | 1.1e-4 | 6.5e-6 | 1.0e-6 | 1.7e-3 | 4.4 |
/// | | 1e-4 | 3.7e-5 | 1.2e-5 | 1.2e-7 | 6.0e-8 | 1.8e-4 | 4.8 |
///
/// No sum of the local errors of the energy alone tells the actual error: what the error of the state does
/// is the larger part of it, up to a thirtyfold of `Σ|e|`. In sliding, where errors of the motion add up,
/// the figure is within a factor of 2 of three times the actual error. In contact-separation an impact
/// forgets part of them and they cancel over the periods: there it is an upper bound, by a factor of 1 to
/// 20. In the first second after a start it can be half of the actual error, and at the largest tolerance
/// in sliding 0.9 of it.
///
/// # By rounding
///
/// 74 roundings of the energy: those of the energy of a step; of the compensated sum, whose error does not
/// grow with the number of steps; and one of the state in a radian, remembered likewise (a state is a pair
/// of numbers, so its rounding does not grow with them either). Between `f32` and `f64` with the same steps
/// 30 at most were found.
///
/// # Not covered
///
/// A motion that is chaotic (bump-stop in contact), the straight lines between samples, and how well the
/// model's parameters are those of the harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Uncertainty<S> {
    /// Error of the energy in joules by the finite step, as the method estimates it; `None` for a method
    /// without an estimate (RK4, the modal steps of bump-stop): choose its step on the host.
    pub step: Option<S>,
    /// Error of the energy in joules by rounding.
    pub rounding: S,
    /// Samples that were lost.
    pub missing_samples: u32,
    /// Samples at the end of the sensor's range.
    pub saturated_samples: u32,
    /// Part of the integrated time, in seconds, of which the acceleration is interpolated across lost
    /// samples or cut off at the sensor's range, or in which the harvester is still settling after a start
    /// at rest.
    pub uncertain_seconds: S,
    /// Time in seconds that was not integrated.
    pub unknown_seconds: S,
    /// All of it, relative: the errors by step and rounding over the energy, and the uncertain and unknown
    /// seconds over all seconds, as if nothing at all were known of the power in them.
    pub relative: S,
}
