//! Recorded accelerations that cannot be used.

use std::path::Path;

use super::tool::{SHIPPED, file, folder, refused};

/// A scene that is shaken by `trace.csv` beside it.
fn scene(folder: &Path, column: &str, more: &str) -> String {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let start = shipped.find("[excitation]").expect("the table is there");
    let text = format!(
        "{}[excitation]\nkind = \"file\"\npath = \"trace.csv\"\ncolumn = {column}\nrate_hz = 10.0\n\
         scale_m_per_s2 = 1.0\n{more}\n[run]\nduration_s = 0.3\n",
        &shipped[..start]
    );
    file(folder, "scene.toml", text)
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
        ("x\n1\n2\n3\n", "\"x\"", vec!["run.duration_s = 0.3", "0.2 s long", "repeat"]),
    ] {
        file(&folder, "trace.csv", data);
        let scene = scene(&folder, column, "");
        let mut all = vec![scene.as_str()];
        all.extend(parts);
        refused(&["run", &scene, "--method", "reference"], &all);
    }
}

#[test]
fn bad_keys() {
    let folder = folder("bad-trace-keys");
    file(&folder, "trace.csv", "x\n1\n2\n3\n4\n");
    let good = scene(&folder, "\"x\"", "");
    for (change, parts) in [
        ("excitation.path=absent.csv", ["excitation.path = \"absent.csv\"", "absent.csv"]),
        ("excitation.path=\"\"", ["excitation.path = \"\"", "excitation.path"]),
        ("excitation.path=1", ["excitation.path = 1", "name of a CSV or WAV file"]),
        ("excitation.repeat=1", ["excitation.repeat = 1", "true or false"]),
        ("excitation.amplitude_g=1", ["excitation.amplitude_g = 1", "unknown key"]),
        ("run.duration_s=0.31", ["run.duration_s = 0.31", "0.3 s long"]),
    ] {
        refused(&["run", &good, "--method", "reference", "--set", change], &parts);
    }
    let text = std::fs::read_to_string(&good).expect("just written");
    for (line, key) in [
        ("path = \"trace.csv\"", "excitation.path"),
        ("column = \"x\"", "excitation.column"),
        ("rate_hz = 10.0", "excitation.rate_hz"),
        ("scale_m_per_s2 = 1.0", "excitation.scale_m_per_s2"),
    ] {
        assert!(text.contains(line));
        let scene = file(&folder, "without.toml", text.replace(line, ""));
        refused(&["run", &scene, "--method", "reference"], &[key, "is missing"]);
    }
}
