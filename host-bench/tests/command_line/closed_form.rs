//! Mean power without a trajectory: `closed-form`.

use super::tool::{SHIPPED, accepted, file, folder, refused};

const SLIDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/sliding.toml");
const RECTIFIED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/rectified.toml");
/// Two loads, two amplitudes and three frequencies.
const SMALL: [&str; 8] = [
    "--map",
    "--resistance=1e7:1e8:2",
    "--amplitude=0.2:0.4:2",
    "--frequency=17:18:3",
    "--references",
    "0",
    "--set",
    "run.settle_s=1",
];

#[test]
fn a_scene_has_its_power_and_whether_that_holds() {
    let of = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&accepted(arguments)).expect("one JSON object")
    };
    let found = of(&["closed-form", SLIDING, "--format", "json"]);
    assert_eq!((&found["scene"], &found["holds"]), (&"sliding".into(), &true.into()));
    // The RMS voltage at the peak, a millihertz away, of the other program of `sliding_rows.rs`.
    let voltage = found["rms_voltage_v"].as_f64().expect("a number");
    assert!((voltage / 44.18 - 1.0).abs() < 0.01, "{voltage}");
    let found = of(&["closed-form", SHIPPED, "--format", "json", "--precision", "f32"]);
    assert_eq!(found["holds"], false);
    assert!(found["reason"].as_str().expect("a word").starts_with("impacts"), "{found}");
    assert!(accepted(&["closed-form", SHIPPED]).contains("mean_power_w"));
}

#[test]
fn a_map_has_a_row_for_each_point_and_a_picture_for_each_load() {
    let folder = folder("closed-form");
    let path = folder.join("made");
    let path = path.to_str().expect("a plain path");
    let text =
        accepted(&[&["closed-form", SHIPPED, "--format", "csv", "--output", path], &SMALL[..]].concat());
    let written = std::fs::read_to_string(folder.join("made/closed-form.csv")).expect("the table");
    assert_eq!(text, written);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let heading = reader.headers().expect("a heading").clone();
    let column = |name: &str| heading.iter().position(|head| head == name).expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 12);
    for row in &rows {
        assert_eq!(&row[column("holds")], "true");
        let error: f64 = row[column("error")].parse().expect("a number");
        assert!(error < 0.02, "{row:?}");
    }
    for name in ["closed-form-0.svg", "closed-form-1.svg"] {
        let picture = std::fs::read_to_string(folder.join("made").join(name)).expect("the picture");
        assert!(picture.contains("log10 of the error") && picture.contains("frequency_hz"));
    }
    let table = accepted(&[&["closed-form", SHIPPED], &SMALL[..]].concat());
    assert!(table.contains("wrongly_holding") && table.contains("median_error"), "{table}");
}

#[test]
fn a_beam_behind_a_bridge_has_a_closed_form_too() {
    let beam = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bump-stop-none.toml");
    let weak = ["--set", "parameters.piezo_d31_m_per_v=-19e-12", "--set", "excitation.amplitude_m_per_s2=2"];
    let power = |load: &str| {
        let options = ["closed-form", beam, "--format", "json", "--set", load];
        let found: serde_json::Value =
            serde_json::from_str(&accepted(&[&options[..], &weak].concat())).expect("one JSON object");
        assert_eq!(found["holds"], true, "{found}");
        found["mean_power_w"].as_f64().expect("a number")
    };
    // The steady voltage of a store at its load is that of the bus that delivers as much.
    let store = power(
        "load={kind='rectified-store',capacitance_f=1e-6,diode_drop_v=0,leakage_ohm=2e5,initial_v=0,\
         draw={kind='resistor',value=2e5}}",
    );
    let voltage = (store * 1e5).sqrt();
    let bus = power(&format!("load={{kind='dc-bus',voltage_v={voltage},diode_drop_v=0}}"));
    assert!((store / bus - 1.0).abs() < 1e-2, "{store:e} {bus:e}");
}

/// A plate and a slider behind a bridge at a constant voltage: the power is that voltage times the charge per second.
#[test]
fn a_triboelectric_scene_behind_a_bridge_has_a_closed_form_at_a_constant_voltage() {
    let of = |arguments: &[&str]| -> serde_json::Value {
        let found = accepted(&[&["closed-form"], arguments, &["--format", "json"]].concat());
        serde_json::from_str(&found).expect("one JSON object")
    };
    let small = ["--set", "excitation.amplitude_g=0.05", "--set", "excitation.frequency_hz=18"];
    let held = of(&[&[RECTIFIED, "--storage-voltage", "1"], &small[..]].concat());
    let number = |found: &serde_json::Value, key: &str| found[key].as_f64().expect("a number");
    assert_eq!(held["holds"], true, "{held}");
    assert!(number(&held, "mean_power_w") > 0.0);
    let ratio = number(&held, "mean_power_w") / number(&held, "mean_store_current_a");
    assert!((ratio - 1.0).abs() < 1e-12, "{held}");
    let bus = "load={kind='dc-bus',voltage_v=20,diode_drop_v=0.3}";
    let slider = of(&[SLIDING, "--set", bus]);
    assert_eq!(slider["holds"], true, "{slider}");
    let single = of(&[SLIDING, "--set", bus, "--precision", "f32"]);
    assert!((number(&single, "mean_power_w") / number(&slider, "mean_power_w") - 1.0).abs() < 1e-3);
}

#[test]
fn what_has_no_closed_form_is_refused() {
    let store =
        "load={kind='rectified-store',capacitance_f=1e-6,diode_drop_v=0.3,leakage_ohm=1e9,initial_v=0}";
    refused(&["closed-form", SHIPPED, "--set", store], &["load.kind", "\"resistor\"", "--storage-voltage"]);
    refused(&["closed-form", SHIPPED, "--storage-voltage", "3"], &["load.kind", "must be a bridge"]);
    let held = ["closed-form", SHIPPED, "--set", store, "--storage-voltage"];
    refused(&[&held[..], &["-1"]].concat(), &["--storage-voltage -1", "from 0"]);
    refused(
        &["closed-form", RECTIFIED, "--storage-voltage", "3", "--set", "load.initial_v=1"],
        &["load.initial_v", "--storage-voltage holds"],
    );
    let silence = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let (before, after) = silence.split_once("[excitation]").expect("a section");
    let (_, run) = after.split_once("[run]").expect("a section");
    let text = format!("{before}[excitation]\nkind = \"silence\"\n[run]{run}");
    let scene = file(&folder("closed-form-silence"), "silence.toml", text);
    refused(&["closed-form", &scene], &["silence.toml", "excitation.kind", "\"sine\""]);
    refused(&["closed-form", SHIPPED, "--map", "--frequency", "1:2"], &["--frequency", "FROM:TO:COUNT"]);
    refused(&["closed-form", SHIPPED, "--map", "--amplitude", "0:2:3"], &["--amplitude", "above 0"]);
    refused(&["closed-form", SHIPPED, "--frequency", "1:2:3"], &["--map"]);
    let many = ["--frequency", "1:2:1000", "--amplitude", "1:2:1000"];
    refused(&[&["closed-form", SHIPPED, "--map"], &many[..]].concat(), &["--map", "at most 100000"]);
    refused(
        &["closed-form", SHIPPED, "--map", "--set", "load.resistance_ohm=inf"],
        &["resistance_ohm", "--resistance"],
    );
}
