//! The shipped scenes, in either precision.

use core::marker::PhantomData;

use model_core::part::load::AnyLoad;
use model_core::part::monomorph::Layer;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{AnyRestitution, VelocityDependentRestitution};
use model_core::scalar::Scalar;
use model_core::scene::{bump_stop, contact_separation, sliding};

pub(crate) type ContactChoices<S> = contact_separation::AnyChoices<S, <S as Scalar>::Build>;
pub(crate) type Contact<S> = contact_separation::ContactSeparation<S, ContactChoices<S>>;
pub(crate) type Slide<S> = sliding::Sliding<S, sliding::AnyChoices<S>>;
pub(crate) type Bump<S, const B: usize, const R: usize> =
    bump_stop::Stepper<S, bump_stop::AnyChoices<S>, B, R>;

pub(crate) fn contact_parameters<S: Scalar>() -> contact_separation::Parameters<S, ContactChoices<S>> {
    let number = S::from_f64;
    contact_separation::Parameters {
        mass: number(5e-3),
        stiffness: number(80.0),
        damping_ratio: number(0.005),
        initial_gap: number(3e-3),
        electrode_area: number(4e-4),
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(50e-6),
        choices: contact_separation::Choices {
            load: AnyLoad { resistance: number(1e8) },
            restitution: AnyRestitution::VelocityDependent(VelocityDependentRestitution {
                at_rest: number(0.8),
                at_speed: number(0.5),
                reference_speed: number(0.3),
                mathematics: PhantomData,
            }),
            force_law: contact_separation::AnyForceLaw::TransferredCharge,
            parasitic: ParasiticCapacitance { capacitance: number(1e-12) },
            sticking: contact_separation::StickCharge::Frozen,
        },
    }
}

pub(crate) fn contact<S: Scalar>() -> Contact<S> {
    contact_parameters().build().expect("in bounds")
}

pub(crate) fn sliding_parameters<S: Scalar>() -> sliding::Parameters<S, sliding::AnyChoices<S>> {
    let number = S::from_f64;
    sliding::Parameters {
        beam_length: number(0.1),
        beam_width: number(0.02),
        beam_thickness: number(5e-4),
        young_modulus: number(210e9),
        density: number(7800.0),
        damping_ratio: number(0.0035),
        slider_mass: number(8e-3),
        patch_radius: number(0.01),
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(80e-6),
        choices: sliding::Choices {
            load: AnyLoad { resistance: number(1e8) },
            friction: sliding::PatchFriction {
                static_active: number(0.35),
                static_inert: number(0.25),
                kinetic_active: number(0.30),
                kinetic_inert: number(0.20),
            },
            force_law: sliding::AnyForceLaw::TransferredCharge,
            sticking: sliding::StickCharge::Frozen,
            lateral_force: sliding::AnyLateralForce::None,
        },
    }
}

pub(crate) fn slide<S: Scalar>() -> Slide<S> {
    sliding_parameters().build().expect("in bounds")
}

/// 50 × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A against an aluminium rod of 20 × 2 × 2 mm, 10 µm from its
/// tip, into 1 MΩ.
pub(crate) fn bump_parameters<S: Scalar>() -> bump_stop::Parameters<S, bump_stop::AnyChoices<S>> {
    bump_parameters_into(bump_stop::Resistive(AnyLoad { resistance: S::from_f64(1e6) }))
}

/// The same into any load.
pub(crate) fn bump_parameters_into<S: Scalar, L>(
    load: L,
) -> bump_stop::Parameters<S, bump_stop::AnyChoices<S, L>> {
    let number = S::from_f64;
    bump_stop::Parameters {
        beam_length: number(0.05),
        beam_width: number(0.01),
        substrate: Layer { thickness: number(5e-4), young_modulus: number(200e9), density: number(7850.0) },
        piezo: Layer { thickness: number(5e-4), young_modulus: number(66e9), density: number(7800.0) },
        piezo_d31: number(-190e-12),
        piezo_permittivity: number(15.93e-9),
        damping_ratio: number(0.01),
        choices: bump_stop::Choices {
            load,
            stop: bump_stop::Stop {
                length: number(0.02),
                section: number(4e-6),
                young_modulus: number(70e9),
                density: number(2700.0),
                position: number(0.05),
                gap: number(10e-6),
                contact_compliance: S::ZERO,
                contact: bump_stop::AnyContact::ResidualFlexibility,
            },
            coupling: bump_stop::AnyCoupling::TwoWay,
            tip_mass: None,
            transducer: None,
        },
    }
}

/// With steps of 9 µs near contact and 80 µs in flight.
pub(crate) fn bump<S: Scalar, const B: usize, const R: usize>(
    contact: bump_stop::AnyContact<S>,
) -> Bump<S, B, R> {
    let mut parameters = bump_parameters();
    parameters.choices.stop.contact = contact;
    let scene = parameters.build().expect("in bounds");
    bump_stop::Stepper::new(scene, S::from_f64(9e-6), S::from_f64(80e-6)).expect("in bounds")
}

/// `amplitude · sin(2π · frequency · n / rate)` for each sample `n`, rounded once.
pub(crate) fn sine_samples<S: Scalar>(amplitude: f64, frequency: f64, rate: f64, count: u32) -> Vec<S> {
    let sample =
        |n: u32| S::from_f64(amplitude * (core::f64::consts::TAU * frequency * f64::from(n) / rate).sin());
    (0..count).map(sample).collect()
}
