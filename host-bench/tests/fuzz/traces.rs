//! Recordings of arbitrary content, CSV and WAV: an error of one line, or a trace that is sound.

use std::fs;
use std::path::Path;

use arbtest::arbitrary::Unstructured;
use host_bench::scene_file;

use super::change::{self, any, below, one_of};
use super::scenes::{folder, judge};
use crate::fuzz;

/// Tables with the keys that suit them.
const TABLES: [(&[u8], &str); 6] = [
    (include_bytes!("corpus/one-column.csv"), "column = 1\nrate_hz = 100.0"),
    (include_bytes!("corpus/two-columns.csv"), "column = 2\ntime_column = 1"),
    (include_bytes!("corpus/decimal-commas.csv"), "column = \"x\"\ntime_column = \"t\""),
    (include_bytes!("corpus/tabs.csv"), "column = \"y\"\nrate_hz = 100.0\ntime_column = false"),
    (include_bytes!("corpus/quoted.csv"), "column = \"x\"\ntime_column = \"t\""),
    (include_bytes!("../../scenes/noise.csv"), "column = \"acceleration\"\nrate_hz = 48000"),
];
const WAVES: [&[u8]; 5] = [
    include_bytes!("corpus/pcm16.wav"),
    include_bytes!("corpus/pcm24-stereo.wav"),
    include_bytes!("corpus/pcm8.wav"),
    include_bytes!("corpus/pcm32-three.wav"),
    include_bytes!("corpus/float32.wav"),
];

/// A scene that is shaken by a recording beside it, four of five with the keys that suit it.
fn shaken_by(bytes: &mut Unstructured<'_>, recording: &str, usual: &str) -> String {
    let shipped = fs::read_to_string(scene_file::shipped("contact-separation")).expect("the shipped scene");
    let start = shipped.find("[excitation]").expect("the table is there");
    let columns = ["", "", "column = 1", "column = 0", "column = 2", "column = \"x\"", "column = 1e18"];
    let lines = [
        one_of(bytes, &columns),
        one_of(bytes, &["", "", "rate_hz = 100.0", "rate_hz = 1000.0", "rate_hz = 48000"]),
        one_of(bytes, &["", "", "resample_hz = 100.0", "resample_hz = 1e6\nlongest_gap_samples = 1000"]),
        one_of(bytes, &["", "", "time_column = 1", "time_column = false", "time_column = \"t\""]),
    ];
    let other = lines.join("\n");
    let keys = if below(bytes, 5) == 0 { &other } else { usual };
    format!(
        "{}[excitation]\nkind = \"file\"\npath = \"{recording}\"\nscale_m_per_s2 = 1.0\nrepeat = true\n{keys}\n[run]\nduration_s = 0.02\n",
        &shipped[..start],
    )
}

/// Writes a scene and its recording, and judges them; whether they were accepted.
fn is_taken(
    bytes: &mut Unstructured<'_>,
    folder: &Path,
    (name, usual): (&str, &str),
    recording: &[u8],
) -> bool {
    let file = folder.join("scene.toml");
    fs::write(folder.join(name), recording).expect("a file");
    fs::write(&file, shaken_by(bytes, name, usual)).expect("a file");
    judge(bytes, &file, &[]).is_some()
}

#[test]
fn tables() {
    let folder = folder("fuzz-tables");
    fuzz("CSV", 1000, |bytes| {
        let (table, usual) = TABLES[below(bytes, TABLES.len())];
        let recording = change::table(bytes, table);
        is_taken(bytes, &folder, ("table.csv", usual), &recording)
    });
}

#[test]
fn waves() {
    let folder = folder("fuzz-waves");
    fuzz("WAV", 1000, |bytes| {
        let mut recording = WAVES[below(bytes, WAVES.len())].to_vec();
        // Any data of integers is valid.
        let data = 44 + below(bytes, recording.len() - 44);
        recording[data] = any(bytes);
        // The header counts: its fields are small numbers and extremes.
        for _ in 0..if below(bytes, 4) == 0 { 1 + below(bytes, 3) } else { 0 } {
            let place = below(bytes, 44);
            let value = [0, 1, 2, 3, 8, 16, 24, 32, 33, 64, 0x7f, 0x80, 0xfe, 0xff][below(bytes, 14)];
            match below(bytes, 4) {
                0 => recording[place] ^= 1 << below(bytes, 8),
                1 => recording[place] = any(bytes),
                2 => recording[place] = value,
                _ => recording[20 + 2 * below(bytes, 8)] = value,
            }
        }
        if below(bytes, 12) == 0 {
            recording.truncate(below(bytes, recording.len()));
        }
        is_taken(bytes, &folder, ("wave.wav", "column = 1"), &recording)
    });
}
