//! The closed form of the beam against trajectories: where one is claimed to hold it does, and where the motion leaves its
//! regime it says so.

use cross_crate_tests::{
    GRAVITY, assert_close, on_all_cores, outcome, periods, reference, resistor, shipped, sine, value,
};
use host_bench::closed_form::estimate;
use host_bench::method::{Options, Precision};
use host_bench::scene_file::{Model, Scene};

/// The closed form in single precision, as a node has it, must hold and have the mean power of the reference.
fn compare(cases: &[(Scene, f64)]) {
    let found = on_all_cores(cases, |(scene, _)| {
        let estimate = estimate(scene, Precision::F32).expect("one sine");
        (estimate, outcome(scene, &reference()))
    });
    for ((scene, tolerance), (estimate, outcome)) in cases.iter().zip(found) {
        let what = format!("{} at {:?}, {:?}", scene.name(), scene.excitation, scene.load);
        println!("{what}: {estimate:?}, {:?} W", outcome.mean_power_w);
        assert!(estimate.holds, "{what}: {estimate:?}");
        assert_close(&what, estimate.mean_power_w, value(outcome.mean_power_w), *tolerance);
    }
}

fn beam(name: &str, amplitude: f64, frequency_hz: f64, resistance: f64) -> Scene {
    let mut scene = shipped(name, &[]);
    // Few modes: the reference resolves the fastest.
    let Model::BumpStop(model) = &mut scene.model else { panic!("a bump-stop scene") };
    model.parameters.beam_modes = 4;
    if let Some(stop) = &mut model.stop {
        stop.rod_modes = 1;
    }
    scene.load = resistor(resistance);
    scene.excitation = sine(amplitude / GRAVITY, frequency_hz);
    let count = |seconds: f64| (seconds * frequency_hz) as u32;
    scene.run = periods(frequency_hz, count(0.8), count(0.2));
    scene
}

#[test]
fn a_beam_clear_of_its_stop_delivers_what_the_reference_says() {
    compare(&[
        (beam("bump-stop-none", 20.0, 220.0, 1e6), 1e-3),
        (beam("bump-stop-none", 20.0, 240.0, 2e4), 1e-3),
        (beam("bump-stop", 2.0, 220.0, 1e5), 1e-3),
    ]);
}

/// Motions with contact: what the runs count, the closed form must not hold for.
#[test]
fn motions_out_of_the_regime_are_flagged() {
    let cases = [
        beam("bump-stop", 20.0, 220.0, 1e6),
        beam("bump-stop", 5.0, 235.0, 1e6),
        beam("bump-stop-mid-span", 20.0, 220.0, 1e6),
    ];
    let outcomes = on_all_cores(&cases, |scene| outcome(scene, &Options::default()));
    for (scene, outcome) in cases.iter().zip(outcomes) {
        let motion = outcome.bump_stop().expect("a beam");
        assert!(motion.contacts > 0, "{:?} is regular", scene.excitation);
        let estimate = estimate(scene, Precision::F32).expect("one sine");
        assert!(!estimate.holds, "{} {:?}: {estimate:?}", scene.name(), scene.excitation);
    }
}
