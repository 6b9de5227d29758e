//! The bump-stop scene behind a full bridge, from a scene file to an outcome.
//!
//! The expected store voltage is that of another program, which is not in this repository: event-driven, in NumPy,
//! by the eigenvectors of the six regimes of contact and bridge.

use cross_crate_tests::{assert_close, outcome, reference, shipped, value};
use host_bench::method::{Failure, Method, Options};
use host_bench::outcome::{Outcome, StoreOutcome};
use host_bench::run::run_scene;
use host_bench::scene_file::Scene;

/// The shipped scene with a load and with these keys changed.
fn with_load(name: &str, load: &str, changes: &[(&str, &str)]) -> Scene {
    shipped(name, &[changes, &[("load", load)]].concat())
}

fn run(scene: &Scene, options: &Options) -> (Outcome, StoreOutcome) {
    let outcome = outcome(scene, options);
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
    let scene = with_load("bump-stop", SIX_REGIMES, &OTHER_PROGRAM);
    let step = Options { step_s: Some(1e-7), trace_every_s: Some(1e-3), ..Options::default() };
    let (exact, exact_storage) = run(&scene, &Options { trace_every_s: Some(12e-3), ..reference() });
    assert!((value(exact_storage.store_voltage_v) - 0.675_257_0).abs() <= 0.6e-7, "{exact_storage:?}");
    let rows = exact.trace.expect("a trace").rows;
    assert!((rows[1][4] - 0.216_503_9).abs() <= 0.6e-7, "{rows:?}");
    assert_eq!((exact.events, Some(rows[1][7])), (54, exact_storage.store_voltage_v));
    assert!(value(exact.energy_residual) < 1e-12, "{:?}", exact.energy_residual);
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
fn a_bus_has_a_voltage_and_no_energy() {
    let bus = "{kind='dc-bus',voltage_v=0.4,diode_drop_v=0.05}";
    let (outcome, storage) = run(&with_load("bump-stop", bus, &OTHER_PROGRAM), &Options::default());
    assert_eq!((storage.store_voltage_v, storage.stored_energy_j), (Some(0.4), None));
    assert!(value(outcome.mean_power_w) > 0.0 && value(outcome.energy_residual) < 1e-10);
    // The bridge holds the terminals at the bus and two diodes.
    assert_close("peak voltage", value(outcome.peak_voltage_v), 0.5, 1e-9);
    assert_close("diode loss", value(storage.diode_loss_j), value(outcome.delivered_energy_j) / 4.0, 1e-9);
}

#[test]
fn methods_without_a_bridge_refuse_it() {
    let scene = with_load("bump-stop", SIX_REGIMES, &OTHER_PROGRAM);
    for method in [Method::TrBdf2, Method::Rk4, Method::Newmark] {
        let refused = run_scene(&scene, &Options { method, ..Options::default() });
        let Err(Failure::Input(told)) = refused else { panic!("{method:?} runs") };
        assert!(told.contains("load.kind: must be \"resistor\""), "{told}");
    }
}
