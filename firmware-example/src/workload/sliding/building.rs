//! What it costs to make the coefficients of the parameters, the beam's eigenvalue included.

use core::hint::black_box;

use super::super::{Progress, Workload};
use super::parts;

/// The coefficients of the default scene, made once: a step is a build.
#[derive(Debug, Default)]
pub struct Building {
    done: bool,
    bits: [u32; 4],
}

impl Workload for Building {
    fn name(&self) -> &'static str {
        "sliding-build"
    }

    fn advance(&mut self) -> Progress {
        if self.done {
            return Progress::Finished;
        }
        self.done = true;
        let Ok(scene) = black_box(parts::whole()).build() else { return Progress::Failed };
        let scene = black_box(scene);
        self.bits =
            [scene.angular_frequency(), scene.modal_mass(), scene.base_coupling(), scene.charge_unit()]
                .map(f32::to_bits);
        Progress::Sample { steps: 1, simulated_us: 0 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
