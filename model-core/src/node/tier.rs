//! What a board needs of a node, whatever the node needs to know, and the estimates of each node.

use core::num::NonZero;

use super::{Finding, Regular};
use crate::bounds::{Bounds, ParameterError};
use crate::scalar::add_increment;
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

    /// Takes samples of a burst, in order, as many as the FIFO has. Of a burst that is complete it does a part of the evaluation and takes none.
    /// At the end of a block before the last one it takes fewer than it is given, as [`Progress::More`] tells: give the others again.
    fn samples(&self, _state: &mut Self::State, _samples: &[i16]) -> Progress {
        Progress::Idle
    }

    /// Says that samples were lost, for example by an overrun of the FIFO: the burst goes on and gives no value.
    fn samples_lost(&self, _state: &mut Self::State) {}

    /// What the node knows now.
    fn status(&self, state: &Self::State) -> Status;

    /// The action with this index; `None` without one.
    fn action(&self, state: &Self::State, index: usize) -> Option<ActionStatus>;

    /// Books energy in J at the load, −10⁶ to 10⁶, that has left the storage beside what is stated; a negative one was booked and has
    /// not left it, as of an action that failed. Call it before the voltage is read again.
    ///
    /// # Errors
    /// An energy outside its bounds; nothing is booked then.
    fn book(&self, state: &mut Self::State, energy: f32) -> Result<(), ParameterError<f32>>;
}

/// What a node knows now. Bounds are two and a half standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Status {
    /// Voltage of the storage in V, of a battery the open-circuit one, without the income since the last reading that was used.
    pub voltage: f32,
    /// Stored energy in J without that income, at least 0.
    pub energy: f32,
    /// Bound of its error in J: infinite before the first reading, and after an outage that no clock knows.
    pub energy_bound: f32,
    /// Seconds from that reading to the last wake.
    pub energy_age: u32,
    /// Energy in J between the lock-out and a storage that may be full, above 0.
    pub room: f32,
    /// Part of the room that has energy, 0 to 1.
    pub charge: f32,
    /// Harvested power in W before the charging efficiency, at least 0: of a reading the mean since the one before, of a burst that of
    /// its time. What has changed since is not in it, nor in its bound.
    pub power: f32,
    /// Bound of its error in W.
    pub power_bound: f32,
    /// Seconds from the reading or the burst that it is by to the last wake.
    pub power_age: u32,
    /// By what the power is known.
    pub source: PowerSource,
    /// Seconds, at least, from the last wake to the lock-out without any income, action, reading and burst; 0 where the energy is unknown.
    pub endurance: f32,
    /// Whether the harvested power carries the node.
    pub verdict: Verdict,
}

/// Whether the harvested power is above standing power and leakage, by more than the bounds: at a cold start, whether the node lives on.
/// Actions, readings and bursts are left out. Where the power is assumed, as of a full storage, it is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// The bounds allow both.
    Open,
    /// The stored energy rises between readings.
    LivesOn,
    /// It falls.
    Fades,
}

/// Thresholds of [`Status::charge`] with hysteresis, the lowest first, between modes of a firmware.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Thresholds<const N: usize> {
    levels: [[f32; 2]; N],
    mode: usize,
}

impl<const N: usize> Thresholds<N> {
    /// Thresholds, each by the charge below which the upper mode ends, and that above which it begins, 0 to 1. Where the first is not the
    /// smaller one there is no hysteresis.
    #[must_use]
    pub const fn new(levels: [[f32; 2]; N]) -> Self {
        Self { levels, mode: 0 }
    }

    /// The mode now, 0 to `N`: 0 also where the stored energy is unknown.
    pub fn mode(&mut self, status: &Status) -> usize {
        let charge = if status.energy_bound < f32::INFINITY { status.charge } else { f32::NEG_INFINITY };
        while self.levels.get(self.mode).is_some_and(|[_, begin]| charge > *begin) {
            self.mode += 1;
        }
        while self.levels.get(..self.mode).and_then(<[_]>::last).is_some_and(|[end, _]| charge < *end) {
            self.mode -= 1;
        }
        self.mode
    }
}

/// By what a power is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PowerSource {
    /// Nothing: it is 0, with the largest power as its bound.
    Unknown,
    /// The power of before, as the last reading gave none; the bound includes any up to the largest one.
    Assumed,
    /// Two readings of the voltage: the mean between them.
    Voltage,
    /// The last burst, by the map.
    Map,
}

