//! Exported netlists: what ngspice computes of them beside the core, and what is refused.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::tool::{
    BEAM, BIMORPH, BUMP_STOP, PASSIVE, SLIDING, accepted, file, folder, json, number, place, refused, rows,
    set,
};

/// With this variable of the environment a test fails where there is no ngspice; without it the test is skipped.
const REQUIRED: &str = "HARVESTER_NGSPICE";

// Shipped decks around an exported cantilever.
const BRIDGE_STORE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bridge-store.cir");
const SSHI: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/sshi.cir");

/// Whether ngspice is there.
fn has_ngspice() -> bool {
    let found = Command::new("ngspice").arg("--version").stdout(Stdio::null()).status().is_ok();
    if !found {
        assert!(std::env::var_os(REQUIRED).is_none(), "{REQUIRED} is set, and ngspice is not installed");
        // The standard error itself: the harness hides what a macro prints.
        let _ = writeln!(std::io::stderr(), "skipped: ngspice is not installed");
    }
    found
}

/// A measured number of a deck of ngspice.
fn measured(printed: &str, name: &str) -> f64 {
    let value = printed.lines().find_map(|line| line.strip_prefix(name)?.trim_start().strip_prefix('='));
    let number = value.and_then(|value| value.split_whitespace().next()?.parse().ok());
    number.unwrap_or_else(|| panic!("no {name} in {printed}"))
}

/// What ngspice prints of a deck.
fn simulated(folder: &Path, deck: &str) -> String {
    // It looks for the included file in the current folder first. -n: without the settings of a user.
    let run = Command::new("ngspice").args(["-n", "-b", deck]).current_dir(folder).output();
    String::from_utf8_lossy(&run.expect("ngspice starts").stdout).into_owned()
}

/// Asserts that mean power and RMS voltage of a scene with overrides by ngspice of the exported files are those by the core, within a
/// relative bound; the result of the core.
fn agreed(name: &str, scene: &str, overrides: &[&str], bound: f64) -> Value {
    let folder = folder(name);
    let [spice, deck] = ["harvester.cir", "harvester_test.cir"].map(|name| place(&folder, name));
    let set = set(overrides);
    accepted(&[&["export", scene, "--spice", &spice, "--deck", &deck][..], &set].concat());
    let printed = simulated(&folder, &deck);
    let core = json(&[&["run", scene, "--no-accuracy"][..], &set].concat());
    let names = ["mean_power_w", "rms_voltage_v"];
    let [by_ngspice, by_core] =
        [names.map(|name| measured(&printed, name)), names.map(|name| number(&core, name))];
    for (found, expected) in by_ngspice.iter().zip(by_core) {
        assert!((found / expected - 1.0).abs() < bound, "{name}: {by_ngspice:?} {by_core:?}");
    }
    core
}

#[test]
fn ngspice_has_the_mean_power_of_a_cantilever() {
    if !has_ngspice() {
        return;
    }
    let short = ["run.duration_s=0.25", "run.settle_s=0.05"];
    let cases: [(&str, &str, &[&str]); 5] = [
        ("export-free", BEAM, &[]),
        (
            "export-phase",
            BEAM,
            &["excitation.phase_rad=1", "parameters.coupling=one-way", "load.resistance_ohm=10k"],
        ),
        (
            "export-start",
            BEAM,
            &[
                "excitation.amplitude_m_per_s2=0.1",
                "initial.modal_displacement=[1e-6,0,0,0,0,0,0,0,0,0]",
                "initial.modal_velocity=[0,1e-3,0,0,0,0,0,0,0,0]",
                "initial.voltage_v=-3",
            ],
        ),
        ("export-series", BIMORPH, &[]),
        ("export-parallel", BIMORPH, &["parameters.transducer=bimorph-parallel"]),
    ];
    for (name, scene, changes) in cases {
        agreed(name, scene, &[&short[..], changes].concat(), 1e-3);
    }
}

