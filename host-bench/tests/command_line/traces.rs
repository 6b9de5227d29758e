//! Recorded accelerations with a column of times, in WAV files, and those that cannot be used.

use std::path::Path;

use hound::{SampleFormat, WavSpec, WavWriter};

use super::tool::{SHIPPED, file, folder, outcome, refused};

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

/// Writes a WAV file of 400 samples a second: `channel` after others of nothing.
fn wave<S: hound::Sample + Copy + Default>(
    folder: &Path,
    channels: u16,
    bits_per_sample: u16,
    sample_format: SampleFormat,
    channel: &[S],
) {
    let spec = WavSpec { channels, sample_rate: 400, bits_per_sample, sample_format };
    let mut writer = WavWriter::create(folder.join("trace.wav"), spec).expect("a writable folder");
    for &sample in channel {
        (1..channels).for_each(|_| writer.write_sample(S::default()).expect("written"));
        writer.write_sample(sample).expect("written");
    }
    writer.finalize().expect("written");
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
        wave(&folder, 2, bits, SampleFormat::Int, &samples);
        let recorded = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 2"), &[]);
        assert_eq!(recorded["peak_gap_m"], peak_gap_by_table(&folder, &parts), "{bits} bits");
        let silent = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 1\nrate_hz = 400"), &[]);
        assert_eq!(silent["first_impact_s"], serde_json::Value::Null);
    }
    let floats: Vec<f32> = integers(24).iter().map(|&sample| sample as f32 / 8_388_608.0).collect();
    wave(&folder, 2, 32, SampleFormat::Float, &floats);
    let recorded = outcome(&scene(&folder, "path = \"trace.wav\"\ncolumn = 2"), &[]);
    let same: Vec<f64> = floats.iter().map(|&sample| f64::from(sample)).collect();
    assert_eq!(recorded["peak_gap_m"], peak_gap_by_table(&folder, &same));
    // One channel needs no column.
    wave(&folder, 1, 32, SampleFormat::Float, &floats);
    assert_eq!(outcome(&scene(&folder, "path = \"trace.wav\""), &[])["peak_gap_m"], recorded["peak_gap_m"]);
}

#[test]
fn bad_wave_files() {
    let folder = folder("bad-waves");
    wave(&folder, 2, 16, SampleFormat::Int, &integers(16));
    for (keys, parts) in [
        ("column = 3", ["excitation.column = 3", "from 1 to 2"]),
        ("column = \"x\"", ["excitation.column = \"x\"", "number of a channel"]),
        ("column = 2\nrate_hz = 401", ["excitation.rate_hz = 401", "must be 400"]),
        ("column = 2\ntime_column = 1", ["excitation.time_column = 1", "unknown key"]),
        ("column = 2\nresample_hz = 400", ["excitation.resample_hz = 400", "unknown key"]),
        ("", ["excitation.column: is missing", "from 1 to 2"]),
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
    wave(&folder, 2, 16, SampleFormat::Int, &integers(16)[..1]);
    refused(&["run", &good, "--method", "reference"], &["excitation.path", "frame 1", "1 samples"]);
    wave(&folder, 2, 32, SampleFormat::Float, &[0.0, f32::NAN, 0.0]);
    refused(&["run", &good, "--method", "reference"], &["excitation.path", "frame 1", "NaN"]);
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
        ("Acceleration (G)", 0.2, ""),
    ] {
        let found = gap(&peak(heading, factor, scale));
        assert!((found / expected - 1.0).abs() < 1e-9, "{heading}: {found} {expected}");
    }
    let contradicted = peak("Acceleration (g)", 0.2, "scale_m_per_s2 = 1.0");
    refused(
        &["run", &contradicted],
        &["excitation.scale_m_per_s2 = 1", "must be 9.81", "\"Acceleration (g)\""],
    );
    // A unit that is not known is no factor 1.
    let unknown = peak("Acceleration (furlong/s²)", 0.2, "scale_m_per_s2 = 1.0");
    refused(&["run", &unknown], &["excitation.path", "\"Acceleration (furlong/s²)\"", "must be g, mg, m/s²"]);
    let unknown = peak("Acceleration (V)", 0.2, "");
    refused(&["run", &unknown], &["excitation.scale_m_per_s2", "is missing", "(m/s²)"]);
}

