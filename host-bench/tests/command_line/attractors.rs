//! Runs from displaced starts, and the motions that they find.

use serde_json::Value;

use super::tool::{BEAM, PASSIVE, SHIPPED, accepted, folder, host_bench, json, number, place, refused};

const BISTABLE: [&str; 2] = ["--set", "excitation.frequency_hz=22.5"];

fn power(scene: &str, more: &[&str]) -> f64 {
    number(&json(&[&["run", scene, "--single-start"], &BISTABLE[..], more].concat()), "mean_power_w")
}

fn close(branch: &Value, expected: f64) -> bool {
    (number(branch, "mean_power_w") / expected - 1.0).abs() < 0.01
}

/// Both motions are known from runs whose start is given in the scene.
#[test]
fn a_run_states_the_motion_to_which_another_start_leads() {
    for scene in [SHIPPED, PASSIVE] {
        let rest = power(scene, &[]);
        let impacting = power(scene, &["--set", "initial.velocity_m_per_s=0.9"]);
        assert!(impacting > 5e3 * rest, "{rest:e} {impacting:e}");
        let found = json(&[&["run", scene], &BISTABLE[..]].concat());
        let branches = found["branches"].as_array().expect("two motions");
        assert!(
            branches.len() == 2 && close(&branches[0], rest) && close(&branches[1], impacting),
            "{branches:?}"
        );
        let warning = found["warnings"].to_string();
        assert!(warning.contains("the start decides") && warning.contains(" of 3 starts)"), "{warning}");
        // From where the other motion is reached, the first one is the other.
        let start = format!("initial.velocity_m_per_s={}", branches[1]["velocity_m_per_s"]);
        let gap = format!("initial.gap_m={}", branches[1]["displacement_m"]);
        let again = power(scene, &["--set", &start, "--set", &gap]);
        assert!((again / impacting - 1.0).abs() < 0.01, "{again:e}");
        let alone = json(&[&["run", scene, "--single-start"], &BISTABLE[..]].concat());
        assert!(alone["branches"].is_null() && !alone["warnings"].to_string().contains("attractors:"));
    }
}

#[test]
fn a_linear_scene_has_one_motion_whenever_its_window_begins() {
    for settle in ["run={duration_s=0.6,settle_s=0.4}", "run={duration_s=0.2,settle_s=0.0}"] {
        assert!(json(&["run", BEAM, "--set", settle])["branches"].is_null(), "{settle}");
    }
    let all = json(&["attractors", BEAM, "--starts", "6", "--set", "run={duration_s=0.6,settle_s=0.4}"]);
    assert!(all.as_array().is_some_and(|all| all.len() == 1 && all[0]["period"] == 1), "{all}");
}

#[test]
fn all_starts_are_shared_among_the_motions_that_they_find() {
    let picture = &place(&folder("attractors"), "basin.svg");
    let command = ["attractors", SHIPPED, "--starts", "40", "--picture", picture];
    let all = json(&[&command[..], &BISTABLE].concat());
    let all = all.as_array().expect("rows");
    let keys: Vec<&String> = all[0].as_object().expect("an object").keys().collect();
    assert_eq!(keys[..5], ["mean_power_w", "period", "share", "starts", "displacement_m"]);
    for row in all {
        assert!(row["accuracy"]["total"].as_f64().is_some_and(|total| total < 0.1), "{row}");
        assert!(row["warnings"].to_string().contains("model: fringing"), "{row}");
    }
    let shares: Vec<f64> = all.iter().filter_map(|row| row["share"].as_f64()).collect();
    assert!(
        shares.len() == 2 && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares[1] > 0.2,
        "{all:?}"
    );
    let drawn = std::fs::read_to_string(picture).expect("a picture");
    assert!(drawn.contains("of 40 starts") && drawn.contains("velocity at the start"));
    assert_eq!(json(&[&command[..], &BISTABLE].concat()).as_array(), Some(all), "the same starts again");
    refused(
        &["attractors", SHIPPED, "--set", "excitation={kind=\"silence\"}"],
        &["must be a moving harvester under a sine"],
    );
}

#[test]
fn starts_that_have_not_settled_are_warned_of() {
    let short = ["--set", "run={duration_s=0.6,settle_s=0.3}"];
    let found = json(&[&["run", PASSIVE], &BISTABLE[..], &short].concat());
    let warnings = found["warnings"].to_string();
    assert!(
        found["branches"].is_null() && warnings.contains("attractors: runs from displaced starts have not")
    );
    let picture = &place(&folder("attractors-many"), "starts.svg");
    let short = ["--set", "run={duration_s=0.3,settle_s=0.1}"];
    let many = ["attractors", PASSIVE, "--starts", "40", "--picture", picture];
    let all = json(&[&many[..], &BISTABLE, &short].concat());
    assert!(all[0]["warnings"].to_string().contains("have not settled"), "{all}");
    // Six of them have a sign of their own, the others one together.
    let drawn = std::fs::read_to_string(picture).expect("a picture");
    let others = all.as_array().map_or(0, Vec::len) - 6;
    assert!(others > 1 && drawn.contains(&format!("{others} other motions, ")), "{others}");
    assert_eq!(drawn.matches(" of 40 starts").count(), 7);
}

#[test]
fn the_help_has_the_accuracy_of_the_runs_and_a_short_command_no_progress() {
    let help = accepted(&["attractors", "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("1e-4; a bump-stop") && !help.contains("[default: 1e-6; 1e-5 in f32"), "{help}");
    let told = host_bench(&[&["attractors", PASSIVE, "--starts", "9"], &BISTABLE[..]].concat()).stderr;
    assert!(!String::from_utf8_lossy(&told).contains("elapsed"));
}

/// From the start comes a motion of three periods, beside the orbit of the largest power.
#[test]
fn a_resonance_warns_of_another_motion_and_of_a_peak_at_an_edge() {
    let found = json(&["resonance", PASSIVE, "--from", "18", "--to", "22", "--points", "11"]);
    let warnings = found["warnings"].to_string();
    assert!(found["accuracy"]["total"].is_null() && found["peak_at_edge"] == true, "{found}");
    assert!(
        warnings.contains("it has 1.376045e-5 W at 20.14429 Hz, the motion from the start 1.380731e-5 W"),
        "{warnings}"
    );
    assert!(warnings.contains("range: the largest amplitude is at its edge, 22 Hz"), "{warnings}");
}

#[test]
fn a_finding_names_other_motions_of_its_runs() {
    let of = |more: &[&str]| json(&[&["findings", "--only", "37"], more].concat()).to_string();
    assert!(of(&[]).contains("such runs, of 4"));
    assert!(!of(&["--single-start"]).contains("such runs"));
}
