//! Scene files and overrides: an error of one line, or a scene that is sound and runs.

use std::fs;
use std::path::{Path, PathBuf};

use arbtest::arbitrary::Unstructured;
use host_bench::method::{Options, Precision};
use host_bench::outcome::fields;
use host_bench::run::run_scene;
use host_bench::scene_file::{self, Excitation, Model, Override, Scene};

use super::change::{self, any, below};
use crate::fuzz;

/// Attempted steps of a run of a triboelectric scene, and simulated seconds of any.
const MOST_STEPS: u64 = 300;
const SECONDS: f64 = 2e-3;

/// A folder of one target, with the recording of the shipped scenes.
pub(super) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("a folder");
    fs::copy(scene_file::shipped("noise").with_extension("csv"), folder.join("noise.csv")).expect("a copy");
    folder
}

/// The shipped scenes.
fn texts() -> Vec<String> {
    let mut texts = Vec::new();
    let shipped = scene_file::shipped("node").parent().expect("a folder").to_owned();
    for folder in [shipped.join("measured"), shipped] {
        for entry in fs::read_dir(folder).expect("the shipped scenes") {
            let path = entry.expect("an entry").path();
            let is_toml = path.extension().is_some_and(|extension| extension == "toml");
            if is_toml && !path.ends_with("Cargo.toml") {
                texts.push(fs::read_to_string(path).expect("a scene"));
            }
        }
    }
    texts.sort();
    texts
}

#[track_caller]
fn one_line(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    assert!(!text.is_empty() && !text.contains(['\n', '\r']), "{text:?}");
}

/// Reads a scene. An error is one line; a scene is sound, the same if it is read again, and runs.
pub(super) fn judge(bytes: &mut Unstructured<'_>, file: &Path, overrides: &[Override]) -> Option<Scene> {
    let scene = match scene_file::read(file, overrides) {
        Ok(scene) => scene,
        Err(error) => {
            one_line(&error);
            return None;
        }
    };
    let numbers = format!("{scene:?}");
    assert!(!numbers.contains("NaN"), "{numbers}");
    assert!(scene.run.duration_s > 0.0 && scene.run.duration_s.is_finite(), "{numbers}");
    assert!((0.0..scene.run.duration_s).contains(&scene.run.settle_s), "{numbers}");
    if let Excitation::File(trace) = &scene.excitation {
        let samples = &trace.samples_m_per_s2;
        assert!(samples.len() >= 2 && samples.iter().all(|sample| sample.abs() <= 1e5), "{numbers}");
        assert!(trace.rate_hz > 0.0 && trace.rate_hz.is_finite(), "{numbers}");
    }
    assert!(scene_file::files(file, overrides).is_ok(), "{numbers}");
    assert_eq!(scene_file::read(file, overrides).as_ref(), Ok(&scene));
    if below(bytes, 4) == 0 {
        run(bytes, &scene);
    }
    Some(scene)
}

/// The first moments of a run: numbers, or an error of one line.
fn run(bytes: &mut Unstructured<'_>, scene: &Scene) {
    let mut scene = scene.clone();
    let longest = if matches!(scene.model, Model::BumpStop(_)) { SECONDS } else { 10.0 * SECONDS };
    scene.run.duration_s = scene.run.duration_s.min(longest);
    scene.run.settle_s = 0.0;
    let precision = Some(if any(bytes) { Precision::F32 } else { Precision::F64 });
    let options = Options { precision, most_attempts: Some(MOST_STEPS), ..Options::default() };
    match run_scene(&scene, &options) {
        Ok(outcome) => assert!(!fields(&outcome).is_empty()),
        Err(failure) => one_line(&failure),
    }
}

#[test]
fn scene_files() {
    let (folder, texts) = (folder("fuzz-scenes"), texts());
    let file = folder.join("scene.toml");
    fuzz("scene files", 500, |bytes| {
        let text = &texts[below(bytes, texts.len())];
        let changed = change::scene(bytes, text.as_bytes());
        fs::write(&file, &changed).expect("a file");
        let Some(scene) = judge(bytes, &file, &[]) else { return false };
        // Comments and line ends mean nothing.
        let text = String::from_utf8(changed).expect("accepted, so it is text");
        if any(bytes) && !text.contains('\r') && !text.contains("\"\"\"") && !text.contains("'''") {
            let other = format!("\u{feff}# a comment\r\n{}\r\n# and one", text.replace('\n', "\r\n"));
            fs::write(&file, other).expect("a file");
            assert_eq!(scene_file::read(&file, &[]).as_ref(), Ok(&scene), "{text}");
        }
        true
    });
}

/// The keys of a scene with their values, as overrides.
fn settings(text: &str) -> Vec<String> {
    let (mut table, mut found) = (String::new(), Vec::new());
    for line in text.lines().map(|line| line.split('#').next().unwrap_or_default().trim()) {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            table = format!("{name}.");
        } else if let Some((key, value)) = line.split_once('=').filter(|_| !table.starts_with('[')) {
            found.push(format!("{table}{}={}", key.trim(), value.trim()));
        }
    }
    found
}

#[test]
fn overrides() {
    let (folder, texts) = (folder("fuzz-overrides"), texts());
    let file = folder.join("scene.toml");
    let all: Vec<String> = texts.iter().flat_map(|text| settings(text)).collect();
    fuzz("overrides", 400, |bytes| {
        let text = &texts[below(bytes, texts.len())];
        fs::write(&file, text).expect("a file");
        let own = settings(text);
        let mut overrides = Vec::new();
        for _ in 0..1 + below(bytes, 3) {
            let from = if below(bytes, 10) == 0 { &all } else { &own };
            let setting = &from[below(bytes, from.len())];
            match change::set(bytes, setting).parse::<Override>() {
                Ok(change) => overrides.push(change),
                Err(error) => one_line(&error),
            }
        }
        judge(bytes, &file, &overrides).is_some()
    });
}
