//! The energy that a force law creates: its share of the delivered energy, and the warning of it.

use serde_json::Value;

use super::tool::{NODE, PASSIVE, SHIPPED, SLIDING, folder, json_and_told, number, place, set};

/// Whether it is another than that the plates are too small or the slope too large, which these scenes have, or a file is written.
fn is_other(text: &str) -> bool {
    !["model: fringing = ", "model: slope_rad = ", "written: "].iter().any(|known| text.contains(known))
}

/// Runs a command with overrides; gives the JSON and the lines on standard error.
fn told(command: &[&str], overrides: &[&str]) -> (Value, Vec<String>) {
    let (found, told) = json_and_told(&[command, &set(overrides)].concat());
    (found, told.lines().filter(|line| is_other(line)).map(str::to_owned).collect())
}

/// The warnings of an object, which are the lines on standard error.
#[track_caller]
fn warnings(found: &Value, told: &[String]) -> Vec<String> {
    let list = found["warnings"].as_array().expect("a list");
    let list = list.iter().map(|text| text.as_str().expect("text"));
    let list: Vec<String> = list.filter(|text| is_other(text)).map(str::to_owned).collect();
    let lines: Vec<String> = list.iter().map(|text| format!("warning: {text}")).collect();
    assert_eq!(lines, told);
    list
}

fn run(scene: &str, overrides: &[&str]) -> (Value, Vec<String>) {
    let (found, told) = told(&["run", scene, "--no-accuracy"], overrides);
    let warnings = warnings(&found, &told);
    (found, warnings)
}

const SHORT: [&str; 2] = ["run.duration_s=1.5", "run.settle_s=0.5"];

#[test]
fn the_share_is_the_quotient_and_the_warning_names_law_number_and_remedy() {
    let (found, warnings) = run(SHIPPED, &SHORT);
    let share = number(&found, "created_energy_share");
    assert_eq!(share, number(&found, "created_energy_j") / number(&found, "delivered_energy_j"));
    assert!(share > 1.0, "{share}");
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    let parts =
        ["force_law = \"transferred-charge\" creates energy", &format!("{share:.3} times"), "\"gap-field\""];
    for part in parts {
        assert!(warning.contains(part), "{part:?} is not in {warning}");
    }
    assert!(!warning.starts_with("accuracy:"), "the numbers are right for that law");

    let (found, warnings) = run(PASSIVE, &SHORT);
    assert_eq!((found["created_energy_share"].as_f64(), warnings.len()), (Some(0.0), 0), "{warnings:?}");
}

#[test]
fn without_delivered_energy_the_share_is_null() {
    for load in ["load.resistance_ohm=0", "load.resistance_ohm=inf"] {
        let (found, warnings) = run(SHIPPED, &[&SHORT[..], &[load]].concat());
        assert!(found["created_energy_share"].is_null() && warnings.is_empty(), "{load}: {warnings:?}");
        assert!(found["created_energy_j"].is_number(), "{load}");
    }
}

#[test]
fn sliding_without_the_lateral_force_takes_nothing_from_the_motion() {
    let short = ["run={duration_periods=60,settle_periods=40}"];
    let (found, warnings) = run(SLIDING, &short);
    let share = number(&found, "created_energy_share");
    assert!((share - 1.0).abs() < 0.05, "{share}");
    assert!(
        warnings.len() == 1 && warnings[0].contains("lateral_force = false creates energy"),
        "{warnings:?}"
    );
    let lateral = [&short[..], &["parameters.lateral_force=true"]].concat();
    let (found, warnings) = run(SLIDING, &lateral);
    assert_eq!((found["created_energy_share"].as_f64(), warnings.len()), (Some(0.0), 0), "{warnings:?}");
}

#[test]
fn a_sweep_warns_once_and_each_of_its_points_has_its_warning() {
    let over = ["sweep", SHIPPED, "--over", "load.resistance_ohm=0:2e8:3", "--single-start"];
    let (points, told) = told(&over, &SHORT);
    let [line] = &told[..] else { panic!("{told:?}") };
    assert!(line.starts_with("warning: at 2 of 3 points, the most at load.resistance_ohm = "), "{line}");
    let counts: Vec<usize> = points
        .as_array()
        .expect("a list")
        .iter()
        .map(|point| point["warnings"].as_array().expect("a list"))
        .map(|list| list.iter().filter(|text| is_other(text.as_str().expect("text"))).count())
        .collect();
    assert_eq!(counts, [0, 1, 1]);
}

#[test]
fn a_budget_warns_of_income_that_is_created() {
    let command = ["budget", NODE, "--svg", &place(&folder("created"), "day.svg")];
    let short = ["run.duration_s=3", "run.settle_s=2"];
    let (day, lines) = told(&command, &short);
    let creates = |list: &[String]| list.iter().filter(|text| text.contains("creates energy")).count();
    assert_eq!(creates(&warnings(&day, &lines)), 0, "the shipped node conserves energy");
    let (day, lines) = told(&command, &[&short[..], &["parameters.force_law=transferred-charge"]].concat());
    let warnings = warnings(&day, &lines);
    let part = "3 of 3 runs: force_law = \"transferred-charge\" creates energy";
    assert!(warnings.iter().any(|warning| warning.starts_with(part)), "{warnings:?}");
}
