//! A recorded acceleration: samples at a fixed rate, linearly interpolated.

use super::sample_grid::{SampleGrid, between_samples, line_between_samples};
use super::{Excitation, ExcitationError, Line};
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::Scalar;

/// The acceleration after the last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AfterLastSample {
    /// Zero from the last sample on.
    Silence,
    /// The trace repeats, one sample interval after its last sample.
    Repeat,
}

/// Acceleration samples at a fixed rate, linearly interpolated; the first sample is at time zero.
///
/// The slope jumps at a sample. So a step ends at the next sample, or a few millionths of the interval past it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled<'a, S> {
    samples: &'a [S],
    grid: SampleGrid<S>,
    after: AfterLastSample,
}

impl<'a, S: Scalar> Sampled<'a, S> {
    /// A trace of `samples` in m/s² at `rate` samples per second.
    ///
    /// # Errors
    /// Fewer than two samples, a sample that is not finite, or a rate that is not above 0 and at most 10⁶ Hz.
    pub fn new(samples: &'a [S], rate: S, after: AfterLastSample) -> Result<Self, ExcitationError> {
        if samples.len() < 2 {
            return Err(ExcitationError::TooFewSamples);
        }
        if let Some(index) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(ExcitationError::Sample { index });
        }
        Ok(Self { samples, grid: SampleGrid::new(rate)?, after })
    }

    /// The samples on either side of `at`, and the position of `at` between them, 0 to 1.
    fn bracket(&self, at: Instant) -> (S, S, S) {
        let (whole, theta) = self.grid.place(at);
        let count = self.samples.len() as u64;
        let first = match self.after {
            // There are at least two samples, but `%` would link the panic of a division by zero.
            AfterLastSample::Repeat => whole.checked_rem(count).unwrap_or(0),
            AfterLastSample::Silence => whole.min(count),
        } as usize;
        let wrapped = match self.after {
            AfterLastSample::Repeat => self.samples.first(),
            AfterLastSample::Silence => None,
        };
        let at_or_rest = |index: usize| self.samples.get(index).copied().unwrap_or(S::ZERO);
        let left = at_or_rest(first);
        let next = first.saturating_add(1);
        match (next >= self.samples.len(), wrapped) {
            (false, _) => (left, at_or_rest(next), theta),
            (true, Some(&start)) => (left, start, theta),
            // At and after the last sample the base is at rest.
            (true, None) => (S::ZERO, S::ZERO, theta),
        }
    }
}

impl<S: Scalar> Excitation<S> for Sampled<'_, S> {
    between_samples!();
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRACE: [f64; 4] = [0.0, 1.0, -2.0, 0.5];
    const TICK: f64 = 1.0 / crate::clock::TICKS_PER_SECOND as f64;

    fn at(seconds: f64) -> Instant {
        Instant::from_seconds(seconds).expect("in range")
    }

    #[test]
    fn interpolates_and_ends_as_specified() {
        let once = Sampled::new(&TRACE, 4.0, AfterLastSample::Silence).expect("valid");
        // An instant is within half a tick of its seconds; the steepest line falls by 12 m/s² per second.
        let bound = 6.0 * TICK + 1e-14;
        let cases =
            [(0.0, 0.0), (0.125, 0.5), (0.25, 1.0), (0.375, -0.5), (0.6, -1.0), (0.75, 0.0), (9.0, 0.0)];
        for (seconds, expected) in cases {
            assert!((once.acceleration(at(seconds)) - expected).abs() < bound, "{seconds}");
        }
        let again = Sampled::new(&TRACE, 4.0, AfterLastSample::Repeat).expect("valid");
        for (seconds, expected) in [(0.75, 0.5), (0.875, 0.25), (1.0, 0.0), (101.25, 1.0), (101.375, -0.5)] {
            assert!((again.acceleration(at(seconds)) - expected).abs() < bound, "{seconds}");
        }
        assert!((once.jerk(at(0.3)) + 12.0).abs() < 1e-9);
    }

    #[test]
    fn steps_end_at_the_samples() {
        for rate in [3.0, 100.0, 400.0, 1600.0] {
            let double = Sampled::new(&TRACE, rate, AfterLastSample::Repeat).expect("valid");
            let samples = TRACE.map(|sample| sample as f32);
            let single = Sampled::new(&samples, rate as f32, AfterLastSample::Repeat).expect("valid");
            // A step is at most 15.6 ms long. An interval may need several steps, and one more because the
            // first steps past a sample shorten it.
            let steps_per_sample = (1.0 / rate / crate::clock::LONGEST_STEP_S).ceil();
            let walk = |next: &dyn Fn(Instant) -> u32| {
                let (mut now, mut steps) = (Instant::START, 0.0);
                while now.seconds::<f64>() < 300.0 / rate {
                    let before = double.grid.sample_before(now);
                    now = now.after(next(now));
                    let (after, beyond) = double.grid.place(now);
                    // No more than a millionth of an interval beyond the next sample.
                    assert!(after == before || after == before + 1 && beyond < 1e-6, "{rate} Hz");
                    steps += 1.0;
                }
                assert!(steps <= 301.0 * steps_per_sample, "{rate} Hz: {steps} steps");
            };
            walk(&|at| double.smooth_ticks(at));
            walk(&|at| single.smooth_ticks(at));
        }
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
