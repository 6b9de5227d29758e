//! An accelerometer that plays a trace from flash.

use super::Accelerometer;

// `COUNTS: [i16; _]`, by the build script from `trace/machine.csv`.
include!(concat!(env!("OUT_DIR"), "/trace.rs"));

/// Metres per second squared in a raw count: a range of 2 g in 16 bits.
const SCALE: f32 = 9.81 / 16384.0;

/// Plays `trace/machine.csv` once.
#[derive(Debug, Default)]
pub struct FlashTrace {
    played: usize,
}

impl FlashTrace {
    /// Whole seconds that it lasts.
    pub const SECONDS: u32 = (COUNTS.len() as u32 - 1) / super::RATE_HZ;
}

impl Accelerometer for FlashTrace {
    fn sample(&mut self) -> Option<f32> {
        let count = *COUNTS.get(self.played)?;
        self.played += 1;
        Some(f32::from(count) * SCALE)
    }
}
