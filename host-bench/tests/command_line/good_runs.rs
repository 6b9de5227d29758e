//! What a good run prints and writes.

use std::path::Path;

use super::tool::{SHIPPED, accepted, file, folder, has_keys, number, outcome, place, rows, set};

/// Half a second of the shipped scene, with impacts in it.
const SHORT: [&str; 2] = ["run.duration_s=0.6", "run.settle_s=0.3"];

#[test]
fn json_has_every_key_of_the_contract() {
    let found = outcome(SHIPPED, &SHORT);
    let own = "natural_frequency_hz peak_gap_m min_gap_m impacts impacts_per_period max_impact_speed_m_per_s \
               first_impact_s stuck_fraction";
    has_keys(&found, true, own);
    assert_eq!(found["scene"], "contact-separation");
    assert_eq!(found["method"], "reference");
    assert_eq!(found["precision"], "f64");
    let power = number(&found, "mean_power_w");
    assert!((number(&found, "delivered_energy_j") / (power * 0.3) - 1.0).abs() < 1e-12);
    assert!((number(&found, "rms_voltage_v").powi(2) / 1e8 / power - 1.0).abs() < 1e-12);
    assert!(number(&found, "peak_voltage_v") > number(&found, "rms_voltage_v"));
    assert!((number(&found, "first_impact_s") - 0.430_180_818).abs() < 1e-8);
    assert!((number(&found, "impacts_per_period") * 6.0 - number(&found, "impacts")).abs() < 1e-9);
    assert_eq!(number(&found, "min_gap_m"), 0.0);
    // 80 N/m and 5 g.
    let natural = (80.0_f64 / 5e-3).sqrt() / std::f64::consts::TAU;
    assert!((number(&found, "natural_frequency_hz") / natural - 1.0).abs() < 1e-14);
    assert!(number(&found, "energy_residual") < 1e-10);
}

#[test]
fn what_does_not_exist_is_null() {
    // Nothing moves and nothing is charged.
    let still = ["excitation={kind=\"silence\"}", "parameters.charge_density_c_per_m2=0"];
    let found = outcome(SHIPPED, &[&still[..], &SHORT[..]].concat());
    for key in ["energy_residual", "impacts_per_period", "max_impact_speed_m_per_s", "first_impact_s"] {
        assert!(found[key].is_null(), "{key}");
    }
    assert_eq!(number(&found, "mean_power_w"), 0.0);
    assert_eq!(number(&found, "peak_gap_m"), 3e-3);
}

#[test]
fn the_same_numbers_in_every_format() {
    let run = |format| {
        let run = ["run", SHIPPED, "--method", "reference", "--format", format];
        accepted(&[&run[..], &set(&SHORT)].concat())
    };
    let object: serde_json::Value = serde_json::from_str(&run("json")).expect("one JSON object");
    let csv = rows(&run("csv"));
    assert_eq!(csv.len(), 1);
    let table = run("table");
    for (name, cell) in &csv[0] {
        assert!(table.lines().any(|line| line.split_whitespace().next() == Some(name)), "{name}");
        let value = match name.strip_prefix("accuracy_") {
            Some(source) => object["accuracy"].get(source),
            None => object.get(name),
        };
        let value = value.unwrap_or_else(|| panic!("{name} is not in the JSON object"));
        if let (Some(value), true) = (value.as_f64(), name != "processor_s") {
            assert_eq!(cell.parse::<f64>().expect("a number"), value, "{name}");
        }
    }
}

#[test]
fn overrides_replace_their_alternatives() {
    let base = outcome(SHIPPED, &SHORT);
    let same = outcome(
        SHIPPED,
        &["excitation.amplitude_m_per_s2=1.962", "run.duration_periods=12", "run.settle_periods=6"],
    );
    // 0.2 g is not to the last bit 1.962 m/s².
    assert!((number(&base, "mean_power_w") / number(&same, "mean_power_w") - 1.0).abs() < 1e-9);
    assert_eq!(base["duration_s"], same["duration_s"]);
    let words = outcome(SHIPPED, &[&SHORT[..], &["parameters.force_law=gap-field"]].concat());
    assert_ne!(base["mean_power_w"], words["mean_power_w"]);
}

#[test]
fn one_sine_may_be_written_as_a_sum() {
    let tones = "excitation={kind=\"sines\",tones=[{amplitude_g=0.1,frequency_hz=20},\
                 {amplitude_m_per_s2=0.981,frequency_hz=20,phase_rad=0}]}";
    let (sine, sum) = (outcome(SHIPPED, &SHORT), outcome(SHIPPED, &[&SHORT[..], &[tones]].concat()));
    let (one, other) = (number(&sine, "mean_power_w"), number(&sum, "mean_power_w"));
    assert!((one / other - 1.0).abs() < 1e-8);
    assert!(sum["impacts_per_period"].is_null());
    let louder = [&SHORT[..], &[tones, "excitation.tones.1.amplitude_m_per_s2=3"]].concat();
    assert_ne!(outcome(SHIPPED, &louder)["mean_power_w"], sum["mean_power_w"]);
}

