//! Closed forms against trajectories: where one is claimed to hold it does, and where the motion leaves its
//! regime it says so.

use std::path::Path;

use cross_crate_tests::{
    GRAVITY, adaptive, assert_close, contact_separation, on_all_cores, periods, reference, resistor, sine,
    sliding, value,
};
use host_bench::closed_form::estimate;
use host_bench::method::{Options, Precision};
use host_bench::outcome::{Outcome, Particular};
use host_bench::run::run_scene;
use host_bench::scene_file::{self, Model, Scene};

fn run(scene: &Scene, options: &Options) -> Outcome {
    run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}"))
}

/// The closed form in single precision, as a node has it, must hold and have the mean power of the reference.
fn compare(cases: &[(Scene, f64)]) {
    let found = on_all_cores(cases, |(scene, _)| {
        let estimate = estimate(scene, Precision::F32).expect("one sine");
        (estimate, run(scene, &reference()))
    });
    for ((scene, tolerance), (estimate, outcome)) in cases.iter().zip(found) {
        let what = format!("{} at {:?}, {:?}", scene.name(), scene.excitation, scene.load);
        println!("{what}: {estimate:?}, {:?} W", outcome.mean_power_w);
        assert!(estimate.holds(), "{what}: {estimate:?}");
        assert_close(&what, estimate.mean_power_w, value(outcome.mean_power_w), *tolerance);
    }
}

/// Twenty seconds, of which the last two count: ten times the time in which a disturbance fades.
fn plate(gravities: f64, frequency_hz: f64, resistance: f64) -> Scene {
    contact_separation(|scene, _| {
        scene.load = resistor(resistance);
        scene.excitation = sine(gravities, frequency_hz);
        let count = |seconds: f64| (seconds * frequency_hz) as u32;
        scene.run = periods(frequency_hz, count(20.0), count(2.0));
    })
}

fn slider(density: f64, gravities: f64, frequency_hz: f64, resistance: f64) -> Scene {
    sliding(|scene, model| {
        model.parameters.charge_density_c_per_m2 = density;
        scene.load = resistor(resistance);
        scene.excitation = sine(gravities, frequency_hz);
        scene.run = periods(frequency_hz, 240, 20);
    })
}

fn beam(name: &str, amplitude: f64, frequency_hz: f64, resistance: f64) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-bench/scenes").join(name);
    let mut scene = scene_file::read(&file, &[]).expect("the shipped scene is valid");
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
fn a_plate_that_does_not_touch_delivers_what_the_reference_says() {
    compare(&[
        (plate(0.2, 18.0, 1e8), 5e-3),
        (plate(0.2, 22.5, 1e6), 5e-3),
        (plate(0.01, 19.4, 1e9), 3e-2),
        (plate(0.3, 12.0, 1e10), 5e-3),
    ]);
}

#[test]
fn a_slider_that_does_not_stick_delivers_what_the_reference_says() {
    compare(&[
        (slider(80e-6, 0.36, 18.373, 1e8), 2e-2),
        (slider(20e-6, 0.36, 17.0, 1e7), 3e-2),
        (slider(120e-6, 0.5, 18.2, 1e9), 2e-2),
    ]);
}

#[test]
fn a_beam_clear_of_its_stop_delivers_what_the_reference_says() {
    compare(&[
        (beam("bump-stop-none.toml", 20.0, 220.0, 1e6), 1e-3),
        (beam("bump-stop-none.toml", 20.0, 240.0, 2e4), 1e-3),
        (beam("bump-stop.toml", 2.0, 220.0, 1e5), 1e-3),
    ]);
}

/// Motions with impacts, sticks and contacts: what the runs count, the closed forms must not hold for.
#[test]
fn motions_out_of_the_regime_are_flagged() {
    let cases = [
        plate(0.2, 19.5, 1e8),
        plate(0.2, 20.1, 1e6),
        plate(1.0, 18.0, 1e8),
        slider(80e-6, 0.30, 6.0, 1e8),
        slider(80e-6, 0.30, 10.0, 1e8),
        slider(80e-6, 0.28, 14.0, 1e8),
        beam("bump-stop.toml", 20.0, 220.0, 1e6),
        beam("bump-stop.toml", 5.0, 235.0, 1e6),
        beam("bump-stop-mid-span.toml", 20.0, 220.0, 1e6),
    ];
    for (scene, outcome) in cases.iter().zip(on_all_cores(&cases, |scene| {
        let is_beam = scene.name() == "bump-stop";
        run(scene, &if is_beam { Options::default() } else { adaptive(1e-4) })
    })) {
        let counted = match &outcome.particular {
            Particular::ContactSeparation(motion) => motion.impacts as f64,
            Particular::Sliding(motion) => value(motion.stick_fraction),
            Particular::BumpStop(motion) => motion.contacts as f64,
        };
        assert!(counted > 0.0, "{:?} is regular", scene.excitation);
        let estimate = estimate(scene, Precision::F32).expect("one sine");
        assert!(!estimate.holds(), "{} {:?}: {estimate:?}", scene.name(), scene.excitation);
    }
}
