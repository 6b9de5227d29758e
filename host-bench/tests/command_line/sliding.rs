//! The sliding scene: what it refuses and what it prints.

use super::tool::{SLIDING, accepted, file, folder, has_keys, number, outcome, refused_scene, set};

/// Two seconds of it.
const SHORT: [&str; 2] = ["run.duration_s=2", "run.settle_s=1"];

#[track_caller]
fn refused_with(overrides: &[&str], parts: &[&str]) {
    refused_scene(SLIDING, overrides, parts);
}

#[test]
fn json_has_every_key_of_the_contract() {
    let found = outcome(SLIDING, &SHORT);
    let own = "natural_frequency_hz peak_displacement_m amplitude_m stick_fraction sticks_per_period";
    has_keys(&found, true, own);
    assert_eq!(found["scene"], "sliding");
    assert_eq!(found["method"], "reference");
    assert!((number(&found, "natural_frequency_hz") - 18.373_129_8).abs() < 1e-7);
    assert!(
        (number(&found, "rms_voltage_v").powi(2) / 1e8 / number(&found, "mean_power_w") - 1.0).abs() < 1e-12
    );
    let amplitude = number(&found, "amplitude_m");
    assert!(amplitude > 1e-3 && number(&found, "peak_displacement_m") >= amplitude);
    assert!(number(&found, "energy_residual") < 1e-9);
}

#[test]
fn what_does_not_exist_is_null() {
    // It rests, uncharged, where its spring does not pull.
    let found = outcome(SLIDING, &[&SHORT[..], &["excitation={kind=\"silence\"}"]].concat());
    for key in ["energy_residual", "sticks_per_period"] {
        assert!(found[key].is_null(), "{key}");
    }
    assert_eq!((number(&found, "stick_fraction"), number(&found, "amplitude_m")), (1.0, 0.0));
}

#[test]
fn a_trace_has_the_motion() {
    let folder = folder("sliding-trace");
    let trace = file(&folder, "trace.csv", "");
    let arguments = ["run", SLIDING, "--method", "reference", "--trace", &trace, "--trace-every", "0.01"];
    accepted(&[&arguments[..], &set(&SHORT)].concat());
    let mut reader = csv::Reader::from_path(&trace).expect("the trace");
    let heading: Vec<String> = reader.headers().expect("a heading").iter().map(ToOwned::to_owned).collect();
    let expected =
        "time_s displacement_m velocity_m_per_s charge_c voltage_v base_acceleration_m_per_s2 stuck";
    assert_eq!(heading, expected.split(' ').collect::<Vec<_>>());
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|row| row.expect("a row").iter().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 201);
    // At rest in the middle until the base pushes hard enough; later it moves.
    assert_eq!(rows[0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    assert!(rows.iter().any(|row| row[1] > 1e-3 && row[3] > 0.0 && row[6] == 0.0));
}

#[test]
fn numbers_that_do_not_fit_together() {
    for patch in ["active", "inert"] {
        let [kinetic, at_rest] =
            ["kinetic", "static"].map(|kind| format!("parameters.{kind}_friction_{patch}=0.4"));
        refused_with(
            &[&kinetic],
            &[&kinetic.replace('=', " = "), &format!("must not be above static_friction_{patch} = 0.")],
        );
        // As large as the other it may be.
        outcome(SLIDING, &[&SHORT[..], &[&kinetic, &at_rest]].concat());
    }
    refused_with(
        &["initial.displacement_m=-0.02"],
        &["initial.displacement_m = -0.02", "two patch radii", "less than 0.02"],
    );
    outcome(SLIDING, &[&SHORT[..], &["initial.displacement_m=-0.0199"]].concat());
    refused_with(
        &["parameters.beam_length_m=1e-4"],
        &["parameters.beam_length_m = 1e-4", "natural frequency", "from 1e-3 to 1e4"],
    );
}
