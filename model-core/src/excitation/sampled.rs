//! A recorded acceleration: samples at a fixed rate, joined by straight lines.

use super::{Excitation, ExcitationError};
use crate::clock::{Cycles, Frequency, Instant};
use crate::scalar::Scalar;

/// What follows the last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AfterLastSample {
    /// The base comes to rest: zero acceleration from the last sample on.
    Silence,
    /// The trace starts again one sample interval after its last sample.
    Repeat,
}

/// Acceleration samples at a fixed rate, linearly interpolated; the first sample is at time zero.
///
/// No step of an integrator crosses a sample, because the slope jumps there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled<'a, S> {
    samples: &'a [S],
    rate: Frequency,
    /// Samples per second.
    samples_per_second: S,
    /// Ticks from one sample to the next.
    ticks_per_sample: S,
    after: AfterLastSample,
}

impl<'a, S: Scalar> Sampled<'a, S> {
    /// `samples` in m/s², `rate` in samples per second.
    ///
    /// # Errors
    /// Fewer than two samples, a sample that is not finite, or a rate that is zero or out of range.
    pub fn new(samples: &'a [S], rate: S, after: AfterLastSample) -> Result<Self, ExcitationError> {
        if samples.len() < 2 {
            return Err(ExcitationError::TooFewSamples);
        }
        if let Some(index) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(ExcitationError::Sample { index });
        }
        let fixed = Frequency::from_hertz(rate).ok_or(ExcitationError::Frequency)?;
        if !(rate > S::ZERO) {
            return Err(ExcitationError::Frequency);
        }
        let ticks_per_sample = S::power_of_two(40) / rate;
        Ok(Self { samples, rate: fixed, samples_per_second: rate, ticks_per_sample, after })
    }

    /// The samples on either side of `at`, and how far it lies between them.
    fn bracket(&self, at: Instant) -> (S, S, S) {
        let Cycles { whole, fraction } = self.rate.cycles(at);
        // from_fraction counts in 2^63.
        let theta = S::from_fraction((fraction >> 1).cast_signed());
        let count = self.samples.len() as u64;
        let first = match self.after {
            AfterLastSample::Repeat => whole % count,
            AfterLastSample::Silence => whole.min(count),
        } as usize;
        let wrapped = match self.after {
            AfterLastSample::Repeat => self.samples.first(),
            AfterLastSample::Silence => None,
        };
        let at_or_rest = |index: usize| self.samples.get(index).copied().unwrap_or(S::ZERO);
        let left = at_or_rest(first);
        let last = first + 1 >= self.samples.len();
        match (last, wrapped) {
            (false, _) => (left, at_or_rest(first + 1), theta),
            (true, Some(&start)) => (left, start, theta),
            // At and after the last sample the base is at rest.
            (true, None) => (S::ZERO, S::ZERO, theta),
        }
    }
}

impl<S: Scalar> Excitation<S> for Sampled<'_, S> {
    fn acceleration(&self, at: Instant) -> S {
        let (left, right, theta) = self.bracket(at);
        left + theta * (right - left)
    }

    fn jerk(&self, at: Instant) -> S {
        let (left, right, _) = self.bracket(at);
        (right - left) * self.samples_per_second
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        let fraction = self.rate.phase(at);
        let rest = S::ONE - S::from_fraction((fraction >> 1).cast_signed());
        // One tick beyond the sample, so that a rounded-down product cannot leave a sliver.
        (rest * self.ticks_per_sample).to_u32().saturating_add(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRACE: [f64; 4] = [0.0, 1.0, -2.0, 0.5];

    fn at(seconds: f64) -> Instant {
        Instant::from_seconds(seconds).expect("in range")
    }

    #[test]
    fn interpolates_and_ends_as_told() {
        let once = Sampled::new(&TRACE, 4.0, AfterLastSample::Silence).expect("valid");
        let cases =
            [(0.0, 0.0), (0.125, 0.5), (0.25, 1.0), (0.375, -0.5), (0.6, -1.0), (0.75, 0.0), (9.0, 0.0)];
        for (seconds, expected) in cases {
            assert!((once.acceleration(at(seconds)) - expected).abs() < 1e-11, "{seconds}");
        }
        let again = Sampled::new(&TRACE, 4.0, AfterLastSample::Repeat).expect("valid");
        for (seconds, expected) in [(0.75, 0.5), (0.875, 0.25), (1.0, 0.0), (101.25, 1.0), (101.375, -0.5)] {
            assert!((again.acceleration(at(seconds)) - expected).abs() < 1e-11, "{seconds}");
        }
        assert!((once.jerk(at(0.3)) + 12.0).abs() < 1e-9);
    }

    #[test]
    fn steps_end_at_the_samples() {
        let trace = Sampled::new(&TRACE, 400.0, AfterLastSample::Repeat).expect("valid");
        let mut now = Instant::START;
        for _ in 0..1000 {
            now = now.after(trace.smooth_ticks(now));
        }
        // A thousand intervals of 2.5 ms, each at most two ticks long.
        assert!((now.seconds::<f64>() - 2.5).abs() < 2e-9);
    }

    #[test]
    fn bad_traces_are_refused() {
        let refuse = |samples: &[f64], rate| Sampled::new(samples, rate, AfterLastSample::Silence).err();
        assert_eq!(refuse(&[1.0], 4.0), Some(ExcitationError::TooFewSamples));
        assert_eq!(refuse(&[1.0, f64::NAN], 4.0), Some(ExcitationError::Sample { index: 1 }));
        assert_eq!(refuse(&TRACE, 0.0), Some(ExcitationError::Frequency));
        assert_eq!(refuse(&TRACE, -4.0), Some(ExcitationError::Frequency));
    }
}
