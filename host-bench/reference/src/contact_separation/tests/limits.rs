//! Closed-form limits.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::super::physics::Physics;
use super::*;
use crate::triboelectric::Stick;
use harvester_scene::base_motion::Base;
use harvester_scene::scene_file::Trace;

/// Natural frequency of Table 2 in rad/s.
fn natural() -> f64 {
    (80.0f64 / 5e-3).sqrt()
}

/// No charge, no damping, a rebound by the constant `coefficient`.
fn mechanical(coefficient: f64) -> ContactSeparationParameters {
    ContactSeparationParameters {
        damping_ratio: 0.0,
        restitution: Restitution::Constant { coefficient },
        ..table_2(0.0, ForceLaw::TransferredCharge)
    }
}

#[test]
fn without_charge_or_impact_the_oscillator_is_linear() {
    let (amplitude, omega) = (0.1 * GRAVITY, TAU * 15.0);
    let parameters = table_2(0.0, ForceLaw::TransferredCharge);
    let outcome =
        run(&scene(parameters, ContactSeparationStart::default(), 1e8, sine(amplitude, 15.0), [40.0, 41.0]));
    let (detuning, damping) = (natural().powi(2) - omega * omega, 2.0 * 0.005 * natural() * omega);
    let expected = amplitude / detuning.hypot(damping);
    let found = particular(&outcome);
    close(found.peak_gap_m.map(|gap| gap - 3e-3), expected, 1e-9);
    close(found.min_gap_m.map(|gap| 3e-3 - gap), expected, 1e-9);
    assert_eq!((found.impacts, found.max_impact_speed_m_per_s, found.first_impact_s), (0, None, None));
    assert_eq!(outcome.mean_power_w, Some(0.0));
}

/// At a gap that does not move, the capacitances discharge through the load: all their energy arrives.
#[test]
fn a_fixed_gap_discharges_into_the_load() {
    let parameters = ContactSeparationParameters {
        mass_kg: 1e3,
        stiffness_n_per_m: 1e9,
        ..table_2(50e-6, ForceLaw::GapField)
    };
    let permittivity_area = VACUUM_PERMITTIVITY * 4e-4;
    let capacitance = permittivity_area / (3e-3 + 25e-6);
    let total = capacitance + 1e-12;
    let voltage = 100.0;
    let charge = 50e-6 * 4e-4 * 3e-3 / (3e-3 + 25e-6) - capacitance * voltage;
    let start = ContactSeparationStart { charge_c: Some(charge), ..Default::default() };
    let tau = 1e8 * total;
    // The force of the charge that is left would shake the mass; what matters is over long before.
    let outcome = run(&scene(parameters, start, 1e8, Excitation::Silence, [0.0, 30.0 * tau]));
    close(outcome.delivered_energy_j, 0.5 * total * voltage * voltage, 1e-6);
    close(outcome.mean_voltage_v, voltage * tau / (30.0 * tau), 1e-6);
    close(outcome.peak_voltage_v, voltage, 1e-9);
}

#[test]
fn a_short_circuit_carries_the_charge_of_its_gap() {
    let mut scene = shipped(0.0);
    scene.run = RunSpan { settle_s: 0.0, duration_s: 0.8 };
    let options = ReferenceOptions { record_every: Some(1e-3), ..ReferenceOptions::default() };
    let outcome = crate::run(&scene, &options).expect("the reference gets to the end");
    assert_eq!(outcome.mean_power_w, Some(0.0));
    let recording = outcome.trace.expect("a recording");
    assert_eq!(recording.rows.len(), 801);
    for row in recording.rows {
        let (gap, charge) = (row[1], row[3]);
        assert!((charge - 50e-6 * 4e-4 * gap / (gap + 25e-6)).abs() < 1e-20);
    }
}

#[test]
fn power_of_a_small_load_is_proportional_to_it_and_of_a_large_one_to_its_inverse() {
    let power = |resistance: f64| run(&shipped(resistance)).mean_power_w.expect("a number");
    // Through the change from the dynamic to the quasi-static circuit.
    close(Some(power(1e-9) / 1e-9), power(1e-3) / 1e-3, 1e-7);
    close(Some(power(1e20) * 1e20), power(1e30) * 1e30, 1e-7);
}

#[test]
fn an_open_circuit_is_the_limit_of_a_large_load() {
    let (open, large) = (run(&shipped(f64::INFINITY)), run(&shipped(1e30)));
    close(open.rms_voltage_v, large.rms_voltage_v.expect("a number"), 1e-8);
    close(particular(&open).peak_gap_m, particular(&large).peak_gap_m.expect("a number"), 1e-9);
    assert_eq!((open.mean_power_w, open.delivered_energy_j), (Some(0.0), Some(0.0)));
}

