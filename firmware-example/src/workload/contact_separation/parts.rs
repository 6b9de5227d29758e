//! What the contact-separation scene is made of.

use core::marker::PhantomData;

use model_core::part::load::Resistor;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::VelocityDependentRestitution;
use model_core::scene::contact_separation::{Choices, GapField, Parameters, TransferredCharge};

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e8 };
/// Its parasitic capacitance.
pub const PARASITIC: ParasiticCapacitance<f32> = ParasiticCapacitance { capacitance: 1e-12 };
/// Its law of restitution.
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

/// The default scene.
#[must_use]
pub fn whole() -> Parameters<f32, Whole> {
    loaded(LOAD.resistance)
}

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
