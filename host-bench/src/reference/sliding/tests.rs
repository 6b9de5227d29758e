//! Published values, closed-form limits, and what tightening the tolerance changes.

mod ledgers;
mod limits;
mod published;
mod sticking;
mod store;

use crate::outcome::{Outcome, SlidingOutcome};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{
    Excitation, ForceLaw, Load, Model, RunSpan, Scene, Sliding, SlidingParameters, SlidingStart, StickCharge,
    Tone,
};

/// Natural frequency of Table 1 in Hz.
const NATURAL: f64 = 18.373_129_8;

/// Table 1 of the paper as completed by our choices.
pub(super) fn table_1(charge_density: f64, force_law: ForceLaw) -> SlidingParameters {
    SlidingParameters {
        beam_length_m: 0.1,
        beam_width_m: 20e-3,
        beam_thickness_m: 0.5e-3,
        young_modulus_pa: 210e9,
        density_kg_per_m3: 7800.0,
        damping_ratio: 0.0035,
        slider_mass_kg: 8e-3,
        patch_radius_m: 10e-3,
        static_friction_active: 0.35,
        static_friction_inert: 0.25,
        kinetic_friction_active: 0.30,
        kinetic_friction_inert: 0.20,
        dielectric_thickness_m: 0.05e-3,
        relative_permittivity: 2.0,
        charge_density_c_per_m2: charge_density,
        force_law,
        stick_charge: StickCharge::Frozen,
        lateral_force: false,
    }
}

/// Table 1 with the same friction everywhere.
fn rubbing(charge_density: f64, friction: f64) -> SlidingParameters {
    SlidingParameters {
        static_friction_active: friction,
        static_friction_inert: friction,
        kinetic_friction_active: friction,
        kinetic_friction_inert: friction,
        ..table_1(charge_density, ForceLaw::TransferredCharge)
    }
}

/// Amplitude in g.
fn sine(gravities: f64, frequency_hz: f64) -> Excitation {
    Excitation::Sine(Tone { amplitude_m_per_s2: gravities * 9.81, frequency_hz, phase_rad: 0.0 })
}

/// A run from rest, of so many periods of the frequency, measured over the last of them.
fn shaken(
    parameters: SlidingParameters,
    resistance_ohm: f64,
    gravities: f64,
    frequency: f64,
    [settle, end]: [f64; 2],
) -> Scene {
    let span = [settle / frequency, end / frequency];
    scene(parameters, SlidingStart::default(), resistance_ohm, sine(gravities, frequency), span)
}

/// A scene with the given parts.
fn scene(
    parameters: SlidingParameters,
    initial: SlidingStart,
    resistance_ohm: f64,
    excitation: Excitation,
    [settle_s, duration_s]: [f64; 2],
) -> Scene {
    Scene {
        file: "test".into(),
        model: Model::Sliding(Sliding { parameters, initial }),
        load: Load::Resistor { resistance_ohm },
        excitation,
        run: RunSpan { duration_s, settle_s },
    }
}

fn run(scene: &Scene) -> Outcome {
    reference::run(scene, &ReferenceOptions::default()).expect("the reference gets to the end")
}

fn particular(outcome: &Outcome) -> &SlidingOutcome {
    outcome.sliding().expect("a sliding run")
}

/// Asserts that a number is there and within `relative` of what is expected.
#[track_caller]
fn close(actual: Option<f64>, expected: f64, relative: f64) {
    let actual = actual.expect("a number");
    let error = (actual - expected).abs();
    assert!(error <= relative * expected.abs(), "{actual} is not {expected}: off by {:e}", error / expected);
}