#[test]
fn an_undamped_bounce_returns_after_its_closed_form_time() {
    let (speed, coefficient) = (0.1, 0.5);
    let hop = |speed: f64| (PI + 2.0 * 3e-3f64.atan2(speed / natural())) / natural();
    let first = hop(speed);
    let second = first + hop(coefficient * speed);
    let start =
        ContactSeparationStart { gap_m: Some(0.0), velocity_m_per_s: Some(speed), ..Default::default() };
    // The window holds the second impact only.
    let span = [second - 1e-6, second + 1e-6];
    let outcome = run(&scene(mechanical(coefficient), start, 1e8, Excitation::Silence, span));
    let found = particular(&outcome);
    close(found.first_impact_s, first, 2e-10);
    // The energy is that of a speed eight times as high: its error counts sixty times here.
    close(found.max_impact_speed_m_per_s, coefficient * speed, 2e-8);
    assert_eq!((found.impacts, outcome.events), (1, 2));
    assert_eq!(found.impacts_per_period, None);
}

/// A turning point a hair below the dielectric is an impact, a hair above it is none, both inside one
/// step of the integrator.
#[test]
fn a_graze_is_found_and_a_near_miss_is_none() {
    for (depth, impacts) in [(1e-9, 1), (-1e-9, 0)] {
        let reach = 3e-3 * (1.0 + depth);
        let start =
            ContactSeparationStart { velocity_m_per_s: Some(-natural() * reach), ..Default::default() };
        let quarter = 0.25 * TAU / natural();
        let outcome = run(&scene(mechanical(0.5), start, 1e8, Excitation::Silence, [0.0, quarter + 1e-4]));
        let found = particular(&outcome);
        assert_eq!(found.impacts, impacts, "{depth}");
        if impacts > 0 {
            let speed = natural() * reach * (1.0 - (1.0 / (1.0 + depth)).powi(2)).sqrt();
            // The depth is three picometres: the speed tells it from the tolerance on the gap.
            close(found.max_impact_speed_m_per_s, speed, 1e-2);
        } else {
            let clearance = found.min_gap_m.expect("a number");
            assert!((clearance - 3e-12).abs() < 1e-13, "{clearance}");
        }
    }
}

/// The mass bounces ever faster under a constant push, and comes to rest after finitely many impacts.
#[test]
fn a_bounce_under_a_push_ends_in_rest() {
    let push = 1000.0;
    let constant =
        Excitation::Sine(Tone { amplitude_m_per_s2: push, frequency_hz: 0.0, phase_rad: 0.5 * PI });
    let coefficient = 0.5f64;
    let outcome =
        run(&scene(mechanical(coefficient), ContactSeparationStart::default(), 1e8, constant, [0.0, 0.1]));
    let found = particular(&outcome);
    let speed = (2.0 * push * 3e-3f64).sqrt();
    // Soft spring: it changes the speed by 2 % at most.
    close(found.max_impact_speed_m_per_s, speed, 0.03);
    let threshold = 1e-4 * natural() * 3e-3;
    let rebounds = (threshold / found.max_impact_speed_m_per_s.expect("a number")).log(coefficient);
    assert_eq!(found.impacts, rebounds.ceil() as u64);
    // Fall, and the geometric series of hops.
    let fall = speed / push;
    let series = 2.0 * fall * coefficient / (1.0 - coefficient);
    close(found.stuck_fraction, 1.0 - (fall + series) / 0.1, 0.02);
    assert!(outcome.energy_residual.expect("a number") < 1e-9);
}

#[test]
fn rests_at_the_static_equilibrium() {
    for (charge_density, gap) in [
        (5e-6, 2.99798e-3),
        (20e-6, 2.96737e-3),
        (35e-6, 2.89795e-3),
        (50e-6, 2.78438e-3),
        (80e-6, 2.37028e-3),
    ] {
        let parameters = ContactSeparationParameters {
            damping_ratio: 0.3,
            ..table_2(charge_density, ForceLaw::TransferredCharge)
        };
        let span = [1.9, 2.0];
        let outcome =
            run(&scene(parameters, ContactSeparationStart::default(), 1e6, Excitation::Silence, span));
        let found = particular(&outcome);
        close(found.peak_gap_m, gap, 2e-6);
        close(found.min_gap_m, gap, 2e-6);
    }
}

