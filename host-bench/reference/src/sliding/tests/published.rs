//! Values found before by independent implementations (TR-BDF2 with bisected events, Radau at 1e-9).

use super::*;

/// Two sticks in each period.
#[test]
fn sticks_each_period() {
    use StickCharge::{Frozen, Relaxing};
    for (gravities, frequency, stick_charge, amplitude, stuck, voltage) in [
        (0.30, 6.0, Frozen, 0.188287e-3, 0.5405, 0.500),
        (0.30, 6.0, Relaxing, 0.18829e-3, 0.5405, 0.555),
        (0.30, 10.0, Frozen, 0.298331e-3, 0.2504, 1.021),
        (0.30, 10.0, Relaxing, 0.29833e-3, 0.2504, 1.099),
        (0.28, 14.0, Frozen, 0.321551e-3, 0.0345, 1.271),
        (0.28, 14.0, Relaxing, 0.32155e-3, 0.0345, 1.288),
    ] {
        let parameters = SlidingParameters { stick_charge, ..table_1(80e-6, ForceLaw::TransferredCharge) };
        let outcome = run(&shaken(parameters, 1e8, gravities, frequency, [20.0, 30.0]));
        let found = particular(&outcome);
        // The relaxing rows are known to be the same to 1e-4; a unit of the last digit else.
        let digits = if stick_charge == Frozen { 4e-6 } else { 1e-4 };
        close(found.amplitude_m, amplitude, digits);
        close(found.stick_fraction, stuck, 2e-3);
        close(found.sticks_per_period, 2.0, 1e-12);
        close(outcome.rms_voltage_v, voltage, 1.1e-3);
    }
}

#[test]
fn a_large_motion_has_its_known_amplitude() {
    let parameters = table_1(120e-6, ForceLaw::TransferredCharge);
    let outcome = run(&shaken(parameters, 1e8, 0.5, 18.33, [50.0, 60.0]));
    let found = particular(&outcome);
    close(found.amplitude_m, 11.31623e-3, 5e-7);
    assert_eq!((found.stick_fraction, found.sticks_per_period), (Some(0.0), Some(0.0)));
    close(found.natural_frequency_hz, NATURAL, 1e-8);
}

/// Amplitude and voltage at the peak of the response, that of the voltage taken over all frequencies;
/// by fixed steps of 1/400 to 1/800 of a period. Weakly charged motions take too long to settle.
#[test]
fn the_peaks_of_the_response_are_where_they_were_found() {
    for (charge_density, resistance, shift, amplitude, voltage) in [
        (80e-6, 1e8, -0.0145, 8.474e-3, 44.18),
        (120e-6, 1e8, -0.02277, 6.7224e-3, 50.056),
        (120e-6, 0.0, -0.00554, 7.1146e-3, 0.0),
    ] {
        let parameters = table_1(charge_density, ForceLaw::TransferredCharge);
        let outcome = run(&shaken(parameters, resistance, 0.36, NATURAL + shift, [290.0, 300.0]));
        close(particular(&outcome).amplitude_m, amplitude, 1e-4);
        close(outcome.rms_voltage_v, voltage, 3e-4);
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
