//! A day of a node.

use serde_json::Value;

use super::tool::{
    BUMP_STOP, NODE, PASSIVE, SHIPPED, SLIDING, file, folder, json as any_json, number, place, printed,
    refused, rows,
};

const SHORT: [&str; 4] = ["--set", "run.duration_s=3", "--set", "run.settle_s=2"];

/// Runs `budget` with short windows: what it prints, what stands on standard error but for the name of the picture, and its
/// picture in a folder of the test.
fn budget(name: &str, file: &str, options: &[&str]) -> [String; 3] {
    let picture = place(&folder(name), "day.svg");
    let [day, told] = printed(&[&["budget", file, "--svg", &picture], &SHORT[..], options].concat());
    let told = told.replace(&format!("written: {picture}\n"), "");
    [day, told, std::fs::read_to_string(&picture).expect("the picture")]
}

/// The day of the shipped node.
fn json(name: &str, options: &[&str]) -> Value {
    day(name, NODE, options).0
}

/// The day of a node, what stands on standard error, and the picture.
fn day(name: &str, file: &str, options: &[&str]) -> (Value, [String; 2]) {
    let [day, told, picture] = budget(name, file, &[&["--format", "json"], options].concat());
    (serde_json::from_str(&day).expect("one JSON object"), [told, picture])
}

/// The sum over the actions of a day.
fn over_actions(day: &Value, of: impl Fn(&Value) -> f64) -> f64 {
    day["actions"].as_array().expect("actions").iter().map(of).sum()
}

/// Keys of version 0.1 are read as the new ones, with a line for each.
#[test]
fn an_old_key_works_with_a_warning() {
    let text = std::fs::read_to_string(NODE).expect("the scene").replace("[node.burst]", "[node.listen]");
    let old = file(&folder("budget-old-file"), "node.toml", text);
    let day = |file: &str, set: &str| {
        let (day, [told, _]) = day("budget-old", file, &["--set", set]);
        (day["estimation"].clone(), told)
    };
    let (found, warnings) = day(&old, "node.listen.every_s=400");
    let (expected, none) = day(NODE, "node.burst.every_s=400");
    assert!(found == expected && found[0]["name"] == "burst", "{found} {expected}");
    assert!(
        warnings.contains("node.listen is now named node.burst") && !none.contains("now named"),
        "{warnings}"
    );
}

#[test]
fn a_day_adds_up_and_is_drawn() {
    let (day, [_, picture]) = day("budget-day", NODE, &[]);
    let of = |key: &str| number(&day, key);
    assert!(of("store_residual") < 1e-12, "{day}");
    assert!(of("budget_ledger_residual") < 1e-5, "{day}");
    assert!((of("income_j") / of("harvested_energy_j") - 0.8).abs() < 1e-9);
    // The actions are what their runs cost, through the converter, which is none here.
    let actions = day["actions"].as_array().expect("a list");
    let spent = over_actions(&day, |action| number(action, "spent_j"));
    assert!((of("actions_j") / spent - 1.0).abs() < 1e-9, "{day}");
    // A wake-up of 5 µs at 32 MHz and 264 pJ; 16 readings of 0.15 µJ; a packet of 24 bytes at 25.5 mA and 3.3 V.
    let wake_up = 264e-12 * 32e6 * 5e-6;
    let on_air = 1e-3 + (20.25 + (44.0 + 24.0 * 8.0) * 5.0 / 28.0) * 1.024e-3;
    let energies = [300e-6 + 16.0 * 0.15e-6 + wake_up, 25.5e-3 * 3.3 * on_air + wake_up];
    for (action, joules) in actions.iter().zip(energies) {
        assert!((number(action, "spent_j") - number(action, "runs") * joules).abs() < 1e-9);
        assert!(number(action, "runs") <= number(action, "wished_runs") + 1.0);
        // The plan does at least what the budget holds for sustainable at an even rate in the morning.
        assert!(number(action, "runs") > 0.95 * number(action, "sustainable_runs"), "{day}");
        let period = 86_400.0 / number(action, "sustainable_runs");
        assert!((number(action, "sustainable_period_s") / period - 1.0).abs() < 1e-9, "{day}");
    }
    // The budget knows its store, and the node is never switched off.
    assert!(of("budget_error") < 1e-3 && of("lockout_s") == 0.0, "{day}");
    assert!(of("lowest_voltage_v") >= 2.44, "{day}");
    let labels = ["stored energy [mJ]", "harvested power [µW]", "runs per hour", "measure", "transmit"];
    for label in labels.into_iter().chain(["Estimating the income", "mean power [nW]", "voltage_reading"]) {
        assert!(picture.contains(label), "{label} is in the picture");
    }
}

