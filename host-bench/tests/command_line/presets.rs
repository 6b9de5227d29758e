//! Parts by name.

use super::tool::{NODE, json, refused, refused_with};

const BRIDGE: &str = "capacitance_f=1e-4,initial_v=3.0";

#[test]
fn what_a_part_does_not_give_is_still_asked_for() {
    refused_with(
        &["load={kind='rectified-store',preset='ltc3588-1-3v3'}"],
        &["load.capacitance_f: is missing"],
    );
    refused_with(
        &["load={kind='rectified-store',preset='ltc3588-1-3v3',capacitance_f=1e-4}"],
        &["load.initial_v: is missing"],
    );
    // Plain diodes have no thresholds.
    refused_with(
        &[&format!(
            "load={{kind='rectified-store',preset='diodes',{BRIDGE},draw={{kind='power',value=1e-6}}}}"
        )],
        &["load.draw.turn_on_v: is missing"],
    );
}

#[test]
fn an_explicit_key_takes_the_place_of_the_parts_and_meets_its_bounds() {
    let store =
        |more: &str| format!("load={{kind='rectified-store',preset='ltc3588-1-3v3',{BRIDGE},{more}}}");
    refused_with(&["load.preset='diodes'"], &["load.preset = \"diodes\"", "unknown key"]);
    // 5.05 V of the part below 6 V of the file.
    refused_with(
        &[&store("draw={kind='power',value=1e-6,turn_off_v=6.0}")],
        &["load.draw.turn_off_v = 6", "must be below turn_on_v = 5.05"],
    );
}

#[test]
fn a_charger_does_not_start_below_its_cold_start_voltage() {
    refused_with(
        &["load={kind='dc-bus',preset='bq25504',voltage_v=0.5}"],
        &["load.voltage_v = 0.5", "at least 0.6", "cold start of \"bq25504\""],
    );
}

#[test]
fn a_run_checks_a_node_and_goes_on_without_it() {
    let short = ["--set", "run.duration_s=0.3", "--set", "run.settle_s=0.1", "--tolerance", "1e-2"];
    let run = |more: &[&'static str]| [&["run", NODE], &short[..], more].concat();
    let told = json(&run(&[]));
    assert!(told["mean_power_w"].as_f64().is_some_and(|power| power > 0.0));
    refused(&run(&["--set", "node.update_s=7"]), &["node.update_s = 7", "must divide 86400"]);
}
