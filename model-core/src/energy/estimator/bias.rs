//! Tracks the mean of the samples: gravity and the bias of the sensor.

use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// The mean of all samples at first, an exponentially weighted mean later: a one-pole high-pass of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bias<S> {
    /// The mean in m/s².
    mean: S,
    /// Number of samples in the mean, at most that of the time constant.
    samples: u32,
}

impl<S: Scalar> Bias<S> {
    /// Includes a sample in m/s² into a mean over `longest` samples.
    pub(super) fn track(&mut self, sample: S, longest: u32) {
        self.samples = self.samples.saturating_add(1).min(longest.max(1));
        self.mean += (sample - self.mean) / S::from_u32(self.samples);
    }

    /// The mean in m/s².
    pub(super) fn mean(&self) -> S {
        self.mean
    }
}

snapshot_fields!(impl [S: Scalar] Bias<S> { mean, samples });
