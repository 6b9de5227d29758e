//! A run of a harvester as a workload: at rest or in motion at time zero, shaken by a sine, sampled at equal times.

use core::hint::black_box;

use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::{HybridState, Work};
use model_core::scene::bump_stop::{Parts, Stepper};
use model_core::scene::{Harvester, Simulation};

use super::{Progress, Workload};

/// The excitation of a run and its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// One word, for the log.
    pub name: &'static str,
    /// Amplitude of the base acceleration in m/s².
    pub amplitude: f32,
    /// Its frequency in Hz.
    pub frequency: f32,
    /// Velocity at the start in m/s.
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
const QUARTER_TICKS: u64 = TICKS_PER_SECOND / 4;
const QUARTER_US: u32 = 250_000;

/// A run of a harvester, with `W` logged words.
///
/// `F` writes these words from the harvester, its state, the delivered energy in J and the work since the last sample.
#[derive(Debug)]
pub struct Run<H: Harvester<f32>, F, const W: usize> {
    plan: Plan,
    harvester: H,
    excitation: Sine<f32>,
    state: H::State,
    meter: PowerMeter<f32>,
    samples: u32,
    words: F,
    bits: [u32; W],
}

/// Place of the delivered energy in the logged words, in J.
pub const ENERGY: usize = 4;
/// Place of the rejected long steps in the logged words of bump-stop.
pub const REJECTED: usize = 7;

impl<H: Harvester<f32>, F: Fn(&H, &H::State, f32, Work, &mut [u32; W]), const W: usize> Run<H, F, W> {
    /// `harvester` at `start`; `None` if the start or the plan is refused.
    #[must_use]
    #[inline]
    pub fn new(plan: Plan, harvester: H, start: &H::Start, words: F) -> Option<Self> {
        // `black_box` keeps the compiler from evaluating the run at compile time.
        let excitation = Sine::new(black_box(plan.amplitude), black_box(plan.frequency), 0.0).ok()?;
        let state = harvester.start(start, &excitation).ok()?;
        let meter = PowerMeter::new();
        Some(Self { plan, harvester, excitation, state, meter, samples: 0, words, bits: [0; W] })
    }
}

