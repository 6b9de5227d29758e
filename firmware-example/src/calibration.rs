//! The workload whose cost is known: a step is one instruction, nearly always a `nop`.
//!
//! It shows whether the host knows what a tick is worth on this board. An instruction per step is
//! the right answer, up to the reading of the counter and its resolution.

use crate::workload::{Progress, Workload};
use core::arch::asm;

/// Few, because the branches of the M0 are short, and so are those that the compiler puts around
/// what looks like five lines to it.
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
