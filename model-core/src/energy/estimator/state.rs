//! The state of a running estimator.

use super::accumulator::{ElapsedTime, EnergyAccumulator};
use super::response::Response;
use super::{Estimator, Settings};
use crate::excitation::{LARGEST_SAMPLE, Stream};
use crate::scalar::{Scalar, add_increment};
use crate::scene::Harvester;
use crate::snapshot::{Configuration, Fingerprint, Snapshot, snapshot_fields, snapshot_variants};

/// The relation of harvester and samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// No sample yet.
    Waiting,
    /// The harvester is simulated from the samples.
    Following,
    /// The state of the harvester is unknown: the next sample restarts it.
    Lost,
}

/// Samples that the stream has yet to take: one sample, preceded by lost samples interpolated linearly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Queue<S> {
    /// The previous sample in m/s².
    pub(super) from: S,
    /// The sample in m/s² that ends the queue.
    pub(super) target: S,
    /// Whether that sample is limited by the sensor's range.
    pub(super) saturated: bool,
    /// Whether the harvester restarts with that sample.
    pub(super) restarts: bool,
    pub(super) length: u32,
    pub(super) left: u32,
}

/// Most samples in a queue: [`Settings::longest_gap`](super::Settings::longest_gap) lost ones, and one.
const MOST_QUEUED: u32 = 1 << 16;

impl<S: Scalar> Queue<S> {
    /// Removes the next sample, with whether its value is uncertain; `None` for an empty queue.
    #[inline]
    pub(super) fn next(&mut self) -> Option<(S, bool)> {
        self.left = self.left.checked_sub(1)?;
        if self.left == 0 {
            return Some((self.target, self.saturated));
        }
        let part = S::from_u32(self.length.wrapping_sub(self.left)) / S::from_u32(self.length);
        // Finite if both ends are finite.
        Some(((S::ONE - part) * self.from + part * self.target, true))
    }
}

/// The state of an [`Estimator`]; it can be copied, compared, saved and restored. `T` is the state of its harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S, T> {
    pub(super) stream: Stream<S>,
    /// Largest error of the rate of the stream, relative.
    pub(super) rate_tolerance: S,
    pub(super) harvester: T,
    pub(super) accumulator: EnergyAccumulator<S>,
    pub(super) response: Response<S>,
    pub(super) bias: Bias<S>,
    /// The newest two samples in m/s², before the filter; the newest last.
    pub(super) unfiltered: [S; 2],
    pub(super) queue: Queue<S>,
    pub(super) phase: Phase,
    /// Whether the harvester has yet to be advanced to the end of the known acceleration.
    pub(super) pending: bool,
    /// Whether each of the stream's samples is uncertain: bit 0 the newest, bit 3 the one before the oldest.
    pub(super) uncertain: u8,
    /// Number of intervals until the harvester has settled.
    pub(super) settling: u32,
    /// Lost samples after the newest sample of the stream or the queue.
    pub(super) missing: u32,
    /// Sequence number that the next sample should have.
    pub(super) expected: Option<u32>,
    pub(super) missing_samples: u32,
    pub(super) saturated_samples: u32,
    pub(super) uncertain_time: ElapsedTime,
    pub(super) unknown_time: ElapsedTime,
}

impl<S: Scalar, T> State<S, T> {
    /// Before the first sample, with a harvester at rest.
    pub(super) fn waiting(stream: Stream<S>, rate_tolerance: S, harvester: T) -> Self {
        Self {
            stream,
            rate_tolerance,
            harvester,
            accumulator: EnergyAccumulator::default(),
            response: Response::default(),
            bias: Bias::default(),
            unfiltered: [S::ZERO; 2],
            queue: Queue::default(),
            phase: Phase::Waiting,
            pending: false,
            uncertain: 0,
            settling: 0,
            missing: 0,
            expected: None,
            missing_samples: 0,
            saturated_samples: 0,
            uncertain_time: ElapsedTime::default(),
            unknown_time: ElapsedTime::default(),
        }
    }

    /// Counts intervals as unknown.
    pub(super) fn add_unknown(&mut self, intervals: u32) {
        self.unknown_time.add_intervals(intervals, self.stream.ticks_per_sample());
    }
}

snapshot_fields!(impl [S: Scalar, T: Snapshot] State<S, T> {
    stream, rate_tolerance, harvester, accumulator, response, bias, unfiltered, queue, phase, pending, uncertain, settling,
    missing, expected, missing_samples, saturated_samples, uncertain_time, unknown_time,
} if |state| {
    let in_range = state.rate_tolerance >= S::ZERO && state.rate_tolerance <= S::ONE;
    in_range && (state.phase != Phase::Following || state.missing < MOST_QUEUED)
});

snapshot_fields!(impl [S: Scalar] Queue<S> { from, target, saturated, restarts, length, left }
    if |queue| queue.left <= queue.length && queue.length <= MOST_QUEUED);

snapshot_variants!(Phase { Waiting, Following, Lost });

impl<S: Scalar, H: Harvester<S>> Configuration for Estimator<S, H> {
    type State = State<S, H::State>;

    /// Includes the model, its method and step control, and all settings. A rate set later is part of the state.
    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.harvester.identify(fingerprint);
        self.settings.format.identify(fingerprint);
        let Settings { rate, settling_seconds, rate_tolerance, jitter, .. } = self.settings;
        fingerprint.numbers(&[rate, settling_seconds, rate_tolerance, jitter]);
        fingerprint.count(self.settings.longest_gap.into());
        fingerprint.count(self.settings.interpolation as u32);
        fingerprint.numbers(self.settings.bias_seconds.as_slice());
    }
}

/// The mean of all samples at first, an exponentially weighted mean later: a one-pole high-pass of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bias<S> {
    /// The mean in m/s², and its rounding remainder: a sample changes the mean of a long time by less than a rounding.
    pub(super) mean: S,
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
}

snapshot_fields!(impl [S: Scalar] Bias<S> { mean, remainder, samples } if |bias| {
    let largest = S::from_f64(LARGEST_SAMPLE);
    bias.mean.abs() <= largest && bias.remainder.abs() <= largest
});
