//! Closed-form limits of a motion that does not stick.

use std::f64::consts::{PI, TAU};

use super::super::REACH;
use super::super::physics::{Overlap, Physics};
use super::*;

/// Angular frequency in rad/s, modal mass in kg and participation of Table 1.
fn mode() -> [f64; 3] {
    let beam = Cantilever::new(&table_1(0.0, ForceLaw::TransferredCharge));
    [beam.angular_frequency, beam.modal_mass, beam.participation]
}

#[test]
fn without_friction_the_beam_is_linear() {
    let parameters = SlidingParameters { damping_ratio: 0.05, ..rubbing(0.0, 0.0) };
    let outcome = run(&shaken(parameters, 1e8, 0.3, 15.0, [75.0, 85.0]));
    let ([omega, _, participation], drive) = (mode(), TAU * 15.0);
    let response = (omega * omega - drive * drive).hypot(2.0 * 0.05 * omega * drive);
    let found = particular(&outcome);
    close(found.amplitude_m, participation * 0.3 * GRAVITY / response, 1e-9);
    close(found.peak_displacement_m, participation * 0.3 * GRAVITY / response, 1e-9);
    assert_eq!((found.stick_fraction, outcome.events), (Some(0.0), 0));
    assert_eq!((outcome.mean_power_w, outcome.peak_voltage_v), (Some(0.0), Some(0.0)));
}

/// Den Hartog (1931): an undamped oscillator under Coulomb friction in steady motion without stops.
#[test]
fn under_coulomb_friction_it_has_den_hartogs_amplitude() {
    let [omega, modal_mass, participation] = mode();
    for frequency in [16.0, 22.0, 25.0] {
        let parameters = SlidingParameters { damping_ratio: 0.0, ..rubbing(0.0, 0.2) };
        let outcome = run(&shaken(parameters, 1e8, 0.36, frequency, [150.0, 155.0]));
        let ratio = TAU * frequency / omega;
        let response = 1.0 / (1.0 - ratio * ratio);
        let damping = (PI / ratio).sin() / (ratio * (1.0 + (PI / ratio).cos()));
        let drive = participation * 0.36 * GRAVITY / (omega * omega);
        let friction = 0.2 * 8e-3 * GRAVITY / (modal_mass * omega * omega);
        let expected = ((drive * response).powi(2) - (friction * damping).powi(2)).sqrt();
        // What is left of the transient.
        close(particular(&outcome).amplitude_m, expected, 1e-6);
    }
}

/// At resonance the work of the base over a cycle, `π κ M A X`, is what damper and friction take from a
/// sinusoidal motion, with the charge of the short circuit: right to the harmonics, 6e-4.
#[test]
fn at_resonance_the_energy_balances() {
    let [omega, modal_mass, participation] = mode();
    let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
    let permittivity_area = VACUUM_PERMITTIVITY * 2.0 * PI * 1e-4;
    let friction = |x: f64| {
        let overlap = Overlap::at(x, 10e-3, 1.0);
        let charge = 80e-6 * PI * 1e-4 * overlap.inert;
        let normal = 8e-3 * GRAVITY + charge * charge / (2.0 * permittivity_area * overlap.active);
        (0.3 * overlap.active + 0.2 * overlap.inert) * normal
    };
    let surplus = |amplitude: f64| {
        let damper = 2.0 * PI * 0.0035 * modal_mass * omega * omega * amplitude * amplitude;
        let count = 1000;
        let middles = (0..count).map(|index| (f64::from(index) + 0.5) / f64::from(count));
        let mean = middles.map(|part| friction(part * amplitude)).sum::<f64>() / f64::from(count);
        PI * participation * modal_mass * 0.36 * GRAVITY * amplitude - damper - 4.0 * mean * amplitude
    };
    let (mut low, mut high) = (1e-3, 19e-3);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if surplus(middle) > 0.0 { low = middle } else { high = middle }
    }
    let outcome = run(&shaken(parameters, 0.0, 0.36, omega / TAU, [220.0, 225.0]));
    close(particular(&outcome).amplitude_m, low, 6e-4);
    // The same by the table of the derivation.
    close(Some(low), 8.860e-3, 1e-4);
}

