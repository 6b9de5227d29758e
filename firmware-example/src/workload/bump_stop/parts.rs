//! What the bump-stop scene is made of, whole and with one part left out.

use model_core::part::load::{OpenCircuit, Resistor};
use model_core::part::monomorph::Layer;
use model_core::scene::bump_stop::{NoStop, OneWay, Parameters, Parts, ResidualFlexibility, Stop, TwoWay};

/// Names a list of parts.
macro_rules! parts {
    ($($(#[$text:meta])* $name:ident: $load:ty, $coupling:ty, $contact:ty;)*) => {$(
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name;

        impl Parts<f32> for $name {
            type Load = $load;
            type Coupling = $coupling;
            type Contact = $contact;
        }
    )*};
}

parts! {
    /// Everything that the default scene has, and nothing else.
    Whole: Resistor<f32>, TwoWay, ResidualFlexibility;
    /// Without the stop.
    WithoutStop: Resistor<f32>, TwoWay, NoStop;
    /// Without the voltage acting back on the beam.
    WithoutBack: Resistor<f32>, OneWay, ResidualFlexibility;
    /// With the load open.
    Open: OpenCircuit, TwoWay, ResidualFlexibility;
}

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { ohms: 1e6 };
/// Distance of beam and rod at rest in the default scene, in m.
pub const GAP: f32 = 10e-6;

/// 50 mm × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A against an aluminium rod of 20 mm × 2 mm × 2 mm, `gap`
/// metres from the tip.
#[must_use]
pub fn parameters<P: Parts<f32>>(
    load: P::Load,
    coupling: P::Coupling,
    contact: P::Contact,
    gap: f32,
) -> Parameters<f32, P> {
    Parameters {
        beam_length: 50e-3,
        beam_width: 10e-3,
        substrate: Layer { thickness: 0.5e-3, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 0.5e-3, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        stop: Stop {
            length: 20e-3,
            section: 4e-6,
            young_modulus: 70e9,
            density: 2700.0,
            position: 50e-3,
            gap,
            contact_compliance: 0.0,
        },
        load,
        coupling,
        contact,
    }
}

/// The default scene with a gap of its own.
#[must_use]
pub fn whole(gap: f32) -> Parameters<f32, Whole> {
    parameters(LOAD, TwoWay, ResidualFlexibility, gap)
}
