//! A run that cannot be finished: an explicit method with a step a thousand times too long for the load; and
//! one that should not be believed.

use super::tool::{SHIPPED, folder, host_bench, json_and_told, number, place, rows, unfolded};

const BLOWS_UP: [&str; 4] = ["--method", "rk4", "--step", "1e-3"];

#[test]
fn a_run_ends_with_code_3_and_one_line() {
    let folder = folder("step-error");
    let trace = place(&folder, "trace.csv");
    let more =
        ["--set", "load.resistance_ohm=1e3", "--format", "json", "--trace", &trace, "--trace-every", "0.01"];
    let output = host_bench(&[&["run", SHIPPED], &BLOWS_UP[..], &more[..]].concat());
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(output.stdout.is_empty());
    assert_eq!(told.lines().count(), 1, "{told}");
    // The time and the state.
    for part in [" at 0.00", " s", "gap", "m/s"] {
        assert!(told.contains(part), "{part:?} is not in {told}");
    }
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0, "no trace is written");
}

/// Seven steps a period, with a load whose current comes in spikes.
#[test]
fn a_run_whose_energy_ledger_does_not_close_warns() {
    let run = |step| {
        let span = ["--set", "run.duration_s=1", "--set", "run.settle_s=0", "--no-accuracy"];
        let method = ["--method", "tr-bdf2", "--step", step, "--set", "load.resistance_ohm=1e7"];
        let (outcome, told) = json_and_told(&[&["run", SHIPPED], &method[..], &span[..]].concat());
        let residual = number(&outcome, "energy_residual");
        let warnings = outcome["warnings"].as_array().expect("a list");
        let of_accuracy = |warning: &&serde_json::Value| {
            warning.as_str().is_some_and(|warning| warning.starts_with("accuracy: energy_residual = "))
        };
        let count = warnings.iter().filter(of_accuracy).count();
        assert_eq!(count, usize::from(residual > 1e-2), "{warnings:?}");
        (residual, told)
    };
    let (residual, told) = run("3e-3");
    assert!(residual > 1e-2);
    // The created energy is not known where the ledger does not close.
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines.len() == 2 && lines[1].contains("model: fringing = "), "{told}");
    assert!(told.starts_with("warning: accuracy: energy_residual = ") && lines[0].contains("0.01"), "{told}");
    let (residual, told) = run("1e-3");
    let lines: Vec<&str> = told.lines().collect();
    let parts = ["creates energy", "model: fringing = "];
    assert!(residual < 1e-2 && lines.len() == 2, "{residual} {told}");
    assert!(lines.iter().zip(parts).all(|(line, part)| line.contains(part)), "{told}");
}

#[test]
fn a_sweep_keeps_the_points_that_got_to_the_end() {
    let over = ["--over", "load.resistance_ohm=1e3:1e9:3:log", "--set", "run.duration_s=1"];
    let window = ["--set", "run.settle_s=0", "--single-start", "--format", "csv"];
    let output = host_bench(&[&["sweep", SHIPPED], &BLOWS_UP[..], &over[..], &window[..]].concat());
    let told = unfolded(output.stderr);
    assert_eq!(output.status.code(), Some(3), "{told}");
    let parts = [
        "creates energy",
        "model: fringing = ",
        "2 of 3 points failed, the first at load.resistance_ohm = 1000",
    ];
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines.len() == 3 && lines.iter().zip(parts).all(|(line, part)| line.contains(part)), "{told}");
    let rows = rows(&String::from_utf8(output.stdout).expect("text"));
    assert_eq!(rows.len(), 3);
    for (row, failed) in rows.iter().zip([true, true, false]) {
        assert_eq!(row["mean_power_w"].is_empty(), failed);
        assert_eq!(row["error"].contains(" at 0.00"), failed);
    }
}