#[test]
fn the_start_may_be_chosen() {
    let start = "initial={gap_m=0.0,charge_c=1e-8}";
    let found = outcome(SHIPPED, &[start, "run.duration_s=0.001", "run.settle_s=0"]);
    assert_eq!(number(&found, "min_gap_m"), 0.0);
    // q = 1e-8 C at closed gap: V = −q d_e / (ε0 S), and it falls from there.
    let voltage = 1e-8 * 25e-6 / (model_core::part::VACUUM_PERMITTIVITY * 4e-4);
    assert!((number(&found, "peak_voltage_v") / voltage - 1.0).abs() < 1e-9);
    let start = "initial={gap_m=1e-3,velocity_m_per_s=-1.0}";
    let found = outcome(SHIPPED, &[start, "run.duration_s=0.02", "run.settle_s=0"]);
    // A millisecond to the dielectric, and a little more: the spring pulls away from it.
    let first = number(&found, "first_impact_s");
    assert!(first > 1e-3 && first < 1.1e-3, "{first}");
    for resistance in ["load.resistance_ohm=0", "load.resistance_ohm=inf"] {
        let found = outcome(SHIPPED, &[&SHORT[..], &[resistance]].concat());
        assert_eq!(number(&found, "mean_power_w"), 0.0);
    }
}

/// A trace beside its scene file: the path is relative to that, whatever the current folder is.
#[test]
fn a_recorded_acceleration_shakes_the_base() {
    let folder = folder("good-trace");
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let start = shipped.find("[excitation]").expect("the table is there");
    let write = |name: &str, table: &str| {
        file(&folder, name, format!("{}{table}\n[run]\nduration_s = 0.5\n", &shipped[..start]))
    };
    let rows: String = (0..=200)
        .map(|row| format!("{row},{}\n", (0.05 * std::f64::consts::PI * f64::from(row)).sin()))
        .collect();
    // A byte order mark, a comment, Windows line ends: as instruments write them.
    let text = format!("\u{feff}# g, 400 Hz\nn, x\n{rows}").replace('\n', "\r\n");
    file(&folder, "trace.csv", text);
    let table = |column: &str, more: &str| {
        format!(
            "[excitation]\nkind = \"file\"\npath = \"trace.csv\"\ncolumn = {column}\nrate_hz = 400\n\
             scale_m_per_s2 = 1.962\n{more}"
        )
    };
    let by_name = outcome(&write("name.toml", &table("\"x\"", "")), &[]);
    let by_number = outcome(&write("number.toml", &table("2", "repeat = true")), &[]);
    assert_eq!(by_name["peak_gap_m"], by_number["peak_gap_m"]);
    let sine = outcome(
        &write("sine.toml", "[excitation]\nkind = \"sine\"\namplitude_g = 0.2\nfrequency_hz = 10.0"),
        &[],
    );
    let (recorded, smooth) = (number(&by_name, "peak_gap_m"), number(&sine, "peak_gap_m"));
    // Straight lines between 40 samples a period take 0.2 % off.
    assert!((recorded / smooth - 1.0).abs() < 3e-3, "{recorded} {smooth}");
    assert!(by_name["impacts_per_period"].is_null());
}

#[test]
fn a_trace_of_the_motion_is_written_whole() {
    let folder = folder("motion");
    let path = &place(&folder, "motion.csv");
    let run = ["run", SHIPPED, "--method", "reference", "--trace", path, "--trace-every", "1e-3"];
    accepted(&[&run[..], &set(&SHORT)].concat());
    let mut reader = csv::Reader::from_path(path).expect("the trace");
    let heading: Vec<String> = reader.headers().expect("a heading").iter().map(str::to_owned).collect();
    assert_eq!(
        heading.join(" "),
        "time_s gap_m velocity_m_per_s charge_c voltage_v base_acceleration_m_per_s2 stuck"
    );
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|record| record.expect("a row").iter().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 601);
    assert_eq!(rows[0][..3], [0.0, 3e-3, 0.0]);
    for (index, row) in rows.iter().enumerate() {
        assert!((row[0] - 1e-3 * index as f64).abs() < 1e-12);
        assert!(row[1] >= -1e-15);
        let base = 1.962 * (2.0 * std::f64::consts::PI * 20.0 * row[0]).sin();
        assert!((row[5] - base).abs() < 1e-9);
    }
    let names: Vec<_> = std::fs::read_dir(Path::new(&folder)).expect("the folder").collect();
    assert_eq!(names.len(), 1, "no parts are left");
}

#[test]
fn help_and_version_are_no_errors() {
    assert!(accepted(&["--help"]).contains("sweep"));
    assert!(accepted(&["run", "--help"]).contains("--trace-every"));
    assert!(accepted(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
}
