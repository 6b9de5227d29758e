//! Limits of the reference's own parts; the limits of the harvester are in the tests across crates.

use super::super::REACH;
use super::super::physics::Physics;
use super::*;

fn short(resistance: f64) -> Scene {
    shaken(table_1(80e-6, ForceLaw::TransferredCharge), resistance, 0.36, 18.373, [5.0, 10.0])
}

/// `V → R σ sgn(x) √(4r² − x²) x'` with a small load; 1e3 Ω lag by a hundred-thousandth of a radian.
#[test]
fn a_small_load_sees_the_current_of_the_short_circuit() {
    let options = ReferenceOptions { record_every: Some(1e-3), ..ReferenceOptions::default() };
    let outcome = crate::run(&short(1e3), &options).expect("the reference gets to the end");
    let peak = outcome.peak_voltage_v.expect("a number");
    let rows = outcome.trace.expect("a recording").rows;
    for row in rows.iter().filter(|row| row[6] == 0.0 && row[1].abs() > 1e-5) {
        let chord = (4e-4 - row[1] * row[1]).sqrt();
        let expected = 1e3 * 80e-6 * row[1].signum() * chord * row[2];
        assert!((row[4] - expected).abs() < 2e-4 * peak, "{row:?} {expected}");
    }
}

#[test]
fn power_of_a_small_load_is_proportional_to_it_and_of_a_large_one_to_its_inverse() {
    let power = |resistance: f64| run(&short(resistance)).mean_power_w.expect("a number");
    // Through the change from the dynamic to the quasi-static circuit.
    close(Some(power(1e-7) / 1e-7), power(1e-3) / 1e-3, 1e-7);
    close(Some(power(1e20) * 1e20), power(1e30) * 1e30, 1e-7);
}

/// The overlap is the same on both sides of the middle.
#[test]
fn a_mirrored_motion_gives_the_same_voltage() {
    let mirrored = |sign: f64| {
        let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
        let start = TriboelectricStart {
            position_m: Some(sign * 6e-3),
            velocity_m_per_s: Some(sign * 0.3),
            charge_c: Some(1e-9),
        };
        let tone = Tone { amplitude_m_per_s2: sign * 3.0, frequency_hz: 6.0, phase_rad: 0.4 };
        run(&scene(parameters, start, 1e8, Excitation::Sine(tone), [0.0, 1.5]))
    };
    let (one, other) = (mirrored(1.0), mirrored(-1.0));
    close(one.rms_voltage_v, other.rms_voltage_v.expect("a number"), 1e-10);
    close(one.mean_voltage_v, other.mean_voltage_v.expect("a number"), 1e-10);
    let (one, other) = (particular(&one), particular(&other));
    close(one.peak_displacement_m, other.peak_displacement_m.expect("a number"), 1e-11);
    assert_eq!(one.stick_fraction.map(|part| part > 0.0), Some(true));
}

/// A free swing that reaches two patch radii: the overlap ends there, and so does the run.
#[test]
fn a_slider_that_leaves_the_patch_is_an_error_with_its_time() {
    let omega = Cantilever::new(&table_1(0.0, ForceLaw::TransferredCharge)).angular_frequency;
    for sign in [1.0, -1.0] {
        let parameters = SlidingParameters { damping_ratio: 0.0, ..rubbing(0.0, 0.0) };
        let start = TriboelectricStart { velocity_m_per_s: Some(sign * 25e-3 * omega), ..Default::default() };
        let swing = scene(parameters, start, 1e8, Excitation::Silence, [0.0, 1.0]);
        let failure = crate::run(&swing, &ReferenceOptions::default()).expect_err("it leaves");
        close(Some(failure.time_s), (0.8 * REACH).asin() / omega, 1e-9);
        assert!(failure.reason.contains("displacement") && failure.reason.contains("two patch radii"));
        let (physics, _) = Physics::new(&parameters, Load::Resistor { resistance_ohm: 1e8 }, &start);
        assert!(failure.reason.contains(&format!("{:e} m (two", 2.0 * physics.radius)), "{failure}");
    }
}

#[test]
fn tightening_the_tolerance_changes_nothing_that_counts() {
    for resistance in [1e6, 1e8] {
        let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
        let scene = shaken(parameters, resistance, 0.3, 10.0, [5.0, 10.0]);
        let usual = run(&scene);
        let tight = ReferenceOptions { tolerance: 1e-13, ..ReferenceOptions::default() };
        let tight = crate::run(&scene, &tight).expect("the reference gets to the end");
        close(usual.mean_power_w, tight.mean_power_w.expect("a number"), 1e-9);
        close(usual.peak_voltage_v, tight.peak_voltage_v.expect("a number"), 1e-9);
        let (usual, tight) = (particular(&usual), particular(&tight));
        close(usual.amplitude_m, tight.amplitude_m.expect("a number"), 1e-9);
        close(usual.stick_fraction, tight.stick_fraction.expect("a number"), 1e-8);
    }
}
