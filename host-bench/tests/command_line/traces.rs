//! Recorded accelerations with a column of times, and in WAV files.

use std::path::{Path, PathBuf};

use hound::{SampleFormat, WavSpec, WavWriter};

use super::tool::{SHIPPED, accepted, file, folder, outcome, refused};

/// A scene that is shaken as `table` says, for half a second.
pub(super) fn scene(folder: &Path, table: &str) -> String {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let start = shipped.find("[excitation]").expect("the table is there");
    let text = format!(
        "{}[excitation]\nkind = \"file\"\nscale_m_per_s2 = 1.962\n{table}\n[run]\nduration_s = 0.5\n",
        &shipped[..start]
    );
    file(folder, "scene.toml", text)
}

/// A sine of 10 Hz at 400 samples a second, as integers of so many bits.
fn integers(bits: u16) -> Vec<i32> {
    let full = f64::from(bits - 1).exp2() - 1.0;
    (0..=200).map(|at| ((0.05 * std::f64::consts::PI * f64::from(at)).sin() * full).round() as i32).collect()
}

/// Writes a WAV file of 400 samples a second: one channel of nothing, and `channel`.
fn wave<S: hound::Sample + Copy + Default>(
    folder: &Path,
    bits_per_sample: u16,
    sample_format: SampleFormat,
    channel: &[S],
) -> PathBuf {
    let path = folder.join("trace.wav");
    let spec = WavSpec { channels: 2, sample_rate: 400, bits_per_sample, sample_format };
    let mut writer = WavWriter::create(&path, spec).expect("a writable folder");
    for &sample in channel {
        writer.write_sample(S::default()).expect("written");
        writer.write_sample(sample).expect("written");
    }
    writer.finalize().expect("written");
    path
}

/// The largest gap of a run that is shaken by a column of these numbers.
fn peak_gap_by_table(folder: &Path, numbers: &[f64]) -> serde_json::Value {
    let rows: String = numbers.iter().map(|number| format!("{number:e}\n")).collect();
    file(folder, "trace.csv", rows);
    outcome(&scene(folder, "path = \"trace.csv\"\ncolumn = 1\nrate_hz = 400"), &[])["peak_gap_m"].clone()
}

#[test]
fn a_wave_file_shakes_as_a_table_of_the_same_numbers_does() {
    let folder = folder("waves");
    for bits in [8, 16, 24, 32] {
        let samples = integers(bits);
        let full_scale = f64::from(bits - 1).exp2();
        let parts: Vec<f64> = samples.iter().map(|&sample| f64::from(sample) / full_scale).collect();
        wave(&folder, bits, SampleFormat::Int, &samples);
        let recorded = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 2"), &[]);
        assert_eq!(recorded["peak_gap_m"], peak_gap_by_table(&folder, &parts), "{bits} bits");
        let silent = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 1\nrate_hz = 400"), &[]);
        assert_eq!(silent["first_impact_s"], serde_json::Value::Null);
    }
    let floats: Vec<f32> = integers(24).iter().map(|&sample| sample as f32 / 8_388_608.0).collect();
    wave(&folder, 32, SampleFormat::Float, &floats);
    let recorded = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 2"), &[]);
    let same: Vec<f64> = floats.iter().map(|&sample| f64::from(sample)).collect();
    assert_eq!(recorded["peak_gap_m"], peak_gap_by_table(&folder, &same));
}

#[test]
fn bad_wave_files() {
    let folder = folder("bad-waves");
    wave(&folder, 16, SampleFormat::Int, &integers(16));
    for (keys, parts) in [
        ("column = 3", ["excitation.column = 3", "from 1 to 2"]),
        ("column = \"x\"", ["excitation.column = \"x\"", "number of a channel"]),
        ("column = 2\nrate_hz = 401", ["excitation.rate_hz = 401", "must be 400"]),
        ("column = 2\ntime_column = 1", ["excitation.time_column = 1", "unknown key"]),
    ] {
        let scene = scene(&folder, &format!("path = \"trace.wav\"\n{keys}"));
        refused(&["run", &scene, "--method", "reference"], &parts);
    }
    let good = scene(&folder, "path = \"trace.wav\"\ncolumn = 2");
    let whole = std::fs::read(folder.join("trace.wav")).expect("just written");
    let cut = |length: usize| file(&folder, "trace.wav", &whole[..length]);
    for length in [0, 30, whole.len() - 300] {
        cut(length);
        refused(&["run", &good, "--method", "reference"], &["excitation.path = \"trace.wav\""]);
    }
    wave(&folder, 16, SampleFormat::Int, &integers(16)[..1]);
    refused(&["run", &good, "--method", "reference"], &["excitation.path", "frame 1", "1 samples"]);
    wave(&folder, 32, SampleFormat::Float, &[0.0, f32::NAN, 0.0]);
    refused(&["run", &good, "--method", "reference"], &["excitation.path", "frame 1", "NaN"]);
}

