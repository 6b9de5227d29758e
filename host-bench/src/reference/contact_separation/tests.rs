//! Spec values, closed-form limits, and what tightening the tolerance changes.

mod limits;
mod published;
mod store;

use crate::outcome::{ContactSeparationOutcome, Outcome};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{
    ContactSeparation, ContactSeparationParameters, ContactSeparationStart, Excitation, ForceLaw, Load,
    Model, Restitution, RunSpan, Scene, StickCharge, Tone,
};

/// Table 2 of the paper as completed by our choices.
pub(super) fn table_2(charge_density: f64, force_law: ForceLaw) -> ContactSeparationParameters {
    ContactSeparationParameters {
        mass_kg: 5e-3,
        stiffness_n_per_m: 80.0,
        damping_ratio: 0.005,
        initial_gap_m: 3e-3,
        electrode_area_m2: 4e-4,
        dielectric_thickness_m: 0.05e-3,
        relative_permittivity: 2.0,
        charge_density_c_per_m2: charge_density,
        parasitic_capacitance_f: 1e-12,
        force_law,
        stick_charge: StickCharge::Frozen,
        restitution: Restitution::VelocityDependent {
            at_rest: 0.8,
            at_speed: 0.5,
            reference_speed_m_per_s: 0.3,
        },
    }
}

/// `amplitude` in m/s².
fn sine(amplitude: f64, frequency_hz: f64) -> Excitation {
    Excitation::Sine(Tone { amplitude_m_per_s2: amplitude, frequency_hz, phase_rad: 0.0 })
}

/// A scene with the given parts.
fn scene(
    parameters: ContactSeparationParameters,
    initial: ContactSeparationStart,
    resistance_ohm: f64,
    excitation: Excitation,
    [settle_s, duration_s]: [f64; 2],
) -> Scene {
    Scene {
        file: "test".into(),
        model: Model::ContactSeparation(ContactSeparation { parameters, initial }),
        load: Load::Resistor { resistance_ohm },
        excitation,
        run: RunSpan { duration_s, settle_s },
    }
}

/// The shipped scene: 50 µC/m², 0.2 g, 20 Hz, 15 s settled 10 s.
fn shipped(resistance_ohm: f64) -> Scene {
    let parameters = table_2(50e-6, ForceLaw::TransferredCharge);
    scene(parameters, ContactSeparationStart::default(), resistance_ohm, sine(0.2 * 9.81, 20.0), [10.0, 15.0])
}

fn run(scene: &Scene) -> Outcome {
    reference::run(scene, &ReferenceOptions::default()).expect("the reference gets to the end")
}

fn particular(outcome: &Outcome) -> &ContactSeparationOutcome {
    outcome.contact_separation().expect("a contact-separation run")
}

/// Asserts that a number is there and within `relative` of what is expected.
#[track_caller]
fn close(actual: Option<f64>, expected: f64, relative: f64) {
    let actual = actual.expect("a number");
    let error = (actual - expected).abs();
    assert!(error <= relative * expected.abs(), "{actual} is not {expected}: off by {:e}", error / expected);
}