#[test]
fn ngspice_has_the_mean_power_of_contact_separation() {
    const OF_22_HZ: [&str; 3] = ["excitation.frequency_hz=22.5", "run.duration_s=2", "run.settle_s=1"];
    if !has_ngspice() {
        return;
    }
    let constant = "parameters.restitution={kind=\"constant\",coefficient=0.6}";
    let low = ["excitation.frequency_hz=22.5", "run.duration_s=1", "run.settle_s=0.5"];
    // Overrides, bound of the relative difference, and least mean power in W: both branches at 22.5 Hz.
    let cases: [(&str, &[&str], f64, f64); 5] = [
        ("export-low", &OF_22_HZ, 1e-3, 0.0),
        ("export-high", &[&OF_22_HZ[..], &["initial.velocity_m_per_s=-0.5"]].concat(), 1e-2, 7e-6),
        ("export-impacts", &["run.duration_s=3", "run.settle_s=2"], 1e-2, 1e-5),
        (
            "export-transferred",
            &[&low[..], &["parameters.force_law=transferred-charge", "load.resistance_ohm=1G"]].concat(),
            1e-3,
            0.0,
        ),
        (
            "export-no-force",
            &[
                "run.duration_s=2",
                "run.settle_s=1",
                constant,
                "parameters.force_law=none",
                "load.resistance_ohm=1M",
                "initial.gap_m=2e-3",
                "initial.charge_c=1e-8",
            ],
            2e-2,
            1e-6,
        ),
    ];
    for (name, overrides, bound, least) in cases {
        let power = number(&agreed(name, PASSIVE, overrides, bound), "mean_power_w");
        assert!(power > least, "{name}: {power}");
    }
}

#[test]
fn ngspice_has_the_mean_power_of_sliding() {
    if !has_ngspice() {
        return;
    }
    let periods = ["run.duration_periods=10", "run.settle_periods=6"];
    let slide = ["excitation.frequency_hz=14", "excitation.amplitude_g=0.7"];
    let slip = ["excitation.frequency_hz=10"];
    let start = ["initial.displacement_m=-2e-3", "initial.velocity_m_per_s=0.1", "initial.charge_c=1e-8"];
    let passive =
        ["parameters.lateral_force=true", "parameters.force_law=gap-field", "load.resistance_ohm=1G"];
    // Overrides, bound of the relative difference, least mean power in W, and the share of the time in stick.
    let cases: [(&str, &[&str], f64, f64, f64); 5] = [
        ("export-slide", &slide, 2e-3, 1e-7, 0.0),
        ("export-slide-1k", &[&slide[..], &["load.resistance_ohm=1k"]].concat(), 2e-3, 1e-12, 0.0),
        ("export-slide-passive", &[&slide[..], &passive, &start].concat(), 2e-3, 1e-8, 0.0),
        ("export-slip", &slip, 5e-3, 1e-8, 0.19),
        (
            "export-slip-relaxing",
            &[&slip[..], &start, &["parameters.stick_charge=relaxing", "load.resistance_ohm=1M"]].concat(),
            5e-3,
            1e-9,
            0.19,
        ),
    ];
    for (name, changes, bound, least, stick) in cases {
        let overrides = [&periods[..], changes].concat();
        let core = agreed(name, SLIDING, &overrides, bound);
        let [power, found] = ["mean_power_w", "stick_fraction"].map(|name| number(&core, name));
        assert!(power > least && (found - stick).abs() < 0.01, "{name}: {power}, {found} in stick");
    }
}

#[test]
fn ngspice_charges_the_storage_of_a_bridge_as_the_scene_does() {
    if !has_ngspice() {
        return;
    }
    let folder = folder("store-bimorph");
    let deck = fs::read_to_string(BRIDGE_STORE).expect("the shipped deck");
    let deck = file(&folder, "bridge-store.cir", deck);
    accepted(&["export", BIMORPH, "--spice", &place(&folder, "harvester.cir")]);
    let by_ngspice = measured(&simulated(&folder, &deck), "store_v");
    let load =
        "load={kind=\"rectified-store\",capacitance_f=10e-6,diode_drop_v=0.3,leakage_ohm=1e9,initial_v=1}";
    let run = "run={duration_s=1,settle_s=0}";
    let core = json(&["run", BIMORPH, "--no-accuracy", "--set", load, "--set", run]);
    let by_core = number(&core, "store_voltage_v");
    // The energy that came in, so that what was there at the start covers nothing.
    let ratio = (by_ngspice.powi(2) - 1.0) / (by_core.powi(2) - 1.0);
    assert!(by_core > 1.5 && (ratio - 1.0).abs() < 1e-2, "{by_ngspice} V, {by_core} V");
}

