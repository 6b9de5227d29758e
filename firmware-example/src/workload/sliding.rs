//! The sliding scene: its variants.
//!
//! The corners of the motion are events, four in a period.

use core::hint::black_box;

use model_core::integrate::{
    Adaptive, ExponentialRadau, FixedStep, Method, RungeKutta4, StepControl, TrBdf2,
};
use model_core::part::load::Resistor;
use model_core::scene::Simulation;
use model_core::scene::sliding::{Choices, Parameters, Parts, PatchFriction, Start, TransferredCharge};

use super::run::{self, Building, Plan, Run, triboelectric_runs};
use super::{Visit, Workload, show};

/// 0.36 g at 18.373 Hz, the natural frequency: the slider lets go in the first period and slides from then on. Three seconds.
pub const SLIDING: Plan =
    Plan { name: "sliding", amplitude: 3.5316, frequency: 18.373, velocity: 0.0, quarters: 1, samples: 12 };
/// 0.30 g at 6 Hz: the slider sticks twice a period, for half of the time.
pub const STICK_SLIP: Plan = Plan { name: "stick-slip", amplitude: 2.943, frequency: 6.0, ..SLIDING };
/// Fifteen seconds at resonance, of which the last five are settled.
pub const SETTLING: Plan = Plan { name: "settling", quarters: 20, samples: 3, ..SLIDING };
/// [`SETTLING`] a little below the resonance: on the flanks an error of the frequency shows.
pub const BELOW: Plan = Plan { name: "below", frequency: 18.303, ..SETTLING };
/// [`SETTLING`] a little above the resonance.
pub const ABOVE: Plan = Plan { name: "above", frequency: 18.443, ..SETTLING };

/// Relative tolerance per radian of [`bench()`].
pub const TOLERANCE: f32 = 5e-2;
/// Step of the Runge–Kutta method of [`others`] in seconds: some 27 in a period.
pub const STEP: f32 = 2e-3;
/// Loads in Ω of [`precision`].
pub const LOADS: [f32; 3] = [1e8, 1e6, 1e4];
/// Tolerances of [`precision`] for each load.
pub const LOAD_TOLERANCES: [f32; 2] = [TOLERANCE, 1e-2];
/// Tolerances of [`precision`] for TR-BDF2.
pub const TOLERANCES: [f32; 4] = [5e-2, 2e-2, 1e-2, 5e-3];
/// Fixed steps of [`precision`] for TR-BDF2, in seconds.
pub const STEPS: [f32; 2] = [1e-3, 5e-4];
/// Fixed steps of [`precision`] for the classical Runge–Kutta method, in seconds.
pub const EXPLICIT_STEPS: [f32; 4] = [3.8e-3, 2.5e-3, 2e-3, 1e-3];

/// The default scene.
pub fn bench(visit: Visit<'_>) -> Option<()> {
    adaptive(visit, SLIDING, whole())
}

/// [`STICK_SLIP`] as the bench runs it and by the classical Runge–Kutta method, and the build of the coefficients, the
/// beam's eigenvalue included.
pub fn others(visit: Visit<'_>) -> Option<()> {
    adaptive(visit, STICK_SLIP, whole())?;
    fixed(visit, STICK_SLIP, whole(), RungeKutta4, STEP)?;
    visit(&mut Building::new("sliding-build", || {
        let scene = black_box(black_box(whole()).build().ok()?);
        Some([scene.angular_frequency(), scene.modal_mass(), scene.base_coupling(), scene.charge_unit()])
    }));
    Some(())
}

#[inline]
fn adaptive<P: Parts<f32>>(visit: Visit<'_>, plan: Plan, parameters: Parameters<f32, P>) -> Option<()> {
    show(visit, run(plan, parameters, ExponentialRadau, Adaptive::new(TOLERANCE).ok()?))
}

triboelectric_runs!();

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e8 };
pub const FRICTION: PatchFriction<f32> =
    PatchFriction { static_active: 0.35, static_inert: 0.25, kinetic_active: 0.30, kinetic_inert: 0.20 };

/// Table 1 of the paper with σ = 80 µC/m².
#[must_use]
pub fn parameters<C>(choices: C) -> Parameters<f32, C> {
    Parameters {
        beam_length: 0.1,
        beam_width: 20e-3,
        beam_thickness: 0.5e-3,
        young_modulus: 210e9,
        density: 7800.0,
        damping_ratio: 0.0035,
        slider_mass: 8e-3,
        patch_radius: 10e-3,
        dielectric_thickness: 0.05e-3,
        relative_permittivity: 2.0,
        charge_density: 80e-6,
        choices,
    }
}

/// What the default scene is made of.
pub type Whole = Choices<Resistor<f32>, PatchFriction<f32>, TransferredCharge>;

/// The default scene with another load in Ω.
#[must_use]
pub fn loaded(resistance: f32) -> Parameters<f32, Whole> {
    parameters(Choices::new(Resistor { resistance }, FRICTION).force_law(TransferredCharge))
}
