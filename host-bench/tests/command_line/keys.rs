//! `keys` and `new`.

use std::path::Path;

use super::tool::{SHIPPED, accepted, folder, json, place, refused};

#[test]
fn keys_are_printed_in_each_format() {
    let table = accepted(&["keys", "sliding"]);
    for part in ["[parameters] of sliding", "patch_radius_m", "1e-6 to 1", "Radius of", "[load.draw]"] {
        assert!(table.contains(part), "{part:?} is not in {table}");
    }
    assert!(!table.contains("stiffness_n_per_m") && !table.contains("piezo"), "{table}");
    let rows = json(&["keys"]);
    let of = |scene: &str, key: &str| {
        let mut rows = rows.as_array().expect("a list").iter();
        rows.find(|row| row["scene"] == scene && row["key"] == key).expect("a row").clone()
    };
    let damping = of("bump-stop", "damping_ratio");
    assert_eq!((&damping["lowest"], &damping["highest"]), (&0.0.into(), &0.9.into()));
    let stored = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/keys.csv"));
    assert_eq!(stored.ok(), Some(accepted(&["keys", "--format", "csv"])), "the printed is the stored");
    let schema: serde_json::Value =
        serde_json::from_str(&accepted(&["keys", "--format", "schema"])).expect("an object");
    assert_eq!(schema["oneOf"].as_array().map(Vec::len), Some(3));
    refused(&["keys", "cantilever"], &["cantilever", "sliding"]);
    refused(&["keys", "sliding", "--format", "schema"], &["--format schema"]);
}

#[test]
fn run_accepts_each_template() {
    let folder = folder("new");
    let names = ["contact-separation", "sliding", "bump-stop", "bump-stop-tip-mass", "rectified", "node"];
    for name in names {
        let file = &place(&folder, &format!("{name}.toml"));
        accepted(&["new", name, "--output", file]);
        let text = std::fs::read_to_string(file).expect("the template");
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        let outcome = json(&["run", file, "--no-accuracy", "--set", "run={settle_s=0,duration_s=0.2}"]);
        assert!(outcome["mean_power_w"].as_f64().is_some_and(|power| power >= 0.0), "{name}: {outcome}");
    }
    let first = &place(&folder, "sliding.toml");
    let text = std::fs::read_to_string(first).expect("the template");
    assert_eq!(text, accepted(&["new", "sliding"]));
    refused(&["new", "sliding", "--output", first], &["exists"]);
    refused(&["new", "cantilever"], &["cantilever", "rectified"]);
}

#[test]
fn the_shipped_scenes_name_the_schema() {
    let folder = Path::new(SHIPPED).parent().expect("a folder");
    for entry in std::fs::read_dir(folder).expect("scenes").map(|entry| entry.expect("a file").path()) {
        let is_toml = entry.extension().is_some_and(|extension| extension == "toml");
        if is_toml && !entry.ends_with("Cargo.toml") {
            let text = std::fs::read_to_string(&entry).expect("a scene");
            assert!(text.starts_with("#:schema scene.schema.json\n"), "{}", entry.display());
        }
    }
    accepted(&["keys"]);
}
