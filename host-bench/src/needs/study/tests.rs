//! The mean over the runs of a chaotic scene.

use super::*;
use crate::outcome::standard_error_of_sum;
use crate::scene_file;

const ACCURACY: f64 = 0.2;

/// The stop at mid-span, with few modes and a short window.
fn scene(duration_s: &str) -> Scene {
    let changes = [
        ("parameters.beam_modes", "2"),
        ("stop.rod_modes", "1"),
        ("run.duration_s", duration_s),
        ("run.settle_s", "0.1"),
    ];
    scene_file::read_shipped("bump-stop-mid-span", &changes).expect("valid")
}

/// The window of 14 s ends within a cycle of the switch, the one of 15 s just after a turn-on.
#[test]
fn a_switched_storage_is_compared_over_whole_cycles_wherever_the_window_ends() {
    let of = |duration_s: &str| {
        let changes = [("run.duration_s", duration_s)];
        let scene = scene_file::read_shipped("rectified", &changes).expect("valid");
        let study = Study::new(&scene, 0.01).expect("runs");
        let change = study.change(&[Part::ElectrostaticForce]).expect("runs");
        (study, change)
    };
    let [(study, one), (_, other)] = ["14", "15"].map(of);
    for change in [one, other] {
        assert!(change.is_within(0.01) == Some(true) && change.largest() < 0.005, "{change:?}");
    }
    let [one, other] = [one, other].map(|change| change.store_voltage.expect("a storage"));
    assert!((one - other).abs() < 1e-6, "{one} {other}");
    // The meter of a window from the first turn-on to the last finds the same mean.
    let cycles = cycles(&study.full).expect("cycles");
    assert_eq!(cycles.count, 4);
    let mut scene = study.scene.clone();
    (scene.run.settle_s, scene.run.duration_s) = (cycles.from_s, cycles.until_s);
    let run = run_scene(&scene, &study.options).expect("runs");
    let [found, mean] = [cycles.mean_power_w, run.mean_power_w.expect("a mean")];
    assert!((found / mean - 1.0).abs() < 1e-6, "{found} {mean}");
}

#[test]
fn the_mean_over_runs_is_that_of_a_long_window_and_decides_early() {
    let study = Study::new(&scene("0.5"), ACCURACY).expect("runs");
    assert!(study.is_chaotic && study.is_sound(), "{:?}", study.full.accuracy);
    // Each look doubles the runs from eight on.
    assert!(study.runs() >= 8 && study.runs().is_power_of_two(), "{}", study.runs());
    let (found, scatter) = (study.full.mean_power_w.expect("a mean"), study.accuracy_of_a_run() - ACCURACY);
    assert!(scatter > 0.01, "{scatter}");
    // Twenty windows after each other, of which the sixteen parts say how well their mean is known.
    let long = run_scene(&scene("8.1"), &study.options).expect("runs");
    let mean = long.mean_power_w.expect("a mean");
    let error = standard_error_of_sum(&long.block_energies_j) / long.block_energies_j.iter().sum::<f64>();
    let of_runs = scatter / OF_A_RUN / (study.runs() as f64).sqrt();
    assert!((found / mean - 1.0).abs() < 4.0 * error.hypot(of_runs), "{found} {mean} {error} {of_runs}");
    // What is clear takes the fewest runs.
    let change = study.change(&[Part::Stop]).expect("runs");
    assert_eq!((change.runs, change.is_within(ACCURACY)), (FEWEST_RUNS, Some(false)));
    // Nothing is left out: the runs are the same, and do not scatter against each other.
    let change = study.change(&[]).expect("runs");
    assert_eq!((change.runs, change.mean_power, change.sampling_error), (FEWEST_RUNS, Some(0.0), Some(0.0)));
}
