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

use crate::calibration::Nops;
use crate::counter::Counter;
use crate::stack;
use crate::stop::{Code, stop};
use crate::workload::{Progress, Visit, Workload};
use core::hint::black_box;
use cortex_m::Peripherals;
use defmt::info;

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
        stack::paint();
        let started = counter.ticks();
        // The boxes keep the compiler from moving the work out from between the two readings.
        let progress = black_box(black_box(&mut *workload).advance());
        let elapsed = counter.ticks() - started;
        match progress {
            Progress::Sample { steps: more, simulated_us: later } => {
                steps += u64::from(more);
                simulated_us += u64::from(later);
                ticks += elapsed;
                deepest = deepest.max(stack::deepest());
                info!("sample {=u64} {=u64} {=u64} {=[?]:08x}", simulated_us, steps, ticks, workload.state());
            }
            Progress::Finished => break,
            Progress::Failed => stop(Code::WorkloadFailed),
        }
    }
    info!("count stack_bytes {=u32}", deepest);
    info!("end {=str}", workload.name());
}
