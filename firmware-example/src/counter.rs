//! SysTick as a 64-bit counter.
//!
//! Every Cortex-M has SysTick; the M0 has nothing else, and QEMU does not emulate the cycle counter
//! of the larger cores. On a board it counts cycles of the core's clock. Under `qemu-system-arm
//! -icount shift=0` each instruction takes a nanosecond of the board's clock, so there it counts
//! *instructions*, in units of (10⁹ / clock frequency).

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::exception;

/// SysTick counts down through 24 bits.
const BITS: u32 = 24;
const MASK: u32 = (1 << BITS) - 1;

/// How often SysTick has passed zero. Only the exception writes it, so a load and a storage are
/// enough: the M0 has no atomic addition.
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

#[exception]
fn SysTick() {
    let wraps = WRAPS.load(Ordering::Relaxed);
    WRAPS.store(wraps.wrapping_add(1), Ordering::Relaxed);
}