/// Under the gap field a mass at closed gap stays for ever above 103.08 µC/m²; under the transferred
/// charge, zero at closed gap, it is always released.
#[test]
fn adheres_above_the_threshold_charge() {
    let start = ContactSeparationStart { gap_m: Some(0.0), ..Default::default() };
    for (force_law, charge_density, stuck) in [
        (ForceLaw::GapField, 103.07e-6, false),
        (ForceLaw::GapField, 103.09e-6, true),
        (ForceLaw::TransferredCharge, 103.09e-6, false),
    ] {
        let parameters = table_2(charge_density, force_law);
        let outcome = run(&scene(parameters, start, 1e8, Excitation::Silence, [0.0, 0.05]));
        let found = particular(&outcome);
        assert_eq!(found.stuck_fraction, Some(f64::from(u8::from(stuck))));
        assert_eq!(found.peak_gap_m > Some(1e-3), !stuck);
        // Nothing moves, but the field in the dielectric has energy: the ratio exists.
        assert!(outcome.energy_residual.expect("a number") < 1e-9);
    }
}

#[test]
fn a_sticking_mass_leaves_when_the_base_stops_pressing() {
    let parameters = table_2(0.0, ForceLaw::GapField);
    let start = ContactSeparationStart { gap_m: Some(0.0), ..Default::default() };
    let (physics, motion) = Physics::new(&parameters, Load::Resistor { resistance_ohm: 1e8 }, &start);
    // m A sin(2π f t) falls to k d0 on its way down.
    let (amplitude, frequency) = (100.0, 6.0);
    let excitation = Excitation::Sine(Tone {
        amplitude_m_per_s2: amplitude,
        frequency_hz: frequency,
        phase_rad: 0.5 * PI,
    });
    let base = Base(&excitation).from(0.0);
    let stick = Stick { harvester: &physics, base: &base, start: motion };
    let expected = (80.0f64 * 3e-3 / (5e-3 * amplitude)).acos() / (TAU * frequency);
    close(stick.release(1.0), expected, 1e-12);
    assert_eq!(stick.release(0.9 * expected), None);
}

/// A dip of the contact force far shorter than the excitation's period.
#[test]
fn a_short_dip_of_the_contact_force_releases() {
    let parameters = table_2(0.0, ForceLaw::GapField);
    let start = ContactSeparationStart { gap_m: Some(0.0), ..Default::default() };
    let (physics, motion) = Physics::new(&parameters, Load::Resistor { resistance_ohm: 1e8 }, &start);
    let weight = 80.0 * 3e-3 / 5e-3;
    for (depth, released) in [(1e-7, true), (-1e-7, false)] {
        // The lowest acceleration is just below or above what presses no more.
        let tone = |amplitude, frequency_hz, phase_rad| Tone {
            amplitude_m_per_s2: amplitude,
            frequency_hz,
            phase_rad,
        };
        let push = weight + 10.0 - depth;
        let excitation = Excitation::Sines(vec![tone(push, 0.0, 0.5 * PI), tone(10.0, 7.0, 0.3)]);
        let base = Base(&excitation).from(0.0);
        let stick = Stick { harvester: &physics, base: &base, start: motion };
        assert_eq!(stick.release(1.0 / 7.0).is_some(), released, "{depth}");
    }
}

/// A trace of a sine, finely sampled, does what the sine does.
#[test]
fn a_sampled_sine_is_nearly_the_sine() {
    let mut smooth = shipped(1e8);
    smooth.run = RunSpan { settle_s: 0.5, duration_s: 1.0 };
    let mut sampled = smooth.clone();
    let rate = 4000.0;
    let samples: Arc<[f64]> =
        (0..200).map(|index| 0.2 * GRAVITY * (TAU * 20.0 * f64::from(index) / rate).sin()).collect();
    sampled.excitation = Excitation::File(Trace { samples_m_per_s2: samples, rate_hz: rate, repeat: true });
    let (smooth, sampled) = (run(&smooth), run(&sampled));
    // Straight lines between samples take (2π · 20 / 4000)² / 12 off the amplitude.
    close(sampled.mean_power_w, smooth.mean_power_w.expect("a number"), 2e-3);
    close(particular(&sampled).first_impact_s, particular(&smooth).first_impact_s.expect("one"), 2e-3);
    assert_eq!(particular(&sampled).impacts_per_period, None);
    assert!(sampled.energy_residual.expect("a number") < 1e-9);
}
