//! What the sliding scene is made of.

use model_core::part::load::Resistor;
use model_core::scene::sliding::{Choices, Parameters, PatchFriction, TransferredCharge};

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e8 };
/// Its friction.
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

/// The default scene.
#[must_use]
pub fn whole() -> Parameters<f32, Whole> {
    loaded(LOAD.resistance)
}

/// The default scene with another load in Ω.
#[must_use]
pub fn loaded(resistance: f32) -> Parameters<f32, Whole> {
    parameters(Choices::new(Resistor { resistance }, FRICTION).force_law(TransferredCharge))
}