#[test]
fn what_knowing_costs_is_counted_by_the_figures_of_the_parts() {
    let day = json("budget-knowing", &[]);
    let of = |key: &str| number(&day, key);
    // An STM32L051 asleep: 0.8 µA at 3 V.
    assert!(
        (of("standing_power_w") - 2.4e-6).abs() < 1e-15 && of("asleep_power_w") == of("standing_power_w")
    );
    let knowing = day["estimation"].as_array().expect("a list");
    let [burst, reading] = knowing.as_slice() else { panic!("a burst and a reading: {day}") };
    // 1284 samples at 400 Hz, 3 µA and 2 V; 45 788 instructions of 1.5 cycles; 48 bits a sample, 170 in the FIFO.
    let wake_up = 264e-12 * 32e6 * 5e-6;
    let costs = [
        ("sensor_j", 1284.0 / 400.0 * 6e-6),
        ("computing_j", 45_788.0 * 1.5 * 264e-12),
        ("transfer_j", 1280.0 * 48.0 * 0.5e-9),
        ("wake_up_j", 8.0 * wake_up),
        ("waiting_j", 0.0),
    ];
    for (key, joules) in costs {
        assert!((number(burst, key) - joules).abs() < 1e-12, "{key} {burst}");
    }
    let sum: f64 = costs.iter().map(|(_, joules)| joules).sum();
    assert!((number(burst, "energy_j") - sum).abs() < 1e-12);
    assert!((number(reading, "energy_j") - 0.15e-6 - wake_up).abs() < 1e-12, "{reading}");
    // Near the lock-out before dawn the budget refuses some.
    let runs = (number(burst, "runs"), number(reading, "runs"));
    assert!((280.0..=288.0).contains(&runs.0) && (1400.0..=1440.0).contains(&runs.1), "{runs:?}");
    // The storage has no converter behind it.
    let spent = number(burst, "spent_j") + number(reading, "spent_j");
    assert!((of("estimation_j") / spent - 1.0).abs() < 1e-12);
    assert!((of("estimation_share_of_income") - spent / of("income_j")).abs() < 1e-12);
    assert!(of("estimation_share_of_income") < 0.01, "{day}");
    let figures = day["figures"].as_array().expect("a list");
    let marks = ["confirmed", "secondary", "unconfirmed", "estimated"];
    assert!(figures.iter().all(|figure| marks.iter().any(|mark| figure["evidence"] == *mark)));
    assert!(figures.iter().any(|figure| figure["part"] == "ADXL362" && figure["evidence"] == "confirmed"));
    // Behind a gated supply the clock alone stands, and a burst has a cold start and waits.
    let gated = json("budget-gated", &["--set", "node.parts.clock=\"ab18x5-crystal\""]);
    assert!((number(&gated, "standing_power_w") - 165e-9).abs() < 1e-15);
    let start = 1e-6 * 9.0 + 264e-12 * 32e6 * 2e-3;
    assert!((number(&gated["estimation"][0], "wake_up_j") - start - 7.0 * wake_up).abs() < 1e-12, "{gated}");
    assert!(
        (number(&gated["estimation"][0], "waiting_j") - 2.4e-6 * 1284.0 / 400.0).abs() < 1e-12,
        "{gated}"
    );
    // A cold start for each reading, 25.9 µJ each minute, is more than a hundredth.
    assert!(number(&gated, "estimation_share_of_income") > 0.01, "{gated}");
}

