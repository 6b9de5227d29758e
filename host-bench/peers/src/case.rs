//! The scenes that are compared.

use harvester_scene::scene_file::{self, Override, Scene, SceneError};

/// A shipped scene with other values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Name in the command line.
    pub name: &'static str,
    /// Name of the scene file, without ending.
    pub file: &'static str,
    /// Other values, as `KEY=VALUE`.
    pub overrides: &'static [&'static str],
}

const CONTACT_RUN: [&str; 2] = ["run.duration_s=3", "run.settle_s=2"];
const SLIDING_RUN: [&str; 2] = ["run.duration_periods=54", "run.settle_periods=36"];
/// A storage, at a voltage that the harvester exceeds.
const STORE: &str = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e9, \
                     initial_v=5.0, draw={kind=\"none\"}}";
const STORE_OF_PIEZO: &str = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e9, \
                              initial_v=0.5, draw={kind=\"none\"}}";

/// All of them, in the order of the table.
pub const CASES: [Case; 9] = [
    Case {
        name: "contact-100M",
        file: "contact-separation",
        overrides: &["load.resistance_ohm=1e8", CONTACT_RUN[0], CONTACT_RUN[1]],
    },
    Case {
        name: "contact-1M",
        file: "contact-separation",
        overrides: &["load.resistance_ohm=1e6", CONTACT_RUN[0], CONTACT_RUN[1]],
    },
    Case {
        name: "contact-1k",
        file: "contact-separation",
        overrides: &["load.resistance_ohm=1e3", CONTACT_RUN[0], CONTACT_RUN[1]],
    },
    Case {
        name: "sliding-100M",
        file: "sliding",
        overrides: &["load.resistance_ohm=1e8", SLIDING_RUN[0], SLIDING_RUN[1]],
    },
    Case {
        name: "sliding-1M",
        file: "sliding",
        overrides: &["load.resistance_ohm=1e6", SLIDING_RUN[0], SLIDING_RUN[1]],
    },
    Case {
        name: "stick-slip",
        file: "sliding",
        overrides: &[
            "excitation.amplitude_g=0.30",
            "excitation.frequency_hz=6",
            "run.duration_periods=18",
            "run.settle_periods=12",
        ],
    },
    // The core of this comparison has the force law of the first paper.
    Case {
        name: "contact-bridge",
        file: "rectified",
        overrides: &[
            CONTACT_RUN[0],
            CONTACT_RUN[1],
            "parameters.force_law=transferred-charge",
            "excitation.frequency_hz=20.0",
        ],
    },
    Case { name: "sliding-bridge", file: "sliding", overrides: &[STORE, SLIDING_RUN[0], SLIDING_RUN[1]] },
    Case {
        name: "bump-stop-bridge",
        file: "bump-stop",
        overrides: &[
            STORE_OF_PIEZO,
            "parameters.beam_modes=4",
            "stop.rod_modes=1",
            "run.duration_s=0.02",
            "run.settle_s=0.005",
        ],
    },
];

impl Case {
    /// The scene.
    ///
    /// # Errors
    /// If a scene file was changed so that a value no longer fits.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let overrides = self.overrides.iter().filter_map(|pair| pair.split_once('='));
        let overrides: Vec<Override> = overrides.map(|(key, value)| Override::new(key, value)).collect();
        scene_file::read(&scene_file::shipped(self.file), &overrides)
    }
}
