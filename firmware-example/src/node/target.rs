//! The node on a microcontroller. A loss of power is a reset of the whole part: what remains is the world, in memory that a
//! start does not write to.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use cortex_m::Peripherals;
use cortex_m::peripheral::SCB;

use super::entry::log;
use super::{End, LOSSES, Meter, Part, WORK, World, cycle};
use crate::measure::Counter;
use crate::stop::{Code, stop};

/// What memory holds after the first start.
const MARK: u32 = 0x57_0A_1D_5E;

/// The world, behind a mark that it has been made.
#[repr(C)]
struct Retained {
    mark: u32,
    world: MaybeUninit<World>,
}

struct Memory(UnsafeCell<MaybeUninit<Retained>>);

// SAFETY: there is one core, no interrupt uses it, and `run` takes the only reference.
unsafe impl Sync for Memory {}

/// Startup code leaves this section alone. QEMU starts with zeros in it.
#[unsafe(link_section = ".uninit.WORLD")]
static MEMORY: Memory = Memory(UnsafeCell::new(MaybeUninit::uninit()));

impl Meter for Counter {
    fn ticks(&self) -> u64 {
        Counter::ticks(self)
    }
}

/// Runs the node to the end of its day, through resets.
pub fn run() -> ! {
    let Some(peripherals) = Peripherals::take() else { stop(Code::Faulted) };
    let counter = Counter::start(peripherals.SYST);
    // SAFETY: this function is called once after a start, and there is no other reference.
    let retained = unsafe { &mut *MEMORY.0.get() };
    let retained = retained.as_mut_ptr();
    // SAFETY: the mark is a number in memory that the reset has not touched, or an arbitrary one.
    let is_made = unsafe { (&raw const (*retained).mark).read_volatile() } == MARK;
    // SAFETY: as above.
    let world = unsafe { &mut (*retained).world };
    if !is_made {
        make(world);
        // SAFETY: as above.
        unsafe { (&raw mut (*retained).mark).write_volatile(MARK) };
    }
    // SAFETY: it was made now or before the last reset, by this program.
    let world = unsafe { world.assume_init_mut() };
    crate::measure::paint_stack();
    let ended = cycle(Part::TARGET, world, &counter, &mut log);
    world.stack = world.stack.max(crate::measure::deepest_stack());
    match ended {
        Ok(End::PowerLost) => SCB::sys_reset(),
        Ok(End::Day) => {
            log_counts(world);
            stop(Code::Done)
        }
        Err(_) => stop(Code::WorkloadFailed),
    }
}

#[inline(never)]
fn make(world: &mut MaybeUninit<World>) {
    world.write(World::new(LOSSES.len()));
}

/// What the host does not have: the cost.
fn log_counts(world: &World) {
    for (work, count) in WORK.into_iter().zip(world.counts()) {
        defmt::info!(
            "count {=str} {=u32} {=u32} {=u64}",
            work.name(),
            count.calls,
            count.samples,
            count.ticks
        );
    }
    defmt::info!("count stack {=u32} {=u32} {=u64}", 1, 0, u64::from(world.stack));
}
