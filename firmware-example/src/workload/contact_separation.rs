//! The contact-separation scene: its variants.

use core::hint::black_box;
use core::marker::PhantomData;

use model_core::integrate::{
    Adaptive, ExponentialRadau, FixedStep, Method, RungeKutta4, StepControl, TrBdf2,
};
use model_core::part::draw::NoDraw;
use model_core::part::load::{OpenCircuit, Resistor};
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::VelocityDependentRestitution;
use model_core::part::storage::{Capacitor, StorageCapacitor};
use model_core::scene::Simulation;
use model_core::scene::contact_separation::{Choices, GapField, Parameters, Parts, Start, TransferredCharge};
use model_core::scene::rectified::{FullBridge, Rectified};

use super::run::{self, Plan, Run, triboelectric_runs};
use super::{Visit, Workload, show};

/// 0.2 g at 20 Hz, just below the natural frequency: impacts from 0.43 s on. Three seconds.
pub const IMPACTING: Plan = Plan {
    name: "contact-separation",
    amplitude: 1.962,
    frequency: 20.0,
    velocity: 0.0,
    quarters: 1,
    samples: 12,
};
/// 0.2 g at 20.51 Hz, where the motion under the force of the field is periodic: two periods are 39 samples of 400 a second.
pub const PASSIVE: Plan = Plan { frequency: 800.0 / 39.0, ..IMPACTING };
/// [`IMPACTING`] for fifteen seconds, of which the last five are settled.
pub const SETTLING: Plan = Plan { name: "settling", quarters: 20, samples: 3, ..IMPACTING };
/// 0.2 g at 22 Hz, above the natural frequency: the mass never reaches the dielectric.
pub const SMOOTH: Plan = Plan { name: "smooth", frequency: 22.0, quarters: 12, samples: 1, ..IMPACTING };

/// Relative tolerance per radian of [`bench()`].
pub const TOLERANCE: f32 = 5e-2;
/// Loads in Ω of [`precision`].
pub const LOADS: [f32; 6] = [1e8, 1e6, 1e5, 1e4, 1e3, 1.0];
/// Tolerances of [`precision`] for each load.
pub const LOAD_TOLERANCES: [f32; 3] = [TOLERANCE, 3e-2, 1e-2];
/// Tolerances of [`precision`] for TR-BDF2.
pub const TOLERANCES: [f32; 4] = [1e-1, 5e-2, 2e-2, 1e-2];
/// Fixed steps of [`precision`] for TR-BDF2, in seconds.
pub const STEPS: [f32; 2] = [1e-3, 5e-4];
/// Fixed steps of [`precision`] for the classical Runge–Kutta method, in seconds.
pub const EXPLICIT_STEPS: [f32; 2] = [5e-4, 2.5e-4];
pub const SMOOTH_TOLERANCES: [f32; 3] = [1e-1, 1e-2, 1e-3];
/// Fixed step of [`smooth`] for the classical Runge–Kutta method, in seconds.
pub const SMOOTH_STEP: f32 = 2.5e-4;

/// The storage of [`others`]: capacitance in F, voltage at the start in V, forward voltage of each of the bridge's diodes in V.
pub const STORAGE: [f32; 3] = [22e-6, 2.6, 0.3];

/// The default scene.
pub fn bench(visit: Visit<'_>) -> Option<()> {
    show(visit, run(IMPACTING, whole(), ExponentialRadau, Adaptive::new(TOLERANCE).ok()?))
}

/// The default scene under the force of the field, with [`PASSIVE`], behind a bridge that charges [`STORAGE`].
pub fn others(visit: Visit<'_>) -> Option<()> {
    let [capacitance, initial_voltage, diode_drop] = black_box(STORAGE);
    let capacitor = Capacitor { capacitance, leakage_resistance: f32::INFINITY };
    let storage = StorageCapacitor { capacitor, initial_voltage, draw: NoDraw };
    // The bridge is what is at the terminals.
    let alone = black_box(passive(OpenCircuit)).build().ok()?;
    let scene = Rectified::new(alone, FullBridge { diode_drop, storage }).ok()?;
    let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).ok()?);
    show(visit, Run::new(PASSIVE, harvester, &Start::default(), run::outputs))
}

/// [`SMOOTH`] with each of [`SMOOTH_TOLERANCES`] and with [`SMOOTH_STEP`].
pub fn smooth(visit: Visit<'_>) -> Option<()> {
    for tolerance in SMOOTH_TOLERANCES {
        show(visit, run(SMOOTH, whole(), ExponentialRadau, Adaptive::new(tolerance).ok()?))?;
    }
    fixed(visit, SMOOTH, whole(), RungeKutta4, SMOOTH_STEP)
}

triboelectric_runs!();

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e8 };
pub const PARASITIC: ParasiticCapacitance<f32> = ParasiticCapacitance { capacitance: 1e-12 };
pub const LAW_OF_SPEED: VelocityDependentRestitution<f32> = VelocityDependentRestitution {
    at_rest: 0.8,
    at_speed: 0.5,
    reference_speed: 0.3,
    mathematics: PhantomData,
};

/// Table 2 of the paper with σ = 50 µC/m².
#[must_use]
pub fn parameters<C>(choices: C) -> Parameters<f32, C> {
    Parameters {
        mass: 5e-3,
        stiffness: 80.0,
        damping_ratio: 0.005,
        initial_gap: 3e-3,
        electrode_area: 4e-4,
        dielectric_thickness: 5e-5,
        relative_permittivity: 2.0,
        charge_density: 50e-6,
        choices,
    }
}

/// What the default scene is made of.
pub type Whole =
    Choices<Resistor<f32>, VelocityDependentRestitution<f32>, TransferredCharge, ParasiticCapacitance<f32>>;

/// The default scene with another load in Ω.
#[must_use]
pub fn loaded(resistance: f32) -> Parameters<f32, Whole> {
    parameters(
        Choices::new(Resistor { resistance }, LAW_OF_SPEED).force_law(TransferredCharge).parasitic(PARASITIC),
    )
}

/// The parts of the default scene under the force of the field, which conserves energy.
pub type Passive<L> = Choices<L, VelocityDependentRestitution<f32>, GapField, ParasiticCapacitance<f32>>;

/// The default scene under the force of the field, with another load.
#[must_use]
pub fn passive<L>(load: L) -> Parameters<f32, Passive<L>> {
    parameters(Choices::new(load, LAW_OF_SPEED).parasitic(PARASITIC).force_law(GapField))
}
