//! The figures of the estimator for its own error, by the step and by rounding, against the actual error.

use super::calibration::{contact_scenes, sliding_scenes};
use super::{follow, hybrid, settings};
use crate::common::harvesters::{bump, contact_parameters, sine_samples, sliding_parameters};
use crate::common::{adaptive, fixed};
use model_core::energy::{Estimate, Estimator};
use model_core::integrate::{StepControl, TrBdf2};
use model_core::part::GRAVITY;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::AnyContact;
use model_core::scene::{Harvester, Scene};

/// One run from rest: the energy in joules, and the figures for its error by step and by rounding.
fn measured<S: Scalar, A: Scene<S, 3, 1>, C: StepControl<S>>(
    scene: A,
    control: C,
    samples: &[S],
) -> [f64; 3] {
    let mut estimator = Estimator::new(hybrid(scene, TrBdf2, control), settings(400.0)).expect("valid");
    let Estimate { energy, uncertainty, .. } = follow(&mut estimator, samples);
    [energy, uncertainty.step.expect("an estimate"), uncertainty.rounding].map(S::to_f64)
}

/// The figure for the error by the step over the actual error, for each tolerance of a scene.
fn step_figures<A: Scene<f64, 3, 1> + Copy>(name: &str, scene: A, samples: &[f64]) -> Vec<f64> {
    let [exact, ..] = measured(scene, adaptive(1e-6), samples);
    let mut ratios = Vec::new();
    for tolerance in [1e-1, 5e-2, 1e-2, 1e-3, 1e-4] {
        let [energy, step, _] = measured(scene, adaptive(tolerance), samples);
        let (actual, figure) = ((energy / exact - 1.0).abs(), step / energy);
        println!("| {name} | {tolerance:.0e} | {actual:.1e} | {figure:.1e} | {:.1} |", figure / actual);
        ratios.push(figure / actual);
    }
    ratios
}

#[test]
fn the_figure_for_the_step_is_of_the_size_of_the_actual_error() {
    for (resistance, load) in [(1e8, "100 MΩ"), (1e6, "1 MΩ")] {
        let mut parameters = contact_parameters::<f64>();
        parameters.choices.load.resistance = resistance;
        let samples = sine_samples(1.962, 20.0, 400.0, 2000);
        let scene = parameters.build().expect("in bounds");
        let ratios = step_figures(&format!("contact-separation, {load}"), scene, &samples);
        assert!(ratios.iter().all(|ratio| (1.0..30.0).contains(ratio)), "{ratios:?}");

        let mut parameters = sliding_parameters::<f64>();
        parameters.choices.load.resistance = resistance;
        let samples = sine_samples(0.36 * GRAVITY, 18.373, 400.0, 2000);
        let scene = parameters.build().expect("in bounds");
        let ratios = step_figures(&format!("sliding, {load}"), scene, &samples);
        assert!(ratios.iter().all(|ratio| (1.0..6.0).contains(ratio)), "{ratios:?}");
    }
}

/// Samples in single precision, and the same numbers in double.
fn both_precisions(amplitude: f64, frequency: f64, rate: f64, count: u32) -> (Vec<f32>, Vec<f64>) {
    let single = sine_samples::<f32>(amplitude, frequency, rate, count);
    let double = single.iter().map(|&sample| f64::from(sample)).collect();
    (single, double)
}

/// Asserts that the figure for rounding covers the difference between two precisions.
fn covers(exact: f64, single: f64, figure: f64) {
    let (actual, figure) = ((single / exact - 1.0).abs(), figure / single);
    println!("actual {actual:.1e}, figure {figure:.1e}");
    assert!(actual < figure && figure < 1e-5, "{actual} {figure}");
}

/// The same with steps of one length in s: only rounding differs, that of the step included.
fn covers_with_steps<A: Scene<f32, 3, 1>, B: Scene<f64, 3, 1>>(
    (of_single, of_double): (A, B),
    step: f64,
    (single, double): (Vec<f32>, Vec<f64>),
) {
    let [exact, ..] = measured(of_double, fixed(step), &double);
    let [energy, _, figure] = measured(of_single, fixed(step), &single);
    covers(exact, energy, figure);
}

#[test]
fn the_figure_for_rounding_covers_single_precision_in_regular_motion() {
    for step in [2e-4, 5e-5] {
        for resistance in [1e8, 1e6] {
            let samples = both_precisions(0.36 * GRAVITY, 18.373, 400.0, 1200);
            covers_with_steps(sliding_scenes(8e-3, resistance), step, samples);
            let samples = both_precisions(1.962, 20.0, 400.0, 1200);
            covers_with_steps(contact_scenes(80.0, resistance), step, samples);
        }
    }
    // Bump-stop that is not shaken enough to touch: with contact it is chaotic.
    let (single, double) = both_precisions(2.0, 220.0, 3200.0, 6400);
    let of_double = bump::<f64, 4, 1>(AnyContact::ResidualFlexibility);
    let exact = follow(&mut Estimator::new(of_double, settings(3200.0)).expect("valid"), &double);
    let of_single = bump::<f32, 4, 1>(AnyContact::ResidualFlexibility);
    let rounded = follow(&mut Estimator::new(of_single, settings(3200.0)).expect("valid"), &single);
    covers(exact.energy, rounded.energy.into(), rounded.uncertainty.rounding.into());
}

/// A motion that decays freely after an outage, while the harvester of the estimator rests.
#[test]
fn the_energy_that_a_motion_would_deliver_after_an_outage_is_stated() {
    let rate = 400.0;
    let mut parameters = contact_parameters::<f64>();
    // 20 Hz below contact: a linear resonator of the decay rate 0.5 /s.
    (parameters.initial_gap, parameters.damping_ratio) = (2e-2, 4e-3);
    let harvester = hybrid(parameters.build().expect("in bounds"), TrBdf2, adaptive(1e-3));
    let mut samples = vec![0.0; 1200];
    samples.extend(sine_samples::<f64>(1.0, harvester.resonance_frequency(), rate, 200));
    for after in [200, 400, 1600] {
        let [mut whole, mut gappy] =
            [(); 2].map(|()| Estimator::new(harvester, settings(rate)).expect("valid"));
        let silence = vec![0.0; after];
        follow(&mut gappy, &samples);
        assert!(gappy.push_missing(60, u32::MAX).expect("runs").finished);
        let found = follow(&mut gappy, &silence);
        follow(&mut whole, &samples);
        let exact = follow(&mut whole, &[silence, vec![0.0; 60]].concat()).energy;
        let (error, stated) = (exact / found.energy - 1.0, found.uncertainty.relative.expect("known"));
        println!("{after} samples after: error {error:.3}, stated {stated:.3}");
        assert!(error > 0.5 && (error..4.0 * error).contains(&stated), "{error} {stated}");
    }
}
