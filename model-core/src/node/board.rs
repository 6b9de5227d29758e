//! What a node needs of the hardware, and a loop over it.

use super::{Finding, Outage, Progress, Task, Tier, Wake};
use crate::snapshot::{NUMBERED, SnapshotError, image_size, newest_slot, number, read_image, save_image};

/// The hardware of a node.
///
/// [`Runner`] calls it. Firmware that is driven by interrupts or an executor calls its [`Tier`] itself and has no need of this trait.
pub trait Board {
    /// Sleeps for at most `seconds`, or until the sensor, if it is on, has about `samples`. Returns the second of the clock.
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32;

    /// The code of the converter for the storage's voltage; `None` if it cannot be read.
    fn storage_code(&mut self) -> Option<u32>;

    /// Starts the accelerometer, with its FIFO. Only a node that takes bursts calls this function and the next two.
    ///
    /// # Errors
    /// If the sensor does not answer.
    fn start_sensor(&mut self) -> Result<(), Fault> {
        Err(Fault)
    }

    /// Stops the accelerometer: standby. If its supply is switched off instead, no line to it may be high then.
    fn stop_sensor(&mut self) {}

    /// Moves samples along the axis of the harvester from the FIFO to the front of `samples`, as raw counts. Returns
    /// their number, which may be 0.
    ///
    /// # Errors
    /// If samples were lost since the last call, or the sensor does not answer.
    fn read_samples(&mut self, _samples: &mut [i16]) -> Result<usize, Fault> {
        Err(Fault)
    }

    /// Carries an action out.
    fn run(&mut self, action: usize);

    /// Copies the front of a slot of non-volatile memory, 0 or 1, to `bytes`: an image, or the head of that image.
    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]);

    /// Writes `bytes` to the front of a slot of non-volatile memory. A write that is interrupted may leave any bytes.
    ///
    /// # Errors
    /// If the memory reports that it did not erase or write. [`Runner::save`] also reads each image back.
    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault>;
}

/// The hardware did not do what was asked of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault;

/// The reason why an image was not saved. The slot of the newest valid image is as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError {
    /// The node is not [idle](Runner::is_idle): an action is booked and not carried out, or a burst is under way.
    NotIdle,
    /// The buffer is too small.
    Buffer(SnapshotError),
    /// The memory reported a failure, or did not give back what was written.
    Memory,
}

impl core::fmt::Display for SaveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotIdle => write!(f, "the node is not idle"),
            Self::Buffer(error) => error.fmt(f),
            Self::Memory => write!(f, "the memory did not take the image"),
        }
    }
}

impl core::error::Error for SaveError {}

/// A node on a board.
#[derive(Debug)]
pub struct Runner<'a, B, N: Tier> {
    board: B,
    node: &'a N,
    state: N::State,
    wake: Wake,
    is_sampling: bool,
    /// Number and slot of the newest image; `None` before a look at the slots.
    newest: Option<(u32, usize)>,
}

/// Samples that are taken out of the FIFO at once.
const BURST: usize = 128;

/// What a step of a [`Runner`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Step {
    /// It slept and kept the books.
    Slept,
    /// It took samples.
    Sampled,
    /// It finished a burst.
    Burst(Finding),
    /// It carried an action out.
    Ran(usize),
}

