//! The scene that `host-bench needs --emit` made: its run from the start to the end of the window.
//!
//! The file is `scene/contact_separation.rs`, or what the environment variable `HARVESTER_SCENE` names.

/// The emitted module.
pub mod scene {
    include!(concat!(env!("OUT_DIR"), "/scene.rs"));
}

use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::energy::PowerMeter;
use model_core::excitation::Excitation;
use model_core::scene::Harvester;

use super::{Progress, Visit, Workload, show};

/// The run of the emitted scene.
pub fn bench(visit: Visit<'_>) -> Option<()> {
    let harvester = core::hint::black_box(scene::harvester()?);
    let excitation = scene::excitation()?;
    let state = harvester.start(&scene::start(), &excitation).ok()?;
    let [settled, end] = scene::WINDOW_TICKS.map(Instant::from_ticks);
    let stretches = [settled, end];
    show(
        visit,
        Some(Emitted {
            harvester,
            excitation,
            state,
            stretches,
            done: 0,
            meter: PowerMeter::new(),
            bits: [0],
        }),
    )
}

/// The run to the start of the window, then through the window. Logs the energy in J that was delivered in the stretch.
struct Emitted<H: Harvester<f32>, E> {
    harvester: H,
    excitation: E,
    state: H::State,
    stretches: [Instant; 2],
    done: usize,
    meter: PowerMeter<f32>,
    bits: [u32; 1],
}

impl<H: Harvester<f32>, E: Excitation<f32>> Workload for Emitted<H, E> {
    fn name(&self) -> &'static str {
        "emitted"
    }

    fn advance(&mut self) -> Progress {
        let Some(until) = self.stretches.get(self.done) else { return Progress::Finished };
        self.done += 1;
        self.meter = PowerMeter::new();
        let from = self.harvester.clock(&self.state).ticks();
        let advance =
            self.harvester.advance(&mut self.state, &self.excitation, *until, u32::MAX, &mut self.meter);
        let Ok(advance) = advance else { return Progress::Failed };
        self.bits = [self.meter.delivered_energy().to_bits()];
        let simulated_us = (until.ticks() - from) * 1_000_000 / TICKS_PER_SECOND;
        Progress::Sample { steps: advance.work.steps, simulated_us: simulated_us as u32 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