impl<H, F, const W: usize> Workload for Run<H, F, W>
where
    H: Harvester<f32>,
    F: Fn(&H, &H::State, f32, Work, &mut [u32; W]),
{
    fn name(&self) -> &'static str {
        self.plan.name
    }

    fn advance(&mut self) -> Progress {
        if self.samples == self.plan.samples {
            return Progress::Finished;
        }
        self.samples = self.samples.wrapping_add(1);
        let until = u64::from(self.samples.wrapping_mul(self.plan.quarters)).wrapping_mul(QUARTER_TICKS);
        let until = Instant::from_ticks(until);
        let advance =
            self.harvester.advance(&mut self.state, &self.excitation, until, u32::MAX, &mut self.meter);
        let Ok(advance) = advance else { return Progress::Failed };
        let delivered = self.meter.delivered_energy();
        (self.words)(&self.harvester, &self.state, delivered, advance.work, &mut self.bits);
        let simulated_us = self.plan.quarters.wrapping_mul(QUARTER_US);
        Progress::Sample { steps: advance.work.steps, simulated_us }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

/// Position in m, velocity in m/s, charge in units of the scene, current in these units a second, delivered energy in J.
pub fn triboelectric<A, M, C, O>(
    _: &Simulation<A, M, C, 3, 1>,
    state: &HybridState<f32, O, 3, 1>,
    delivered: f32,
    _: Work,
    words: &mut [u32; 5],
) {
    let [position, velocity, charge] = state.point.state;
    let [.., current] = state.point.derivative;
    *words = [position, velocity, charge, current, delivered].map(f32::to_bits);
}

/// Of any harvester: its first coordinate in m and the rate of it in m/s, charge in C, voltage of the storage in V or 0
/// without one, delivered energy in J.
pub fn outputs<H: Harvester<f32>>(
    harvester: &H,
    state: &H::State,
    delivered: f32,
    _: Work,
    words: &mut [u32; 5],
) {
    let outputs = harvester.outputs(state);
    let motion = outputs.coordinate();
    let storage = outputs.storage.map_or(0.0, |storage| storage.voltage);
    *words = [motion.value, motion.rate, outputs.charge.value, storage, delivered].map(f32::to_bits);
}

/// Displacement and velocity of the first beam mode, voltage in V, gap in m, delivered energy in J, displacement of
/// the last beam mode and of the first rod mode, rejected long steps.
pub fn piezoelectric<P: Parts<f32>, const B: usize, const R: usize>(
    stepper: &Stepper<f32, P, B, R>,
    state: &<Stepper<f32, P, B, R> as Harvester<f32>>::State,
    delivered: f32,
    work: Work,
    words: &mut [u32; 8],
) {
    let first = |modes: &[[f32; 2]]| modes.first().copied().unwrap_or_default();
    let [displacement, velocity] = first(&state.beam);
    let [of_the_last, _] = state.beam.last().copied().unwrap_or_default();
    let [of_the_rod, _] = first(&state.rod);
    *words = [
        displacement.to_bits(),
        velocity.to_bits(),
        stepper.scene().voltage(state).to_bits(),
        state.gap().to_bits(),
        delivered.to_bits(),
        of_the_last.to_bits(),
        of_the_rod.to_bits(),
        words[REJECTED].wrapping_add(work.rejected),
    ];
}

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

/// What both triboelectric scenes have, of their own constants, parameters and parts.
macro_rules! triboelectric_runs {
    () => {
        /// [`SETTLING`] with each of [`LOADS`] and [`LOAD_TOLERANCES`], and [`precision_of`].
        pub fn precision(visit: Visit<'_>) -> Option<()> {
            for resistance in LOADS {
                for tolerance in LOAD_TOLERANCES {
                    let loaded = loaded(black_box(resistance));
                    show(visit, run(SETTLING, loaded, ExponentialRadau, Adaptive::new(tolerance).ok()?))?;
                }
            }
            precision_of(SETTLING, visit)
        }

        /// Any plan by the other methods with each of [`TOLERANCES`], [`STEPS`] and [`EXPLICIT_STEPS`].
        pub fn precision_of(plan: Plan, visit: Visit<'_>) -> Option<()> {
            for tolerance in TOLERANCES {
                show(visit, run(plan, whole(), TrBdf2, Adaptive::new(tolerance).ok()?))?;
            }
            for step in STEPS {
                fixed(visit, plan, whole(), TrBdf2, step)?;
            }
            for step in EXPLICIT_STEPS {
                fixed(visit, plan, whole(), RungeKutta4, step)?;
            }
            Some(())
        }

        #[inline]
        fn fixed<P: Parts<f32>>(
            visit: Visit<'_>,
            plan: Plan,
            parameters: Parameters<f32, P>,
            method: impl Method<f32>,
            step: f32,
        ) -> Option<()> {
            show(visit, run(plan, parameters, method, FixedStep::of_seconds(step).ok()?))
        }

        /// A run of `parameters`; `None` if something is refused.
        #[must_use]
        #[inline(never)]
        pub fn run<P: Parts<f32>>(
            plan: Plan,
            parameters: Parameters<f32, P>,
            method: impl Method<f32>,
            control: impl StepControl<f32>,
        ) -> Option<impl Workload> {
            let scene = black_box(parameters).build().ok()?;
            let start = Start { velocity: Some(black_box(plan.velocity)), ..Start::default() };
            Run::new(plan, Simulation::new(scene, method, black_box(control)), &start, run::triboelectric)
        }

        /// The default scene.
        #[must_use]
        pub fn whole() -> Parameters<f32, Whole> {
            loaded(LOAD.resistance)
        }
    };
}
pub(super) use triboelectric_runs;