/// A scene that is shaken by `trace.csv` beside it.
fn by_column(folder: &Path, column: &str) -> String {
    scene(folder, &format!("path = \"trace.csv\"\ncolumn = {column}\nrate_hz = 10.0"))
}

#[test]
fn bad_data() {
    let folder = folder("bad-traces");
    let long = "x\n1\n".to_owned() + &"2\n".repeat(3);
    for (data, column, parts) in [
        ("", "\"x\"", vec!["excitation.path", "line 1", "0 samples", "at least 2"]),
        ("x\n", "\"x\"", vec!["excitation.path", "line 2", "0 samples"]),
        ("x\n1\n", "\"x\"", vec!["excitation.path", "line 3", "1 samples"]),
        ("x\n1\n2\nthree\n4\n", "\"x\"", vec!["excitation.path", "line 4", "\"three\" is not a number"]),
        ("1\n2\nthree\n4\n", "1", vec!["excitation.path", "line 3", "\"three\" is not a number"]),
        ("x\n1\nnan\n3\n4\n", "\"x\"", vec!["excitation.path", "line 3", "NaN", "within 1e5"]),
        ("x\n1\ninf\n3\n4\n", "\"x\"", vec!["excitation.path", "line 3", "inf", "within 1e5"]),
        ("x\n1\n1e6\n3\n4\n", "\"x\"", vec!["excitation.path", "line 3", "1000000", "within 1e5"]),
        ("x,y\n1,2\n3\n4,5\n5,6\n", "\"y\"", vec!["excitation.column = \"y\"", "line 3", "1 columns"]),
        ("x,y\n1,2\n3,4\n", "\"z\"", vec!["excitation.column = \"z\"", "no such column", "\"x\", \"y\""]),
        ("x\n1\n2\n3\n4\n", "2", vec!["excitation.column = 2", "1 columns"]),
        ("x\n1\n\"\"\n3\n4\n", "\"x\"", vec!["excitation.path", "line 3", "\"\" is not a number"]),
        (long.as_str(), "0", vec!["excitation.column = 0", "number from 1"]),
        (long.as_str(), "-1", vec!["excitation.column = -1", "number from 1"]),
        (long.as_str(), "1.5", vec!["excitation.column = 1.5", "number from 1"]),
        (long.as_str(), "true", vec!["excitation.column = true", "number from 1"]),
        ("x\n1\n2\n3\n", "\"x\"", vec!["run.duration_s = 0.5", "0.2 s long", "repeat"]),
    ] {
        file(&folder, "trace.csv", data);
        let scene = by_column(&folder, column);
        refused(&["run", &scene, "--method", "reference"], &[&[scene.as_str()], &parts[..]].concat());
    }
}

#[test]
fn bad_keys() {
    let folder = folder("bad-trace-keys");
    file(&folder, "trace.csv", "x\n1\n2\n3\n4\n5\n6\n");
    let good = by_column(&folder, "\"x\"");
    for (change, parts) in [
        ("excitation.path=absent.csv", ["excitation.path = \"absent.csv\"", "absent.csv"]),
        ("excitation.path=\"\"", ["excitation.path = \"\"", "excitation.path"]),
        ("excitation.path=1", ["excitation.path = 1", "name of a CSV or WAV file"]),
        ("excitation.repeat=1", ["excitation.repeat = 1", "true or false"]),
        ("excitation.amplitude_g=1", ["excitation.amplitude_g = 1", "unknown key"]),
        ("run.duration_s=0.51", ["run.duration_s = 0.51", "0.5 s long"]),
        ("excitation.longest_gap_samples=3", ["longest_gap_samples = 3", "beside resample_hz"]),
        ("excitation.resample_hz=10", ["excitation.resample_hz", "must have a column of times"]),
    ] {
        refused(&["run", &good, "--method", "reference", "--set", change], &parts);
    }
    let text = std::fs::read_to_string(&good).expect("just written");
    for (line, key) in [
        ("path = \"trace.csv\"", "excitation.path"),
        ("column = \"x\"", "excitation.column"),
        ("rate_hz = 10.0", "excitation.rate_hz"),
        ("scale_m_per_s2 = 1.962", "excitation.scale_m_per_s2"),
    ] {
        assert!(text.contains(line));
        let scene = file(&folder, "without.toml", text.replace(line, ""));
        refused(&["run", &scene, "--method", "reference"], &[key, "is missing"]);
    }
}
