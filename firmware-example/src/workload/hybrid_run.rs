//! A hybrid scene as a workload: any harvester of three states, any method, any step control.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::{Automaton, Driver, HybridState};
use model_core::integrate::{Method, StepControl};

use super::{Progress, Workload};

/// States of every harvester here: a position in m, its velocity in m/s, a charge in units of the
/// scene.
const STATES: usize = 3;

/// The state of a scene with the one power that a node integrates.
pub type State<H> = HybridState<f32, <H as Automaton<f32, STATES, 1>>::Mode, STATES, 1>;

/// Parameters of which a run can be made.
pub trait Parameters {
    /// The harvester that is made of them.
    type Harvester: Automaton<f32, STATES, 1>;

    /// The harvester; `None` if the parameters are refused.
    fn build(&self) -> Option<Self::Harvester>;

    /// The harvester at time zero, with `velocity` in m/s where it is when at rest; `None` if the start
    /// is refused.
    fn start<C: StepControl<f32>>(
        harvester: &Self::Harvester,
        velocity: f32,
        excitation: &Sine<f32>,
        control: &C,
    ) -> Option<State<Self::Harvester>>;
}

/// What a run is shaken with, and where it is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// One word, for the log.
    pub name: &'static str,
    /// Amplitude of the base acceleration, in m/s².
    pub amplitude: f32,
    /// Its frequency, in hertz.
    pub frequency: f32,
    /// Velocity at the start, in m/s.
    pub velocity: f32,
    /// Quarters of a simulated second from one sample to the next.
    pub quarters: u32,
    /// Number of samples.
    pub samples: u32,
}

impl Plan {
    /// Length of the whole run in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        f64::from(self.quarters * self.samples) * 0.25
    }
}

/// A quarter of a simulated second, in ticks of the clock and in microseconds.
const QUARTER_TICKS: u64 = 1 << 38;
const QUARTER_US: u32 = 250_000;

/// A scene that is stepped from sample to sample.
#[derive(Debug)]
pub struct HybridRun<P: Parameters, M, C> {
    plan: Plan,
    harvester: P::Harvester,
    driver: Driver<M, C>,
    excitation: Sine<f32>,
    state: State<P::Harvester>,
    meter: PowerMeter<f32>,
    samples: u32,
    bits: [u32; 5],
}

/// Place of the delivered energy in the logged state, in joules.
pub const ENERGY: usize = 4;

impl<P: Parameters, M: Method<f32>, C: StepControl<f32>> HybridRun<P, M, C> {
    /// The scene at its start; `None` if its parameters or the plan are refused.
    #[must_use]
    #[inline]
    pub fn new(plan: Plan, parameters: P, method: M, control: C) -> Option<Self> {
        // Hidden from the compiler, or it would build coefficients, or more, into the firmware.
        let harvester = black_box(parameters).build()?;
        let excitation = Sine::new(black_box(plan.amplitude), black_box(plan.frequency), 0.0).ok()?;
        let control = black_box(control);
        let state = P::start(&harvester, black_box(plan.velocity), &excitation, &control)?;
        let driver = Driver::new(method, control);
        let meter = PowerMeter::new();
        Some(Self { plan, harvester, driver, excitation, state, meter, samples: 0, bits: [0; 5] })
    }
}

impl<P: Parameters, M: Method<f32>, C: StepControl<f32>> Workload for HybridRun<P, M, C> {
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
            &self.harvester,
            &mut self.state,
            &self.excitation,
            until,
            u32::MAX,
            &mut self.meter,
        );
        let Ok(advance) = advance else { return Progress::Failed };
        let [position, velocity, charge] = self.state.point.state;
        let [.., current] = self.state.point.derivative;
        self.bits = [position, velocity, charge, current, self.meter.delivered_energy()].map(f32::to_bits);
        Progress::Sample { steps: advance.work.steps, simulated_us: self.plan.quarters * QUARTER_US }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
