//! Measuring: runs workloads piece by piece and logs what they cost and where they got to.
//!
//! The log is read by a program. Its records, one frame each:
//!
//! ```text
//! begin NAME                     a workload starts
//! sample TIME STEPS TICKS WORDS  simulated microseconds, steps and ticks so far, and the state as
//!                                raw bits: "[3f800000, bf000000]"
//! count NAME VALUE               what was counted over the whole workload
//! end NAME                       it is complete
//! ```
//!
//! Costs are in ticks of [`Counter`]; what a tick is worth depends on the board, and the host knows
//! the board. So the firmware divides nothing and links no 64-bit division.

use core::arch::asm;
use core::hint::black_box;
use core::ptr;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
#[cfg(not(feature = "own-systick"))]
use cortex_m_rt::exception;
use defmt::info;

use super::stop::{Code, stop};
use super::workload::{Progress, Visit, Workload};

/// Measures the calibration and then the workloads of a variant, and ends the run.
pub fn run(workloads: fn(Visit<'_>) -> Option<()>) -> ! {
    let Some(peripherals) = Peripherals::take() else { stop(Code::Faulted) };
    let counter = Counter::start(peripherals.SYST);
    measure(&counter, &mut Nops::default());
    match workloads(&mut |workload| measure(&counter, workload)) {
        Some(()) => stop(Code::Done),
        None => stop(Code::WorkloadFailed),
    }
}

#[inline(never)]
fn measure(counter: &Counter, workload: &mut dyn Workload) {
    info!("begin {=str}", workload.name());
    let (mut steps, mut simulated_us, mut ticks, mut deepest) = (0_u64, 0_u64, 0_u64, 0_u32);
    loop {
        // Anew each time, because logging a sample uses the stack too.
        paint_stack();
        let started = counter.ticks();
        // The boxes keep the compiler from moving the work out from between the two readings.
        let progress = black_box(black_box(&mut *workload).advance());
        let elapsed = counter.ticks() - started;
        match progress {
            Progress::Sample { steps: more, simulated_us: later } => {
                steps += u64::from(more);
                simulated_us += u64::from(later);
                ticks += elapsed;
                deepest = deepest.max(deepest_stack());
                info!("sample {=u64} {=u64} {=u64} {=[?]:08x}", simulated_us, steps, ticks, workload.state());
            }
            Progress::Finished => break,
            Progress::Failed => stop(Code::WorkloadFailed),
        }
    }
    info!("count stack_bytes {=u32}", deepest);
    info!("end {=str}", workload.name());
}

// The workload whose cost is known: a step is one instruction, nearly always a `nop`.
//
// It shows whether the host knows what a tick is worth on this board. An instruction per step is
// the right answer, up to the reading of the counter and its resolution.

/// Few, because the branches of the M0 are short, and so are those that the compiler puts around what looks like five lines to it.
const NOPS: u32 = 50;
const ROUNDS: u32 = 20_000;
/// With a decrement and a branch in each round.
const INSTRUCTIONS: u32 = ROUNDS * (NOPS + 2);

/// A million `nop`s, in a loop that is counted with them.
#[derive(Default)]
pub(crate) struct Nops {
    done: [u32; 1],
}

impl Workload for Nops {
    fn name(&self) -> &'static str {
        "calibration"
    }

    fn advance(&mut self) -> Progress {
        if self.done == [INSTRUCTIONS] {
            return Progress::Finished;
        }
        // The whole loop in assembly, or the compiler would choose its instructions.
        //
        // SAFETY: it touches one register, which is its own, and the flags.
        unsafe {
            asm!(
                "2:",
                ".rept {nops}",
                "nop",
                ".endr",
                "subs {rounds}, #1",
                "bne 2b",
                nops = const NOPS,
                rounds = inout(reg) ROUNDS => _,
                options(nomem, nostack)
            );
        }
        self.done = [INSTRUCTIONS];
        Progress::Sample { steps: INSTRUCTIONS, simulated_us: 0 }
    }

    fn state(&self) -> &[u32] {
        &self.done
    }
}

// SysTick as a 64-bit counter.
//
// Every Cortex-M has SysTick; the M0 has nothing else, and QEMU does not emulate the cycle counter
// of the larger cores. On a board it counts cycles of the core's clock. Under `qemu-system-arm
// -icount shift=0` each instruction takes a nanosecond of the board's clock, so there it counts
// *instructions*, in units of (10⁹ / clock frequency).

/// SysTick counts down through 24 bits.
const BITS: u32 = 24;
const MASK: u32 = (1 << BITS) - 1;

/// How often SysTick has passed zero. Only the exception writes it, so a load and a store are enough: the M0 has no atomic addition.
static WRAPS: AtomicU32 = AtomicU32::new(0);

/// A running SysTick. There is one, because there is one `SYST`.
pub(crate) struct Counter {
    _running: SYST,
}

impl Counter {
    /// Starts counting at zero, with the core's clock.
    pub(crate) fn start(mut systick: SYST) -> Self {
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(MASK);
        systick.clear_current();
        systick.enable_interrupt();
        systick.enable_counter();
        Self { _running: systick }
    }

    /// Ticks since the start.
    pub(crate) fn ticks(&self) -> u64 {
        loop {
            let wraps = WRAPS.load(Ordering::Relaxed);
            let current = SYST::get_current();
            // A wrap between the two reads would pair the old count with the new value.
            if WRAPS.load(Ordering::Relaxed) == wraps {
                // The wrap is counted on arriving at zero: zero is the first value of a round.
                let into_round = current.wrapping_neg() & MASK;
                return (u64::from(wraps) << BITS) + u64::from(into_round);
            }
        }
    }
}

#[cfg(not(feature = "own-systick"))]
#[exception]
fn SysTick() {
    let wraps = WRAPS.load(Ordering::Relaxed);
    WRAPS.store(wraps.wrapping_add(1), Ordering::Relaxed);
}

// How deep the stack went: paint what is free below it, run, and see how far the paint is gone.
//
// A frame that reserves words and never writes them is not seen, so this is a measurement and not
// a bound; the states of a model are written.

/// A word that code is unlikely to leave on the stack.
const PAINT: u32 = 0xCCCC_CCCC;

unsafe extern "C" {
    /// The end of RAM, from the link script: the first word of the stack is just below.
    safe static _stack_start: u32;
}

/// Paints everything between the static variables and the stack as it stands now.
pub fn paint_stack() {
    // In assembly, because only there the stack pointer is known: a compiled function may read it
    // first and push afterwards, and would paint over its own return address.
    //
    // SAFETY: from the end of the static variables up to the stack pointer nobody owns a word:
    // there is no heap, and an Arm function keeps nothing below its stack pointer. An exception
    // taken here uses these words and is done with them when it returns.
    unsafe {
        asm!(
            "2: cmp {word}, sp",
            "bhs 3f",
            "stm {word}!, {{{paint}}}",
            "b 2b",
            "3:",
            word = inout(reg) cortex_m_rt::heap_start() => _,
            paint = in(reg) PAINT,
        );
    }
}

/// Bytes from the top of the stack to the deepest word written since [`paint`].
#[inline(never)]
#[must_use]
pub fn deepest_stack() -> u32 {
    let top = (&raw const _stack_start).addr();
    let mut word = cortex_m_rt::heap_start().cast_const();
    // SAFETY: the words between the end of the static variables and the top of the stack are RAM,
    // aligned, and only read.
    while word.addr() < top && unsafe { ptr::read_volatile(word) } == PAINT {
        word = word.wrapping_add(1);
    }
    (top - word.addr()) as u32
}
