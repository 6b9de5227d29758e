//! Values that make no sense; each key by its bounds, and tables with an unknown key, are in the tests of the scene files.

use super::tool::{SHIPPED, file, folder, refused, refused_with};

#[test]
fn a_bridge_without_its_numbers() {
    for (change, key) in [
        ("load={kind='rectified-store'}", "load.capacitance_f: is missing"),
        ("load={kind='dc-bus'}", "load.voltage_v: is missing"),
        ("load={kind='dc-bus',voltage_v=3.0}", "load.diode_drop_v: is missing"),
        ("load={kind='dc-bus',voltage_v=-1.0,diode_drop_v=0.3}", "load.voltage_v = -1"),
    ] {
        refused_with(&[change], &[key, "a number from"]);
    }
}

#[test]
fn a_draw_that_has_no_consistent_switching() {
    let store = "capacitance_f=1e-6,diode_drop_v=0.3,leakage_ohm=inf,initial_v=0.0";
    for (draw, told) in [
        ("{kind='power',value=1e-6,turn_on_v=3.0,turn_off_v=0.0}", "load.draw.turn_off_v = 0"),
        ("{kind='power',value=1e-6,turn_on_v=2.0,turn_off_v=2.0}", "must be below turn_on_v = 2"),
        ("{kind='current',value=1e-6,turn_on_v=2.0,turn_off_v=3.0}", "must be below turn_on_v = 2"),
        ("{kind='current',value=1e-6}", "load.draw.turn_on_v: is missing"),
        ("{kind='lamp'}", "\"none\" or \"resistor\" or \"current\" or \"power\""),
    ] {
        refused_with(&[&format!("load={{kind='rectified-store',{store},draw={draw}}}")], &[told]);
    }
}

#[test]
fn a_missing_table_is_named() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("missing-keys");
    for table in ["parameters", "load", "excitation", "run"] {
        let start = shipped.find(&format!("[{table}]")).expect("the table is there");
        let rest = &shipped[start + 1..];
        let end = rest.find("\n[").map_or(shipped.len(), |end| start + 1 + end);
        let scene = file(&folder, "scene.toml", format!("{}{}", &shipped[..start], &shipped[end..]));
        refused(&["run", &scene, "--method", "reference"], &[&scene, table, "is missing"]);
    }
}

#[test]
fn numbers_that_do_not_fit_together() {
    refused_with(&["run.settle_s=15"], &["run.settle_s = 15", "before the end of the run at 15 s"]);
    refused_with(&["run.duration_s=10"], &["run.settle_s = 10.0", "at 10 s", ":34:"]);
    refused_with(
        &["parameters.stiffness_n_per_m=1e9", "parameters.mass_kg=1e-12"],
        &["parameters.stiffness_n_per_m = 1e9", "natural frequency", "from 1e-3 to 1e4"],
    );
    refused_with(
        &["excitation={kind=\"sine\",amplitude_g=1,amplitude_m_per_s2=9.81,frequency_hz=1}"],
        &["excitation.amplitude_g = 1", "beside amplitude_m_per_s2"],
    );
    refused_with(
        &["run={duration_s=1,duration_periods=20}"],
        &["run.duration_periods = 20", "beside duration_s"],
    );
    for excitation in ["{kind=\"silence\"}", "{kind=\"sine\",amplitude_g=1,frequency_hz=0}"] {
        refused_with(
            &[&format!("excitation={excitation}"), "run.duration_periods=20"],
            &["run.duration_periods = 20", "one sine"],
        );
    }
    refused_with(&["run.duration_periods=1e12"], &["run.duration_periods = 1e12", "to 1e7 s"]);
}

#[test]
fn the_line_of_the_file_is_told() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("lines");
    let line = 1 + shipped.lines().position(|line| line.starts_with("damping_ratio")).expect("is there");
    for (bad, shown) in [("damping_ratio = -1", "= -1: must be"), ("damping_ratio = '3 mm'", "\"3 mm\"")] {
        let scene = file(&folder, "scene.toml", shipped.replace("damping_ratio = 0.005", bad));
        let place = format!("{scene}:{line}: parameters.damping_ratio");
        refused(&["run", &scene, "--method", "reference"], &[&place, shown]);
    }
}

#[test]
fn a_file_that_is_no_scene() {
    let folder = folder("no-scene");
    let absent = folder.join("absent.toml");
    let absent = absent.to_str().expect("a plain path");
    refused(&["run", absent, "--method", "reference"], &[absent, "cannot be read"]);
    let itself = folder.to_str().expect("a plain path");
    refused(&["run", itself, "--method", "reference"], &[itself, "cannot be read"]);
    let empty = file(&folder, "empty.toml", "");
    refused(&["run", &empty, "--method", "reference"], &[&empty, "scene", "is missing"]);
    let bytes = file(&folder, "bytes.toml", b"scene = 1\n\xff\xfe");
    refused(&["run", &bytes, "--method", "reference"], &[&bytes, ":2:", "UTF-8"]);
    let line_break = file(&folder, "break.toml", "scene = \"a\\nb\"");
    refused(&["run", &line_break, "--method", "reference"], &["scene = \"a\\nb\""]);
}

#[test]
fn an_override_that_leads_nowhere() {
    refused_with(&["scene.deep=1"], &["scene.deep = 1", "no table"]);
    refused_with(&["excitation.tones.0=1"], &["excitation.tones"]);
    refused_with(&["extra.deep.key=1"], &["extra.deep.key = 1", "unknown key"]);
    // A key of another kind of the table.
    refused_with(&["parameters.restitution.coefficient=1"], &["restitution.coefficient = 1", "unknown key"]);
    // A line break must not smuggle in a second key.
    refused_with(&["parameters.mass_kg=1\nextra=2"], &["parameters.mass_kg", "from 1e-12"]);
    for bad in ["parameters.mass_kg", "=1", "parameters.mass_kg=", ""] {
        refused(&["run", SHIPPED, "--method", "reference", "--set", bad], &["--set", "KEY=VALUE"]);
    }
}
