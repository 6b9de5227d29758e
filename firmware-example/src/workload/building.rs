//! The cost of a scene's coefficients: one build of them from the parameters.

use super::{Progress, Workload};

/// A build of coefficients, done once; it is one step of the log.
#[derive(Debug)]
pub struct Building<F> {
    name: &'static str,
    build: F,
    done: bool,
    bits: [u32; 4],
}

impl<F: Fn() -> Option<[f32; 4]>> Building<F> {
    /// `build` gives some of the coefficients, to be compared; `None` if the parameters are refused.
    pub fn new(name: &'static str, build: F) -> Self {
        Self { name, build, done: false, bits: [0; 4] }
    }
}

impl<F: Fn() -> Option<[f32; 4]>> Workload for Building<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn advance(&mut self) -> Progress {
        if self.done {
            return Progress::Finished;
        }
        self.done = true;
        let Some(coefficients) = (self.build)() else { return Progress::Failed };
        self.bits = coefficients.map(f32::to_bits);
        Progress::Sample { steps: 1, simulated_us: 0 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
