//! How far a long computation of this process is, for a display that runs beside it.
//!
//! Runs on several threads at a time overwrite each other: a display beside them counts runs instead.

use std::sync::atomic::{AtomicU64, Ordering};

/// Number of computations that have begun.
static BEGUN: AtomicU64 = AtomicU64::new(0);
/// Bits of the part that is done of the last one.
static DONE: AtomicU64 = AtomicU64::new(0);

/// A computation begins.
pub fn begin() {
    BEGUN.fetch_add(1, Ordering::Relaxed);
    report(0.0);
}

/// This part of it is done, 0 to 1.
pub fn report(part: f64) {
    DONE.store(part.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
}

/// The number of computations that have begun, and the part that is done of the last one.
#[must_use]
pub fn read() -> (u64, f64) {
    (BEGUN.load(Ordering::Relaxed), f64::from_bits(DONE.load(Ordering::Relaxed)))
}
