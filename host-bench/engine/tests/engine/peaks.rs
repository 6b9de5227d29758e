//! Peaks of a run: what counts at the start, behind a bridge and between steps; and voltages within a rounding.

use harvester_engine::embedded;
use harvester_scene::method::{Failure, Method, Options, Precision};
use harvester_scene::outcome::{ClampOutcome, Outcome};
use harvester_scene::scene_file;

fn in_precision(precision: Precision) -> Options {
    Options { precision: Some(precision), ..Options::default() }
}

/// A run of a shipped scene with these keys changed.
fn run(name: &str, changes: &[(&str, &str)], options: &Options) -> Result<Outcome, Failure> {
    embedded::run(&scene_file::read_shipped(name, changes).expect("valid"), options)
}

fn peak(name: &str, changes: &[(&str, &str)], options: &Options) -> f64 {
    let short = [("run.settle_s", "0"), ("run.duration_s", "0.01")];
    let outcome = run(name, &[&short, changes].concat(), options).expect("runs");
    outcome.peak_voltage_v.expect("finite")
}

fn clamp(changes: &[(&str, &str)]) -> ClampOutcome {
    let outcome = run("bump-stop-none", changes, &in_precision(Precision::F64)).expect("runs");
    outcome.bump_stop().and_then(|found| found.clamp).expect("measured")
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() <= tolerance, "{what}: {found} against {expected}");
}

/// A bus leaves its own voltage and two drops, a storage `C_s` of the start voltage `V` above the threshold `U` leaves
/// `U + (V − U) C_p/(C_p + C_s)`.
#[test]
fn a_start_voltage_that_a_bridge_clamps_at_once_is_no_peak() {
    let bus = "{kind=\"dc-bus\",voltage_v=0.23,diode_drop_v=0.1}";
    let start = [("load", bus), ("initial.voltage_v", "-62")];
    close("bus", peak("bump-stop-none", &start, &in_precision(Precision::F64)), 0.43, 1e-12);
    let store = "{kind=\"rectified-store\",capacitance_f=1e-9,diode_drop_v=0.3,initial_v=1,leakage_ohm=1e6}";
    let start = [("load", store), ("initial.voltage_v", "50")];
    // Of a layer of 0.5 mm, 50 mm by 10 mm.
    let own = 15.93e-9 * 50e-3 * 10e-3 / 0.5e-3;
    close(
        "store",
        peak("bump-stop-none", &start, &in_precision(Precision::F64)),
        1.6 + 48.4 * own / (own + 1e-9),
        1e-9,
    );
    let load = [("load", bus), ("run.settle_s", "0"), ("run.duration_s", "0.01")];
    let found = clamp(&[&load[..], &[("initial.voltage_v", "5000")]].concat());
    let still = clamp(&load);
    close("stress", found.clamp_stress_peak_pa, still.clamp_stress_peak_pa, 0.05);
}

/// `V = ((σS − q) x − q d/ε_r)/ε0 S` of the start, however fast the circuit; the charge of a slider at rest on the
/// electrode is held until it slips.
#[test]
fn a_start_charge_at_a_resistor_is_a_peak_at_any_resistance() {
    let volts = (15e-9 * 3e-3 - 5e-9 * 25e-6) / (8.854_187_812_8e-12 * 4e-4);
    for resistance in ["1e8", "1e3", "1e-3"] {
        let start = [("load.resistance_ohm", resistance), ("initial.charge_c", "5e-9")];
        close(
            resistance,
            peak("contact-separation-passive", &start, &in_precision(Precision::F64)),
            volts,
            1e-9,
        );
        close(
            resistance,
            peak("contact-separation-passive", &start, &in_precision(Precision::F32)),
            volts,
            1e-5,
        );
        let volts = 44.937_758_961;
        close(resistance, peak("sliding", &start, &in_precision(Precision::F64)), volts, 1e-9);
    }
}

