//! Runs the binary.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The paths of shipped scenes.
macro_rules! scenes {
    ($($name:ident $file:literal)+) => {
        $(pub(super) const $name: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/", $file, ".toml");)+
    };
}
scenes! {
    SHIPPED "contact-separation"
    // The same harvester under the force of the field, which conserves energy.
    PASSIVE "contact-separation-passive"
    TRUCK "contact-separation-truck"
    RECTIFIED "rectified"
    SLIDING "sliding"
    BUMP_STOP "bump-stop"
    TIP "bump-stop-tip"
    MID_SPAN "bump-stop-mid-span"
    // Without a stop.
    BEAM "bump-stop-none"
    LOADED "bump-stop-tip-mass"
    BIMORPH "bimorph-erturk-inman"
    NODE "node"
    // Measurements that SciPy made, and those of a program with one mode of the beam and a spring.
    MEASURED "measured/contact-separation"
    STOPPED "measured/bump-stop"
}

/// A fresh folder for one test.
pub(super) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // Left over from an earlier run, if it is there.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    folder
}

/// A file in that folder.
pub(super) fn file(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> String {
    let path = place(folder, name);
    fs::write(&path, content).expect("a temporary file");
    path
}

/// The path of a file in that folder, which need not be there.
pub(super) fn place(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("a plain path").to_owned()
}

/// The option `--set` for each change.
pub(super) fn set<'a>(changes: &[&'a str]) -> Vec<&'a str> {
    changes.iter().flat_map(|change| ["--set", change]).collect()
}

pub(super) fn host_bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-bench")).args(arguments).output().expect("the binary starts")
}

/// Runs what must be refused: exit code 2, nothing on standard output, and one line on standard error
/// that holds all of `parts`.
#[track_caller]
pub(super) fn refused(arguments: &[&str], parts: &[&str]) {
    let output = host_bench(arguments);
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(output.stdout.is_empty(), "{arguments:?} printed a result");
    assert!(told.ends_with('\n') && told.lines().count() == 1, "{arguments:?}: more than a line: {told}");
    assert!(!told.contains("panicked"), "{arguments:?}: {told}");
    for part in parts {
        assert!(told.contains(part), "{arguments:?}: {part:?} is not in {told}");
    }
}

/// Runs the shipped scene on the reference with some overrides; it must be refused.
#[track_caller]
pub(super) fn refused_with(overrides: &[&str], parts: &[&str]) {
    refused_scene(SHIPPED, overrides, parts);
}

/// The same of another scene.
#[track_caller]
pub(super) fn refused_scene(scene: &str, overrides: &[&str], parts: &[&str]) {
    refused(&[&["run", scene, "--method", "reference"], &set(overrides)[..]].concat(), parts);
}

/// Runs what must succeed and gives its standard output.
#[track_caller]
pub(super) fn accepted(arguments: &[&str]) -> String {
    printed(arguments)[0].clone()
}

/// The standard output of what must succeed, and what stands on standard error.
#[track_caller]
pub(super) fn printed(arguments: &[&str]) -> [String; 2] {
    let output = host_bench(arguments);
    let told = unfolded(output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    [String::from_utf8(output.stdout).expect("text"), told]
}

/// Standard error with each message in one line. All but errors are folded at 100 columns.
#[track_caller]
pub(super) fn unfolded(told: Vec<u8>) -> String {
    let told = String::from_utf8(told).expect("text");
    let is_wide = |line: &&str| line.chars().count() > 100 && line.trim().contains(' ');
    assert_eq!(told.lines().filter(|line| !line.starts_with("error: ")).find(is_wide), None);
    told.replace("\n  ", " ")
}

/// The JSON of what must succeed.
#[track_caller]
pub(super) fn json(arguments: &[&str]) -> Value {
    json_and_told(arguments).0
}

/// The JSON of what must succeed, and what stands on standard error.
#[track_caller]
pub(super) fn json_and_told(arguments: &[&str]) -> (Value, String) {
    let [found, told] = printed(&[arguments, &["--format", "json"]].concat());
    (serde_json::from_str(&found).expect("one JSON value"), told)
}

/// The charts of a page.
pub(super) fn charts(page: &str) -> Value {
    let data = page.split("const charts = ").nth(1).and_then(|rest| rest.split(";\n").next());
    serde_json::from_str(data.expect("charts")).expect("JSON")
}

/// The rows of CSV, each with its cells by the heading.
pub(super) fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    rows.map(|row| row.expect("a row")).collect()
}

/// The JSON object of a short run on the reference with some overrides.
#[track_caller]
pub(super) fn outcome(scene: &str, overrides: &[&str]) -> Value {
    json(&[&["run", scene, "--method", "reference"], &set(overrides)[..]].concat())
}

/// Asserts that the object of a run has the keys of the contract in their order; the created energy where its force law may
/// create some, and those of its kind.
#[track_caller]
pub(super) fn has_keys(found: &Value, creates: bool, of_kind: &str) {
    let created = if creates { "created_energy_j created_energy_share" } else { "" };
    let wanted = format!(
        "scene method precision math duration_s settle_s mean_power_w mean_power_standard_error_w rms_voltage_v peak_voltage_v \
         mean_voltage_v delivered_energy_j {created} energy_residual steps rejected_steps newton_iterations events processor_s \
         accuracy branches limits smallest_margin impossible_margin warnings {of_kind}"
    );
    let keys: Vec<&str> = found.as_object().expect("an object").keys().map(String::as_str).collect();
    assert_eq!(keys, wanted.split_whitespace().collect::<Vec<_>>());
}

/// A number of an outcome.
pub(super) fn number(outcome: &Value, key: &str) -> f64 {
    outcome[key].as_f64().unwrap_or_else(|| panic!("{key} is a number in {outcome}"))
}
