//! The estimate and its uncertainty.

use super::sampling::sampling_error;
use super::{Estimator, Settings};
use crate::observer::StorageOutput;
use crate::scalar::Scalar;
use crate::scene::Harvester;

/// Mean power over that in the checks of the steps above which the checks have met too little of it for a statement.
const LARGEST_SHARE: f64 = 3.0;

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// The estimate so far.
    #[must_use]
    pub fn estimate(&self) -> Estimate<S> {
        let Settings { interpolation, bias_seconds, .. } = self.settings;
        let state = &self.state;
        let (energy, seconds) = (state.accumulator.energy(), state.accumulator.seconds());
        let checked = self
            .harvester
            .step_doubling_error(&state.harvester)
            .filter(|checked| S::from_f64(LARGEST_SHARE) * checked.power * seconds >= energy.abs());
        let step = if H::ESTIMATES_ERROR {
            let estimated = state.accumulator.step_error(self.harvester.angular_frequency());
            Some(S::from_f64(H::ERROR_PER_ESTIMATE) * estimated)
        } else {
            checked.map(|checked| checked.relative * energy.abs())
        };
        let rounding = state.accumulator.rounding();
        let sampling = sampling_error(&state.response, &self.droop, interpolation, seconds);
        let [noise, rate] = self.sensor_errors(seconds);
        let irregularity = state.response.irregularity(checked.map(|checked| checked.irregular));
        let [uncertain_seconds, unknown_seconds]: [S; 2] =
            [state.uncertain_time.seconds(), state.unknown_time.seconds()];
        let least = energy.abs().max(S::TINY);
        let certain = (seconds - S::from_f64(0.5) * uncertain_seconds).max(S::TINY);
        let energies = state.response.settling_and_lost(self.harvester.decay_rate(), uncertain_seconds);
        let [settling, lost] = energies.map(|energy| energy / least);
        // The amplitudes of the motion from rest and of the lost one add: (√settling + √lost)² in place of the first.
        let more = lost + S::from_f64(2.0) * (settling * lost).sqrt();
        let of_time = unknown_seconds / certain + (uncertain_seconds / certain).max(settling).max(more);
        let relative = step
            .zip(sampling)
            .map(|(step, sampling)| (step + rounding) / least + sampling)
            .map(|error| error + noise + rate + irregularity + of_time)
            .filter(|relative| relative.is_finite());
        Estimate {
            energy,
            mean_power: if seconds > S::ZERO { energy / seconds } else { S::ZERO },
            seconds,
            storage: self.harvester.outputs(&state.harvester).storage,
            bias: bias_seconds.map(|_| state.bias.mean),
            uncertainty: Uncertainty {
                step,
                rounding,
                missing_samples: state.missing_samples,
                saturated_samples: state.saturated_samples,
                uncertain_seconds,
                unknown_seconds,
                sampling,
                irregularity,
                noise,
                rate,
                relative,
            },
        }
    }
}

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
    /// The mean that was removed from the samples, in m/s²; `None` without [`Settings::bias_seconds`].
    pub bias: Option<S>,
    /// The uncertainty of the energy.
    pub uncertainty: Uncertainty<S>,
}

/// The uncertainty of an [`Estimate`] within the model.
///
/// # Error of the steps
///
/// The sum of two terms: the magnitudes of the local errors of the delivered energy, by the embedded formula, and the
/// effect of the local errors of the state on the energy. The second term is twice the mean state error per radian,
/// because a power is a square, times the 20 radians over which the step control lets state errors add up.
///
/// Exponential Radau is one or two orders better than its estimate: its figure is a tenth of the sum
/// ([`Harvester::ERROR_PER_ESTIMATE`]). The tenth was fitted with the total of steps, sampling and impacts, which covers
/// 97 % of random inputs (docs/energy.md). The coverage of the steps alone is not known. With TR-BDF2 the figure is
/// 1.2 to 21 times the actual error over five seconds in contact-separation, and 1.6 to 5.3 times in sliding. In the
/// first second from rest it can be half of the actual error.
/// `cargo test -p model-core estimator::uncertainty -- --nocapture` prints the ratios.
///
/// [`bump_stop::StepDoubling`](crate::scene::bump_stop::StepDoubling) checks its steps against steps of half the length in a part of the
/// time. Its figure is twice the change of the delivered energy in the checks, with twice the standard error of that.
///
/// # Rounding
///
/// 74 roundings of the energy: those of the energy of a step; those of the compensated sum, whose error does not grow with the
/// number of steps; and one rounding of the state per radian over 20 radians (a state is a pair of numbers, so its rounding
/// does not grow with the steps either). The largest difference between `f32` and `f64` with the same steps was 30 roundings.
///
/// # Sampling
///
/// The error of the mean power because the acceleration is linear between samples
/// ([`Interpolation`](super::Interpolation)): the error of the amplitude at the frequencies in the velocity of the
/// harvester, times the gain of the energy, which is estimated from the energies of the resonance periods, times a
/// factor of coverage. Motion of the base above half of the sampling rate is aliased, and not covered.
///
/// # Irregularity
///
/// Impacts make a small difference of two motions grow until the motions are independent. Then their mean powers differ
/// by the standard error of the mean of a period, times √2. In a periodic motion with impacts the figure is too large.
/// Checks of the steps show whether two motions come apart: the figure of a harvester with checks is 0 if they do not, and
/// twice this standard error if they do in a quarter of the checks.
///
/// # Noise and rate
///
/// The amplitude that steps of the converter and jitter take from the signal, and the motion that they add to that of the
/// velocity; the largest ratio of the powers of a linear resonator at two frequencies that differ by the tolerance of the rate,
/// less 1: some hundred for 5 % and a damping ratio of 0.005. Both times the gain of the energy.
///
/// # Not covered
///
/// Intervals whose jitter adds up from sample to sample; a burst in unknown time; a jump to another motion, as from one
/// without impacts or sliding, by the noise or the rate. Chaotic motion of a bump-stop without checks, and the difference
/// between the model's parameters and the real harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Uncertainty<S> {
    /// Error of the energy in J by the finite step, estimated by the method or by checks; `None` for a method without an
    /// estimate (RK4, the modal steps of bump-stop without checks), and as long as checks have not met a third of the mean
    /// power: bursts between them.
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
    /// Error of the mean power by interpolation between samples, relative; `None` below
    /// four samples in a resonance period, where the rate is too low, and until the
    /// first resonance period has ended. 0 at time zero and after whole periods at rest.
    pub sampling: Option<S>,
    /// Difference of the mean power of two motions under this input that impacts have made independent of one another,
    /// relative. 0 without impacts; up to √2 within the first three resonance periods.
    pub irregularity: S,
    /// Error of the mean power by the resolution and the jitter of the samples, relative; 0 before the first period has ended.
    pub noise: S,
    /// Error of the mean power by the tolerance of the rate, relative.
    pub rate: S,
    /// Total relative uncertainty: the errors by step and rounding over the energy, those by sampling, irregularity, noise
    /// and rate, and the uncertain and unknown time. In uncertain time the power is from 0 to one and a half times that of the
    /// other time, and the estimate half of it, as that of a motion that rises from rest; or to that of the estimate and the lost
    /// motion, whose amplitudes add, if that is more. A lost motion has the power of the last period before the outage in it, and
    /// decays freely after it. In unknown time the power is from 0 to that of the other time. Above 1 the energy may be any up to
    /// that multiple. `None` where [`Uncertainty::step`] or [`Uncertainty::sampling`] is unknown, or the sum is not finite.
    pub relative: Option<S>,
}
