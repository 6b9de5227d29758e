//! Closed-form limits, and what tightening the tolerance changes.

use crate::ReferenceOptions;
use crate::test_support::{close, sliding};
use crate::triboelectric::VACUUM_PERMITTIVITY;
use crate::triboelectric::tests::{run, with_resistor};
use harvester_scene::outcome::{Outcome, SlidingOutcome};
use harvester_scene::scene_file::modes::Cantilever;
use harvester_scene::scene_file::{
    Excitation, ForceLaw, GRAVITY, Load, Scene, Sliding, SlidingParameters, StickCharge, Tone,
    TriboelectricStart,
};

mod ledgers;
mod limits;
mod sticking;

/// Natural frequency of Table 1 in Hz.
const NATURAL: f64 = 18.373_129_8;

/// Table 1 of the paper with another charge and force law.
pub(super) fn table_1(charge_density: f64, force_law: ForceLaw) -> SlidingParameters {
    SlidingParameters { charge_density_c_per_m2: charge_density, force_law, ..sliding() }
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
    Excitation::Sine(Tone { amplitude_m_per_s2: gravities * GRAVITY, frequency_hz, phase_rad: 0.0 })
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
    scene(parameters, TriboelectricStart::default(), resistance_ohm, sine(gravities, frequency), span)
}

/// A scene with the given parts.
fn scene(
    parameters: SlidingParameters,
    initial: TriboelectricStart,
    resistance_ohm: f64,
    excitation: Excitation,
    span: [f64; 2],
) -> Scene {
    with_resistor(Sliding { parameters, initial }.into(), resistance_ohm, excitation, span)
}

fn particular(outcome: &Outcome) -> &SlidingOutcome {
    outcome.sliding().expect("a sliding run")
}
