//! What `bench` measures, and the host runs beside it to compare the bits.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::{Driver, HybridState};
use model_core::integrate::{Adaptive, TrBdf2};
use model_core::part::load::Resistor;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::VelocityDependentRestitution;
use model_core::scene::contact_separation::{
    ContactSeparation, FrozenCharge, Mode, Parameters, Parts, STATES, Start, TransferredCharge,
};

/// Something to measure.
///
/// It is used as `dyn Workload`, so that the code around it is the same machine code in `empty`
/// and in `bench`, and the difference of their sizes is the workload's own.
pub trait Workload {
    /// One word, for the log.
    fn name(&self) -> &'static str;

    /// Runs up to the next sample. This, and nothing else, is measured.
    fn advance(&mut self) -> Progress;

    /// The state as raw bits, for a comparison with the host that forgives nothing.
    fn state(&self) -> &[u32];
}

/// What a call of [`Workload::advance`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// It got to the next sample.
    Sample {
        /// Steps taken since the last one.
        steps: u32,
        /// Simulated microseconds since the last one.
        simulated_us: u32,
    },
    /// There was nothing left to do.
    Finished,
    /// It could not go on.
    Failed,
}

/// The parts of the default contact-separation scene, and nothing else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultParts;

impl Parts<f32> for DefaultParts {
    type ForceLaw = TransferredCharge;
    type Load = Resistor<f32>;
    type Parasitic = ParasiticCapacitance<f32>;
    type Restitution = VelocityDependentRestitution<f32>;
    type Sticking = FrozenCharge;
}

/// Table 2 of the paper with σ = 50 µC/m² and R = 100 MΩ.
#[must_use]
pub fn default_parameters() -> Parameters<f32, DefaultParts> {
    Parameters {
        mass: 5e-3,
        stiffness: 80.0,
        damping_ratio: 0.005,
        initial_gap: 3e-3,
        electrode_area: 4e-4,
        dielectric_thickness: 5e-5,
        relative_permittivity: 2.0,
        charge_density: 50e-6,
        parasitic: ParasiticCapacitance { farads: 1e-12 },
        load: Resistor { ohms: 1e8 },
        force_law: TransferredCharge,
        restitution: VelocityDependentRestitution {
            at_rest: 0.8,
            at_speed: 0.5,
            reference_speed: 0.3,
            mathematics: core::marker::PhantomData,
        },
        sticking: FrozenCharge,
    }
}

/// Simulated time between samples, a quarter of a second.
const SAMPLE_TICKS: u64 = 1 << 38;
const SAMPLE_US: u32 = 250_000;
/// Samples: two simulated seconds.
const SAMPLES: u32 = 8;
/// Relative tolerance per radian.
const TOLERANCE: f32 = 5e-2;

/// The default scene shaken at 20 Hz and 0.2 g: impacts from 0.4 s on.
#[derive(Debug)]
pub struct ContactSeparationBench {
    scene: ContactSeparation<f32, DefaultParts>,
    driver: Driver<TrBdf2, Adaptive<f32>>,
    excitation: Sine<f32>,
    state: HybridState<f32, Mode, STATES, 1>,
    meter: PowerMeter<f32, 1>,
    samples: u32,
    bits: [u32; 5],
}

impl ContactSeparationBench {
    /// The scene at its start; `None` if its parameters are refused.
    #[must_use]
    pub fn new() -> Option<Self> {
        // Hidden from the compiler, or it would build coefficients, or more, into the firmware.
        let scene = black_box(default_parameters()).build().ok()?;
        let excitation = Sine::new(black_box(1.962), black_box(20.0), 0.0).ok()?;
        let control = Adaptive::new(black_box(TOLERANCE));
        let state = scene.start(&Start::default(), &excitation, &control).ok()?;
        let driver = Driver::new(TrBdf2, control);
        Some(Self { scene, driver, excitation, state, meter: PowerMeter::new(), samples: 0, bits: [0; 5] })
    }
}

impl Workload for ContactSeparationBench {
    fn name(&self) -> &'static str {
        "contact-separation"
    }

    fn advance(&mut self) -> Progress {
        if self.samples == SAMPLES {
            return Progress::Finished;
        }
        let until = Instant::from_ticks(u64::from(self.samples + 1) * SAMPLE_TICKS);
        let advance = self.driver.advance(
            &self.scene,
            &mut self.state,
            &self.excitation,
            until,
            u32::MAX,
            &mut self.meter,
        );
        let Ok(advance) = advance else { return Progress::Failed };
        self.samples += 1;
        let [gap, velocity, charge] = self.state.point.state;
        let values = [gap, velocity, charge, self.state.point.derivative[2], self.meter.delivered_energy()];
        self.bits = values.map(f32::to_bits);
        Progress::Sample { steps: advance.work.steps, simulated_us: SAMPLE_US }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