#[test]
fn a_node_without_named_parts_states_all_itself() {
    let scene = std::fs::read_to_string(NODE).expect("the shipped scene");
    let (head, tail) = scene.split_once("[node.parts]").expect("named parts");
    let (_, tail) = tail.split_once("[node.storage]").expect("a storage");
    let plain = format!("{head}standing_power_w = 1.5e-6\n[node.storage]{tail}");
    let plain = plain
        .replace("adc_readings = 16", "")
        .replace("packet_bytes = 24", "energy_j = 6.6e-3\nduration_s = 0.05");
    let scene = &file(&folder("budget-plain-file"), "plain.toml", plain);
    let (day, [_, picture]) = day("budget-plain", scene, &[]);
    assert_eq!((number(&day, "standing_power_w"), number(&day, "estimation_j")), (1.5e-6, 0.0));
    assert!(day["asleep_power_w"].is_null() && day["figures"] == serde_json::json!([]), "{day}");
    assert!(!picture.contains("Estimating"));
    let with = |change: &str, parts: &[&str]| refused(&["budget", scene, "--set", change], parts);
    with("node.actions.1.packet_bytes=20", &["node.actions[1].packet_bytes = 20", "needs node.parts"]);
    with("node.burst={every_s=60}", &["node.burst", "needs node.parts"]);
}

#[test]
fn parts_that_do_not_do_what_is_asked_are_refused() {
    let with = |change: &str, parts: &[&str]| refused(&["budget", NODE, "--set", change], parts);
    with("node.parts.processor=\"sam-d21\"", &["its current asleep is not known", "name a clock"]);
    with("node.parts={processor=\"nrf52832\"}", &["node.actions[1].packet_bytes", "node.parts.radio"]);
    let deaf = "node.parts={processor=\"nrf52832\",radio=\"nrf52832-0-dbm\"}";
    with(deaf, &["node.burst.samples", "node.parts.accelerometer"]);
    with("node.burst.rate_hz=401", &["node.burst.rate_hz = 401", "at most 400", "ADXL362"]);
    with("node.voltage_reading={}", &["node.voltage_reading.every_s: is missing"]);
    with("node.actions.0.name=\"burst\"", &["node.actions[0].name", "must not be burst"]);
    let short = "node.parts.radio=\"nrf52832-0-dbm\"";
    refused(
        &["budget", NODE, "--set", short, "--set", "node.actions.1.packet_bytes=32"],
        &["node.actions[1].packet_bytes = 32", "at most 31"],
    );
    refused(
        &["sweep", NODE, "--over", "node.burst.every_s=60:120:2"],
        &["--over node.burst.every_s", "[node] is of the command budget"],
    );
}

