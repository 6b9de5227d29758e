//! The comparison of a bump-stop scene with and without its stop.

use serde_json::Value;

use super::tool::{BEAM, LOADED, SHIPPED, TIP, accepted, json, number, refused};

const SHORT: [&str; 6] =
    ["--set", "parameters.beam_modes=4", "--set", "run.duration_s=0.2", "--set", "run.settle_s=0.1"];

/// Rows of runs in the default steps.
fn rows(arguments: &[&str]) -> Vec<Value> {
    stated(&[arguments, &["--no-accuracy"]].concat())
}

fn stated(arguments: &[&str]) -> Vec<Value> {
    json(&[arguments, &SHORT].concat()).as_array().expect("a list").clone()
}

/// One run without the stop for all positions: that of the scene that is shipped without it.
#[test]
fn each_position_stands_beside_the_run_without_a_stop() {
    let set = ["--set", "stop.rod_modes=1", "--over", "stop.position_m=25e-3:50e-3:2"];
    let found = rows(&[&["stop", TIP][..], &set].concat());
    let [free, middle, tip] = &found[..] else { panic!("three rows: {found:?}") };
    assert_eq!(free["stop.position_m"], Value::Null);
    assert_eq!([number(middle, "stop.position_m"), number(tip, "stop.position_m")], [25e-3, 50e-3]);
    let options = ["--step", "1e-6", "--long-step", "2e-5", "--no-accuracy"];
    let run = json(&[&["run", BEAM][..], &SHORT, &options].concat());
    for key in ["clamp_stress_peak_pa", "clamp_stress_equivalent_range_pa", "mean_power_w"] {
        assert_eq!(free[key], run[key], "{key}");
    }
    for row in [middle, tip] {
        for [key, part] in [
            ["clamp_stress_peak_pa", "clamp_stress_peak_saved"],
            ["clamp_stress_rms_pa", "clamp_stress_rms_saved"],
            ["clamp_stress_equivalent_range_pa", "clamp_stress_equivalent_range_saved"],
            ["mean_power_w", "mean_power_lost"],
        ] {
            let expected = 1.0 - number(row, key) / number(free, key);
            assert!((number(row, part) - expected).abs() < 1e-12, "{part}");
            assert!(expected > 0.2, "{part}: near the resonance a stop saves and costs: {expected}");
        }
        assert!(number(row, "contacts_per_period") > 1.0);
    }
    assert_eq!(free["clamp_stress_peak_saved"], Value::Null);
}

/// A key that is not of the stop has a run without it at each of its values.
#[test]
fn another_key_has_a_run_without_a_stop_at_each_value() {
    let found =
        rows(&["stop", LOADED, "--over", "excitation.amplitude_m_per_s2=1:2:2", "--set", "stop.gap_m=1e-2"]);
    let stops: Vec<bool> = found.iter().map(|row| row["with_stop"] == true).collect();
    assert_eq!(stops, [false, false, true, true]);
    // The gap is too wide for contact: the stop saves and costs nothing.
    for row in &found[2..] {
        assert!(
            number(row, "clamp_stress_peak_saved").abs() < 1e-9
                && number(row, "mean_power_lost").abs() < 1e-9
        );
    }
    assert!(
        (number(&found[1], "clamp_stress_peak_pa") / number(&found[0], "clamp_stress_peak_pa") - 2.0).abs()
            < 1e-6
    );
    let table = accepted(&[&["stop", LOADED, "--no-accuracy"][..], &SHORT].concat());
    // Three lines of headings; a number is in one line. The last column has no room and follows below.
    let rows = table.lines().skip(3).take(2).map(|row| row.split_whitespace().count());
    assert!(
        rows.eq([11, 11]) && table.contains("  saved  ") && table.contains("stop  power lost %"),
        "{table}"
    );
}

/// The statement is that of `run`; what half the steps change is the difference of two runs of `run`.
#[test]
fn the_error_of_the_power_and_the_changes_of_the_stresses_are_those_of_run() {
    let steps = |short: &'static str, long: &'static str| ["--step", short, "--long-step", long];
    let found = stated(&[&["stop", LOADED][..], &steps("2e-6", "4e-5")].concat());
    let [_, stopped] = &found[..] else { panic!("two rows: {found:?}") };
    let run = |more: &[&str]| json(&[&["run", LOADED][..], &SHORT, more].concat());
    let whole = run(&steps("2e-6", "4e-5"));
    assert_eq!(stopped["mean_power_error"], whole["accuracy"]["total"]);
    assert!(number(stopped, "mean_power_error") > 1e-5);
    let halved = run(&[&steps("1e-6", "2e-5")[..], &["--no-accuracy"]].concat());
    let mut largest = 0.0_f64;
    for key in ["clamp_stress_peak_pa", "clamp_stress_rms_pa", "clamp_stress_cycles"] {
        assert_eq!(stopped[key], whole[key], "{key}");
        let change = number(stopped, &format!("{key}_change"));
        assert!(
            (change - (number(&halved, key) / number(&whole, key) - 1.0)).abs() < 1e-12,
            "{key}: {change}"
        );
        largest = largest.max(change.abs());
    }
    assert!(largest > 0.0, "{stopped}");
}

#[test]
fn what_has_no_stop_or_no_bending_is_refused() {
    refused(&["stop", SHIPPED], &["must be a bump-stop scene"]);
    refused(&["stop", BEAM], &["stop", "is missing"]);
    refused(&["stop", TIP, "--over", "stop.gap_m=1e-5:2e-5"], &["--over", "COUNT"]);
    refused(&["stop", TIP, "--over", "stop.gap_m=-1:1:2"], &["stop.gap_m", "0 to 1"]);
    let method = ["stop", TIP, "--method", "newmark"];
    refused(&[&method[..], &SHORT].concat(), &["--method", "bending"]);
}
