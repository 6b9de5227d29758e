//! What the contact-separation scene is made of, whole and with one part left out.

use core::marker::PhantomData;

use model_core::part::load::Resistor;
use model_core::part::parasitic::{NoParasitic, ParasiticCapacitance};
use model_core::part::restitution::{ConstantRestitution, VelocityDependentRestitution};
use model_core::scene::contact_separation::{
    FrozenCharge, NeverSticks, Parameters, Parts, TransferredCharge,
};

type LawOfSpeed = VelocityDependentRestitution<f32>;
type Constant = ConstantRestitution<f32>;
type Capacitance = ParasiticCapacitance<f32>;

/// Names a list of parts: all of them but three are the same everywhere.
macro_rules! parts {
    ($($(#[$text:meta])* $name:ident: $parasitic:ty, $restitution:ty, $sticking:ty;)*) => {$(
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name;

        impl Parts<f32> for $name {
            type ForceLaw = TransferredCharge;
            type Load = Resistor<f32>;
            type Parasitic = $parasitic;
            type Restitution = $restitution;
            type Sticking = $sticking;
        }
    )*};
}

parts! {
    /// Everything that the default scene has, and nothing else.
    Whole: Capacitance, LawOfSpeed, FrozenCharge;
    /// Without a parasitic capacitance.
    WithoutParasitic: NoParasitic, LawOfSpeed, FrozenCharge;
    /// Without sticking.
    WithoutSticking: Capacitance, LawOfSpeed, NeverSticks;
    /// With one coefficient of restitution for all speeds.
    WithoutLawOfSpeed: Capacitance, Constant, FrozenCharge;
    /// Without all of these.
    Bare: NoParasitic, Constant, NeverSticks;
}

/// The parasitic capacitance of the default scene.
pub const PARASITIC: Capacitance = ParasiticCapacitance { farads: 1e-12 };
/// Its law of restitution.
pub const LAW_OF_SPEED: LawOfSpeed = VelocityDependentRestitution {
    at_rest: 0.8,
    at_speed: 0.5,
    reference_speed: 0.3,
    mathematics: PhantomData,
};
/// What stands in for it: its value at the usual impact speed of 0.15 m/s.
pub const CONSTANT: Constant = ConstantRestitution { coefficient: 0.68 };

/// Table 2 of the paper with σ = 50 µC/m² and R = 100 MΩ.
#[must_use]
pub fn parameters<P>(
    parasitic: P::Parasitic,
    restitution: P::Restitution,
    sticking: P::Sticking,
) -> Parameters<f32, P>
where
    P: Parts<f32, ForceLaw = TransferredCharge, Load = Resistor<f32>>,
{
    with_load(Resistor { ohms: 1e8 }, parasitic, restitution, sticking)
}

/// The same with any load.
#[must_use]
pub fn with_load<P>(
    load: P::Load,
    parasitic: P::Parasitic,
    restitution: P::Restitution,
    sticking: P::Sticking,
) -> Parameters<f32, P>
where
    P: Parts<f32, ForceLaw = TransferredCharge>,
{
    Parameters {
        mass: 5e-3,
        stiffness: 80.0,
        damping_ratio: 0.005,
        initial_gap: 3e-3,
        electrode_area: 4e-4,
        dielectric_thickness: 5e-5,
        relative_permittivity: 2.0,
        charge_density: 50e-6,
        parasitic,
        load,
        force_law: TransferredCharge,
        restitution,
        sticking,
    }
}

/// The default scene.
#[must_use]
pub fn whole() -> Parameters<f32, Whole> {
    parameters(PARASITIC, LAW_OF_SPEED, FrozenCharge)
}