#[test]
fn the_same_day_has_the_same_bits_and_other_formats_the_same_numbers() {
    let [one, two] = ["budget-once", "budget-again"].map(|name| budget(name, NODE, &["--format", "csv"]));
    assert_eq!(one, two);
    let day = json("budget-json", &[]);
    let row = &rows(&one[0])[0];
    let cell = |name: &str| row[name].parse::<f64>().expect("a number");
    assert_eq!(cell("shunted_j"), number(&day, "shunted_j"));
    assert_eq!(cell("transmit_runs"), number(&day["actions"][1], "runs"));
    let [table, ..] = budget("budget-table", NODE, &[]);
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
    let spent = over_actions(&day, |action| number(action, "spent_j"));
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
fn a_node_lives_on_a_battery() {
    let on =
        |keys: &str| format!("node.storage={{{keys},charging_efficiency=0.8,discharging_efficiency=0.9}}");
    let day = json("budget-battery", &["--set", &on("battery='slb12400l151'")]);
    let of = |key: &str| number(&day, key);
    assert!((of("income_j") / of("harvested_energy_j") - 0.8 * 0.99).abs() < 1e-9, "{day}");
    // The budget of the core in single precision, and the plant by the charge of the battery.
    assert!(of("store_residual") < 1e-9 && of("budget_error") < 1e-5 && of("lockout_s") == 0.0, "{day}");
    // From half a charge, which loses 1.3e-8 of some 600 J in a second.
    assert!((of("lowest_voltage_v") - 2.34).abs() < 1e-3 && (0.5..0.9).contains(&of("leaked_j")), "{day}");
    assert!(day["capacitance_for_wishes_f"].is_null(), "{day}");
    for (keys, parts) in [
        ("battery='x'", ["node.storage.battery = \"x\"", "\"slb12400l151\""]),
        ("battery='slb12400l151',highest_v=2.9", ["node.storage.highest_v = 2.9", "from 1.8000 to 2.8000"]),
        ("battery='apr18650m1b',turn_off_v=1.9", ["node.storage.turn_off_v = 1.9", "from 2.0102 to 3.5981"]),
    ] {
        refused(&["budget", NODE, "--set", &on(keys)], &parts);
    }
    let both = ["budget", NODE, "--set", BRIDGED, "--set", "node.storage={battery='slb12400l151'}"];
    refused(&both, &["node.storage.battery", "must not be given beside the storage in [load]"]);
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
    let with = |change: &str, parts: &[&str]| refused(&["budget", NODE, "--set", change], parts);
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
    refused(&["budget", NODE, "--learning-days", "1000"], &["--learning-days", "'1000'", "from 0 to 366"]);
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
    refused(&["budget", BUMP_STOP, "--exact"], &["node: is missing"]);
}

#[test]
fn a_verdict_says_whether_all_wishes_are_met_and_by_which_storage() {
    let day = |capacitance: &str| {
        let set = format!("node.storage.capacitance_f={capacitance}");
        json("budget-verdict", &["--set", &set])
    };
    let verdict = |day: &Value| day["verdict"].as_str().expect("a sentence").to_owned();
    let (small, large) = (day("0.02"), day("3"));
    let near = verdict(&day("0.586"));
    assert!(
        near.starts_with("wishes met: 19") && near.contains(" of 1920 runs") && near.contains(" has 593 mF"),
        "{near}"
    );
    // The verdict has the four digits that are known of it.
    let smallest = format!("{:.3e}", number(&small, "capacitance_for_wishes_f"));
    let smallest: f64 = smallest.parse().expect("a number");
    assert!(
        verdict(&small).starts_with("wishes not met: ") && !verdict(&small).contains(" 0 lock-outs"),
        "{small}"
    );
    let storage = format!("{:.4} ", if smallest < 1.0 { 1e3 * smallest } else { smallest });
    let digits = storage.trim().trim_end_matches('0').to_owned();
    assert!(verdict(&small).contains(&digits), "{digits}: {small}");
    assert!(
        verdict(&large).starts_with("wishes met: ") && verdict(&large).contains(", 0 lock-outs;"),
        "{large}"
    );
}

#[test]
fn a_sweep_and_an_optimum_have_the_day_of_the_node() {
    let key = "node.storage.capacitance_f";
    let over = format!("{key}=0.02:0.5:3");
    let short = ["--set", "run={duration_s=3,settle_s=2}", "--node"];
    let drawn = folder("budget-swept-picture");
    let output = ["--output", drawn.to_str().expect("a plain path")];
    let sweep = [&["sweep", NODE, "--over", &over, "--no-accuracy"], &short[..]].concat();
    let points = any_json(&[&sweep[..], &output].concat());
    // What the storage does not change is not drawn, and none of the points is the best.
    let picture = std::fs::read_to_string(drawn.join("sweep.svg")).expect("a picture");
    assert!(picture.contains("runs of the node") && picture.contains("lowest voltage of the storage"));
    assert!(!picture.contains("mean power ["), "it is the same at all points");
    let [_, told] = printed(&sweep);
    assert!(
        told.contains(" at all points: the keys do not change it") && !told.contains("largest mean_power_w"),
        "{told}"
    );
    let day = json("budget-swept", &["--set", &format!("{key}=0.02")]);
    for (of_sweep, of_day) in [
        ("node_lockouts", "lockouts"),
        ("node_lockout_s", "lockout_s"),
        ("node_lowest_voltage_v", "lowest_voltage_v"),
        ("node_shunted_j", "shunted_j"),
        ("node_capacitance_for_wishes_f", "capacitance_for_wishes_f"),
    ] {
        assert_eq!(points[0][of_sweep], day[of_day], "{of_sweep}");
    }
    let runs = over_actions(&day, |one| number(one, "runs"));
    assert_eq!(points[0]["node_runs"].as_f64(), Some(runs));
    assert!(number(&points[2], "node_runs") > runs && number(&points[0], "node_lockouts") > 0.0, "{points}");
    let over = format!("{key}=0.02:0.5");
    let optimise = ["optimise", NODE, "--maximise", "node_runs", "--over", &over, "--grid", "3"];
    let best = any_json(&[&optimise[..], &short].concat());
    assert!(number(&best, "value") >= number(&points[2], "node_runs"), "{best}");
    refused(&optimise, &["--over node.storage.capacitance_f", "--node"]);
    refused(&["sweep", PASSIVE, "--over", "load.resistance_ohm=1:2:2", "--node"], &["node: is missing"]);
}

/// A node that is off does not know the income of those hours; the capacitance that it needs does not depend on it.
#[test]
fn the_capacitance_for_wishes_is_that_of_a_node_that_is_never_off() {
    let with = |capacitance: f64| {
        let set = format!("node.storage.capacitance_f={capacitance}");
        json("budget-capacitance", &["--set", &set, "--set", "node.standing_power_w=0"])
    };
    let locked = with(0.02);
    assert!(number(&locked, "lockouts") > 0.0, "{locked}");
    let needed = number(&locked, "capacitance_for_wishes_f");
    let day = with(needed);
    let missing = |one: &Value| number(one, "wished_runs") - number(one, "runs");
    let all = |one: &Value| missing(one) < 1.5;
    assert!(day["actions"].as_array().expect("actions").iter().all(all), "{needed}: {day}");
    // With less, wishes are missed.
    let less = with(0.6 * needed);
    let missed = over_actions(&less, missing);
    assert!(missed > 5.0, "{less}");
}

#[test]
fn strategies_refuse_a_scene_that_is_no_harvester_of_a_node() {
    let refuse = |scene: &str, parts: &[&str]| {
        let file = format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
        refused(&["node-strategies", &file], parts);
    };
    refuse("contact-separation-truck", &["excitation.kind", "sine"]);
    refuse("rectified", &["load.kind", "resistor"]);
    refuse("bump-stop", &["stop", "must be absent"]);
    refuse("nothing", &["nothing.toml"]);
}

/// The slider by its file: the bursts of its map are at its resonance, and both tiers know their income.
#[test]
#[ignore = "a minute: the map and its rows"]
fn strategies_are_of_a_scene_file_too() {
    let short = ["--course", "speed", "--as-designed", "--seeds", "1", "--storage", "slb12400l151"];
    let rows = any_json(&[&["node-strategies", SLIDING], &short[..]].concat());
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), 42);
    for row in rows.iter().filter(|row| row["strategy"] == "map") {
        // The voltage of a battery says next to nothing in an hour.
        assert!(number(row, "error_median") < 0.2 && number(row, "inside") > 0.7, "{row}");
        assert!(number(row, "actions") > 0.0 && number(row, "share") < 0.05, "{row}");
    }
}
