//! Panics and faults end the run with a code of their own, which QEMU or the debugger returns.
//!
//! Nothing here formats. So a firmware in which nothing can panic links no word of
//! `core::panicking`, and the absence of those symbols is the proof that nothing can.

use core::cell::UnsafeCell;
use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use critical_section::RestoreState;
use semihosting::process::exit;
use semihosting::sys::arm_compat::sys_writec;

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

// defmt frames over semihosting, byte by byte to the console of QEMU or of the debugger.
//
// `defmt-semihosting` does the same and panics when it is misused. The panic would stand in every
// firmware, and the check that nothing can panic would have to look away; so this one ends the run.

#[defmt::global_logger]
struct Logger;

/// What a frame in the making needs.
struct Frame {
    open: bool,
    restore: RestoreState,
    encoder: defmt::Encoder,
}

struct Shared(UnsafeCell<Frame>);

// SAFETY: there is one core, and the frame is touched only inside the critical section that
// `acquire` opens and `release` closes.
unsafe impl Sync for Shared {}

static FRAME: Shared = Shared(UnsafeCell::new(Frame {
    open: false,
    restore: RestoreState::invalid(),
    encoder: defmt::Encoder::new(),
}));

// SAFETY: `acquire` masks interrupts until `release`, so frames never mix; a frame inside a frame
// ends the run.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: `release` closes it, with this state, once for each `acquire`.
        let restore = unsafe { critical_section::acquire() };
        // SAFETY: in the critical section; the reference ends with this function.
        let frame = unsafe { &mut *FRAME.0.get() };
        if frame.open {
            stop(Code::LoggerMisused);
        }
        frame.open = true;
        frame.restore = restore;
        frame.encoder.start_frame(send);
    }

    unsafe fn flush() {
        // The host has each byte when the call that sends it returns.
    }

    unsafe fn release() {
        // SAFETY: defmt calls this after `acquire`, in its critical section; the reference ends
        // before the section does.
        let frame = unsafe { &mut *FRAME.0.get() };
        frame.encoder.end_frame(send);
        frame.open = false;
        let restore = frame.restore;
        // SAFETY: it is the state that the matching `acquire` got.
        unsafe { critical_section::release(restore) };
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: defmt calls this between `acquire` and `release`; the reference ends here.
        let frame = unsafe { &mut *FRAME.0.get() };
        frame.encoder.write(bytes, send);
    }
}

fn send(bytes: &[u8]) {
    for &byte in bytes {
        sys_writec(byte);
    }
}
