//! Long runs: means that follow from stationarity, and statistics of an independent computation.

use super::*;
use harvester_scene::scene_file::modes::BumpStopModes;

/// With a gap of 10 µm at the tip the motion of (6, 2) modes has the period of the base. Over whole periods the
/// mean voltage is 0 and the means of the displacements are those that the mean force makes.
#[test]
fn means_follow_from_the_mean_force() {
    const SETTLED: f64 = 200.0 / FREQUENCY;
    const END: f64 = 204.0 / FREQUENCY;
    let (model, scene) = scene([6, 2], [SETTLED, END]);
    // So many rows that their mean is that over time: a contact lasts 16 µs.
    let every = 1.0 / (1600.0 * FREQUENCY);
    let (outcome, _) = run(&model, &scene, Some(every));
    let found = particular(&outcome);
    close(number(found.contacts_per_period), 9.0, 1e-9);
    let rows = &outcome.trace.as_ref().expect("a recording").rows[320_000..326_400];
    let mean = |column: usize| rows.iter().map(|row| row[column]).sum::<f64>() / rows.len() as f64;
    let force = number(found.mean_force_n);
    let modes = BumpStopModes::new(&model.parameters, model.stop.as_ref());
    let beam: f64 = modes.beam.iter().map(|mode| (mode.at_stop / mode.angular_frequency).powi(2)).sum();
    let rod: f64 = modes.rod.iter().map(|mode| (mode.at_face / mode.angular_frequency).powi(2)).sum();
    close(mean(1), -force * beam, 1e-3);
    close(mean(3), force * rod, 2e-2);
    let root_mean_square = number(outcome.rms_voltage_v);
    let mean_voltage = number(outcome.mean_voltage_v);
    assert!(mean_voltage.abs() < 1e-3 * root_mean_square, "{mean_voltage:e}");
    // The independent computation has 0.694 V over a second.
    close(root_mean_square, 0.694, 3e-3);
    assert!(number(outcome.energy_residual) < 1e-11);
}

/// Restitution is another law of contact with the same electrical result, within the few per cent that the
/// attractors of impacting modes differ by.
#[test]
fn restitution_gives_the_same_voltage() {
    let (mut model, scene) = scene([10, 3], [0.1, 0.3]);
    for (position_m, restitution, expected) in [(50e-3, 0.9, 0.408), (25e-3, 0.5, 0.804)] {
        model.stop = Some(StopParameters {
            position_m,
            gap_m: 0.0,
            contact: Contact::Restitution,
            restitution: Some(restitution),
            ..stop(3)
        });
        let (outcome, _) = run(&model, &scene, None);
        close(number(outcome.rms_voltage_v), expected, 0.05);
    }
}

/// Ten modes each, from 0.5 to 1.5 s, against an independent event-driven computation: gap in µm and position
/// in mm; RMS voltage, power in µW, mean force in mN, contacts per period, largest force in N, fraction.
#[test]
#[ignore = "two minutes in the release profile"]
fn statistics_of_ten_modes_each() {
    let rows = [
        (0.0, 50e-3, [0.4329, 0.187, 15.28, 22.0, 2.448, 0.0294]),
        (0.0, 25e-3, [0.798, 0.637, 45.5, 19.0, 2.82, 0.103]),
        (10e-6, 50e-3, [0.6836, 0.467, 12.97, 20.7, 2.36, 0.030]),
        (10e-6, 25e-3, [1.880, 3.534, 24.2, 10.9, 2.95, 0.037]),
    ];
    for (gap_m, position_m, expected) in rows {
        let (mut model, scene) = scene([10, 10], [0.5, 1.5]);
        model.stop = Some(StopParameters { gap_m, position_m, ..stop(10) });
        let (outcome, _) = run(&model, &scene, None);
        let found = particular(&outcome);
        let numbers = [
            number(outcome.rms_voltage_v),
            1e6 * number(outcome.mean_power_w),
            1e3 * number(found.mean_force_n),
            number(found.contacts_per_period),
            number(found.peak_force_n),
            number(found.contact_fraction),
        ];
        println!("gap {gap_m:e}, position {position_m}: {numbers:?}");
        // Where the motion is chaotic, windows differ by a per cent in voltage.
        for ((found, expected), allowed) in
            numbers.iter().zip(expected).zip([0.02, 0.04, 0.02, 0.05, 0.05, 0.05])
        {
            close(*found, expected, allowed);
        }
    }
}
