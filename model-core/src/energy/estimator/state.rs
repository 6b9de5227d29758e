//! What changes while an estimator runs.

use super::accumulator::EnergyAccumulator;
use crate::excitation::Stream;
use crate::scalar::Scalar;
use crate::snapshot::{Reader, Snapshot, SnapshotError, Writer};

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
pub struct State<S, T> {
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

impl<S: Scalar, T: Snapshot> Snapshot for State<S, T> {
    const BYTES: usize = Stream::<S>::BYTES
        + T::BYTES
        + EnergyAccumulator::<S>::BYTES
        + Queue::<S>::BYTES
        + Phase::BYTES
        + bool::BYTES
        + u8::BYTES
        + 4 * u32::BYTES
        + Option::<u32>::BYTES
        + 2 * u64::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.stream.write(out);
        self.harvester.write(out);
        self.accumulator.write(out);
        self.queue.write(out);
        self.phase.write(out);
        self.pending.write(out);
        self.uncertain.write(out);
        self.settling.write(out);
        self.missing.write(out);
        self.expected.write(out);
        self.missing_samples.write(out);
        self.saturated_samples.write(out);
        self.uncertain_intervals.write(out);
        self.unknown_intervals.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(Self {
            stream: Snapshot::read(from)?,
            harvester: Snapshot::read(from)?,
            accumulator: Snapshot::read(from)?,
            queue: Snapshot::read(from)?,
            phase: Snapshot::read(from)?,
            pending: Snapshot::read(from)?,
            uncertain: Snapshot::read(from)?,
            settling: Snapshot::read(from)?,
            missing: Snapshot::read(from)?,
            expected: Snapshot::read(from)?,
            missing_samples: Snapshot::read(from)?,
            saturated_samples: Snapshot::read(from)?,
            uncertain_intervals: Snapshot::read(from)?,
            unknown_intervals: Snapshot::read(from)?,
        })
    }
}

impl<S: Scalar> Snapshot for Queue<S> {
    const BYTES: usize = 2 * S::BYTES + 2 * bool::BYTES + 2 * u32::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.from.write(out);
        self.target.write(out);
        self.saturated.write(out);
        self.restarts.write(out);
        self.length.write(out);
        self.left.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let queue = Self {
            from: Snapshot::read(from)?,
            target: Snapshot::read(from)?,
            saturated: Snapshot::read(from)?,
            restarts: Snapshot::read(from)?,
            length: Snapshot::read(from)?,
            left: Snapshot::read(from)?,
        };
        if queue.left <= queue.length { Ok(queue) } else { Err(SnapshotError::NoState) }
    }
}

impl Snapshot for Phase {
    const BYTES: usize = 1;

    fn write(&self, out: &mut Writer<'_>) {
        match self {
            Self::Waiting => 0_u8,
            Self::Following => 1,
            Self::Lost => 2,
        }
        .write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        match u8::read(from)? {
            0 => Ok(Self::Waiting),
            1 => Ok(Self::Following),
            2 => Ok(Self::Lost),
            _ => Err(SnapshotError::NoState),
        }
    }
}
