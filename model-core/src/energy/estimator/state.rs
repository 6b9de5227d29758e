//! What changes while an estimator runs.

use super::tally::Tally;
use crate::excitation::Stream;
use crate::image::{Image, ImageError, Reader, Writer};
use crate::scalar::Scalar;

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
/// `T` is the state of its model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S, T> {
    pub(super) stream: Stream<S>,
    pub(super) model: T,
    pub(super) tally: Tally<S>,
    pub(super) queue: Queue<S>,
    pub(super) phase: Phase,
    /// Whether the model has yet to be advanced to where the stream is known.
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

impl<S: Scalar, T: Image> Image for State<S, T> {
    const BYTES: usize = Stream::<S>::BYTES
        + T::BYTES
        + Tally::<S>::BYTES
        + Queue::<S>::BYTES
        + Phase::BYTES
        + bool::BYTES
        + u8::BYTES
        + 4 * u32::BYTES
        + Option::<u32>::BYTES
        + 2 * u64::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.stream.write(out);
        self.model.write(out);
        self.tally.write(out);
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

    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError> {
        Ok(Self {
            stream: Image::read(from)?,
            model: Image::read(from)?,
            tally: Image::read(from)?,
            queue: Image::read(from)?,
            phase: Image::read(from)?,
            pending: Image::read(from)?,
            uncertain: Image::read(from)?,
            settling: Image::read(from)?,
            missing: Image::read(from)?,
            expected: Image::read(from)?,
            missing_samples: Image::read(from)?,
            saturated_samples: Image::read(from)?,
            uncertain_intervals: Image::read(from)?,
            unknown_intervals: Image::read(from)?,
        })
    }
}

impl<S: Scalar> Image for Queue<S> {
    const BYTES: usize = 2 * S::BYTES + 2 * bool::BYTES + 2 * u32::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.from.write(out);
        self.target.write(out);
        self.saturated.write(out);
        self.restarts.write(out);
        self.length.write(out);
        self.left.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError> {
        let queue = Self {
            from: Image::read(from)?,
            target: Image::read(from)?,
            saturated: Image::read(from)?,
            restarts: Image::read(from)?,
            length: Image::read(from)?,
            left: Image::read(from)?,
        };
        if queue.left <= queue.length { Ok(queue) } else { Err(ImageError::NoState) }
    }
}

impl Image for Phase {
    const BYTES: usize = 1;

    fn write(&self, out: &mut Writer<'_>) {
        match self {
            Self::Waiting => 0_u8,
            Self::Following => 1,
            Self::Lost => 2,
        }
        .write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError> {
        match u8::read(from)? {
            0 => Ok(Self::Waiting),
            1 => Ok(Self::Following),
            2 => Ok(Self::Lost),
            _ => Err(ImageError::NoState),
        }
    }
}
