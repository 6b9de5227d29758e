//! Runs from displaced starts, and the motions that they find.

use serde_json::Value;

use super::tool::{PASSIVE, SHIPPED, accepted, folder, refused};

const BEAM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bump-stop-none.toml");
const BISTABLE: [&str; 2] = ["--set", "excitation.frequency_hz=22.5"];

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&accepted(&[arguments, &["--format", "json"]].concat())).expect("JSON")
}

fn power(scene: &str, more: &[&str]) -> f64 {
    json(&[&["run", scene, "--single-start"], &BISTABLE[..], more].concat())["mean_power_w"]
        .as_f64()
        .expect("a power")
}

fn close(branch: &Value, expected: f64) -> bool {
    (branch["mean_power_w"].as_f64().expect("a power") / expected - 1.0).abs() < 0.01
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
        assert!(warning.contains("attractors: the start decides"), "{warning}");
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
    let picture = folder("attractors").join("basin.svg");
    let picture = picture.to_str().expect("a plain path");
    let command = ["attractors", SHIPPED, "--starts", "40", "--picture", picture];
    let all = json(&[&command[..], &BISTABLE].concat());
    let all = all.as_array().expect("rows");
    let keys: Vec<&String> = all[0].as_object().expect("an object").keys().collect();
    assert_eq!(keys, ["mean_power_w", "period", "share", "displacement_m", "velocity_m_per_s"]);
    let shares: Vec<f64> = all.iter().filter_map(|row| row["share"].as_f64()).collect();
    assert!(
        shares.len() == 2 && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares[1] > 0.2,
        "{all:?}"
    );
    let drawn = std::fs::read_to_string(picture).expect("a picture");
    assert!(drawn.contains("mean power [µW]") && drawn.contains("velocity at the start"));
    assert_eq!(json(&[&command[..], &BISTABLE].concat()).as_array(), Some(all), "the same starts again");
    refused(
        &["attractors", SHIPPED, "--set", "excitation={kind=\"silence\"}"],
        &["must be a moving harvester under a sine"],
    );
}
