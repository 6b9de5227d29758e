//! The steady state by shooting: `--steady-state` and `resonance`.

use super::tool::{BEAM, RECTIFIED, SHIPPED, accepted, json, number, printed, refused, rows};

/// A fast core, and a short run for where there is no orbit.
const FAST: [&str; 6] = ["--tolerance", "1e-3", "--set", "run.duration_s=1", "--set", "run.settle_s=0.5"];

#[test]
fn a_run_tells_how_its_steady_state_was_found() {
    let found = json(&[&["run", SHIPPED, "--steady-state"], &FAST[..]].concat());
    assert_eq!(found["steady_state"], "stable-period-1");
    assert_eq!(found["impacts_per_period"].as_f64().map(f64::round), Some(1.0));
    let window = number(&found, "duration_s") - number(&found, "settle_s");
    assert!((window * 20.0 - 1.0).abs() < 1e-9, "one period of 20 Hz, not {window} s");
    let plain = json(&[&["run", SHIPPED], &FAST[..]].concat());
    assert!(plain.get("steady_state").is_none());
}

#[test]
fn a_sweep_has_the_verdict_as_a_column_and_tells_its_price() {
    let grid = ["sweep", SHIPPED, "--over", "excitation.frequency_hz=19.1:20.1:2", "--steady-state"];
    let [found, told] = printed(&[&grid[..], &FAST[..], &["--compare", "--format", "csv"]].concat());
    assert!(told.contains("1 of 2 points") && told.contains("times as long"), "{told}");
    let rows = rows(&found);
    let verdicts: Vec<&str> = rows.iter().map(|row| row["steady_state"].as_str()).collect();
    assert!(["unstable-period-1", "none"].contains(&verdicts[0]), "{verdicts:?}");
    assert_eq!(verdicts[1], "stable-period-1");
    // At no point an orbit: there is nothing to divide by.
    let none = ["sweep", SHIPPED, "--over", "excitation.frequency_hz=19.1:19.2:2", "--steady-state"];
    let [_, told] = printed(&[&none[..], &FAST[..], &["--no-accuracy"]].concat());
    assert!(told.contains("0 of 2 points: none of them") && !told.contains("NaN"), "{told}");
    // Without an orbit the window is that of the scene.
    assert_eq!(rows[0]["settle_s"], "0.5");
    let table = accepted(&[&grid[..], &FAST[..]].concat());
    assert!(table.lines().next().is_some_and(|heading| heading.contains("steady_state")), "{table}");
}

/// A run in half the steps may find its orbit in fewer steps in all, as here.
#[test]
fn the_error_of_an_orbit_is_known_however_long_the_search_for_it_is() {
    let bus = "--set=load={kind=\"dc-bus\",diode_drop_v=0.3,voltage_v=2.229102}";
    let found = json(&["run", BEAM, "--steady-state", "--single-start", bus]);
    assert!(number(&found["accuracy"], "total") < 1e-3, "{found}");
}

#[test]
fn the_resonance_is_printed() {
    let range = ["resonance", SHIPPED, "--from", "19.3", "--to", "19.6", "--points", "7"];
    let small = ["--set", "excitation.amplitude_g=0.005", "--set", "load.resistance_ohm=1e6"];
    let found = json(&[&range[..], &small[..], &["--tolerance", "1e-3"]].concat());
    let frequency = number(&found, "peak_frequency_hz");
    assert!((frequency - 19.4477).abs() < 2e-3, "{frequency}");
    assert_eq!(found["peak_at_edge"], false);
    assert!(found["max_rms_voltage_v"].as_f64().is_some_and(|voltage| voltage > 0.0));
}

