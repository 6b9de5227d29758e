//! A board that plays a trace from flash, as QEMU has no sensors.

use super::{Board, Decision};

// `COUNTS: [i16; _]`, by the build script from `trace/machine.csv`.
include!(concat!(env!("OUT_DIR"), "/trace.rs"));

/// Voltage of the storage at power-up, in volts.
pub const STORE_VOLTAGE: f32 = 2.6;

/// Plays `trace/machine.csv` again and again, and reads the storage at power-up only.
#[derive(Debug, Clone, Copy, Default)]
pub struct FlashBoard {
    played: usize,
    awake: bool,
}

impl Board for FlashBoard {
    fn acceleration(&mut self) -> Option<i16> {
        let count = COUNTS.get(self.played).copied();
        self.played += 1;
        if self.played >= COUNTS.len() {
            self.played = 0;
        }
        count
    }

    fn storage_voltage(&mut self) -> Option<f32> {
        (!core::mem::replace(&mut self.awake, true)).then_some(STORE_VOLTAGE)
    }

    /// There is nothing to measure and nobody to tell: the log has it.
    fn carry_out(&mut self, _decision: Decision) {}
}