/// Between its ends a step has a voltage of a parabola, which a conducting bridge cuts off.
#[test]
fn behind_a_bus_the_peak_is_its_threshold() {
    let bus = ("load", "{kind=\"dc-bus\",voltage_v=1,diode_drop_v=0.3}");
    let rough = Options { tolerance: Some(1e-4), ..in_precision(Precision::F32) };
    for scene in ["sliding", "contact-separation-passive"] {
        let changes = [bus, ("run.settle_s", "0.5"), ("run.duration_s", "2")];
        let outcome = run(scene, &changes, &rough).expect("runs");
        close(scene, outcome.peak_voltage_v.expect("finite"), 1.6, 1e-6);
    }
}

/// 4.4999999 is 4.5 in single precision.
#[test]
fn a_start_voltage_below_the_turn_on_voltage_by_less_than_a_rounding_connects_no_draw() {
    let drawn = |precision| {
        let changes = [("load.initial_v", "4.4999999"), ("run.settle_s", "0"), ("run.duration_s", "3")];
        let outcome = run("rectified", &changes, &in_precision(precision)).expect("runs");
        outcome.store.and_then(|store| store.drawn_energy_j).expect("a draw")
    };
    close("drawn", drawn(Precision::F32), drawn(Precision::F64), 0.02);
}

/// With a voltage a hundred-thousandth of the harvester's, whose roundings are a part of it.
#[test]
fn a_storage_of_picofarads_in_single_precision_takes_the_steps_of_double_precision() {
    for scene in ["contact-separation", "contact-separation-passive", "sliding"] {
        for capacitance in ["1e-12", "1e-11"] {
            let store = format!(
                "{{kind=\"rectified-store\",diode_drop_v=0,initial_v=1,capacitance_f={capacitance},leakage_ohm=1e6}}"
            );
            let changes = [("load", &*store), ("run", "{duration_periods=36,settle_periods=20}")];
            let [single, double] = [Precision::F32, Precision::F64]
                .map(|precision| run(scene, &changes, &in_precision(precision)).expect("runs"));
            let attempts = |run: &Outcome| run.steps + run.rejected_steps;
            assert!(
                attempts(&single) < 2 * attempts(&double),
                "{scene} {capacitance}: {}",
                attempts(&single)
            );
            close(
                scene,
                single.mean_power_w.expect("a window"),
                double.mean_power_w.expect("a window"),
                0.02,
            );
        }
    }
}

/// A charge that holds the plates together, and a storage of a few picofarads that follows its roundings.
#[test]
fn a_run_of_steps_without_end_says_so() {
    let store = "{kind=\"rectified-store\",diode_drop_v=0,initial_v=0,capacitance_f=7e-12,leakage_ohm=5e7}";
    let changes = [
        ("parameters.parasitic_capacitance_f", "2.2e-9"),
        ("parameters.force_law", "gap-field"),
        ("parameters.relative_permittivity", "1.285"),
        ("parameters.restitution", "{kind=\"constant\",coefficient=0.99}"),
        ("parameters.electrode_area_m2", "4.5e-4"),
        ("parameters.charge_density_c_per_m2", "5.5e-5"),
        ("initial.charge_c", "3.931e-7"),
        ("excitation.amplitude_g", "3"),
        ("excitation.frequency_hz", "6.31"),
        ("load", store),
        ("run", "{duration_s=0.1,settle_s=0}"),
    ];
    let failure = run("contact-separation", &changes, &in_precision(Precision::F32)).expect_err("is stuck");
    assert!(failure.to_string().starts_with("steps without end at"), "{failure}");
}

/// A tight tolerance takes a hundred thousand steps a radian and is no run without end.
#[test]
fn a_tight_tolerance_of_tr_bdf2_comes_to_its_end() {
    let options =
        Options { method: Method::TrBdf2, tolerance: Some(1e-10), bare: true, ..Options::default() };
    let short = [("run.duration_s", "0.05"), ("run.settle_s", "0")];
    let found = run("contact-separation-passive", &short, &options).expect("comes to its end");
    assert!(found.steps > 1 << 19, "{}", found.steps);
}
