//! Which parts a scene needs: the changes beside runs without a part, pairs, and the emitted module.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::tool::{
    BEAM, BIMORPH, PASSIVE, SHIPPED, TRUCK, accepted, folder, json, number, outcome, refused, rows, set,
};

/// A second of the shipped scene without impacts.
const SHORT: [&str; 3] = ["excitation.frequency_hz=22", "run.duration_s=1", "run.settle_s=0.5"];

fn needs(scene: &str, overrides: &[&str], more: &[&str]) -> Value {
    json(&[&["needs", scene], &set(overrides)[..], more].concat())
}

fn part<'a>(found: &'a Value, name: &str) -> &'a Value {
    let parts = found["parts"].as_array().expect("a list");
    let named = |part: &&Value| part["part"].as_str().is_some_and(|part| part.starts_with(name));
    parts.iter().find(named).unwrap_or_else(|| panic!("no {name} in {found}"))
}

#[test]
fn the_changes_are_those_of_runs_of_the_reference_without_the_part() {
    let found = needs(SHIPPED, &SHORT, &[]);
    let power = |change: &[&str]| number(&outcome(SHIPPED, &[&SHORT[..], change].concat()), "mean_power_w");
    let full = power(&[]);
    for (name, change) in [
        ("electrostatic force", "parameters.force_law=none"),
        ("parasitic capacitance", "parameters.parasitic_capacitance_f=0"),
    ] {
        let stated = number(part(&found, name), "mean_power");
        let exact = power(&[change]) / full - 1.0;
        assert!(
            (stated - exact).abs() < 2e-4 * (1.0 + exact.abs()) && exact.abs() > 0.01,
            "{name}: {stated} {exact}"
        );
        assert_eq!(part(&found, name)["verdict"], "needed");
    }
    // Without impacts nothing sticks or rebounds.
    for name in ["sticking", "charge in stick", "restitution by speed"] {
        assert_eq!(part(&found, name)["verdict"], "not-needed", "{name}");
        assert_eq!(part(&found, name)["mean_power"], 0.0, "{name}");
    }
    let best = &found["numerics"][0];
    assert!(best["mean_power"].as_f64().is_some_and(|change| change.abs() <= 1e-2), "{best}");
}

#[test]
fn a_part_is_needed_without_another_one() {
    let overrides = "excitation.frequency_hz=60 run.duration_s=0.3 run.settle_s=0.2 parameters.beam_modes=4 \
        load.resistance_ohm=1e5 parameters.piezo_d31_m_per_v=-75e-12";
    let overrides: Vec<&str> = overrides.split(' ').collect();
    let found = needs(BEAM, &overrides, &["--accuracy", "7e-3"]);
    let coupling = part(&found, "two-way coupling");
    assert_eq!(coupling["verdict"], "not-needed-alone", "{found}");
    assert_eq!(coupling["with"], serde_json::json!(["beam modes above 3"]));
    assert_eq!(found["left_out"], serde_json::json!(["beam modes above 3"]));
    assert_eq!(part(&found, "beam modes above 2")["verdict"], "needed");
    assert!(found["without_all"]["mean_power"].as_f64().is_some_and(|change| change.abs() <= 7e-3));
}

#[test]
fn the_scene_of_the_firmware_is_what_the_command_emits() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let emitted = folder("emitted").join("contact_separation.rs");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_host-bench"))
        .current_dir(&root)
        .args(["needs", "host-bench/scenes/contact-separation-passive.toml", "--emit"])
        .arg(&emitted)
        .output()
        .expect("the binary starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let of_firmware = root.join("firmware-example/scene/contact_separation.rs");
    let [found, shipped] =
        [emitted, of_firmware].map(|path| fs::read_to_string(path).expect("a readable module"));
    assert_eq!(found, shipped);
}

#[test]
fn the_emitted_bimorph_has_its_connection() {
    for (connection, value, of_type) in [
        ("bimorph-series", "Bimorph::Series", "Bimorph"),
        ("bimorph-parallel", "Bimorph::Parallel", "Bimorph"),
        ("monomorph", "Monomorph", "Monomorph"),
    ] {
        let set = format!("parameters.transducer={connection}");
        let short = "run={duration_s=0.3,settle_s=0.2}";
        let text = accepted(&["needs", BIMORPH, "--set", &set, "--set", short, "--emit", "-"]);
        assert!(text.contains(&format!("        transducer: {value},\n")), "{text}");
        assert!(text.contains(&format!("TipMass<f32>, {of_type}>;")), "{text}");
    }
}

/// The force that is not needed at 20.5 Hz moves the power by 4 % at 19.8 Hz, below the impacts.
#[test]
fn a_cut_holds_at_the_corners_of_a_range_too() {
    let weak = ["excitation.amplitude_g=0.15", "run={duration_s=3,settle_s=2}"];
    let corner = serde_json::json!([0.15 * 9.81, 19.8]);
    let found = needs(PASSIVE, &weak, &["--frequency", "19.8:20.5"]);
    let force = part(&found, "electrostatic force");
    assert_eq!((&force["verdict"], &force["at"]), (&"needed".into(), &corner), "{force}");
    let run = |force: &str| {
        let changes = [weak[0], weak[1], "excitation.frequency_hz=19.8", force];
        number(&outcome(PASSIVE, &changes), "mean_power_w")
    };
    let exact = run("parameters.force_law=none") / run("parameters.force_law=gap-field") - 1.0;
    let stated = number(force, "mean_power");
    assert!((stated - exact).abs() < 1e-3 && (exact + 0.04).abs() < 2e-3, "{stated} {exact}");
    refused(&["needs", TRUCK, "--amplitude", "1:2"], &["--amplitude", "one sine"]);
}

#[test]
fn csv_is_one_table() {
    let text = accepted(&[&["needs", SHIPPED, "--format", "csv"], &set(&SHORT)[..]].concat());
    // Rows of another length are an error of the reader.
    let rows = rows(&text);
    let count = |table: &str| rows.iter().filter(|row| row["table"] == table).count();
    assert_eq!((count("parts"), count("parts") + count("numerics")), (5, rows.len()), "{text}");
    assert!(count("numerics") > 3, "{text}");
}

#[test]
fn without_power_and_voltage_the_motion_decides_and_is_shown() {
    let sets = [&SHORT[..], &["load.resistance_ohm=0"]].concat();
    let text = accepted(&[&["needs", SHIPPED], &set(&sets)[..]].concat());
    assert!(text.contains("the largest motion decides"), "{text}");
    // The second line of the headings of both tables.
    let folded = text.lines().filter(|line| line.trim_start().starts_with("motion "));
    assert_eq!(folded.count(), 2, "{text}");
    let force = text.lines().find(|line| line.contains("electrostatic force")).expect("a row");
    let change = force.split_whitespace().nth(2).and_then(|cell| cell.parse::<f64>().ok()).expect("a number");
    assert!(change.abs() > 1.0 && force.contains(" needed"), "{force}");
}

#[test]
fn an_accuracy_outside_its_bounds_is_refused_with_its_value() {
    for accuracy in ["0", "0.6", "-1", "600m"] {
        refused(&["needs", SHIPPED, "--accuracy", accuracy], &["--accuracy", "1e-4", "0.5"]);
    }
    refused(&["needs", SHIPPED, "--emit", SHIPPED], &["--emit"]);
}
