//! The duration of stick, and the charge in it.

use std::f64::consts::{PI, TAU};

use super::super::physics::Physics;
use super::*;
use crate::triboelectric::{Harvester, Stick};
use harvester_scene::base_motion::Base;

/// Static friction of weight alone in the middle over what the base pushes per acceleration, in m/s².
fn threshold() -> f64 {
    let parameters = table_1(0.0, ForceLaw::TransferredCharge);
    let beam = Cantilever::new(&parameters);
    0.35 * 8e-3 * GRAVITY / (beam.participation * beam.modal_mass)
}

fn release(
    parameters: &SlidingParameters,
    start: &TriboelectricStart,
    excitation: &Excitation,
    span: f64,
) -> Option<f64> {
    let (physics, motion) = Physics::new(parameters, Load::Resistor { resistance_ohm: 1e8 }, start);
    let base = Base(excitation).from(0.0);
    Stick { harvester: &physics, base: &base, start: motion }.release(span)
}

/// With frozen charge `sin(2π f t) = (±F / M − ω² x) / (κ A)`.
#[test]
fn a_sticking_slider_is_released_at_its_closed_form_time() {
    let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
    let beam = Cantilever::new(&parameters);
    let charge = 1.5e-9;
    for displacement in [1e-4, -1e-4] {
        let start = TriboelectricStart {
            position_m: Some(displacement),
            charge_c: Some(charge),
            ..TriboelectricStart::default()
        };
        let excitation = sine(0.4, 6.0);
        let away: f64 = displacement / 20e-3;
        let root = (1.0 - away * away).sqrt();
        let active = 2.0 / PI * (away.abs().acos() - away.abs() * root);
        let area = VACUUM_PERMITTIVITY * 2.0 * PI * 1e-4 * active;
        let normal = 8e-3 * GRAVITY + charge * charge / (2.0 * area);
        let holding = (0.35 * active + 0.25 * (1.0 - active)) * normal;
        let spring = beam.angular_frequency.powi(2) * displacement;
        let sine = (holding / beam.modal_mass - spring) / (beam.participation * 0.4 * GRAVITY);
        let expected = sine.asin() / (TAU * 6.0);
        close(release(&parameters, &start, &excitation, 1.0), expected, 1e-12);
        assert_eq!(release(&parameters, &start, &excitation, 0.9 * expected), None);
    }
}

/// A peak of the push far shorter than the excitation's period, found or rightly not.
#[test]
fn a_short_peak_of_the_push_releases() {
    let parameters = table_1(0.0, ForceLaw::TransferredCharge);
    for (excess, released) in [(1e-7, true), (-1e-7, false)] {
        let push = threshold() * (1.0 + excess);
        let tone = |amplitude_m_per_s2, frequency_hz, phase_rad| Tone {
            amplitude_m_per_s2,
            frequency_hz,
            phase_rad,
        };
        let excitation = Excitation::Sines(vec![tone(push - 2.0, 0.0, 0.5 * PI), tone(2.0, 7.0, 0.3)]);
        let found = release(&parameters, &TriboelectricStart::default(), &excitation, 1.0 / 7.0);
        assert_eq!(found.is_some(), released, "{excess}");
    }
}

/// The charge presses the slider on the patch: as it relaxes the slider is released, at the instant that
/// `μ (m g + q² / (2 ε S1)) = M ω² x` says for `q = q∞ + (q0 − q∞) exp(−t / RC)`.
#[test]
fn a_relaxing_charge_lets_go() {
    let parameters = SlidingParameters {
        static_friction_active: 1.0,
        static_friction_inert: 1.0,
        stick_charge: StickCharge::Relaxing,
        ..table_1(80e-6, ForceLaw::TransferredCharge)
    };
    let start = TriboelectricStart { position_m: Some(1e-3), charge_c: Some(4e-8), ..Default::default() };
    let beam = Cantilever::new(&parameters);
    let root = (1.0 - 0.0025f64).sqrt();
    let active = 2.0 / PI * (0.05f64.acos() - 0.05 * root);
    let area = VACUUM_PERMITTIVITY * 2.0 * PI * 1e-4 * active;
    let spring = beam.modal_mass * beam.angular_frequency.powi(2) * 1e-3;
    let charge = (2.0 * area * (spring - 8e-3 * GRAVITY)).sqrt();
    let relaxed = 80e-6 * PI * 1e-4 * (1.0 - active);
    let expected = ((4e-8 - relaxed) / (charge - relaxed)).ln() * 1e8 * area / 0.05e-3;
    close(release(&parameters, &start, &Excitation::Silence, 1.0), expected, 1e-11);
}

/// A slider with friction on the inert patch only does not stick in the middle.
#[test]
fn it_starts_without_friction_in_the_middle() {
    let parameters = SlidingParameters {
        static_friction_active: 0.0,
        kinetic_friction_active: 0.0,
        ..table_1(0.0, ForceLaw::TransferredCharge)
    };
    let options = ReferenceOptions { record_every: Some(1e-3), ..ReferenceOptions::default() };
    let outcome = crate::run(&shaken(parameters, 1e8, 0.1, 10.0, [0.0, 0.1]), &options);
    let rows = outcome.expect("the reference gets to the end").trace.expect("a recording").rows;
    let last = rows.last().expect("a row");
    // Shorter than what spring and friction need: x = −κ A Ω t³ / 6.
    let beam = Cantilever::new(&parameters);
    let expected = -beam.participation * 0.981 * TAU * 10.0 * last[0].powi(3) / 6.0;
    assert!((last[1] / expected - 1.0).abs() < 0.15, "{last:?} {expected}");
}

/// A slider at rest slips in the direction of its spring where static friction is too small.
#[test]
fn a_slider_let_go_is_pulled_by_its_spring() {
    let parameters = table_1(0.0, ForceLaw::TransferredCharge);
    for displacement in [3e-3, -3e-3] {
        let start = TriboelectricStart { position_m: Some(displacement), ..Default::default() };
        let (physics, motion) = Physics::new(&parameters, Load::Resistor { resistance_ohm: 1e8 }, &start);
        assert_eq!(motion.branch.side, displacement.signum());
        // The static friction is too small.
        assert!(physics.reserve(&motion, 0.0) < 0.0);
        let outcome = run(&scene(parameters, start, 1e8, Excitation::Silence, [0.0, 1.0]));
        let found = particular(&outcome);
        // It swings to the other side and ends in stick.
        assert!(found.amplitude_m > Some(2e-3) && found.stick_fraction > Some(0.3), "{found:?}");
        close(found.peak_displacement_m, 3e-3, 1e-15);
        assert!(outcome.energy_residual.expect("a number") < 1e-9);
    }
}
