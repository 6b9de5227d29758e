//! The contact-separation scene as a workload: any parts, any method, any step control.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::{Driver, HybridState};
use model_core::integrate::{Method, StepControl};
use model_core::scene::contact_separation::{ContactSeparation, Mode, Parameters, Parts, STATES, Start};

use super::{Progress, Workload};

/// What a run is shaken with, and where it is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// One word, for the log.
    pub name: &'static str,
    /// Amplitude of the base acceleration, in m/s².
    pub amplitude: f32,
    /// Its frequency, in hertz.
    pub frequency: f32,
    /// Quarters of a simulated second from one sample to the next.
    pub quarters: u32,
    /// Number of samples.
    pub samples: u32,
}

/// A quarter of a simulated second, in ticks of the clock and in microseconds.
const QUARTER_TICKS: u64 = 1 << 38;
const QUARTER_US: u32 = 250_000;

/// A contact-separation scene that is stepped from sample to sample.
#[derive(Debug)]
pub struct ContactSeparationRun<P: Parts<f32>, M, C> {
    plan: Plan,
    scene: ContactSeparation<f32, P>,
    driver: Driver<M, C>,
    excitation: Sine<f32>,
    state: HybridState<f32, Mode, STATES, 1>,
    meter: PowerMeter<f32, 1>,
    samples: u32,
    bits: [u32; 5],
}

/// Place of the delivered energy in the logged state, in joules.
pub const ENERGY: usize = 4;

impl<P: Parts<f32>, M: Method<f32>, C: StepControl<f32>> ContactSeparationRun<P, M, C> {
    /// The scene at its start; `None` if its parameters or the plan are refused.
    #[must_use]
    #[inline]
    pub fn new(plan: Plan, parameters: Parameters<f32, P>, method: M, control: C) -> Option<Self> {
        // Hidden from the compiler, or it would build coefficients, or more, into the firmware.
        let scene = black_box(parameters).build().ok()?;
        let excitation = Sine::new(black_box(plan.amplitude), black_box(plan.frequency), 0.0).ok()?;
        let control = black_box(control);
        let state = scene.start(&Start::default(), &excitation, &control).ok()?;
        let driver = Driver::new(method, control);
        let meter = PowerMeter::new();
        Some(Self { plan, scene, driver, excitation, state, meter, samples: 0, bits: [0; 5] })
    }
}

impl<P: Parts<f32>, M: Method<f32>, C: StepControl<f32>> Workload for ContactSeparationRun<P, M, C> {
    fn name(&self) -> &'static str {
        self.plan.name
    }

    fn advance(&mut self) -> Progress {
        if self.samples == self.plan.samples {
            return Progress::Finished;
        }
        self.samples += 1;
        let until = Instant::from_ticks(u64::from(self.samples * self.plan.quarters) * QUARTER_TICKS);
        let advance = self.driver.advance(
            &self.scene,
            &mut self.state,
            &self.excitation,
            until,
            u32::MAX,
            &mut self.meter,
        );
        let Ok(advance) = advance else { return Progress::Failed };
        let [gap, velocity, charge] = self.state.point.state;
        let [.., current] = self.state.point.derivative;
        self.bits = [gap, velocity, charge, current, self.meter.delivered_energy()].map(f32::to_bits);
        Progress::Sample { steps: advance.work.steps, simulated_us: self.plan.quarters * QUARTER_US }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
