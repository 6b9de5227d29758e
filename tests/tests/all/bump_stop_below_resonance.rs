//! The scenes of the second paper far below the resonance: core and reference against another program.
//!
//! The other program is not in this repository: finite-element modes, and exact propagation in each of the two
//! regimes. The orbit with the stop at the tip is not periodic, so statistics are compared only.

use cross_crate_tests::{assert_close, on_all_cores, reference, run_beam, shipped, value};
use host_bench::method::Options;
use host_bench::scene_file::{RunSpan, Scene};

/// The numbers of the other program for one scene. Without a stop there are no contacts.
struct Expected {
    scene: &'static str,
    rms_voltage_v: f64,
    peak_voltage_v: f64,
    mean_power_w: f64,
    peak_tip_m: f64,
    /// Contacts per period, part of the time in contact, mean and peak force in N.
    contacts: Option<[f64; 4]>,
    first_contact_s: Option<f64>,
    /// Voltage of the storage in V after 1 s and after 5 s.
    stored_v: [f64; 2],
}

const EXPECTED: [Expected; 3] = [
    Expected {
        scene: "bump-stop-below-resonance",
        rms_voltage_v: 2.059_23,
        peak_voltage_v: 4.970,
        mean_power_w: 42.40e-6,
        peak_tip_m: 0.148_28e-3,
        contacts: Some([138.0, 0.340, 85.75e-3, 2.72]),
        first_contact_s: Some(11.948_875e-3),
        stored_v: [2.576, 5.491],
    },
    Expected {
        scene: "bump-stop-below-resonance-mid-span",
        rms_voltage_v: 2.473_26,
        peak_voltage_v: 5.659,
        mean_power_w: 61.17e-6,
        peak_tip_m: 0.144_87e-3,
        contacts: Some([54.0, 0.331, 191.98e-3, 3.37]),
        first_contact_s: Some(12.219_097e-3),
        stored_v: [3.562, 7.090],
    },
    Expected {
        scene: "bump-stop-below-resonance-none",
        rms_voltage_v: 3.135_620,
        peak_voltage_v: 4.434_44,
        mean_power_w: 98.3212e-6,
        peak_tip_m: 0.139_79e-3,
        contacts: None,
        first_contact_s: None,
        stored_v: [4.633, 9.3817],
    },
];

/// Compares the statistics of a run: those of the electrical output, then those of the contact.
fn compare(expected: &Expected, options: &Options) {
    let (found, motion) = run_beam(&shipped(expected.scene, &[]), options);
    let close = |what: &str, found: Option<f64>, wanted: f64, tolerance: f64| {
        println!("{}: {what}: {} instead of {wanted}", expected.scene, value(found));
        assert_close(what, value(found), wanted, tolerance);
    };
    close("RMS voltage", found.rms_voltage_v, expected.rms_voltage_v, 0.01);
    close("mean power", found.mean_power_w, expected.mean_power_w, 0.02);
    close("peak voltage", found.peak_voltage_v, expected.peak_voltage_v, 0.04);
    close("peak tip displacement", motion.peak_tip_displacement_m, expected.peak_tip_m, 0.02);
    let Some([contacts, fraction, mean_force, peak_force]) = expected.contacts else {
        assert_eq!(motion.contacts, 0);
        assert_close("RMS voltage without a stop", value(found.rms_voltage_v), expected.rms_voltage_v, 1e-6);
        return;
    };
    // Contacts and peak force depend on the step.
    close("contacts per period", motion.contacts_per_period, contacts, 0.2);
    close("time in contact", motion.contact_fraction, fraction, 0.02);
    close("mean force", motion.mean_force_n, mean_force, 0.01);
    close("peak force", motion.peak_force_n, peak_force, 0.1);
    let first = value(motion.first_contact_s);
    assert!((first - value(expected.first_contact_s)).abs() < 1e-6, "first contact at {first} s");
}

#[test]
fn the_core_has_the_statistics_of_another_program() {
    on_all_cores(&EXPECTED, |expected| compare(expected, &Options::default()));
}

/// Each run takes half a minute.
#[test]
#[ignore = "a minute"]
fn the_reference_has_the_statistics_of_another_program() {
    on_all_cores(&EXPECTED, |expected| compare(expected, &reference()));
}

/// Compares the voltage of the storage after 1 s, or after 5 s, when it is full.
fn compare_stored(is_full: bool) {
    on_all_cores(&EXPECTED, |expected| {
        let duration_s = if is_full { 5.0 } else { 1.0 };
        let charging = shipped("bump-stop-below-resonance-charging", &[]);
        let run_span = RunSpan { duration_s, settle_s: 0.0 };
        let scene = Scene { load: charging.load, run: run_span, ..shipped(expected.scene, &[]) };
        let (outcome, _) = run_beam(&scene, &Options::default());
        let found = value(outcome.store.expect("a storage").store_voltage_v);
        println!("{}: {found} V after {duration_s} s", expected.scene);
        let tolerance = if is_full && expected.contacts.is_none() { 1e-4 } else { 0.01 };
        assert_close(expected.scene, found, expected.stored_v[usize::from(is_full)], tolerance);
    });
}

#[test]
fn the_storage_has_the_voltage_of_another_program() {
    compare_stored(false);
}

#[test]
#[ignore = "ten seconds"]
fn the_full_storage_has_the_voltage_of_another_program() {
    compare_stored(true);
}