impl<'a, B: Board, N: Tier> Runner<'a, B, N>
where
    N::State: Copy,
{
    /// A node that wakes up at `second` and knows nothing. It reads the voltage of the storage.
    #[inline(never)]
    pub fn new(mut board: B, node: &'a N, second: u32) -> Self {
        let mut state = node.start(second);
        let code = board.storage_code();
        let wake = node.wake(&mut state, second, code);
        Self { board, node, state, wake, is_sampling: false, newest: None }
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &N::State {
        &self.state
    }

    /// The state, for what a firmware asks of the node, as [`MapState::ask_for_burst`](super::MapState::ask_for_burst).
    pub fn state_mut(&mut self) -> &mut N::State {
        &mut self.state
    }

    /// Whether the next step sleeps: nothing is booked that has not been done. Save an image then.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        matches!(self.wake.task, Task::Sleep)
    }

    /// The node.
    #[must_use]
    pub fn node(&self) -> &'a N {
        self.node
    }

    /// The board.
    #[must_use]
    pub fn board(&self) -> &B {
        &self.board
    }

    /// The board, for what the node does not do.
    pub fn board_mut(&mut self) -> &mut B {
        &mut self.board
    }

    /// The board, after power-down.
    #[must_use]
    pub fn into_board(self) -> B {
        self.board
    }

    /// The same with another node of the same storage, as of [learnt parameters](super::LearntCapacitance::parameters). Call it while
    /// it is idle. It reads the voltage; of the time since the last reading nothing is said.
    #[must_use]
    pub fn with_node<'n>(mut self, node: &'n N) -> Runner<'n, B, N> {
        let code = self.board.storage_code();
        let wake = node.wake_after(&mut self.state, Outage::Unknown, code);
        Runner { board: self.board, node, state: self.state, wake, is_sampling: false, newest: self.newest }
    }

    /// Does what the node said, one thing, and asks it again. Only [`Board::sleep`] takes time.
    pub fn step(&mut self) -> Step {
        match self.wake.task {
            Task::Run(action) => {
                self.board.run(action);
                self.ask(N::second(&self.state), None);
                Step::Ran(action)
            }
            Task::Sleep => {
                let now = self.board.sleep(self.wake.again_in, 0);
                let code = if self.wake.read { self.board.storage_code() } else { None };
                self.ask(now, code);
                Step::Slept
            }
            Task::Burst { samples } if N::BURSTS => self.burst(samples),
            Task::Burst { .. } => Step::Slept,
        }
    }

    /// Takes a burst of samples.
    #[inline(never)]
    fn burst(&mut self, mut missing: u32) -> Step {
        if !self.is_sampling {
            self.is_sampling = true;
            if self.board.start_sensor().is_err() {
                self.node.samples_lost(&mut self.state);
            }
        }
        let mut burst = [0; BURST];
        let now = self.board.sleep(self.wake.again_in, missing.min(BURST as u32));
        let mut found = None;
        while self.is_sampling {
            let Ok(count) = self.board.read_samples(&mut burst) else {
                self.node.samples_lost(&mut self.state);
                break;
            };
            let mut left = burst.get(..count).unwrap_or(&burst);
            if left.is_empty() {
                break;
            }
            while !left.is_empty() && self.is_sampling {
                match self.node.samples(&mut self.state, left) {
                    Progress::More(samples) => {
                        left = left.get(missing.saturating_sub(samples) as usize..).unwrap_or(&[]);
                        (missing, self.wake.task) = (samples, Task::Burst { samples });
                    }
                    Progress::Done(finding) => {
                        self.board.stop_sensor();
                        (self.is_sampling, found) = (false, finding);
                    }
                    Progress::Idle => left = &[],
                }
            }
        }
        while !self.is_sampling
            && found.is_none()
            && let Progress::Done(finding) = self.node.samples(&mut self.state, &[])
        {
            found = finding;
        }
        // The books wait for the end of the burst, because they cost more than a part of it.
        let since = now.checked_sub(N::second(&self.state));
        let is_over = since.is_none_or(|since| since >= self.wake.again_in);
        if !self.is_sampling || is_over {
            self.ask(now, None);
        }
        found.map_or(Step::Sampled, Step::Burst)
    }

    #[inline(never)]
    fn ask(&mut self, now: u32, code: Option<u32>) {
        self.wake = self.node.wake(&mut self.state, now, code);
        if N::BURSTS && self.is_sampling && !matches!(self.wake.task, Task::Burst { .. }) {
            self.board.stop_sensor();
            self.is_sampling = false;
        }
    }

    /// Writes an image of the state to the slot that is not the newest one, and reads it back, by way of a buffer of at
    /// least [`image_size`] bytes. Returns the number of the image.
    ///
    /// A node that begins anew finds the number of the newest image in the slots, so that its own is newer.
    ///
    /// # Errors
    /// [`SaveError`]. After a failure the next image goes to the same slot with the same number.
    #[cold]
    #[inline(never)]
    pub fn save(&mut self, buffer: &mut [u8]) -> Result<u32, SaveError> {
        if !self.is_idle() {
            return Err(SaveError::NotIdle);
        }
        let (needed, given) = (Self::image_bytes(), buffer.len());
        if given < needed {
            return Err(SaveError::Buffer(SnapshotError::NoRoom { needed, given }));
        }
        let (newest, taken) = match self.newest {
            Some(newest) => newest,
            None => self.take_newest(buffer, true).unwrap_or((0, 1)),
        };
        let (sequence, slot) = (newest.wrapping_add(1), 1 - taken.min(1));
        let size = save_image(self.node, &self.state, sequence, buffer).map_err(SaveError::Buffer)?;
        let image = buffer.get_mut(..size).unwrap_or(&mut []);
        let checksum = image.last_chunk::<4>().copied();
        self.board.write_slot(slot, image).map_err(|Fault| SaveError::Memory)?;
        // The image of an attempt that failed may be whole, of another state and of the same number.
        if self.sequence_in(slot, image) != Ok(sequence) || image.last_chunk().copied() != checksum {
            return Err(SaveError::Memory);
        }
        self.newest = Some((sequence, slot));
        Ok(sequence)
    }

    /// Reads the newest image of this node to the state; gives its number and slot. Without one, or with `keeps_state`, the state stays.
    #[inline(never)]
    fn take_newest(&mut self, buffer: &mut [u8], keeps_state: bool) -> Result<(u32, usize), SnapshotError> {
        let state = self.state;
        let numbers = [0, 1].map(|slot| {
            let mut head = [0; NUMBERED];
            self.board.read_slot(slot, &mut head);
            number(&head)
        });
        let newest = newest_slot(numbers, |slot| self.take_image(slot, buffer));
        if keeps_state || newest.is_err() {
            self.state = state;
        }
        newest
    }

    /// Reads the image in a slot to the state; gives its number. Of an image that is not valid the state has no meaning.
    #[inline(never)]
    fn take_image(&mut self, slot: usize, buffer: &mut [u8]) -> Result<u32, SnapshotError> {
        self.board.read_slot(slot, buffer);
        read_image(self.node, buffer, &mut self.state)
    }

    /// Number of the image in a slot, if it is valid.
    #[inline(never)]
    fn sequence_in(&mut self, slot: usize, buffer: &mut [u8]) -> Result<u32, SnapshotError> {
        let state = self.state;
        let sequence = self.take_image(slot, buffer);
        self.state = state;
        sequence
    }

    /// Continues from the newest image of both slots after `gap`, with a reading of the voltage if the node was off, by way
    /// of a buffer of at least [`image_size`] bytes. A burst that was under way gives no value.
    ///
    /// # Errors
    /// If there is no image of this node; the runner is then unchanged.
    #[cold]
    #[inline(never)]
    pub fn resume(&mut self, buffer: &mut [u8], gap: Outage) -> Result<u32, SnapshotError> {
        let (sequence, slot) = self.take_newest(buffer, false)?;
        self.newest = Some((sequence, slot));
        self.is_sampling = false;
        let is_known = gap == Outage::OnUntil(N::second(&self.state));
        let code = if is_known { None } else { self.board.storage_code() };
        self.wake = self.node.wake_after(&mut self.state, gap, code);
        Ok(sequence)
    }

    /// Bytes that a buffer of [`Runner::save`] and [`Runner::resume`] needs.
    #[must_use]
    pub const fn image_bytes() -> usize {
        image_size::<N>()
    }
}
