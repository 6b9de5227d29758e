//! What a node needs of the hardware, and a loop over it.

use super::{Hearing, Node, NodeState, Progress, Task, Wake};
use crate::energy::response_map::Words;
use crate::snapshot::{SnapshotError, image_size, newest_slot, read_image, save_image};

/// The hardware of a node.
///
/// [`Runner`] calls it. Firmware that is driven by interrupts or an executor calls [`Node`] itself and has no need of this
/// trait.
pub trait Board {
    /// Sleeps for at most `seconds`, or until the sensor, if it is on, has about `samples`. Returns the second of the clock.
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32;

    /// The code of the converter for the storage's voltage; `None` if it cannot be read.
    fn storage_code(&mut self) -> Option<u32>;

    /// Starts the accelerometer, with its FIFO.
    ///
    /// # Errors
    /// If the sensor does not answer.
    fn start_sensor(&mut self) -> Result<(), Fault>;

    /// Stops the accelerometer: standby. If its supply is switched off instead, no line to it may be high then.
    fn stop_sensor(&mut self);

    /// Moves samples along the axis of the harvester from the FIFO to the front of `samples`, as raw counts. Returns
    /// their number, which may be 0.
    ///
    /// # Errors
    /// If samples were lost since the last call, or the sensor does not answer.
    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault>;

    /// Carries an action out.
    fn run(&mut self, action: usize);

    /// Copies the front of a slot of non-volatile memory, 0 or 1, to `bytes`.
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

/// The time between an image and the resumption from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Gap {
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

/// The reason why an image was not saved. The slot of the newest valid image is as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError {
    /// The node is not [idle](Runner::is_idle): an action is booked and not carried out, or a listen is under way.
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

/// A node on a board, with a buffer of `BURST` samples.
#[derive(Debug)]
pub struct Runner<
    B,
    W: Words,
    const M: usize,
    const P: usize,
    const SLOTS: usize,
    const ACTIONS: usize,
    const BURST: usize,
> {
    board: B,
    node: Node<W, M, P, SLOTS, ACTIONS>,
    state: NodeState<P, SLOTS, ACTIONS>,
    wake: Wake,
    is_listening: bool,
    /// Number and slot of the newest image; `None` before a look at the slots.
    newest: Option<(u32, usize)>,
    burst: [i16; BURST],
}

/// What a step of a [`Runner`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Step {
    /// It slept and kept the books.
    Slept,
    /// It took samples.
    Sampled,
    /// It finished a listen.
    Heard(Hearing),
    /// It carried an action out.
    Ran(usize),
}

impl<
    B: Board,
    W: Words,
    const M: usize,
    const P: usize,
    const SLOTS: usize,
    const ACTIONS: usize,
    const BURST: usize,
