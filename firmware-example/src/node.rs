//! A node of [`model_core::node`] on a simulated plant, under QEMU and on the host alike: `host-bench on-target --node`
//! compares what both log.
//!
//! | module | subject |
//! | --- | --- |
//! | `parts` | the node: processor, map, storage, actions |
//! | `plant` | the true node: storage, converter, accelerometer; a day of a harvester that is not as designed, minute by minute |
//! | `world` | the plant with two slots of memory, and a supply that fails ten times |
//! | `entry` | what the log has |
//! | `target` | the loop on a microcontroller: a loss of power is a reset |
//! | `bare` | the program without plant and log, on the registers of a microcontroller or on registers in memory |

#[cfg(target_os = "none")]
pub mod bare;
mod entry;
pub mod parts;
pub mod plant;
#[cfg(target_os = "none")]
pub mod target;
mod world;

use model_core::node::{IncomeOfTime, Outage, Step, Tier};

use parts::ExampleNode;
use plant::{Draws, SECONDS};
use world::Simulated;

pub use entry::{Entry, Hour, State};
pub use parts::{Part, Runner};
pub use plant::Plant;
pub use world::{Count, IMAGE_BYTES, IMAGE_EVERY, LOSSES, Loss, Moment, WORK, Work, World};

/// Counts time. Under QEMU it counts instructions.
pub trait Meter {
    /// Ticks since the start.
    fn ticks(&self) -> u64;
}

/// Counts nothing, for the host.
#[derive(Debug, Clone, Copy)]
pub struct NoMeter;

impl Meter for NoMeter {
    fn ticks(&self) -> u64 {
        0
    }
}

/// Seconds from one state in the log to the next.
const STATE_EVERY: u32 = 600;

/// How a [`cycle`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// With the day.
    Day,
    /// The power is lost: the next cycle resumes from the slots.
    PowerLost,
}

/// The node cannot go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failed {
    /// An image was not written.
    Image,
    /// The storage fell to the voltage of the lock-out, which this day does not have.
    LockedOut,
}

/// Starts the node, from its newest image if there is one, and runs it.
///
/// After a loss of power the plant is set back to the time of that image, so that the same time passes once more: the node
/// must come to the same bits.
///
/// # Errors
/// If the node cannot go on.
pub fn cycle<M: Meter>(
    part: Part,
    world: &mut World,
    meter: &M,
    log: &mut dyn FnMut(&Entry),
) -> Result<End, Failed> {
    let runner = &mut start(part.node(), world, meter);
    resume(runner, log);
    let mut diary = Diary::new(runner);
    loop {
        let readings = runner.state().voltage().readings();
        let board = runner.board_mut();
        (board.ticks, board.samples) = (0, 0);
        let started = meter.ticks();
        let step = runner.step();
        let ticks = meter.ticks().wrapping_sub(started);
        let readings = runner.state().voltage().readings().wrapping_sub(readings);
        let work = match step {
            Step::Slept if readings > 0 => Work::Reading,
            Step::Slept => Work::Wake,
            Step::Ran(_) => Work::Action,
            Step::Sampled => Work::Samples,
            Step::Burst(_) => Work::Burst,
        };
        let board = runner.board_mut();
        board.know(readings);
        let (samples, ticks) = (board.samples, ticks.saturating_sub(board.ticks));
        board.world.count(work, samples, ticks);
        if board.world.plant().is_locked_out() {
            return Err(Failed::LockedOut);
        }
        if board.world.is_off() {
            return Ok(End::PowerLost);
        }
        diary.write(runner, log);
        if ExampleNode::second(runner.state()) >= SECONDS && runner.is_idle() {
            save(runner, log)?;
            return Ok(End::Day);
        }
        if runner.is_idle() && diary.is_image_due(runner) {
            save(runner, log)?;
            if runner.board().world.is_off() {
                return Ok(End::PowerLost);
            }
        }
    }
}

type Node<'a, M> = Runner<'a, Simulated<'a, M>>;

/// The node on its board. What it takes on the stack is free again afterwards.
#[inline(never)]
fn start<'a, M: Meter>(node: &'a ExampleNode, world: &'a mut World, meter: &'a M) -> Node<'a, M> {
    let draws = Draws::new(node);
    world.switch_on();
    Runner::new(Simulated::new(world, draws, meter), node, 0)
}

/// Continues from the newest image, if there is one.
#[inline(never)]
fn resume<M: Meter>(runner: &mut Node<'_, M>, log: &mut dyn FnMut(&Entry)) {
    let mut buffer = [0; IMAGE_BYTES];
    // The simulated clock stood still since the image, whose second only its state has.
    if runner.resume(&mut buffer, Outage::Unknown).is_err() {
        return;
    }
    let second = ExampleNode::second(runner.state());
    if let Ok(sequence) = runner.resume(&mut buffer, Outage::OnUntil(second)) {
        let world = &mut runner.board_mut().world;
        world.set_back(second);
        log(&Entry::Resumed { losses: world.losses() as u32, sequence, second });
    }
}

/// Writes an image.
#[inline(never)]
fn save<M: Meter>(runner: &mut Node<'_, M>, log: &mut dyn FnMut(&Entry)) -> Result<(), Failed> {
    let mut buffer = [0; IMAGE_BYTES];
    let saved = runner.save(&mut buffer);
    if runner.board().world.is_off() {
        return Ok(());
    }
    let sequence = saved.map_err(|_| Failed::Image)?;
    let checksum = buffer.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    log(&Entry::Image { sequence, bytes: IMAGE_BYTES as u32, checksum });
    Ok(())
}

/// What was logged last.
struct Diary {
    states: u32,
    images: u32,
    hour: Option<IncomeOfTime>,
}

impl Diary {
    fn new<M: Meter>(runner: &Node<'_, M>) -> Self {
        let second = ExampleNode::second(runner.state());
        Self { states: second / STATE_EVERY, images: second / IMAGE_EVERY, hour: runner.state().last_hour() }
    }

    /// Logs the hour if one is over, and the state if it is time.
    fn write<M: Meter>(&mut self, runner: &mut Node<'_, M>, log: &mut dyn FnMut(&Entry)) {
        let last_hour = runner.state().last_hour();
        if last_hour != self.hour {
            self.hour = last_hour;
            if let Some(estimated) = last_hour {
                let income = runner.board_mut().world.income_since();
                log(&Entry::Hour(Hour { second: ExampleNode::second(runner.state()), estimated, income }));
            }
        }
        let states = ExampleNode::second(runner.state()) / STATE_EVERY;
        if states != self.states {
            self.states = states;
            log(&Entry::State(State::new(runner.node(), runner.state(), runner.board().world.plant())));
        }
    }

    /// Whether it is time for an image, which is then taken.
    fn is_image_due<M: Meter>(&mut self, runner: &Node<'_, M>) -> bool {
        let images = ExampleNode::second(runner.state()) / IMAGE_EVERY;
        core::mem::replace(&mut self.images, images) != images
    }
}