/// Behind a bridge the storage is held, and power and charge per second are printed.
#[test]
fn the_resonance_behind_a_bridge_is_that_at_a_held_voltage() {
    let range =
        ["resonance", RECTIFIED, "--from", "18", "--to", "19.4", "--points", "7", "--tolerance", "1e-3"];
    let held = ["--storage-voltage", "2", "--set", "excitation.amplitude_g=0.05"];
    let found = json(&[&range[..], &held[..]].concat());
    let ratio = number(&found, "max_mean_power_w") / number(&found, "max_mean_power_current_a");
    assert!((ratio - 2.0).abs() < 1e-6, "{found}");
    refused(&range, &["rectified.toml", "load.kind", "--storage-voltage"]);
    refused(&["run", RECTIFIED, "--storage-voltage", "2"], &["--storage-voltage", "--steady-state"]);
    let run = ["run", RECTIFIED, "--storage-voltage", "2", "--steady-state", "--no-accuracy"];
    let found = json(&[&run[..], &FAST[..]].concat());
    assert_eq!((&found["steady_state"], &found["store_voltage_v"]), (&"stable-period-1".into(), &2.0.into()));
    assert!(found["mean_store_current_a"].as_f64().is_some_and(|current| current > 0.0));
}

/// The beam is stiffer with open terminals, by the closed form of its first mode.
#[test]
fn the_resonances_with_short_circuited_and_open_terminals_are_compared() {
    let range = ["resonance", BEAM, "--short-open", "--from", "237", "--to", "248", "--points", "8"];
    let found = json(&[&range[..], &["--set", "parameters.beam_modes=1"]].concat());
    let number = |key: &str| number(&found, key);
    // ω² + θ²/C, with θ = 0.04149795 and C = 15.93 nF.
    let natural = 239.705_436_f64;
    let open = (natural.powi(2) + (0.041_497_95 / std::f64::consts::TAU).powi(2) / 15.93e-9).sqrt();
    assert!((number("undamped_short_circuit_frequency_hz") - natural).abs() < 1e-5);
    assert!((number("undamped_open_circuit_frequency_hz") - open).abs() < 1e-4, "{found}");
    // The peak of a damped mode is at √(1 − 2ζ²) of its frequency.
    let damped = natural * (1.0 - 2e-4_f64).sqrt();
    assert!((number("short_circuit_frequency_hz") - damped).abs() < 1e-3, "{found}");
    let factor = number("coupling_factor_squared");
    assert!((factor / number("undamped_coupling_factor_squared") - 1.0).abs() < 2e-3, "{found}");
    assert!((number("short_circuit_peak_power_w") / number("open_circuit_peak_power_w") - 1.0).abs() < 0.02);
    refused(
        &[&range[..], &["--set", "load.resistance_ohm=1"]].concat(),
        &["load.resistance_ohm", "--short-open"],
    );
    refused(&[&range[..], &["--storage-voltage", "1"]].concat(), &["--storage-voltage"]);
}

#[test]
fn what_has_no_period_map_is_refused() {
    let run = |options: &[&'static str]| [&["run", SHIPPED, "--steady-state"], options].concat();
    refused(&run(&["--method", "reference"]), &["--method reference", "steady state"]);
    refused(&run(&["--precision", "f32"]), &["--precision f32", "f64"]);
    refused(&run(&["--math", "micromath"]), &["--math micromath", "f64"]);
    refused(&run(&["--trace", "x.csv", "--trace-every", "1"]), &["--trace-every", "steady state"]);
    refused(&run(&["--set", "excitation.frequency_hz=0"]), &["excitation.kind", "frequency_hz above 0"]);
    let grid = ["sweep", SHIPPED, "--over", "excitation.frequency_hz=0:20:2", "--steady-state"];
    refused(&grid, &["excitation.kind", "frequency_hz above 0"]);
    refused(&[&grid[..4], &["--compare"]].concat(), &["--steady-state"]);
    let still = "excitation={kind='silence'}";
    refused(&run(&["--set", still]), &["excitation.kind", "sine"]);
    let resonance = ["resonance", SHIPPED, "--from", "19", "--to", "20", "--set", still];
    refused(&resonance, &["excitation.kind", "sine"]);
    let range = |from: &'static str, to: &'static str| ["resonance", SHIPPED, "--from", from, "--to", to];
    refused(&range("0", "20"), &["--from 0", "above 0"]);
    refused(&range("19", "nan"), &["--to <HZ>", "must be a finite number"]);
    refused(&range("20", "19"), &["--from 20", "--to 19"]);
    refused(&[&range("19", "20")[..], &["--points", "2"]].concat(), &["--points", "'2'", "from 3"]);
    refused(&[&range("19", "20")[..], &["--method", "reference"]].concat(), &["--method reference"]);
}
