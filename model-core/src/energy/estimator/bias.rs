//! Tracks the mean of the samples: gravity and the bias of the sensor.

use crate::excitation::LARGEST_SAMPLE;
use crate::scalar::{Scalar, add_increment};
use crate::snapshot::snapshot_fields;

/// The mean of all samples at first, an exponentially weighted mean later: a one-pole high-pass of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bias<S> {
    /// The mean in m/s², and its rounding remainder: a sample changes the mean of a long time by less than a rounding.
    mean: S,
    remainder: S,
    /// Number of samples in the mean, at most that of the time constant.
    samples: u32,
}

impl<S: Scalar> Bias<S> {
    /// Includes a sample in m/s² into a mean over `longest` samples.
    pub(super) fn track(&mut self, sample: S, longest: u32) {
        self.samples = self.samples.saturating_add(1).min(longest.max(1));
        let increment = (sample - self.mean) / S::from_u32(self.samples);
        (self.mean, self.remainder) = add_increment(self.mean, self.remainder, increment);
    }

    /// The mean in m/s².
    pub(super) fn mean(&self) -> S {
        self.mean
    }
}

snapshot_fields!(impl [S: Scalar] Bias<S> { mean, remainder, samples } if |bias| {
    let largest = S::from_f64(LARGEST_SAMPLE);
    bias.mean.abs() <= largest && bias.remainder.abs() <= largest
});
