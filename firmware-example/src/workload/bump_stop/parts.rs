//! What the bump-stop scene is made of.

use model_core::part::load::Resistor;
use model_core::part::monomorph::Layer;
use model_core::scene::bump_stop::{Choices, Parameters, ResidualFlexibility, Resistive, Stop};

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e6 };
/// Distance of beam and rod at rest in the default scene, in m.
pub const GAP: f32 = 10e-6;

/// 50 mm × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A.
#[must_use]
pub fn parameters<C>(choices: C) -> Parameters<f32, C> {
    Parameters {
        beam_length: 50e-3,
        beam_width: 10e-3,
        substrate: Layer { thickness: 0.5e-3, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 0.5e-3, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        choices,
    }
}

/// An aluminium rod of 20 mm × 2 mm × 2 mm, `gap` metres from the beam's tip.
#[must_use]
pub fn stop(gap: f32) -> Stop<f32> {
    Stop {
        length: 20e-3,
        section: 4e-6,
        young_modulus: 70e9,
        density: 2700.0,
        position: 50e-3,
        gap,
        contact_compliance: 0.0,
        contact: ResidualFlexibility,
    }
}

/// What the default scene is made of.
pub type Whole = Choices<Resistive<Resistor<f32>>, Stop<f32>>;

/// The default scene with a gap of its own.
#[must_use]
pub fn whole(gap: f32) -> Parameters<f32, Whole> {
    parameters(Choices::new(LOAD).stop(stop(gap)))
}
