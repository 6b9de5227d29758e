//! Panics and faults end the run with a code of their own, which QEMU or the debugger returns.
//!
//! Nothing here formats. So a firmware in which nothing can panic links no word of
//! `core::panicking`, and the absence of those symbols is the proof that nothing can.

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::process::exit;

/// How a run ended. `host-bench on-target` puts these in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// All is well.
    Done = 0,
    /// A model refused its parameters, or could not go on.
    WorkloadFailed = 10,
    /// Something panicked.
    Panicked = 11,
    /// A fault, or an interrupt that nobody enabled.
    Faulted = 12,
    /// A log call inside a log call.
    LoggerMisused = 13,
}

/// Ends the run.
pub fn stop(code: Code) -> ! {
    exit(code as i32)
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    stop(Code::Panicked)
}

/// `defmt`'s own panics (`defmt::panic!`, `defmt::unwrap!`) would otherwise keep `core`'s alive.
#[defmt::panic_handler]
fn defmt_panic() -> ! {
    stop(Code::Panicked)
}

// SAFETY: it touches no memory but its own frame, and does not return.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    stop(Code::Faulted)
}

// SAFETY: as above; no interrupt is enabled, so this is a fault as well.
#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    stop(Code::Faulted)
}
