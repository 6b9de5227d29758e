//! `run --accuracy` is held by the statement of its own result.

use serde_json::Value;

use super::interrupted::{sorted_rows, text};
use super::tool::{
    BUMP_STOP, PASSIVE, RECTIFIED, SHIPPED, SLIDING, accepted, folder, json, json_and_told, number, printed,
    refused,
};

/// The result of a run, and what was told on standard error.
fn found(scene: &str, more: &[&str]) -> (Value, String) {
    json_and_told(&[&["run", scene], more].concat())
}

/// The stated error, and what was told on standard error.
fn stated(scene: &str, accuracy: &str, more: &[&str]) -> (f64, String) {
    let (outcome, told) = found(scene, &[&["--accuracy", accuracy], more].concat());
    (number(&outcome["accuracy"], "total"), told)
}

#[test]
fn one_random_case_has_the_row_that_it_has_among_all() {
    let rows = |more: &[&str]| {
        let random = ["stability", "--random", "5", "--seed", "407"];
        json(&[&random, more].concat()).as_array().expect("rows").clone()
    };
    let all = rows(&[]);
    for number in [1, 4] {
        assert_eq!(rows(&["--case", &number.to_string()]), all[number..=number]);
    }
    assert_eq!(rows(&["--case", "4,1", "--judges", "200"]), [all[1].clone(), all[4].clone()]);
    refused(&["stability", "--random", "5", "--case", "0,5"], &["--case 5", "below the 5 of --random"]);
}

#[test]
fn rows_of_stability_on_standard_output_and_of_parts_are_those_of_a_file() {
    let random = ["stability", "--random", "5", "--seed", "407", "--output"];
    let file = folder("stability-rows").join("rows.csv");
    accepted(&[&random[..], &[text(&file)]].concat());
    let [found, told] = printed(&[&random[..], &["-"]].concat());
    assert!(told.contains("undecided"), "{told}");
    let read = || sorted_rows(&std::fs::read_to_string(&file).expect("was written"));
    let written = read();
    assert!(found.starts_with("number,") && sorted_rows(&found) == written, "{found}");
    let of = |option: &'static str| [&random[..], &[text(&file), option]].concat();
    for part in ["--part=2/2", "--part=1/2"] {
        refused(&of("--merge=2"), &["part-", "must have all "]);
        accepted(&of(part));
    }
    std::fs::remove_file(&file).expect("is there");
    accepted(&of("--merge=2"));
    assert_eq!(read(), written);
    refused(&["stability", "--merge=2", "--output=x.csv"], &["--merge", "must be with --random"]);
}

/// At these accuracies the first run of each of the first three has a statement above what is asked for.
#[test]
fn a_run_is_made_tighter_until_its_statement_is_within_what_was_asked() {
    for (scene, accuracy) in
        [(SHIPPED, "1e-3"), (PASSIVE, "1e-2"), (SLIDING, "1e-4"), (RECTIFIED, "1e-4"), (SHIPPED, "1e-2")]
    {
        let (total, told) = stated(scene, accuracy, &[]);
        let asked: f64 = accuracy.parse().expect("a number");
        assert!(total <= asked && !told.contains("is not held"), "{scene} {accuracy}: {total:e}: {told}");
    }
}

#[test]
fn a_tighter_accuracy_never_takes_fewer_steps() {
    for scene in [SHIPPED, PASSIVE, SLIDING] {
        let mut last = 0.0;
        for accuracy in ["1e-2", "2e-3", "1e-3", "1e-4", "3e-5", "1e-5", "1e-6"] {
            let steps = number(&found(scene, &["--accuracy", accuracy]).0, "steps");
            assert!(steps >= last, "{scene} {accuracy}: {steps} after {last}");
            last = steps;
        }
    }
}

#[test]
fn an_accuracy_that_cannot_be_held_is_told() {
    // Chaotic at 20 Hz: the mean over a second depends on which second it is.
    let chaotic = ["--set", "excitation.frequency_hz=20", "--set", "run={duration_s=3,settle_s=2}"];
    let (total, told) = stated(PASSIVE, "1e-4", &chaotic);
    assert!(total > 1e-4, "{total:e}");
    assert!(told.contains("accuracy: 1e-4 is not held: the estimated relative error"), "{told}");
    // Single precision rounds by more.
    let (total, told) = stated(SHIPPED, "1e-5", &["--precision", "f32"]);
    assert!(total > 1e-5 && told.contains("1e-5 is not held"), "{total:e}: {told}");
}

/// The steps that the core cuts where a sine is too fast for them are the same in half the default steps.
#[test]
fn a_sine_of_hundreds_of_kilohertz_is_resolved_and_its_error_stated() {
    let sine = "excitation={kind=\"sine\",amplitude_m_per_s2=1000,frequency_hz=3e5}";
    let fast = ["--set", sine, "--set", "run={duration_s=0.01,settle_s=0.005}"];
    let power = |outcome: &Value| number(outcome, "mean_power_w");
    let (exact, _) = found(BUMP_STOP, &[&fast[..], &["--no-accuracy", "--step", "2e-8"]].concat());
    for (step, most) in [(&[][..], 2e-3), (&["--step", "1e-6"], 0.5)] {
        let (outcome, told) = found(BUMP_STOP, &[&fast[..], step].concat());
        let error = (power(&outcome) / power(&exact) - 1.0).abs();
        let total = number(&outcome["accuracy"], "total");
        assert!(error <= total && total <= most, "{step:?}: {error:e} {total:e} {told}");
    }
}

#[test]
fn a_chaotic_run_prints_the_mean_of_an_ensemble_with_its_error() {
    let chaotic = ["--set", "excitation.frequency_hz=20", "--set", "run={duration_s=3,settle_s=2}"];
    let (outcome, _) = found(PASSIVE, &chaotic);
    let (own, _) = found(PASSIVE, &[&chaotic[..], &["--no-accuracy"]].concat());
    let of = |name: &str| number(&outcome["accuracy"], name);
    let relative = number(&outcome, "mean_power_standard_error_w") / number(&outcome, "mean_power_w");
    assert!((of("chaos") / relative - 2.4).abs() < 1e-12 && of("total") >= of("chaos"), "{outcome}");
    assert_ne!(outcome["mean_power_w"], own["mean_power_w"]);
    for name in ["peak_gap_m", "delivered_energy_j", "rms_voltage_v"] {
        assert_eq!(outcome[name], own[name], "{name}");
    }
    // A window of a second: four times as long halves its error.
    assert!(of("window") > 0.0 && (of("window_halved_s") - 6.0).abs() < 1e-9, "{outcome}");
    let (single, _) = found(PASSIVE, &[&chaotic[..], &["--precision", "f32"]].concat());
    let ratio = number(&single["accuracy"], "total") / of("total");
    assert!((0.25..4.0).contains(&ratio), "{ratio}");
    let (periodic, _) = found(SHIPPED, &["--set", "run={duration_periods=36,settle_periods=20}"]);
    assert!(periodic["mean_power_standard_error_w"].is_null() && periodic["accuracy"]["chaos"].is_null());
}
