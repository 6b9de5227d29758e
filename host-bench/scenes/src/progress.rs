//! How far a long computation of this process is, for a display that runs beside it.
//!
//! Runs on several threads at a time overwrite each other: a display beside them counts runs instead.

use std::sync::atomic::{AtomicU64, Ordering};

/// Number of computations that have begun.
static BEGUN: AtomicU64 = AtomicU64::new(0);
/// Bits of the part that is done of the last one.
static DONE: AtomicU64 = AtomicU64::new(0);
/// Number of its steps, rejected ones included, and of its events.
static STEPS: AtomicU64 = AtomicU64::new(0);
static EVENTS: AtomicU64 = AtomicU64::new(0);

/// A computation begins.
pub fn begin() {
    BEGUN.fetch_add(1, Ordering::Relaxed);
    report(0.0, [0; 2]);
}

/// This part of it is done, 0 to 1, by so many steps and events.
pub fn report(part: f64, [steps, events]: [u64; 2]) {
    DONE.store(part.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
    STEPS.store(steps, Ordering::Relaxed);
    EVENTS.store(events, Ordering::Relaxed);
}

/// The number of computations that have begun, and of the last one the part that is done, its steps and its events.
pub fn read() -> (u64, f64, [u64; 2]) {
    let [begun, done, steps, events] = [&BEGUN, &DONE, &STEPS, &EVENTS].map(|of| of.load(Ordering::Relaxed));
    (begun, f64::from_bits(done), [steps, events])
}
