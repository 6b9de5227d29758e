//! What a node needs of the hardware, and a loop over it.

use super::{Hearing, Node, NodeState, Progress, Task, Wake};
use crate::energy::response_map::Words;
use crate::snapshot::{SnapshotError, image_size, newest_image, save_image};

/// The hardware of a node.
///
/// [`Runner`] calls it. Firmware that is driven by interrupts or an executor calls [`Node`] itself and has no need of this
/// trait.
pub trait Board {
    /// Sleeps for at most `seconds`, or until the sensor, if it is on, has about `samples`. Returns the second of the clock.
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32;

    /// The code of the converter for the storage's voltage; `None` if it cannot be read.
    fn storage_code(&mut self) -> Option<u32>;

    /// Switches the supply of the accelerometer on, with its FIFO.
    ///
    /// # Errors
    /// If the sensor does not answer.
    fn start_sensor(&mut self) -> Result<(), Fault>;

    /// Switches the supply of the accelerometer off.
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
    fn write_slot(&mut self, slot: usize, bytes: &[u8]);
}

/// The hardware did not do what was asked of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault;

/// A node on a board, with a buffer of `BURST` samples.
#[derive(Debug)]
pub struct Runner<
    B,
    W,
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
    sequence: u32,
    slot: usize,
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
    pub fn new(mut board: B, node: Node<W, M, P, SLOTS, ACTIONS>, second: u32) -> Self {
        let mut state = node.start(second);
        let code = board.storage_code();
        let wake = node.wake(&mut state, second, code);
        Self { board, node, state, wake, is_listening: false, sequence: 0, slot: 1, burst: [0; BURST] }
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
    fn listen(&mut self, samples: u32) -> Step {
        if !self.is_listening {
            self.is_listening = true;
            if self.board.start_sensor().is_err() {
                self.node.samples_lost(&mut self.state);
            }
        }
        let burst = u32::try_from(BURST).unwrap_or(u32::MAX);
        let now = self.board.sleep(self.wake.again_in, samples.min(burst));
        let mut step = Step::Sampled;
        loop {
            let Ok(count) = self.board.read_samples(&mut self.burst) else {
                self.node.samples_lost(&mut self.state);
                break;
            };
            let burst = self.burst.get(..count).unwrap_or(&self.burst);
            if burst.is_empty() {
                break;
            }
            if let Progress::Heard(hearing) = self.node.samples(&mut self.state, burst) {
                self.board.stop_sensor();
                self.is_listening = false;
                step = Step::Heard(hearing);
                break;
            }
        }
        self.ask(now, None);
        step
    }

    fn ask(&mut self, now: u32, code: Option<u32>) {
        self.wake = self.node.wake(&mut self.state, now, code);
        if self.is_listening && !matches!(self.wake.task, Task::Listen { .. }) {
            self.board.stop_sensor();
            self.is_listening = false;
        }
    }

    /// Writes an image of the state, while the node [is idle](Self::is_idle), to the slot that is not the newest one, by way of a buffer of at least
    /// [`image_size`] bytes. Returns the number of the image.
    ///
    /// # Errors
    /// If the buffer is too small.
    pub fn save(&mut self, buffer: &mut [u8]) -> Result<u32, SnapshotError> {
        let sequence = self.sequence.wrapping_add(1);
        let slot = 1 - self.slot.min(1);
        let size = save_image(&self.node, &self.state, sequence, buffer)?;
        self.board.write_slot(slot, buffer.get(..size).unwrap_or(&[]));
        (self.sequence, self.slot) = (sequence, slot);
        Ok(sequence)
    }

    /// Continues from the newest image of both slots at the second `now`, with a reading of the voltage, by way of two
    /// buffers of at least [`image_size`] bytes.
    ///
    /// A time since the image counts as a time without supply, unless `was_on`: then the node was on all the time and
    /// lost its memory only. A listen that was under way gives no value.
    ///
    /// # Errors
    /// If there is no image of this node; the runner is then unchanged.
    pub fn resume(&mut self, buffers: [&mut [u8]; 2], now: u32, was_on: bool) -> Result<u32, SnapshotError> {
        let [first, second] = buffers;
        self.board.read_slot(0, first);
        self.board.read_slot(1, second);
        let image = newest_image(&self.node, [&*first, &*second])?;
        self.state = image.state;
        (self.sequence, self.slot) = (image.sequence, image.slot);
        self.is_listening = false;
        if was_on {
            self.node.interrupt(&mut self.state);
            self.ask(now, None);
        } else {
            let code = self.board.storage_code();
            self.wake = self.node.wake_after_gap(&mut self.state, now, code);
        }
        Ok(image.sequence)
    }

    /// Bytes that a buffer of [`Runner::save`] needs.
    #[must_use]
    pub const fn image_bytes() -> usize {
        image_size::<Node<W, M, P, SLOTS, ACTIONS>>()
    }
}