> Runner<B, W, M, P, SLOTS, ACTIONS, BURST>
{
    /// A node that wakes up at `second` and knows nothing. It reads the voltage of the storage.
    #[inline(never)]
    pub fn new(mut board: B, node: Node<W, M, P, SLOTS, ACTIONS>, second: u32) -> Self {
        let mut state = node.start(second);
        let code = board.storage_code();
        let wake = node.wake(&mut state, second, code);
        Self { board, node, state, wake, is_listening: false, newest: None, burst: [0; BURST] }
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &NodeState<P, SLOTS, ACTIONS> {
        &self.state
    }

    /// Whether the next step sleeps: nothing is booked that has not been done. Save an image then.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        matches!(self.wake.task, Task::Sleep)
    }

    /// The node.
    #[must_use]
    pub fn node(&self) -> &Node<W, M, P, SLOTS, ACTIONS> {
        &self.node
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

    /// Does what the node said, one thing, and asks it again. Only [`Board::sleep`] takes time.
    pub fn step(&mut self) -> Step {
        match self.wake.task {
            Task::Run(action) => {
                self.board.run(action);
                self.ask(self.state.second(), None);
                Step::Ran(action)
            }
            Task::Sleep => {
                let now = self.board.sleep(self.wake.again_in, 0);
                let code = if self.wake.read { self.board.storage_code() } else { None };
                self.ask(now, code);
                Step::Slept
            }
            Task::Listen { samples } => self.listen(samples),
        }
    }

    /// Takes a burst of samples.
    #[inline(never)]
    fn listen(&mut self, samples: u32) -> Step {
        if !self.is_listening {
            self.is_listening = true;
            if self.board.start_sensor().is_err() {
                self.node.samples_lost(&mut self.state);
            }
        }
        let burst = u32::try_from(BURST).unwrap_or(u32::MAX);
        let now = self.board.sleep(self.wake.again_in, samples.min(burst));
        let mut heard = None;
        loop {
            let Ok(count) = self.board.read_samples(&mut self.burst) else {
                self.node.samples_lost(&mut self.state);
                break;
            };
            let burst = self.burst.get(..count).unwrap_or(&self.burst);
            if burst.is_empty() {
                break;
            }
            match self.node.samples(&mut self.state, burst) {
                Progress::More(samples) => self.wake.task = Task::Listen { samples },
                Progress::Heard(hearing) => {
                    self.board.stop_sensor();
                    self.is_listening = false;
                    heard = Some(hearing);
                    break;
                }
                Progress::Idle => {}
            }
        }
        // The books wait for the end of the listen, because they cost more than a burst.
        let since = now.checked_sub(self.state.second());
        let is_over = since.is_none_or(|since| since >= self.wake.again_in);
        if heard.is_some() || is_over {
            self.ask(now, None);
        }
        heard.map_or(Step::Sampled, Step::Heard)
    }

    #[inline(never)]
    fn ask(&mut self, now: u32, code: Option<u32>) {
        self.wake = self.node.wake(&mut self.state, now, code);
        if self.is_listening && !matches!(self.wake.task, Task::Listen { .. }) {
            self.board.stop_sensor();
            self.is_listening = false;
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
            None => self.look_for_newest(buffer),
        };
        let (sequence, slot) = (newest.wrapping_add(1), 1 - taken.min(1));
        let size = save_image(&self.node, &self.state, sequence, buffer).map_err(SaveError::Buffer)?;
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

    /// Number and slot of the newest image of this node; number 0 in the second slot without one.
    fn look_for_newest(&mut self, buffer: &mut [u8]) -> (u32, usize) {
        self.newest_in_slots(buffer).unwrap_or((0, 1))
    }

    /// Number and slot of the newest image of this node.
    fn newest_in_slots(&mut self, buffer: &mut [u8]) -> Result<(u32, usize), SnapshotError> {
        let numbers = [self.sequence_in(0, buffer), self.sequence_in(1, buffer)];
        let slot = newest_slot(numbers)?;
        let [first, second] = numbers;
        Ok((if slot == 0 { first } else { second }?, slot))
    }

    /// Reads the image in a slot to the state; gives its number. Of an image that is not valid the state has no meaning.
    #[inline(never)]
    fn take_image(&mut self, slot: usize, buffer: &mut [u8]) -> Result<u32, SnapshotError> {
        self.board.read_slot(slot, buffer);
        read_image(&self.node, buffer, &mut self.state)
    }

    /// As [`Runner::take_image`]; the state stays if the image is not valid.
    #[inline(never)]
    fn continue_from(&mut self, slot: usize, buffer: &mut [u8]) -> Result<u32, SnapshotError> {
        let state = self.state;
        let sequence = self.take_image(slot, buffer);
        if sequence.is_err() {
            self.state = state;
        }
        sequence
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
    /// of a buffer of at least [`image_size`] bytes. A listen that was under way gives no value.
    ///
    /// # Errors
    /// If there is no image of this node; the runner is then unchanged.
    #[cold]
    #[inline(never)]
    pub fn resume(&mut self, buffer: &mut [u8], gap: Gap) -> Result<u32, SnapshotError> {
        let (_, slot) = self.newest_in_slots(buffer)?;
        let sequence = self.continue_from(slot, buffer)?;
        self.newest = Some((sequence, slot));
        self.is_listening = false;
        match gap {
            Gap::OnUntil(now) => {
                if now == self.state.second() {
                    self.node.interrupt(&mut self.state);
                    self.ask(now, None);
                } else {
                    let code = self.board.storage_code();
                    self.wake = self.node.wake_after_reset(&mut self.state, now, code);
                }
            }
            Gap::OffUntil(now) => {
                let code = self.board.storage_code();
                self.wake = self.node.wake_after_gap(&mut self.state, now, code);
            }
            Gap::LockedOutUntil(now) => {
                let code = self.board.storage_code();
                self.wake = self.node.wake_after_lost_calls(&mut self.state, now, code);
            }
            Gap::Unknown => {
                let code = self.board.storage_code();
                self.wake = self.node.wake_after_unknown_gap(&mut self.state, code);
            }
        }
        Ok(sequence)
    }

    /// Bytes that a buffer of [`Runner::save`] and [`Runner::resume`] needs.
    #[must_use]
    pub const fn image_bytes() -> usize {
        image_size::<Node<W, M, P, SLOTS, ACTIONS>>()
    }
}
