//! What the sliding scene is made of, whole and with one part left out or replaced.

use model_core::part::load::{OpenCircuit, Resistor, ShortCircuit};
use model_core::scene::sliding::{
    Frictionless, FrozenCharge, GapField, NeverSticks, NoLateralForce, Parameters, Parts, PatchFriction,
    TransferredCharge,
};

/// Names a list of parts: none has a lateral force.
macro_rules! parts {
    ($($(#[$text:meta])* $name:ident: $force_law:ty, $load:ty, $friction:ty, $sticking:ty;)*) => {$(
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name;

        impl Parts<f32> for $name {
            type ForceLaw = $force_law;
            type Load = $load;
            type Friction = $friction;
            type Sticking = $sticking;
            type LateralForce = NoLateralForce;
        }
    )*};
}

parts! {
    /// Everything that the default scene has, and nothing else.
    Whole: TransferredCharge, Resistor<f32>, PatchFriction<f32>, FrozenCharge;
    /// Without friction.
    WithoutFriction: TransferredCharge, Resistor<f32>, Frictionless, FrozenCharge;
    /// Without sticking.
    WithoutSticking: TransferredCharge, Resistor<f32>, PatchFriction<f32>, NeverSticks;
    /// With the load open.
    Open: TransferredCharge, OpenCircuit, PatchFriction<f32>, FrozenCharge;
    /// With the load shorted.
    Shorted: TransferredCharge, ShortCircuit, PatchFriction<f32>, FrozenCharge;
    /// With the force of the field.
    OfTheField: GapField, Resistor<f32>, PatchFriction<f32>, FrozenCharge;
}

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { ohms: 1e8 };
/// Its friction.
pub const FRICTION: PatchFriction<f32> =
    PatchFriction { static_active: 0.35, static_inert: 0.25, kinetic_active: 0.30, kinetic_inert: 0.20 };

/// Table 1 of the paper with σ = 80 µC/m².
#[must_use]
pub fn parameters<P>(
    force_law: P::ForceLaw,
    load: P::Load,
    friction: P::Friction,
    sticking: P::Sticking,
) -> Parameters<f32, P>
where
    P: Parts<f32, LateralForce = NoLateralForce>,
{
    Parameters {
        beam_length: 0.1,
        beam_width: 20e-3,
        beam_thickness: 0.5e-3,
        young_modulus: 210e9,
        density: 7800.0,
        damping_ratio: 0.0035,
        slider_mass: 8e-3,
        patch_radius: 10e-3,
        friction,
        dielectric_thickness: 0.05e-3,
        relative_permittivity: 2.0,
        charge_density: 80e-6,
        load,
        force_law,
        sticking,
        lateral_force: NoLateralForce,
    }
}

/// The default scene.
#[must_use]
pub fn whole() -> Parameters<f32, Whole> {
    parameters(TransferredCharge, LOAD, FRICTION, FrozenCharge)
}
