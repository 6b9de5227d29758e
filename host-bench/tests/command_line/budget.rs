//! A day of a node.

use super::tool::{SHIPPED, accepted, folder, refused};

const NODE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/node.toml");

/// Runs `budget` on the shipped node, its windows short, with a picture in a folder of the test.
fn budget(name: &str, options: &[&str]) -> (String, String) {
    let picture = folder(name).join("day.svg");
    let path = picture.to_str().expect("a plain path");
    let short = ["--set", "run.duration_s=3", "--set", "run.settle_s=2", "--svg", path];
    let told = accepted(&[&["budget", NODE], &short[..], options].concat());
    (told, std::fs::read_to_string(&picture).expect("the picture"))
}

fn json(name: &str, options: &[&str]) -> serde_json::Value {
    let (told, _) = budget(name, &[&["--format", "json"], options].concat());
    serde_json::from_str(&told).expect("one JSON object")
}

fn number(day: &serde_json::Value, key: &str) -> f64 {
    day[key].as_f64().unwrap_or(f64::NAN)
}

#[test]
fn a_day_adds_up_and_is_drawn() {
    let (told, picture) = budget("budget-day", &["--format", "json"]);
    let day: serde_json::Value = serde_json::from_str(&told).expect("one JSON object");
    let of = |key: &str| number(&day, key);
    assert!(of("store_residual") < 1e-12, "{told}");
    assert!(of("budget_ledger_residual") < 1e-5, "{told}");
    assert!((of("income_j") / of("harvested_energy_j") - 0.8).abs() < 1e-9);
    // The actions are what their runs cost, through the converter, which is none here.
    let actions = day["actions"].as_array().expect("a list");
    let spent: f64 = actions.iter().map(|action| number(action, "spent_j")).sum();
    assert!((of("actions_j") / spent - 1.0).abs() < 1e-9, "{told}");
    for (action, joules) in actions.iter().zip([300e-6, 6.6e-3]) {
        assert!((number(action, "spent_j") - number(action, "runs") * joules).abs() < 1e-9);
        assert!(number(action, "runs") <= number(action, "wished_runs") + 1.0);
        // The plan does at least what the budget holds for sustainable at an even rate in the morning.
        assert!(number(action, "runs") > 0.95 * number(action, "sustainable_runs"), "{told}");
        let period = 86_400.0 / number(action, "sustainable_runs");
        assert!((number(action, "sustainable_period_s") / period - 1.0).abs() < 1e-9, "{told}");
    }
    // The budget knows its store, and the node is never switched off.
    assert!(of("budget_error") < 1e-3 && of("lockout_s") == 0.0, "{told}");
    assert!(of("lowest_voltage_v") >= 2.44, "{told}");
    for label in ["stored energy [mJ]", "harvested power [µW]", "runs per hour", "measure", "transmit"] {
        assert!(picture.contains(label), "{label} is in the picture");
    }
}

#[test]
fn the_same_day_has_the_same_bits_and_other_formats_the_same_numbers() {
    let (one, picture) = budget("budget-once", &["--format", "csv"]);
    let (two, again) = budget("budget-again", &["--format", "csv"]);
    assert_eq!((&one, &picture), (&two, &again));
    let day = json("budget-json", &[]);
    let mut reader = csv::Reader::from_reader(one.as_bytes());
    let heading = reader.headers().expect("a heading").clone();
    let row = reader.records().next().expect("a row").expect("a row");
    let cell = |name: &str| {
        let column = heading.iter().position(|head| head == name).expect("a column");
        row[column].parse::<f64>().expect("a number")
    };
    assert_eq!(cell("shunted_j"), number(&day, "shunted_j"));
    assert_eq!(cell("transmit_runs"), number(&day["actions"][1], "runs"));
    let (table, _) = budget("budget-table", &[]);
    assert!(table.lines().any(|line| line.starts_with("measure_sustainable_runs ")));
}

#[test]
fn a_node_without_income_stops_before_its_lock_out() {
    let dark = "node.day.hours=[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]";
    let day = json("budget-dark", &["--set", dark, "--set", "node.storage.initial_v=3.1"]);
    assert_eq!(number(&day, "harvested_energy_j"), 0.0);
    let runs = |index: usize| number(&day["actions"][index], "runs");
    assert_eq!((runs(0), runs(1)), (0.0, 0.0), "nothing can go on for ever");
    // Whatever is harvested, a wish of nothing but shunts.
    let idle = "node.actions=[{name='idle',energy_j=1e-12,duration_s=0,every_s=86400}]";
    let day = json("budget-idle", &["--set", idle, "--learning-days", "3"]);
    assert!(number(&day, "shunted_j") > 0.5 * number(&day, "income_j"));
    assert!((number(&day, "end_charge") - 1.0).abs() < 0.1);
}

#[test]
fn a_store_below_its_lock_out_waits_for_the_turn_on_voltage() {
    let day = json("budget-empty", &["--set", "node.storage.initial_v=2.0", "--learning-days", "0"]);
    assert!(number(&day, "lockout_s") > 5.0 * 3600.0);
    // It leaks until the morning, with a time constant of nine days.
    assert!((1.9..2.0).contains(&number(&day, "lowest_voltage_v")));
    assert!(number(&day, "budget_error") < 1e-3);
}

