//! What a board needs of a node, whatever the node needs to know, and the estimates of each node.

use super::Finding;
use crate::snapshot::{Configuration, snapshot_fields, snapshot_variants};

/// Standard deviations in a bound. The vibration of machines jumps more often than a normal distribution has it: two would
/// hold for nine hours of ten.
pub(super) const BOUND: f32 = 2.5;

/// A node as its board sees it: [`VoltageNode`](super::VoltageNode), or [`MapNode`](super::MapNode), which takes bursts of samples
/// too. [`Runner`](super::Runner) drives either. Nothing waits: each call does a bounded amount of work.
pub trait Tier: Configuration {
    /// Whether it takes bursts of samples. Without them none of their code is in a [`Runner`](super::Runner).
    const BURSTS: bool = false;

    /// The state before any reading, at a time in whole seconds of the clock. Read the voltage before the first
    /// [`Tier::wake`]: without it the node can afford nothing.
    fn start(&self, second: u32) -> Self::State;

    /// Second of the clock at the last wake.
    fn second(state: &Self::State) -> u32;

    /// Advances the time to the second `now`, with the code of the converter for the storage's voltage where it was read,
    /// and says what to do.
    fn wake(&self, state: &mut Self::State, now: u32, code: Option<u32>) -> Wake;

    /// As [`Tier::wake`] after a time without calls.
    fn wake_after(&self, state: &mut Self::State, gap: Outage, code: Option<u32>) -> Wake;

    /// Takes samples of a burst, in order, as many as the FIFO has.
    fn samples(&self, _state: &mut Self::State, _samples: &[i16]) -> Progress {
        Progress::Idle
    }

    /// Says that samples were lost, for example by an overrun of the FIFO: the burst goes on and gives no value.
    fn samples_lost(&self, _state: &mut Self::State) {}
}

/// What to do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Task {
    /// Nothing.
    Sleep,
    /// Take so many samples, those of the start-up included, and give them to [`Tier::samples`].
    Burst {
        /// Samples that are still missing.
        samples: u32,
    },
    /// Carry out the action with this index. Its energy is booked.
    Run(usize),
}

/// The answer of [`Tier::wake`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wake {
    /// What to do now.
    pub task: Task,
    /// Call [`Tier::wake`] again after so many seconds; after the task, or at once, if 0.
    pub again_in: u32,
    /// Read the voltage of the storage before that call.
    pub read: bool,
}

/// The answer of [`Tier::samples`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// So many samples are still missing.
    More(u32),
    /// The burst is complete: switch the sensor off, and wake.
    Done(Finding),
    /// No burst is under way: switch the sensor off.
    Idle,
}

/// The time between an image and the resumption from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outage {
    /// The node was on until this second of its clock, and lost its memory only. What it did after the image is unknown: the
    /// income since is uncertain by the energy of what it could have run.
    OnUntil(u32),
    /// The node was off from the image until this second of its clock: nothing was drawn. An image is then saved at the
    /// power-down. What the node spends after the image is taken for an income that was missing.
    OffUntil(u32),
    /// The node went off at an unknown time after the image, as by a lock-out, and was off until this second of its clock. It
    /// drew any energy up to what it draws at most; the income of the time is uncertain by as much.
    LockedOutUntil(u32),
    /// The node was off for a time that no clock knows. The clock goes on from the second of the image.
    Unknown,
}

impl Outage {
    /// Second of the clock at its end; `None` if no clock knows it.
    pub(super) fn end(self) -> Option<u32> {
        match self {
            Self::OnUntil(now) | Self::OffUntil(now) | Self::LockedOutUntil(now) => Some(now),
            Self::Unknown => None,
        }
    }
}

/// The income of a time with its bound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IncomeOfTime {
    /// Seconds.
    pub seconds: u32,
    /// Harvested energy in J, before the charging efficiency.
    pub energy: f32,
    /// Bound of its error in J: two and a half standard deviations.
    pub bound: f32,
    /// Seconds of them without an estimate, as the storage was full or its energy unknown.
    pub silent: u32,
}

snapshot_fields!(impl [] IncomeOfTime { seconds, energy, bound, silent });

/// What a reading of the voltage was good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreReading {
    /// It gave the income.
    Used,
    /// The storage may have been full since the reading before, or its energy was not known: the reading says nothing about
    /// the income.
    #[default]
    Silent,
    /// It did not come, was at an end of the converter, or so far off that the next reading must confirm it.
    Refused,
}

snapshot_variants!(StoreReading { Used, Silent, Refused });