/// Rows of a time and a number at 10 Hz, with the times as `printed` gives them.
fn timed(printed: impl Fn(f64) -> String) -> String {
    (0..8).map(|row| format!("{},{row}\n", printed(0.1 * f64::from(row)))).collect()
}

#[test]
fn a_column_of_times_is_checked() {
    let folder = folder("timed-traces");
    let scene = |clock: &str| {
        let keys = format!("path = \"trace.csv\"\ncolumn = 2\nrate_hz = 10\ntime_column = {clock}");
        scene(&folder, &keys)
    };
    let run = |clock: &str, data: String| {
        file(&folder, "trace.csv", data);
        accepted(&["run", &scene(clock), "--method", "reference"]);
    };
    run("1", timed(|time| format!("{time}")));
    // From any time on, a little rounded.
    run("\"t\"", "t,x\n".to_owned() + &timed(|time| format!("{:.2}", 1234.567 + time)));
    let late = timed(|time| format!("{}", if time > 0.45 { time + 0.05 } else { time }));
    let drifting = timed(|time| format!("{}", 1.06 * time));
    for (data, clock, parts) in [
        (late, "1", vec!["excitation.time_column = 1", "line 6", "must be 0.5 s", "rate_hz = 10"]),
        (drifting, "1", vec!["excitation.time_column = 1", "line 6", "must be 0.5 s"]),
        ("0,1\nnan,2\n0.2,3\n".to_owned(), "1", vec!["excitation.time_column", "line 2", "NaN"]),
        (
            "0,1\nnoon,2\n0.2,3\n".to_owned(),
            "1",
            vec!["excitation.path", "line 2", "\"noon\" is not a number"],
        ),
        ("0,1\n0.1,2\n".to_owned(), "3", vec!["excitation.time_column = 3", "line 1", "2 columns"]),
        (
            "s,x\n0.1,2\n".to_owned(),
            "\"t\"",
            vec!["excitation.time_column = \"t\"", "line 1", "\"s\", \"x\""],
        ),
        ("0,1\n".to_owned(), "0", vec!["excitation.time_column = 0", "number from 1"]),
    ] {
        file(&folder, "trace.csv", data);
        refused(&["run", &scene(clock), "--method", "reference"], &parts);
    }
}

#[test]
fn the_unit_of_a_heading_counts() {
    let folder = folder("headings");
    let peak = |heading: &str, factor: f64, scale: &str| {
        let row = |at: u32| (0.05 * std::f64::consts::PI * f64::from(at)).sin() * factor;
        let rows: String =
            (0..=200).map(|at| format!("{},{:e}\n", 2.5e-3 * f64::from(at), row(at))).collect();
        file(&folder, "trace.csv", format!("Time (s),{heading}\n{rows}"));
        let text = std::fs::read_to_string(scene(&folder, "path = \"trace.csv\"")).expect("written");
        file(&folder, "scene.toml", text.replace("scale_m_per_s2 = 1.962", scale))
    };
    let gap = |scene: &str| outcome(scene, &[])["peak_gap_m"].as_f64().expect("a gap");
    let expected = gap(&peak("x", 1.962, "scale_m_per_s2 = 1.0"));
    for (heading, factor, scale) in [
        ("Acceleration (g)", 0.2, ""),
        ("Beschleunigung (g)", 0.2, ""),
        ("Beschleunigung (g)", 0.2, "scale_m_per_s2 = 9.81"),
        ("acceleration_m_per_s2", 1.962, ""),
        ("a [mm/s²]", 1962.0, ""),
    ] {
        let found = gap(&peak(heading, factor, scale));
        assert!((found / expected - 1.0).abs() < 1e-9, "{heading}: {found} {expected}");
    }
    let contradicted = peak("Acceleration (g)", 0.2, "scale_m_per_s2 = 1.0");
    refused(
        &["run", &contradicted],
        &["excitation.scale_m_per_s2 = 1", "must be 9.81", "\"Acceleration (g)\""],
    );
    let unknown = peak("Acceleration (V)", 0.2, "");
    refused(&["run", &unknown], &["excitation.scale_m_per_s2", "is missing", "(m/s²)"]);
}