const BRIDGED: &str = "load={kind='rectified-store',preset='ltc3588-1-3v3',capacitance_f=4e-3,initial_v=6.0}";

#[test]
fn a_bridge_feeds_the_store_of_its_part() {
    let day = json("budget-bridged", &["--set", BRIDGED, "--set", "node.storage={}"]);
    let of = |key: &str| number(&day, key);
    assert!(of("store_residual") < 1e-12 && of("harvested_energy_j") > 0.1, "{day}");
    assert!((of("income_j") / of("harvested_energy_j") - 1.0).abs() < 1e-12);
    let spent: f64 = day["actions"]
        .as_array()
        .map_or(f64::NAN, |actions| actions.iter().map(|action| number(action, "spent_j")).sum());
    assert!(spent > 0.0 && (of("actions_j") * 0.85 / spent - 1.0).abs() < 1e-9, "{day}");
    // What comes in depends on the voltage of the store: the slots of the day tell less of it, but the state of
    // charge is known.
    assert!(of("budget_error") < 1e-3, "{day}");
}

#[test]
#[ignore = "25 million steps of a day, and the events of its bridge: minutes"]
fn the_ledger_of_a_whole_day_on_the_store_closes_in_single_precision() {
    let exact = ["--set", BRIDGED, "--set", "node.storage={}", "--exact"];
    let day = json("budget-exact", &exact);
    assert!(number(&day, "store_residual") < 1e-3, "{day}");
    assert!(number(&day, "steps") > 2e7 && number(&day, "budget_error") < 1e-2, "{day}");
    // The mean power at each amplitude is that of the whole day but for its starts and stops.
    let fast = json("budget-by-level", &["--set", BRIDGED, "--set", "node.storage={}"]);
    let ratio = number(&day, "harvested_energy_j") / number(&fast, "harvested_energy_j");
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn two_storages_at_once_are_refused() {
    for (storage, key) in [
        ("{preset='ltc3588-1-3v3'}", "node.storage.preset"),
        ("{capacitance_f=4e-3}", "node.storage.capacitance_f = 4e-3"),
        ("{leakage_ohm=1e9}", "node.storage.leakage_ohm"),
        ("{initial_v=6.0}", "node.storage.initial_v = 6.0"),
    ] {
        let storage = format!("node.storage={storage}");
        let arguments = ["budget", NODE, "--set", BRIDGED, "--set", &storage];
        refused(&arguments, &[key, "must not be given beside the storage in [load]"]);
    }
    let drawn = "load.draw={kind='current',value=1e-6,turn_on_v=5.0,turn_off_v=4.0}";
    refused(
        &["budget", NODE, "--set", BRIDGED, "--set", drawn, "--set", "node.storage={turn_on_v=4.5}"],
        &["node.storage.turn_on_v = 4.5", "give load.draw.turn_on_v"],
    );
    refused(&["budget", NODE, "--set", BRIDGED], &[NODE, "node.storage.preset = \"bq25504\""]);
}

#[test]
fn what_a_node_must_not_be_is_refused() {
    let with = |change: &'static str, parts: &[&str]| {
        refused(&["budget", NODE, "--set", change], parts);
    };
    refused(&["budget", SHIPPED], &[SHIPPED, "node: is missing"]);
    with("node.slots_per_day=47", &["node.slots_per_day = 47", "24, 48, 96 or 144"]);
    with("node.decision_s=90", &["node.decision_s = 90", "must be a multiple of update_s = 60"]);
    with("node.extra=1", &["node.extra = 1", "unknown key"]);
    with("node.actions=[]", &["node.actions", "at least one"]);
    with("node.actions.0.energy_j=-1", &["node.actions[0].energy_j = -1", "from 1e-12"]);
    with("node.actions.1.name=\"measure\"", &["node.actions[1].name", "another action"]);
    with("node.actions.1.name=\"\"", &["node.actions[1].name", "not empty"]);
    with("node.day.hours=[1,2]", &["node.day.hours", "24 numbers", "are 2"]);
    with("node.storage.preset=\"x\"", &["node.storage.preset = \"x\"", "\"bq25504\""]);
    with("node.storage.turn_off_v=3.0", &["node.storage.turn_off_v = 3.0", "below turn_on_v = 2.8"]);
    with("node.storage.highest_v=2.7", &["turn_on_v", "below highest_v = 2.7"]);
    with("node.storage.initial_v=4", &["node.storage.initial_v = 4", "at most highest_v = 3.15"]);
    with("node.storage={}", &["node.storage.capacitance_f: is missing"]);
    refused(&["budget", NODE, "--learning-days", "1000"], &["--learning-days 1000", "at most 366"]);
    refused(&["budget", NODE, "--svg", "/nowhere/day.svg"], &["--svg /nowhere/day.svg", "must be a folder"]);
    let lossy = "node.storage={charging_efficiency=0.8}";
    refused(
        &["budget", NODE, "--set", BRIDGED, "--set", lossy, "--exact"],
        &["charging_efficiency: 0.8 must be 1"],
    );
    refused(
        &["budget", NODE, "--exact", "--set", "run.duration_s=20"],
        &["--set run.duration_s", "--exact runs the whole day"],
    );
    let bump_stop = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bump-stop.toml");
    refused(&["budget", bump_stop, "--exact"], &["node: is missing"]);
}
