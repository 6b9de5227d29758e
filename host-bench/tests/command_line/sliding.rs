//! The sliding scene: what it refuses, what it prints, and how a run ends that cannot be finished.

use super::tool::{SLIDING, accepted, file, folder, host_bench, number, outcome, refused_scene, set};

/// Two seconds of it.
const SHORT: [&str; 2] = ["run.duration_s=2", "run.settle_s=1"];

#[track_caller]
fn refused_with(overrides: &[&str], parts: &[&str]) {
    refused_scene(SLIDING, overrides, parts);
}

#[test]
fn json_has_every_key_of_the_contract() {
    let found = outcome(SLIDING, &SHORT);
    let keys: Vec<&str> = found.as_object().expect("an object").keys().map(String::as_str).collect();
    let wanted = "scene method precision math duration_s settle_s mean_power_w mean_power_standard_error_w rms_voltage_v \
                  peak_voltage_v mean_voltage_v delivered_energy_j created_energy_j created_energy_share energy_residual \
                  steps rejected_steps newton_iterations events processor_s accuracy branches limits smallest_margin impossible_margin warnings natural_frequency_hz peak_displacement_m amplitude_m \
                  stick_fraction sticks_per_period";
    assert_eq!(keys, wanted.split_whitespace().collect::<Vec<_>>());
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
fn words_and_flags_that_are_none() {
    for value in ["1", "\"yes\"", "[]"] {
        let change = format!("parameters.lateral_force={value}");
        refused_with(&[&change], &["parameters.lateral_force", "must be true or false"]);
    }
    refused_with(&["parameters.force_law=exact"], &["force_law", "\"transferred-charge\" or \"gap-field\""]);
    refused_with(&["parameters.stick_charge=free"], &["stick_charge", "\"frozen\" or \"relaxing\""]);
    refused_with(&["parameters.mass_kg=1"], &["parameters.mass_kg", "unknown key"]);
    refused_with(&["initial.gap_m=1e-3"], &["initial.gap_m", "unknown key", "displacement_m"]);
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

/// An uncharged slider, shaken too hard, swings out of the overlap: exit code 3, one line, no result.
#[test]
fn a_slider_that_leaves_the_patch_ends_the_run() {
    let changes = ["--set", "parameters.charge_density_c_per_m2=0", "--set", "excitation.amplitude_g=0.5"];
    let output = host_bench(&[&["run", SLIDING, "--method", "reference"], &changes[..]].concat());
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(output.stdout.is_empty());
    assert_eq!(told.lines().count(), 1, "{told}");
    for part in ["displacement", "two patch radii", "2e-2 m", " at 2.7208", "velocity"] {
        assert!(told.contains(part), "{part:?} is not in {told}");
    }
}
