//! What changes while an estimator runs.

use super::accumulator::EnergyAccumulator;
use crate::excitation::Stream;
use crate::scalar::Scalar;
use crate::snapshot::{Snapshot, snapshot_fields, snapshot_variants};

/// How the samples stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// No sample yet.
    Waiting,
    /// The harvester follows them.
    Following,
    /// The harvester is lost: the next sample starts it anew.
    Lost,
}

/// Samples that are known and not yet taken into the stream: one, with those that were lost before it on a
/// straight line to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Queue<S> {
    /// The sample before.
    pub(super) from: S,
    /// The sample that ends the queue.
    pub(super) target: S,
    /// Whether that one is cut off at the sensor's range.
    pub(super) saturated: bool,
    /// Whether the harvester is to be started anew with it.
    pub(super) restarts: bool,
    pub(super) length: u32,
    pub(super) left: u32,
}

impl<S: Scalar> Queue<S> {
    pub(super) const EMPTY: Self =
        Self { from: S::ZERO, target: S::ZERO, saturated: false, restarts: false, length: 0, left: 0 };

    /// Takes the next sample off, and whether its value is uncertain; `None` where none is left.
    #[inline]
    pub(super) fn next(&mut self) -> Option<(S, bool)> {
        self.left = self.left.checked_sub(1)?;
        if self.left == 0 {
            return Some((self.target, self.saturated));
        }
        let part = S::from_u32(self.length - self.left) / S::from_u32(self.length);
        // Finite where both ends are.
        Some(((S::ONE - part) * self.from + part * self.target, true))
    }
}

/// The state of an estimator: a plain value that can be copied, saved, compared and restored.
///
/// `T` is the state of its harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State<S, T> {
    pub(super) stream: Stream<S>,
    pub(super) harvester: T,
    pub(super) accumulator: EnergyAccumulator<S>,
    pub(super) queue: Queue<S>,
    pub(super) phase: Phase,
    /// Whether the harvester has yet to be advanced to where the stream is known.
    pub(super) pending: bool,
    /// Whether each of the stream's samples is uncertain: bit 0 the newest, bit 2 the oldest.
    pub(super) uncertain: u8,
    /// Intervals of the stream for which the harvester is still settling.
    pub(super) settling: u32,
    /// Lost samples since the newest one that the stream or the queue holds.
    pub(super) missing: u32,
    /// Sequence number that the next sample should have.
    pub(super) expected: Option<u32>,
    pub(super) missing_samples: u32,
    pub(super) saturated_samples: u32,
    pub(super) uncertain_intervals: u64,
    pub(super) unknown_intervals: u64,
}

snapshot_fields!(impl [S: Scalar, T: Snapshot] State<S, T> {
    stream, harvester, accumulator, queue, phase, pending, uncertain, settling, missing, expected, missing_samples,
    saturated_samples, uncertain_intervals, unknown_intervals,
});

snapshot_fields!(impl [S: Scalar] Queue<S> { from, target, saturated, restarts, length, left }
    if |queue| queue.left <= queue.length);

snapshot_variants!(Phase { Waiting, Following, Lost });
