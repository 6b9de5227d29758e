//! What outlasts a loss of power: the plant, and two slots of non-volatile memory. And when the power is lost.

use model_core::node::{Board, Fault};

use super::Meter;
use super::parts::ExampleNode;
use super::plant::{Draws, Plant};

pub const IMAGE_BYTES: usize = model_core::snapshot::image_size::<ExampleNode>();

/// Seconds from one image to the next.
pub const IMAGE_EVERY: u32 = 3600;

/// When the power is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// When so many bytes of an image are written. The rest of the slot has what it had before.
    Writing(usize),
    /// In a burst, after some of its samples.
    Sampling,
}

/// A loss of power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loss {
    /// The first such moment from this second of the day on.
    pub from: u32,
    pub moment: Moment,
}

/// The losses of power in the day, in order: in an image at its start, in its middle and before its last byte, after an
/// image, and in bursts.
pub const LOSSES: [Loss; 10] = [
    loss(2, Moment::Writing(IMAGE_BYTES)),
    loss(4, Moment::Writing(0)),
    loss(6, Moment::Sampling),
    loss(7, Moment::Writing(1)),
    loss(9, Moment::Writing(IMAGE_BYTES / 2)),
    // The same image once more.
    loss(9, Moment::Writing(IMAGE_BYTES - 1)),
    loss(12, Moment::Sampling),
    loss(14, Moment::Writing(IMAGE_BYTES - 4)),
    loss(17, Moment::Writing(IMAGE_BYTES)),
    loss(20, Moment::Writing(100)),
];

const fn loss(hour: u32, moment: Moment) -> Loss {
    Loss { from: 3600 * hour, moment }
}

/// A slot of memory, and the plant at the time at which it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slot {
    bytes: [u8; IMAGE_BYTES],
    plant: Plant,
}

/// Calls of the node and what they took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Count {
    pub calls: u32,
    /// Samples of the accelerometer that they took in.
    pub samples: u32,
    /// Ticks of the meter, without those of the board.
    pub ticks: u64,
}

/// What a call of the node did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// A wake with a reading of the voltage.
    Reading,
    /// A wake from sleep without a reading.
    Wake,
    /// A wake after an action.
    Action,
    Samples,
    /// The last samples of a burst with its look-up, and the wake after them.
    Burst,
}

/// All of them, in order.
pub const WORK: [Work; 5] = [Work::Reading, Work::Wake, Work::Action, Work::Samples, Work::Burst];

impl Work {
    /// One word, for the log.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reading => "reading",
            Self::Wake => "wake",
            Self::Action => "action",
            Self::Samples => "samples",
            Self::Burst => "burst",
        }
    }
}

/// What outlasts a loss of power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct World {
    plant: Plant,
    slots: [Slot; 2],
    /// Losses of power that have happened.
    losses: usize,
    /// Losses of power that may happen.
    most_losses: usize,
    is_off: bool,
    counts: [Count; WORK.len()],
    /// Deepest stack in bytes.
    pub stack: u32,
}

impl World {
    /// At midnight, with empty slots; the first so many of [`LOSSES`] will happen.
    #[must_use]
    pub fn new(losses: usize) -> Self {
        let plant = Plant::at_midnight();
        let slot = Slot { bytes: [0xff; IMAGE_BYTES], plant };
        Self {
            plant,
            slots: [slot; 2],
            losses: 0,
            most_losses: losses,
            is_off: false,
            counts: [Count::default(); WORK.len()],
            stack: 0,
        }
    }

    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Income in pJ since the last call.
    pub(super) fn income_since(&mut self) -> u64 {
        let income = self.plant.income;
        income.wrapping_sub(core::mem::replace(&mut self.plant.reported, income))
    }

    /// Losses of power so far.
    #[must_use]
    pub fn losses(&self) -> usize {
        self.losses
    }

