//! What an error or a warning says of the way out: slips of the command line, wrong units, coarse recordings.

use std::fmt::Write;

use serde_json::Value;

use super::tool::{BUMP_STOP, PASSIVE, SHIPPED, file, folder, host_bench, json, number, refused, set};

const OVER: [&str; 2] = ["--over", "load.resistance_ohm=1e6:1e8"];

#[test]
fn a_key_without_its_table_and_one_that_is_misspelt() {
    refused(
        &["run", SHIPPED, "--set", "resistance_ohm=1e6"],
        &["--set resistance_ohm = 1e6: unknown key", "did you mean load.resistance_ohm?"],
    );
    refused(
        &["sweep", SHIPPED, "--over", "frequency_hz=19:20:2"],
        &["--over frequency_hz = 19.0: unknown key", "did you mean excitation.frequency_hz?"],
    );
    refused(
        &["run", SHIPPED, "--set", "load.resistence_ohm=1e6"],
        &["load.resistence_ohm = 1e6: unknown key, probably resistance_ohm misspelt"],
    );
    // Another unit, with or without a slip, in the table of the key and in none.
    for (scene, change, part) in [
        (SHIPPED, "load.resistance_kohm=33", "probably resistance_ohm misspelt, in Ω and not in kohm: 3"),
        (SHIPPED, "load.resistence_kohm=33", "probably resistance_ohm misspelt, in Ω and not in kohm: 3"),
        (SHIPPED, "excitation.freqency_khz=1", "probably frequency_hz misspelt, in Hz and not in khz: 1"),
        (BUMP_STOP, "stop.gpa_mm=5", "probably gap_m misspelt, in m and not in mm: 5e-3"),
        (SHIPPED, "run.duration_min=1", "probably duration_s misspelt, in s and not in min;"),
        (SHIPPED, "mass_g=5", "did you mean parameters.mass_kg, in kg and not in g: 5e-3?"),
    ] {
        refused(&["run", scene, "--set", change], &[part]);
    }
    let over = ["sweep", BUMP_STOP, "--over", "stop.gap_mm=1m:5m:5"];
    refused(&over, &["stop.gap_mm is an unknown key, probably gap_m misspelt, the command keys lists all"]);
    refused(
        &["run", SHIPPED, "--set", "load.resistance_ohm=10V"],
        &["load.resistance_ohm = \"10V\": must be", "in Ω with a prefix or without, not in V"],
    );
    // Only keys of the scene's own kinds.
    let output = host_bench(&["run", SHIPPED, "--set", "beam_modes=2"]);
    let told = String::from_utf8(output.stderr).expect("text");
    assert!(told.contains("unknown key") && !told.contains("did you mean"), "{told}");
}

#[test]
fn a_word_in_place_of_a_command() {
    refused(&["motor.toml"], &["motor.toml: must be a command", "run motor.toml"]);
    refused(&["sweeep", SHIPPED], &["sweeep", "similar", "'sweep'"]);
    refused(&["run", SHIPPED, "--toleranse", "1e-3"], &["--toleranse", "similar", "'--tolerance'"]);
    refused(&[&["optimise", SHIPPED], &OVER[..]].concat(), &["--maximise", "--minimise"]);
    // The other spelling.
    let known = ["optimize", SHIPPED, "--maximize", "processor_s", "--grid", "3"];
    refused(&[&known[..], &OVER].concat(), &["--maximise processor_s", "a time of this computer"]);
    let known = ["optimise", SHIPPED, "--minimize", "processor_s", "--grid", "3"];
    refused(&[&known[..], &OVER].concat(), &["--minimise processor_s", "a time of this computer"]);
}

/// The result of a run, with its warnings.
#[track_caller]
fn run(scene: &str, options: &[&str]) -> (Value, String) {
    let found = json(&[&["run", scene], options].concat());
    let warnings = found["warnings"].to_string();
    (found, warnings)
}

#[test]
fn a_mass_in_grams_shakes_far_from_the_resonance() {
    let short = ["--no-accuracy", "--set", "run={duration_s=1.0,settle_s=0.5}"];
    let (found, warnings) = run(PASSIVE, &[&short[..], &["--set", "parameters.mass_kg=5.0"]].concat());
    let natural = (80.0_f64 / 5.0).sqrt() / std::f64::consts::TAU;
    assert!((number(&found, "natural_frequency_hz") / natural - 1.0).abs() < 1e-12);
    let apart = format!(
        "excitation.frequency_hz = 20.5 is a factor of {:.1} from the natural frequency of {natural:.4} Hz",
        20.5 / natural
    );
    assert!(warnings.contains(&apart) && warnings.contains("parameters.mass_kg"), "{warnings}");
    assert!(!warnings.contains("accuracy:"), "the numbers are right for that mass: {warnings}");
    let (_, warnings) = run(PASSIVE, &short);
    assert!(!warnings.contains("natural frequency"), "{warnings}");
}

#[test]
fn an_error_above_the_value_is_not_a_value() {
    // A step of a quarter of a period.
    let few = ["--set", "parameters.beam_modes=2", "--set", "stop.rod_modes=0"];
    let coarse = [&["--step", "1e-3", "--set", "run={duration_s=0.1,settle_s=0.05}"], &few[..]].concat();
    let (found, warnings) = run(BUMP_STOP, &coarse);
    let total = number(&found["accuracy"], "total");
    assert!(total > 1.0, "{total}");
    assert!(
        warnings.contains("accuracy: the mean power cannot be determined: the estimated relative error"),
        "{warnings}"
    );
    assert!(warnings.contains("a longer run.duration_s may help"), "{warnings}");
}

#[test]
fn a_coarse_recording_is_told_how_many_samples_it_needs() {
    let folder = folder("coarse-recording");
    let mut samples = String::from("a\n");
    for row in 0..=300 {
        let _ = writeln!(samples, "{}", (std::f64::consts::TAU * 20.1 * 0.01 * f64::from(row)).sin());
    }
    file(&folder, "recorded.csv", samples);
    let table = "path = \"recorded.csv\"\nrate_hz = 100\ncolumn = 1";
    let changes = ["run={duration_s=3.0,settle_s=1.0}", "excitation.scale_m_per_s2=0.2"];
    let (_, warnings) = run(&super::traces::scene(&folder, table), &set(&changes));
    let natural = (80.0_f64 / 5e-3).sqrt() / std::f64::consts::TAU;
    assert!(warnings.contains("by the sampling of the trace"), "{warnings}");
    let told = format!(
        "100 Hz are {:.1} samples in a period of the natural frequency of {natural:.4} Hz",
        100.0 / natural
    );
    assert!(warnings.contains("a higher sampling rate helps: ") && warnings.contains(&told), "{warnings}");
}