#[test]
fn the_gain_of_parallel_sshi_is_that_of_prescribed_motion() {
    if !has_ngspice() {
        return;
    }
    let folder = folder("sshi");
    accepted(&["export", BIMORPH, "--spice", &place(&folder, "harvester.cir")]);
    let printed = simulated(&folder, SSHI);
    let [open, standard, sshi] = ["open_v", "standard_w", "sshi_w"].map(|name| measured(&printed, name));
    // docs/export.md derives both: quality 5 of the coil, frequency times capacitance times voltage squared.
    let inverted = (-std::f64::consts::PI / 99.0_f64.sqrt()).exp();
    let expected = [45.6 * 4.12599e-8 * open.powi(2), 2.0 / (1.0 - inverted)];
    assert!((standard / expected[0] - 1.0).abs() < 3e-3, "{standard} W, {expected:?}");
    // The switch closes 1/120 of a period late, and the inversion takes 1/100: less than the formula.
    assert!((sshi / standard / expected[1] - 1.0).abs() < 1e-2, "{sshi} W, {standard} W, {expected:?}");
}

#[test]
fn scenes_without_a_netlist_are_refused_and_nothing_is_written() {
    let folder = folder("export-refused");
    let [spice, deck, elsewhere] =
        ["harvester.cir", "test.cir", "elsewhere/test.cir"].map(|name| place(&folder, name));
    fs::create_dir(folder.join("elsewhere")).expect("a folder");
    refused(&["export", BUMP_STOP, "--spice", &spice], &["stop: must be absent"]);
    refused(&["export", BEAM, "--spice", &spice, "--deck", &elsewhere], &["--deck", "in the folder of"]);
    for (change, part) in [
        ("load.resistance_ohm=0", "load.resistance_ohm: must be above 0"),
        ("load={kind=\"dc-bus\",voltage_v=5,diode_drop_v=0}", "load.kind: must be \"resistor\""),
        ("excitation.frequency_hz=0", "excitation.frequency_hz: is 0"),
        ("excitation={kind=\"silence\"}", "excitation.kind: must be \"sine\""),
    ] {
        refused(&["export", BEAM, "--spice", &spice, "--deck", &deck, "--set", change], &[part]);
    }
    assert!(!folder.join("harvester.cir").exists() && !folder.join("test.cir").exists());
}

/// Without feedback the current into a bus is 4 f C (V − v), V the largest voltage of open terminals, and 0 beyond.
#[test]
fn a_sweep_with_a_bus_has_the_current_of_the_closed_form() {
    let set =
        set(&["parameters.coupling=one-way", "parameters.beam_modes=1", "run={duration_s=1.0,settle_s=0.8}"]);
    let open = json(&[&["run", BEAM, "--no-accuracy", "--set=load.resistance_ohm=inf"], &set[..]].concat());
    let open = 2f64.sqrt() * number(&open, "rms_voltage_v");
    let capacitance = 15.93e-9 * 50e-3 * 10e-3 / 0.5e-3;
    let voltages = format!("--over=load.voltage_v=0:{}:5", 2.0 * open);
    let load = "--set=load={kind=\"dc-bus\",voltage_v=0,diode_drop_v=0}";
    let options = ["--over=excitation.amplitude_m_per_s2=10:20:2", "--no-accuracy", "--format=csv"];
    let written = accepted(&[&["sweep", BEAM, load, &voltages], &options[..], &set].concat());
    let found: Vec<f64> =
        rows(&written).iter().map(|row| row["mean_store_current_a"].parse().expect("a number")).collect();
    let expected = [0.5, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(found.len(), expected.len());
    for (current, expected) in found.iter().zip(expected) {
        assert!((current / (4.0 * 220.0 * capacitance * open) - expected).abs() < 2e-3, "{found:?}");
    }
}
