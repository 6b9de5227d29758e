//! Runs the binary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The scene that is shipped.
pub(super) const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/contact-separation.toml");

/// The same harvester under the force of the field, which conserves energy.
pub(super) const PASSIVE: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/contact-separation-passive.toml");

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
    let path = folder.join(name);
    fs::write(&path, content).expect("a temporary file");
    path.to_str().expect("a plain path").to_owned()
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
    let mut arguments = vec!["run", scene, "--method", "reference"];
    arguments.extend(overrides.iter().flat_map(|change| ["--set", change]));
    refused(&arguments, parts);
}

/// Runs what must succeed and gives its standard output.
#[track_caller]
pub(super) fn accepted(arguments: &[&str]) -> String {
    let output = host_bench(arguments);
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    String::from_utf8(output.stdout).expect("text")
}

/// The JSON object of a short run on the reference with some overrides.
#[track_caller]
pub(super) fn outcome(scene: &str, overrides: &[&str]) -> serde_json::Value {
    let mut arguments = vec!["run", scene, "--method", "reference", "--format", "json"];
    arguments.extend(overrides.iter().flat_map(|change| ["--set", change]));
    serde_json::from_str(&accepted(&arguments)).expect("one JSON object")
}

/// A number of an outcome.
pub(super) fn number(outcome: &serde_json::Value, key: &str) -> f64 {
    outcome[key].as_f64().unwrap_or_else(|| panic!("{key} is a number in {outcome}"))
}
