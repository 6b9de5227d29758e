//! Samples at a fixed rate: the index of the sample before an instant, and the position between two samples.

use super::{Excitation, ExcitationError, Line};
use crate::clock::{Cycles, Frequency, Instant};
use crate::scalar::Scalar;

/// The line over a step of an acceleration that is linear between samples. `bracket` has the samples around
/// the end of the step and the place between them, 0 to 1; `step_in_samples` is the step over their distance.
#[inline]
pub(super) fn line_between_samples<S: Scalar>(
    excitation: &impl Excitation<S>,
    (at, ticks): (Instant, u32),
    step_in_samples: S,
    start: S,
    (before, after, theta): (S, S, S),
) -> Line<S> {
    // The step began after the sample before its end.
    if theta >= step_in_samples {
        return Line::between(start, before + theta * (after - before));
    }
    line_of_pieces(excitation, (at, ticks), start, |at, ticks, start| {
        Line::between(start, excitation.acceleration(at.after(ticks)))
    })
}

/// The items of [`Excitation`] between samples of a `grid`, by `bracket`: the samples around an instant and the place between.
macro_rules! between_samples {
    () => {
        #[inline]
        fn acceleration(&self, at: Instant) -> S {
            let (left, right, theta) = self.bracket(at);
            left + theta * (right - left)
        }

        fn jerk(&self, at: Instant) -> S {
            let (left, right, _) = self.bracket(at);
            (right - left) * self.grid.samples_per_second
        }

        fn smooth_ticks(&self, at: Instant) -> u32 {
            self.grid.ticks_to_next(at)
        }

        #[inline]
        fn response(&self, at: Instant, _ticks: u32, kernel: &Kernel<S>) -> Response<S> {
            let (left, right, theta) = self.bracket(at);
            let rise = right - left;
            kernel.to_line(left + theta * rise, rise * self.grid.samples_per_second)
        }

        #[inline]
        fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S> {
            let around_end = self.bracket(at.after(ticks));
            line_between_samples(self, (at, ticks), step * self.grid.samples_per_second, start, around_end)
        }
    };
}
pub(super) use between_samples;

/// The line over a step from the lines over its pieces, which end at the kinks of the acceleration; `line_of` gives that
/// of a piece from its start, its ticks and the acceleration at its start.
///
/// With `u` from −1 to 1 over the step, the mean is half of `∫ a du`, and half the rise 3/2 of `∫ a u du`. Of samples it
/// is exact but for a jump at the last one of a trace.
#[cold]
#[inline(never)]
pub(super) fn line_of_pieces<S: Scalar>(
    excitation: &impl Excitation<S>,
    (at, ticks): (Instant, u32),
    start: S,
    line_of: impl Fn(Instant, u32, S) -> Line<S>,
) -> Line<S> {
    let half = S::from_f64(0.5);
    let place = |offset: u32| {
        let twice = S::from_u32(offset) / S::from_u32(ticks);
        twice + twice - S::ONE
    };
    let (mut from, mut left) = (0, start);
    let mut until = excitation.smooth_ticks(at).min(ticks);
    let (mut mean, mut moment) = (S::ZERO, S::ZERO);
    loop {
        let piece = line_of(at.after(from), until.wrapping_sub(from), left);
        let (begin, end) = (place(from), place(until));
        let (length, middle) = (end - begin, half * (begin + end));
        mean += length * piece.mean;
        moment += length * (middle * piece.mean + piece.tilt * length * S::from_f64(1.0 / 6.0));
        if until >= ticks {
            return Line { mean: half * mean, tilt: S::from_f64(1.5) * moment, end: piece.end };
        }
        (from, left) = (until, piece.end);
        until = until.saturating_add(excitation.smooth_ticks(at.after(until))).min(ticks);
    }
}

/// A fixed sampling rate; the first sample is at time zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampleGrid<S> {
    rate: Frequency,
    pub(super) samples_per_second: S,
    /// Ticks from one sample to the next, rounded in the precision of the rate.
    ticks_per_sample: u64,
}

impl<S: Scalar> SampleGrid<S> {
    /// A grid without a rate, for a stream that cannot be restored.
    pub(super) fn without_rate() -> Self {
        Self { rate: Frequency::default(), samples_per_second: S::ZERO, ticks_per_sample: 0 }
    }

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
    #[inline]
    pub(super) fn place(&self, at: Instant) -> (u64, S) {
        let Cycles { whole, fraction } = self.rate.cycles(at);
        // `from_fraction` divides by 2⁶³.
        (whole, S::from_fraction((fraction >> 1).cast_signed()))
    }

    /// The index of the last sample at or before `at`.
    #[inline]
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
