//! What `bench` measures, and the host runs beside it to compare the bits.
//!
//! For now a damped oscillator, x″ + 2ζωx′ + ω²x = 0, by a fixed step of the semi-implicit Euler
//! method: small, and sensitive to any difference in rounding.

use crate::measure::{Progress, Workload};
use core::hint::black_box;

const STEPS_PER_SAMPLE: u32 = 256;
const SAMPLES: u32 = 16;
/// 2⁻¹⁰ s exactly, in f32 as on paper.
const STEP: f32 = 1.0 / 1024.0;
const SAMPLE_US: u32 = 250_000;

/// The oscillator and where it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    stiffness: f32,
    damping: f32,
    displacement: f32,
    velocity: f32,
    samples: u32,
    bits: [u32; 2],
}

impl Oscillator {
    /// 20 Hz, 1 % of critical damping, released at rest from 1.
    #[must_use]
    pub fn new() -> Self {
        // Hidden from the compiler, or it would run the model while it builds the firmware.
        let omega = black_box(125.663_71_f32);
        Self {
            stiffness: omega * omega,
            damping: 0.02 * omega,
            displacement: 1.0,
            velocity: 0.0,
            samples: 0,
            bits: [0; 2],
        }
    }
}

impl Default for Oscillator {
    fn default() -> Self {
        Self::new()
    }
}

impl Workload for Oscillator {
    fn name(&self) -> &'static str {
        "oscillator"
    }

    fn advance(&mut self) -> Progress {
        if self.samples == SAMPLES {
            return Progress::Finished;
        }
        for _ in 0..STEPS_PER_SAMPLE {
            let force = self.stiffness * self.displacement + self.damping * self.velocity;
            self.velocity -= STEP * force;
            self.displacement += STEP * self.velocity;
        }
        if !self.displacement.is_finite() {
            return Progress::Failed;
        }
        self.samples += 1;
        self.bits = [self.displacement.to_bits(), self.velocity.to_bits()];
        Progress::Sample { steps: STEPS_PER_SAMPLE, simulated_us: SAMPLE_US }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