/// An action as a node sees it now.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ActionStatus {
    /// As stated.
    pub stated: Regular,
    /// Seconds since it ran, or since the start. It is due from [`Regular::every`] on.
    pub rested: u32,
    /// Whether the storage allows it; not before the first reading.
    pub is_affordable: bool,
}

/// Counts of an action.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TaskAccount {
    /// Times that it was carried out.
    pub done: u32,
    /// Times that it failed.
    pub failed: u32,
    /// Times [`Regular::every`] that it was due and the storage did not allow it, with those of an outage.
    pub refused: u32,
    /// Energy in J at the load that those done and failed took, within 10⁻⁷ of it.
    pub energy: f32,
    /// What rounding removed from it.
    rounded: f32,
    /// Refused since it ran.
    waiting: u32,
}

/// Counts of each action of a node, which the firmware keeps: neither the state nor its images have them.
///
/// An action in which the storage browned out is not entered: after [`Outage::LockedOutUntil`] any draw is within the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TaskLedger<const ACTIONS: usize> {
    /// By the index of the action.
    pub tasks: [TaskAccount; ACTIONS],
}

impl<const ACTIONS: usize> TaskLedger<ACTIONS> {
    /// Without any count.
    pub const EMPTY: Self = Self {
        tasks: [TaskAccount { done: 0, failed: 0, refused: 0, energy: 0.0, rounded: 0.0, waiting: 0 };
            ACTIONS],
    };

    /// Counts an action after [`Task::Run`] and before the voltage is read again. It took `used` J at the load, 0 to 10⁶, also if it failed;
    /// the node's books have that then in place of the stated energy.
    ///
    /// # Errors
    /// An index or an energy outside its bounds; nothing is counted then.
    pub fn enter<N: Tier>(
        &mut self,
        node: &N,
        state: &mut N::State,
        index: usize,
        used: f32,
        has_failed: bool,
    ) -> Result<(), ParameterError<f32>> {
        let Some((task, action)) = self.tasks.get_mut(index).zip(node.action(state, index)) else {
            let actions = (0..ACTIONS).take_while(|index| node.action(state, *index).is_some()).count();
            return Bounds::new(0.0, actions as f64 - 1.0).check("index", index as f32);
        };
        Bounds::new(0.0, 1e6).check("used", used)?;
        node.book(state, used - action.stated.energy)?;
        let count = if has_failed { &mut task.failed } else { &mut task.done };
        *count = count.saturating_add(1);
        (task.energy, task.rounded) = add_increment(task.energy, task.rounded, used);
        Ok(())
    }

    /// Counts what the storage refuses, after each [`Tier::wake`].
    pub fn watch<N: Tier>(&mut self, node: &N, state: &N::State) {
        for (index, task) in self.tasks.iter_mut().enumerate() {
            let Some(action) = node.action(state, index) else { continue };
            let times = action.rested.checked_div(action.stated.every).unwrap_or(0);
            let refused = if action.is_affordable { 0 } else { times.saturating_sub(task.waiting) };
            task.refused = task.refused.saturating_add(refused);
            task.waiting = task.waiting.min(times).saturating_add(refused);
        }
    }
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

/// The seconds of a node by a counter of so many ticks in a second, as `embassy_time::TICK_HZ` of `Instant::as_ticks`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TickClock(pub NonZero<u64>);

impl TickClock {
    /// Whole second of a tick, at most 2³² − 1.
    #[must_use]
    pub fn second(self, tick: u64) -> u32 {
        u32::try_from(tick / self.0).unwrap_or(u32::MAX)
    }

    /// First tick of the second at which [`Tier::wake`] is due again after a wake at a second.
    #[must_use]
    pub fn due(self, second: u32, wake: &Wake) -> u64 {
        self.0.get().saturating_mul(second.saturating_add(wake.again_in).into())
    }
}

/// The answer of [`Tier::samples`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// So many samples are still missing: fewer than before by those taken.
    More(u32),
    /// The burst is complete: switch the sensor off, and wake. What it found is known after some more calls, without samples; a wake does
    /// in place of such a call what is left, a part at a time.
    Done(Option<Finding>),
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
    /// The storage may have been full since the reading before, or its energy was not known: it says nothing about the income.
    #[default]
    Silent,
    /// It did not come, was at an end of the converter, or so far off that the next reading must confirm it.
    Refused,
}

snapshot_variants!(StoreReading { Used, Silent, Refused });