fn short(resistance: f64) -> Scene {
    shaken(table_1(80e-6, ForceLaw::TransferredCharge), resistance, 0.36, 18.373, [5.0, 10.0])
}

#[test]
fn a_short_circuit_carries_the_charge_of_its_overlap() {
    let options = ReferenceOptions { record_every: Some(1e-3), ..ReferenceOptions::default() };
    let outcome = crate::run(&short(0.0), &options).expect("the reference gets to the end");
    assert_eq!((outcome.mean_power_w, outcome.peak_voltage_v), (Some(0.0), Some(0.0)));
    let recording = outcome.trace.expect("a recording");
    assert_eq!(recording.rows.len(), 545);
    assert!(
        recording.rows.iter().any(|row| row[1] > 1e-3) && recording.rows.iter().any(|row| row[1] < -1e-3)
    );
    for row in recording.rows {
        let side = if row[1] < 0.0 { -1.0 } else { 1.0 };
        let expected = 80e-6 * PI * 1e-4 * Overlap::at(row[1], 10e-3, side).inert;
        assert!((row[3] - expected).abs() < 1e-20);
    }
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

#[test]
fn an_open_circuit_is_the_limit_of_a_large_load() {
    let (open, large) = (run(&short(f64::INFINITY)), run(&short(1e30)));
    close(open.rms_voltage_v, large.rms_voltage_v.expect("a number"), 1e-8);
    close(open.peak_voltage_v, large.peak_voltage_v.expect("a number"), 1e-8);
    close(particular(&open).amplitude_m, particular(&large).amplitude_m.expect("a number"), 1e-9);
    assert_eq!((open.mean_power_w, open.delivered_energy_j), (Some(0.0), Some(0.0)));
}

/// Weak charge does not move the slider, and the voltage is proportional to it; in a periodic motion
/// there is no direct voltage.
#[test]
fn voltage_is_proportional_to_a_weak_charge() {
    let outcome = |charge_density: f64| {
        let parameters = table_1(charge_density, ForceLaw::TransferredCharge);
        run(&shaken(parameters, 1e7, 0.3, 10.0, [20.0, 25.0]))
    };
    let (weak, weaker) = (outcome(1e-9), outcome(1e-10));
    close(weak.rms_voltage_v, 10.0 * weaker.rms_voltage_v.expect("a number"), 1e-7);
    let [mean, rms] = [weak.mean_voltage_v, weak.rms_voltage_v].map(|number| number.expect("a number"));
    assert!(mean.abs() < 1e-6 * rms, "{mean} {rms}");
}

/// The overlap is the same on both sides of the middle.
#[test]
fn a_mirrored_motion_gives_the_same_voltage() {
    let mirrored = |sign: f64| {
        let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
        let start = SlidingStart {
            displacement_m: Some(sign * 6e-3),
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
    let [omega, ..] = mode();
    for sign in [1.0, -1.0] {
        let parameters = SlidingParameters { damping_ratio: 0.0, ..rubbing(0.0, 0.0) };
        let start = SlidingStart { velocity_m_per_s: Some(sign * 25e-3 * omega), ..Default::default() };
        let swing = scene(parameters, start, 1e8, Excitation::Silence, [0.0, 1.0]);
        let failure = crate::run(&swing, &ReferenceOptions::default()).expect_err("it leaves");
        close(Some(failure.time_s), (0.8 * REACH).asin() / omega, 1e-9);
        assert!(failure.reason.contains("displacement") && failure.reason.contains("two patch radii"));
        let (physics, _) = Physics::new(&parameters, Load::Resistor { resistance_ohm: 1e8 }, &start);
        assert!(failure.reason.contains(&format!("{:e} m (two", 2.0 * physics.radius)), "{failure}");
    }
}
