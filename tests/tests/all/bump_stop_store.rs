//! The bump-stop scene behind a full bridge, from a scene file to an outcome.
//!
//! The expected store voltage is that of another program, which is not in this repository: event-driven, in NumPy,
//! by the eigenvectors of the six regimes of contact and bridge.

use std::path::Path;

use cross_crate_tests::{assert_close, value};
use host_bench::method::{Failure, Method, Options, Precision};
use host_bench::outcome::{Outcome, StoreOutcome};
use host_bench::run::run_scene;
use host_bench::scene_file::{self, Override, Scene};

/// The shipped scene with a load and with these keys changed.
fn shipped(load: &str, changes: &[(&str, &str)]) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-bench/scenes/bump-stop.toml");
    let changes = changes.iter().copied().chain([("load", load)]);
    let overrides: Vec<Override> = changes.map(|(key, value)| Override::new(key, value)).collect();
    scene_file::read(&file, &overrides).expect("the shipped scene is valid")
}

fn run(scene: &Scene, options: &Options) -> (Outcome, StoreOutcome) {
    let outcome = run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}"));
    let storage = outcome.store.expect("a storage");
    (outcome, storage)
}

const SIX_REGIMES: &str = "{kind='rectified-store',capacitance_f=0.2e-6,diode_drop_v=0.05,leakage_ohm=inf,\
     initial_v=0.2,draw={kind='resistor',value=2e6}}";
const OTHER_PROGRAM: [(&str, &str); 5] = [
    ("parameters.beam_modes", "4"),
    ("stop.rod_modes", "1"),
    ("stop.gap_m", "5e-6"),
    ("run.settle_s", "0"),
    ("run.duration_s", "12e-3"),
];

#[test]
fn the_store_voltage_of_another_program_comes_out_of_a_scene_file() {
    let scene = shipped(SIX_REGIMES, &OTHER_PROGRAM);
    let step = Options { step_s: Some(1e-7), trace_every_s: Some(1e-3), ..Options::default() };
    let (outcome, storage) = run(&scene, &step);
    assert_close("storage voltage", value(storage.store_voltage_v), 0.675_257_0, 1e-5);
    let voltage = value(storage.store_voltage_v);
    assert_close("stored energy", value(storage.stored_energy_j), 0.1e-6 * voltage * voltage, 1e-12);
    // What came in is stored or has gone out, and the ledgers of harvester and storage close.
    let gained = value(storage.stored_energy_j) - 0.1e-6 * 0.04;
    let delivered = value(outcome.delivered_energy_j);
    let left = delivered - value(storage.drawn_energy_j) - value(storage.leaked_energy_j);
    assert_close("gained", gained, left, 1e-9);
    assert_eq!(storage.leaked_energy_j, Some(0.0));
    assert!(value(storage.diode_loss_j) > 0.0);
    assert!(value(outcome.energy_residual) < 1e-10);
    // The run ends at the tick next to 12 ms.
    assert_close("mean power", value(outcome.mean_power_w), delivered / 12e-3, 1e-10);
    // The trace has the storage's voltage as its last column.
    let trace = outcome.trace.expect("a trace");
    assert_eq!(trace.columns.last(), Some(&"store_voltage_v"));
    assert!(trace.rows.iter().all(|row| row.len() == trace.columns.len()));
    let voltages: Vec<f64> = trace.rows.iter().filter_map(|row| row.last().copied()).collect();
    assert_eq!((voltages.len(), voltages[0], voltages[12]), (13, 0.2, voltage));
}

#[test]
fn steps_as_they_are_by_default_and_single_precision_keep_the_store_voltage() {
    let scene = shipped(SIX_REGIMES, &OTHER_PROGRAM);
    let single = Options { precision: Some(Precision::F32), ..Options::default() };
    for options in [Options::default(), single] {
        let (outcome, storage) = run(&scene, &options);
        println!("{}: {:?}, {:?}", outcome.precision, storage.store_voltage_v, outcome.energy_residual);
        assert_close("storage voltage", value(storage.store_voltage_v), 0.675_257_0, 1e-3);
        assert!(value(outcome.energy_residual) < 1e-3);
    }
}

#[test]
fn a_bus_has_a_voltage_and_no_energy() {
    let bus = "{kind='dc-bus',voltage_v=0.4,diode_drop_v=0.05}";
    let (outcome, storage) = run(&shipped(bus, &OTHER_PROGRAM), &Options::default());
    assert_eq!((storage.store_voltage_v, storage.stored_energy_j), (Some(0.4), None));
    assert!(value(outcome.mean_power_w) > 0.0 && value(outcome.energy_residual) < 1e-10);
    // The bridge holds the terminals at the bus and two diodes.
    assert_close("peak voltage", value(outcome.peak_voltage_v), 0.5, 1e-9);
    assert_close("diode loss", value(storage.diode_loss_j), value(outcome.delivered_energy_j) / 4.0, 1e-9);
}

#[test]
fn methods_without_a_bridge_refuse_it() {
    let scene = shipped(SIX_REGIMES, &OTHER_PROGRAM);
    for method in [Method::TrBdf2, Method::Rk4, Method::Newmark] {
        let refused = run_scene(&scene, &Options { method, ..Options::default() });
        let Err(Failure::Input(told)) = refused else { panic!("{method:?} runs") };
        assert!(told.contains("load.kind: must be \"resistor\""), "{told}");
    }
}
