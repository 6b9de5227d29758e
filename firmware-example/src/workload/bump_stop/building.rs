//! What it costs to make the coefficients of the parameters, the compliance of the modes left out included.

use core::hint::black_box;

use model_core::scene::bump_stop::BumpStop;

use super::parts::{self, Whole};
use super::scenes::{BEAM_MODES, ROD_MODES};
use crate::workload::{Progress, Workload};

/// The coefficients of the default scene, made once: a step is a build.
#[derive(Debug, Default)]
pub struct Building {
    done: bool,
    bits: [u32; 4],
}

impl Workload for Building {
    fn name(&self) -> &'static str {
        "bump-stop-build"
    }

    fn advance(&mut self) -> Progress {
        if self.done {
            return Progress::Finished;
        }
        self.done = true;
        let scene: Result<BumpStop<f32, Whole, BEAM_MODES, ROD_MODES>, _> =
            black_box(parts::whole(parts::GAP)).build();
        let Ok(scene) = scene else { return Progress::Failed };
        let scene = black_box(scene);
        self.bits = [
            scene.beam_angular_frequency(0).unwrap_or_default(),
            scene.beam_angular_frequency(BEAM_MODES - 1).unwrap_or_default(),
            scene.rod_angular_frequency(0).unwrap_or_default(),
            scene.contact_stiffness(),
        ]
        .map(f32::to_bits);
        Progress::Sample { steps: 1, simulated_us: 0 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
