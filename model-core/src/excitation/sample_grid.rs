//! Samples at a fixed rate: the index of the sample before an instant, and the position between two samples.

use super::ExcitationError;
use crate::clock::{Cycles, Frequency, Instant};
use crate::scalar::Scalar;

/// A fixed sampling rate; the first sample is at time zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampleGrid<S> {
    rate: Frequency,
    pub(super) samples_per_second: S,
    /// Ticks from one sample to the next, rounded in the precision of the rate.
    ticks_per_sample: u64,
}

impl<S: Scalar> SampleGrid<S> {
    /// A grid of `rate` samples per second.
    pub(super) fn new(rate: S) -> Result<Self, ExcitationError> {
        let fixed = Frequency::from_hertz(rate).ok_or(ExcitationError::Frequency)?;
        if !(rate > S::ZERO) {
            return Err(ExcitationError::Frequency);
        }
        let interval = Instant::from_seconds(S::ONE / rate).ok_or(ExcitationError::Frequency)?;
        Ok(Self { rate: fixed, samples_per_second: rate, ticks_per_sample: interval.ticks() })
    }

    /// The index of the last sample at or before `at`, and the part of the interval since, 0 to 1.
    #[inline(always)]
    pub(super) fn place(&self, at: Instant) -> (u64, S) {
        let Cycles { whole, fraction } = self.rate.cycles(at);
        // `from_fraction` divides by 2⁶³.
        (whole, S::from_fraction((fraction >> 1).cast_signed()))
    }

    /// The index of the last sample at or before `at`.
    #[inline(always)]
    pub(super) fn sample_before(&self, at: Instant) -> u64 {
        self.rate.cycles(at).whole
    }

    /// Ticks from `at` to the next sample, or to a few millionths of the interval beyond it.
    pub(super) fn ticks_to_next(&self, at: Instant) -> u32 {
        // In integers: in `f32` the remainder rounds to zero near the sample, which would cause steps of one
        // tick. At a sample the remainder is the whole interval, 2³².
        let rest = (1 << 32) - (self.rate.phase(at) >> 32);
        rest.checked_mul(self.ticks_per_sample).map_or(u32::MAX, |product| {
            let ticks = product >> 32;
            // Past the sample, so that rounding leaves no short step before it.
            u32::try_from(ticks + (ticks >> 22) + 1).unwrap_or(u32::MAX)
        })
    }

    /// Ticks from one sample to the next, rounded down; `None` if the number does not fit in 64 bits.
    pub(super) fn whole_ticks_per_sample(&self) -> Option<u64> {
        self.rate.whole_ticks_per_cycle()
    }
}