    /// Calls of the node, in the order of [`WORK`].
    #[must_use]
    pub fn counts(&self) -> &[Count] {
        &self.counts
    }

    /// The power is back.
    pub(super) fn switch_on(&mut self) {
        self.is_off = false;
    }

    /// Whether the power is lost.
    pub(super) fn is_off(&self) -> bool {
        self.is_off
    }

    /// Sets the plant back to the time of an image.
    pub(super) fn set_back(&mut self, second: u32) {
        if let Some(slot) = self.slots.iter().find(|slot| slot.plant.second == second) {
            self.plant = slot.plant;
        }
    }

    pub(super) fn count(&mut self, work: Work, samples: u32, ticks: u64) {
        if let Some(count) = self.counts.get_mut(work as usize) {
            (count.calls, count.samples) = (count.calls.wrapping_add(1), count.samples.wrapping_add(samples));
            count.ticks = count.ticks.wrapping_add(ticks);
        }
    }

    /// The next loss of power, if it is due.
    fn due(&self) -> Option<Moment> {
        let next = LOSSES.get(..self.most_losses)?.get(self.losses)?;
        (self.plant.second >= next.from).then_some(next.moment)
    }

    fn lose_power(&mut self) {
        (self.losses, self.is_off) = (self.losses.wrapping_add(1), true);
    }
}

/// The board of a [`World`].
#[derive(Debug)]
pub(super) struct Simulated<'a, M> {
    pub(super) world: &'a mut World,
    draws: Draws,
    meter: &'a M,
    /// Ticks that the board took, and samples that it gave.
    pub(super) ticks: u64,
    pub(super) samples: u32,
}

impl<'a, M: Meter> Simulated<'a, M> {
    pub(super) fn new(world: &'a mut World, draws: Draws, meter: &'a M) -> Self {
        Self { world, draws, meter, ticks: 0, samples: 0 }
    }

    /// The energy of so many readings leaves the storage.
    pub(super) fn know(&mut self, readings: u32) {
        self.world.plant.know(&self.draws, readings);
    }

    /// Does the work of the board and counts what it takes.
    fn work<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let started = self.meter.ticks();
        let done = work(self);
        self.ticks = self.ticks.wrapping_add(self.meter.ticks().wrapping_sub(started));
        done
    }
}

impl<M: Meter> Board for Simulated<'_, M> {
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        self.work(|board| {
            let plant = &mut board.world.plant;
            let until = if samples > 0 { plant.fill(samples) } else { plant.second.wrapping_add(seconds) };
            plant.advance(&board.draws, until);
            plant.second
        })
    }

    fn storage_code(&mut self) -> Option<u32> {
        self.work(|board| Some(board.world.plant.read()))
    }

    fn start_sensor(&mut self) -> Result<(), Fault> {
        self.work(|board| board.world.plant.start_sensor(&board.draws));
        Ok(())
    }

    fn stop_sensor(&mut self) {
        self.work(|board| board.world.plant.stop_sensor());
    }

    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        let count = self.work(|board| board.world.plant.take(samples));
        self.samples = self.samples.wrapping_add(count as u32);
        if count > 0 && self.world.due() == Some(Moment::Sampling) {
            self.world.lose_power();
        }
        Ok(count)
    }

    fn run(&mut self, action: usize) {
        self.work(|board| board.world.plant.run(&board.draws, action));
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        if let Some(slot) = self.world.slots.get(slot) {
            bytes.iter_mut().zip(slot.bytes).for_each(|(to, from)| *to = from);
        }
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        let written = match self.world.due() {
            Some(Moment::Writing(bytes)) => {
                self.world.lose_power();
                bytes
            }
            _ => bytes.len(),
        };
        let plant = self.world.plant;
        if let Some(slot) = self.world.slots.get_mut(slot) {
            slot.bytes.iter_mut().zip(bytes).take(written).for_each(|(to, from)| *to = *from);
            slot.plant = plant;
        }
        Ok(())
    }
}
