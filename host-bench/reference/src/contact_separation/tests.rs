//! Closed-form limits, and what tightening the tolerance changes.

use crate::ReferenceOptions;
use crate::test_support::{close, contact_separation, number};
use crate::triboelectric::tests::{run, with_resistor};
use harvester_scene::outcome::{ContactSeparationOutcome, Outcome};
use harvester_scene::scene_file::{
    ContactSeparation, ContactSeparationParameters, Excitation, ForceLaw, GRAVITY, Load, Model, Restitution,
    RunSpan, Scene, StickCharge, Tone, TriboelectricStart,
};

mod limits;

/// Table 2 of the paper with another charge and force law.
pub(super) fn table_2(charge_density: f64, force_law: ForceLaw) -> ContactSeparationParameters {
    ContactSeparationParameters { charge_density_c_per_m2: charge_density, force_law, ..contact_separation() }
}

/// `amplitude` in m/s².
fn sine(amplitude: f64, frequency_hz: f64) -> Excitation {
    Excitation::Sine(Tone { amplitude_m_per_s2: amplitude, frequency_hz, phase_rad: 0.0 })
}

/// A scene with the given parts.
fn scene(
    parameters: ContactSeparationParameters,
    initial: TriboelectricStart,
    resistance_ohm: f64,
    excitation: Excitation,
    span: [f64; 2],
) -> Scene {
    with_resistor(
        Model::ContactSeparation(ContactSeparation { parameters, initial }),
        resistance_ohm,
        excitation,
        span,
    )
}

/// The shipped scene: 50 µC/m², 0.2 g, 20 Hz, 15 s settled 10 s.
fn shipped(resistance_ohm: f64) -> Scene {
    let parameters = table_2(50e-6, ForceLaw::TransferredCharge);
    scene(parameters, TriboelectricStart::default(), resistance_ohm, sine(0.2 * GRAVITY, 20.0), [10.0, 15.0])
}

fn particular(outcome: &Outcome) -> &ContactSeparationOutcome {
    outcome.contact_separation().expect("a contact-separation run")
}
