//! A bump-stop scene as a workload: any parts, any numbers of modes, one or two lengths of step.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{Parameters, Parts, Start, StateOf, Stepper};

use crate::workload::{Progress, Workload};

/// What a run is shaken with, how it is stepped, and where it is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// One word, for the log.
    pub name: &'static str,
    /// Amplitude of the base acceleration, in m/s².
    pub amplitude: f32,
    /// Its frequency, in hertz.
    pub frequency: f32,
    /// Step near contact, in seconds.
    pub short: f32,
    /// Step in free flight, in seconds; the same as `short` for a single length.
    pub long: f32,
    /// Halves of a simulated second: one sample after each.
    pub halves: u32,
}

impl Plan {
    /// Length of the whole run in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        f64::from(self.halves) * 0.5
    }
}

/// Half a simulated second, in ticks of the clock and in microseconds.
const HALF_TICKS: u64 = 1 << 39;
const HALF_US: u32 = 500_000;

/// Place of the delivered energy in the logged state, in joules.
pub const ENERGY: usize = 4;
/// Place of the number of long steps that were tried and not taken.
pub const REJECTED: usize = 7;
/// Words of the logged state.
const WORDS: usize = 8;

/// A scene that is stepped from sample to sample.
#[derive(Debug)]
pub struct ModalRun<P: Parts<f32>, const B: usize, const R: usize> {
    plan: Plan,
    stepper: Stepper<f32, P, B, R>,
    excitation: Sine<f32>,
    state: StateOf<f32, P, B, R>,
    meter: PowerMeter<f32>,
    samples: u32,
    rejected: u32,
    bits: [u32; WORDS],
}

impl<P: Parts<f32>, const B: usize, const R: usize> ModalRun<P, B, R> {
    /// The scene at rest; `None` if its parameters or the plan are refused.
    #[must_use]
    #[inline]
    pub fn new(plan: Plan, parameters: Parameters<f32, P>) -> Option<Self> {
        // Hidden from the compiler, or it would build coefficients, or more, into the firmware.
        let harvester = black_box(parameters).build().ok()?;
        let excitation = Sine::new(black_box(plan.amplitude), black_box(plan.frequency), 0.0).ok()?;
        let state = harvester.start(&Start::default(), &excitation).ok()?;
        let stepper = Stepper::new(harvester, black_box(plan.short), black_box(plan.long)).ok()?;
        let meter = PowerMeter::new();
        Some(Self { plan, stepper, excitation, state, meter, samples: 0, rejected: 0, bits: [0; WORDS] })
    }
}

impl<P: Parts<f32>, const B: usize, const R: usize> Workload for ModalRun<P, B, R> {
    fn name(&self) -> &'static str {
        self.plan.name
    }

    fn advance(&mut self) -> Progress {
        if self.samples == self.plan.halves {
            return Progress::Finished;
        }
        self.samples += 1;
        let until = Instant::from_ticks(u64::from(self.samples) * HALF_TICKS);
        let advance =
            self.stepper.advance(&mut self.state, &self.excitation, until, u32::MAX, &mut self.meter);
        let Ok(advance) = advance else { return Progress::Failed };
        self.rejected += advance.work.rejected;
        let state = &self.state;
        let first = |modes: &[[f32; 2]]| modes.first().copied().unwrap_or_default();
        let last = |modes: &[[f32; 2]]| modes.last().copied().unwrap_or_default();
        let [displacement, velocity] = first(&state.beam);
        let [of_the_last, _] = last(&state.beam);
        let [of_the_rod, _] = first(&state.rod);
        self.bits = [
            displacement.to_bits(),
            velocity.to_bits(),
            self.stepper.scene().voltage(state).to_bits(),
            state.gap().to_bits(),
            self.meter.delivered_energy().to_bits(),
            of_the_last.to_bits(),
            of_the_rod.to_bits(),
            self.rejected,
        ];
        Progress::Sample { steps: advance.work.steps, simulated_us: HALF_US }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
