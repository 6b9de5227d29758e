//! Limits of the reference's own parts; the limits of the harvester are in the tests across crates.

use std::f64::consts::{PI, TAU};

use super::super::physics::Physics;
use super::*;
use crate::triboelectric::Stick;
use crate::triboelectric::tests::{draws, ledgers_close_with_storage};
use harvester_scene::base_motion::Base;
use harvester_scene::scene_file::Lockout;

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

/// A turning point a hair below the dielectric is an impact, a hair above it is none, both inside one
/// step of the integrator.
#[test]
fn a_graze_is_found_and_a_near_miss_is_none() {
    for (depth, impacts) in [(1e-9, 1), (-1e-9, 0)] {
        let reach = 3e-3 * (1.0 + depth);
        let start = TriboelectricStart { velocity_m_per_s: Some(-natural() * reach), ..Default::default() };
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
        run(&scene(mechanical(coefficient), TriboelectricStart::default(), 1e8, constant, [0.0, 0.1]));
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

/// A dip of the contact force far shorter than the excitation's period.
#[test]
fn a_short_dip_of_the_contact_force_releases() {
    let parameters = table_2(0.0, ForceLaw::GapField);
    let start = TriboelectricStart { position_m: Some(0.0), ..Default::default() };
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

#[test]
fn band_of_impacts_begins_where_it_was_found() {
    // 300 periods from rest; the last 100 without or with impacts.
    for (frequency, resistance, impacts) in
        [(18.83, 1e8, false), (18.84, 1e8, true), (18.96, 1e6, false), (18.97, 1e6, true)]
    {
        let mut scene = shipped(resistance);
        scene.excitation = sine(0.2 * GRAVITY, frequency);
        scene.run = RunSpan { settle_s: 200.0 / frequency, duration_s: 300.0 / frequency };
        let outcome = run(&scene);
        assert_eq!(particular(&outcome).impacts > 0, impacts, "{frequency} Hz, {resistance} ohm");
    }
}

#[test]
fn tightening_the_tolerance_changes_nothing_that_counts() {
    for resistance in [1e6, 1e8] {
        let scene = shipped(resistance);
        let usual = run(&scene);
        let tight = ReferenceOptions { tolerance: 1e-13, ..ReferenceOptions::default() };
        let tight = crate::run(&scene, &tight).expect("the reference gets to the end");
        close(usual.mean_power_w, tight.mean_power_w.expect("a number"), 1e-9);
        close(usual.peak_voltage_v, tight.peak_voltage_v.expect("a number"), 1e-9);
        let first = particular(&tight).first_impact_s.expect("an impact");
        close(particular(&usual).first_impact_s, first, 1e-10);
        assert!(usual.energy_residual.expect("a number") < 5e-10);
    }
}

/// Every law and every draw, with impacts and sticks.
#[test]
fn the_ledgers_close_with_a_storage() {
    for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
        let draws = draws(Lockout { turn_on_v: 1.0, turn_off_v: 0.9 });
        for (index, draw) in draws.into_iter().enumerate() {
            let stick_charge = if index % 2 == 0 { StickCharge::Frozen } else { StickCharge::Relaxing };
            let restitution = Restitution::Constant { coefficient: 0.3 };
            let parameters =
                ContactSeparationParameters { stick_charge, restitution, ..table_2(50e-6, force_law) };
            let start = TriboelectricStart { position_m: Some(6.5e-3), ..Default::default() };
            let scene = scene(parameters, start, 0.0, sine(0.3 * GRAVITY, 15.0), [0.0, 0.5]);
            let outcome = ledgers_close_with_storage(scene, [1.1, 0.3], draw);
            let storage = outcome.store.expect("there is a storage");
            let voltage = number(storage.store_voltage_v);
            close(storage.stored_energy_j, 0.5 * 2e-7 * voltage * voltage, 1e-12);
            assert!(particular(&outcome).impacts > 0);
        }
    }
}
