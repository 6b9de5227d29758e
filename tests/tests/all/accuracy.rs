//! The accuracy statement of `run`: true errors lie within it, and wrong numbers are announced.

use cross_crate_tests::{contact_separation, on_all_cores, reference, shipped, single, value};
use host_bench::accuracy::run_with_accuracy;
use host_bench::method::{Method, Options, Precision};
use host_bench::outcome::{Outcome, fields};
use host_bench::run::run_scene;
use host_bench::scene_file::{Excitation, ForceLaw, RunSpan, Scene, Tone, Trace};
use host_bench::stability::{draw, draw_varied};

fn stated(scene: &Scene, options: &Options) -> Outcome {
    run_with_accuracy(scene, options).unwrap_or_else(|failure| panic!("{failure}"))
}

fn is_warned(outcome: &Outcome) -> bool {
    outcome.warnings.iter().any(|warning| warning.starts_with("accuracy:"))
}

/// A bump-stop scene without a stop, with these keys changed.
fn bump_stop(changes: &[(&str, &str)]) -> Scene {
    shipped("bump-stop-none", changes)
}

/// The relative error of the mean power, which must lie within the statement.
#[track_caller]
fn error_within_statement(scene: &Scene, options: &Options, exact: f64) -> f64 {
    let found = stated(scene, options);
    let error = (value(found.mean_power_w) / exact - 1.0).abs();
    let total = value(found.accuracy.total);
    assert!(error <= total, "{error:e} is not within {total:e}: {:?}", found.accuracy);
    error
}

const SHORT: (&str, &str) = ("run", "{duration_s=0.05,settle_s=0.01}");

#[test]
fn a_small_leaking_storage_behind_the_bridge_of_bump_stop_is_right() {
    for (capacitance, leakage) in [("1e-9", "1e4"), ("1e-11", "1e6"), ("1e-7", "1e3")] {
        let load = format!(
            "{{kind='rectified-store',capacitance_f={capacitance},initial_v=0.0,diode_drop_v=0.3,\
             leakage_ohm={leakage}}}"
        );
        let scene = bump_stop(&[("parameters.beam_modes", "4"), SHORT, ("load", &load)]);
        let exact = value(run_scene(&scene, &reference()).expect("runs").mean_power_w);
        assert!(error_within_statement(&scene, &Options::default(), exact) < 2e-3, "{load}");
        assert!(error_within_statement(&scene, &single(Options::default()), exact) < 2e-3, "{load}");
    }
}

#[test]
fn a_fast_base_within_a_step_of_bump_stop_is_right() {
    let fast = bump_stop(&[SHORT, ("excitation.frequency_hz", "4200")]);
    let mut sampled = bump_stop(&[SHORT]);
    // Samples at 100 kHz that a step of 20 µs does not see.
    let samples: Vec<f64> =
        (0..6000_i32).map(|n| 40.0 * f64::from(n % 7 - 3) + f64::from(n % 401 - 200)).collect();
    let trace = Trace { samples_m_per_s2: samples.into(), rate_hz: 1e5, repeat: true, resampled: None };
    sampled.excitation = Excitation::File(trace);
    for scene in [fast, sampled] {
        let exact = value(run_scene(&scene, &reference()).expect("runs").mean_power_w);
        let found = value(stated(&scene, &Options::default()).mean_power_w);
        assert!((found / exact - 1.0).abs() < 2e-3, "{found:e} {exact:e}");
    }
}

#[test]
fn bump_stop_takes_the_steps_that_meet_an_accuracy() {
    let scene = shipped("bump-stop-tip", &[("run", "{duration_s=0.15,settle_s=0.05}")]);
    let steps = [1e-2, 1e-4].map(|accuracy| {
        let options = Options { accuracy: Some(accuracy), ..Options::default() };
        let found = stated(&scene, &options);
        assert!(value(found.accuracy.total) <= accuracy, "{accuracy}: {:?}", found.accuracy);
        assert!(!is_warned(&found), "{:?}", found.warnings);
        found.steps
    });
    assert!(steps[1] > 2 * steps[0], "{steps:?}");
}

#[test]
fn steps_of_bump_stop_that_are_too_few_for_a_period_are_announced() {
    let few =
        [("parameters.beam_modes", "4"), ("stop.rod_modes", "1"), ("run", "{duration_s=0.01,settle_s=0}")];
    let coarse = Options { step_s: Some(1e-3), ..Options::default() };
    // Half the step was 0.1 % off in a run that is 4 % off.
    let law =
        [("stop.contact", "restitution"), ("stop.restitution", "0.5"), ("parameters.damping_ratio", "0.3")];
    let damped = shipped("bump-stop", &[&few[..], &law].concat());
    let exact = value(run_scene(&damped, &reference()).expect("runs").mean_power_w);
    assert!(error_within_statement(&damped, &coarse, exact) > 0.01);
    assert!(is_warned(&stated(&damped, &coarse)));
}

#[test]
fn without_power_the_statement_is_that_of_the_motion_and_the_voltage() {
    let few =
        [("parameters.beam_modes", "4"), ("stop.rod_modes", "1"), ("run", "{duration_s=0.01,settle_s=0}")];
    for resistance in ["0", "inf"] {
        let scene = shipped("bump-stop", &[&few[..], &[("load.resistance_ohm", resistance)]].concat());
        let fine = stated(&scene, &Options::default());
        assert_eq!(fine.delivered_energy_j, Some(0.0));
        let coarse = stated(&scene, &Options { step_s: Some(1e-3), ..Options::default() });
        let tip = |outcome: &Outcome| value(outcome.bump_stop().expect("bump-stop").peak_tip_displacement_m);
        let error = (tip(&coarse) / tip(&fine) - 1.0).abs();
        assert!(error > 0.1 && error < value(coarse.accuracy.total), "{error:e}: {:?}", coarse.accuracy);
        assert!(coarse.warnings.iter().any(|warning| warning.contains("the largest motion")), "{coarse:?}");
    }
}

#[test]
fn a_tolerance_that_is_too_loose_is_announced() {
    let scene = contact_separation(|scene, _| scene.run = RunSpan { duration_s: 1.5, settle_s: 0.5 });
    let exact = value(run_scene(&scene, &reference()).expect("runs").mean_power_w);
    for options in [
        Options { tolerance: Some(0.1), ..Options::default() },
        Options { method: Method::TrBdf2, tolerance: Some(0.1), ..Options::default() },
    ] {
        let error = error_within_statement(&scene, &options, exact);
        let found = stated(&scene, &options);
        assert!(error > 5e-3 && is_warned(&found), "{error:e} {:?}", found.accuracy);
    }
    let usual = stated(&scene, &Options::default());
    assert!(!is_warned(&usual), "{:?}", usual.warnings);
    assert!(value(usual.accuracy.total) < 1e-3, "{:?}", usual.accuracy);
}

/// Straight lines between the samples of a sine scale it by `sinc²(f/rate)`, and its power by the square of that.
#[test]
fn the_straight_lines_between_samples_are_counted() {
    let (frequency, rate) = (100.0, 900.0);
    let angle = std::f64::consts::PI * frequency / rate;
    let loss = 1.0 - (angle.sin() / angle).powi(4);
    let mut scene = bump_stop(&[("run", "{duration_s=1,settle_s=0.5}")]);
    let samples = (0..900).map(|n| (2.0 * angle * f64::from(n)).sin()).collect();
    scene.excitation =
        Excitation::File(Trace { samples_m_per_s2: samples, rate_hz: rate, repeat: true, resampled: None });
    let found = stated(&scene, &Options::default());
    let tone = Tone { amplitude_m_per_s2: 1.0, frequency_hz: frequency, phase_rad: 0.0 };
    scene.excitation = Excitation::Sine(tone);
    let exact = value(run_scene(&scene, &reference()).expect("runs").mean_power_w);
    let error = 1.0 - value(found.mean_power_w) / exact;
    let sampling = value(found.accuracy.sampling);
    assert!((error / loss - 1.0).abs() < 0.2, "{error} {loss}");
    assert!((0.8 * error..2.0 * error).contains(&sampling), "{error} {sampling}");
    let is_of_sampling = |warning: &String| warning.starts_with("excitation.rate_hz");
    assert!(found.warnings.iter().any(is_of_sampling), "{:?}", found.warnings);
}

/// The core and the reference integrate the created energy apart, the one from the field's side.
#[test]
fn the_created_energy_is_that_of_the_reference_and_none_under_the_field_s_own_force() {
    for (law, creates) in [(ForceLaw::TransferredCharge, true), (ForceLaw::GapField, false)] {
        let scene = contact_separation(|scene, model| {
            scene.run = RunSpan { duration_s: 1.5, settle_s: 0.5 };
            model.parameters.force_law = law;
        });
        let [found, exact] = [Options::default(), reference()]
            .map(|options| run_scene(&scene, &options).unwrap_or_else(|failure| panic!("{failure}")));
        for outcome in [&found, &exact] {
            let told =
                outcome.warnings.iter().any(|warning| warning.contains("transferred-charge\" creates"));
            assert_eq!(told, creates, "{law:?}: {:?}", outcome.warnings);
        }
        let [found, exact] = [found, exact].map(|outcome| {
            let created = outcome.created.expect("a triboelectric scene");
            let share = value(created.created_energy_share);
            let quotient = created.created_energy_j / value(outcome.delivered_energy_j);
            assert!((share - quotient).abs() <= 1e-12 * quotient.abs(), "{law:?}: {created:?}");
            share
        });
        assert!((found - exact).abs() < 1e-3 * exact.abs().max(1.0), "{law:?}: {found} {exact}");
        assert_eq!(exact > 1.0, creates, "{law:?}: {exact}");
        assert!(creates || exact.abs() < 1e-6, "{law:?}: {exact}");
    }
}

/// Rounding aside. With the looser tolerance that `f32` had these statements were 6 to 28 times as large.
#[test]
fn the_statements_of_both_precisions_are_alike() {
    for number in [77, 109, 55, 137, 151, 31] {
        let case = draw_varied(903, number);
        let scene = case.read().expect("a scene");
        let [single, double] = [Precision::F32, Precision::F64].map(|precision| {
            let options = Options { precision: Some(precision), ..case.options() };
            let accuracy = stated(&scene, &options).accuracy;
            value(accuracy.total) - accuracy.rounding.unwrap_or(0.0)
        });
        assert!((0.25..4.0).contains(&(single / double)), "{number}: {single:e} {double:e}");
    }
}

/// Cases of seed 407 behind bridges whose voltages are below the roundings of single precision: all of the power or a part of it
/// is lost.
#[test]
fn what_single_precision_loses_behind_a_bridge_is_stated() {
    for (number, least) in [(36, 0.5), (57, 0.02), (211, 1e-6), (239, 0.5)] {
        let scene = draw_varied(407, number).read().expect("a scene");
        let fine = Options { halvings: 5, ..Options::default() };
        let exact = value(run_scene(&scene, &fine).expect("runs").mean_power_w);
        let error = error_within_statement(&scene, &single(Options::default()), exact);
        assert!(error > least && (error < 5e-3 || is_warned(&stated(&scene, &single(Options::default())))));
    }
}

/// Impacts between two steps are missed at a rigid stop without a gap: two lengths of step agree by chance, and longer ones do not.
#[test]
fn steps_that_are_given_at_a_rigid_stop_without_a_gap_are_warned() {
    let scene = draw(13, 8656).read().expect("a scene");
    let of = |refined: f64| {
        let (step_s, long_step_s) = (Some(1e-6 * refined), Some(2e-5 * refined));
        value(stated(&scene, &Options { step_s, long_step_s, ..Options::default() }).accuracy.total)
    };
    let totals = [0.25, 0.125, 0.0625, 0.03125].map(of);
    println!("{totals:?}");
    assert!(totals.iter().all(|total| *total > 0.0105), "{totals:?}");
}

/// A case of seed 631: half of its steps and a quarter of them agreed by chance, nine times as well as they were right, before the current
/// of the bridge ended long steps.
#[test]
fn the_error_of_a_beam_behind_a_bridge_is_within_the_statement() {
    let scene = draw_varied(631, 16_758).read().expect("a scene");
    let exact = value(run_scene(&scene, &reference()).expect("runs").mean_power_w);
    let error = error_within_statement(&scene, &single(Options::default()), exact);
    assert!(error > 1e-6, "{error}");
}

/// Kilovolts of the charges cancel to a tenth of a millivolt: single precision loses the RMS voltage, and nothing else.
#[test]
fn an_rms_voltage_of_roundings_is_announced_and_the_mean_power_is_not_doubted() {
    let store = "{kind='rectified-store',capacitance_f=8e-4,initial_v=0.0,diode_drop_v=0.0,leakage_ohm=inf}";
    let scene = shipped("contact-separation", &[("load", store), ("run", "{duration_s=0.6,settle_s=0.2}")]);
    let [lost, exact] = [Precision::F32, Precision::F64].map(|precision| {
        let found = stated(&scene, &Options { precision: Some(precision), ..Options::default() });
        assert!(!is_warned(&found), "{:?}", found.warnings);
        found
    });
    let is_announced =
        |found: &Outcome| found.warnings.iter().any(|text| text.starts_with("rounding: rms_voltage_v"));
    assert_eq!([&lost, &exact].map(is_announced), [true, false]);
    assert!(value(lost.rms_voltage_v) > 2.0 * value(exact.rms_voltage_v));
    assert!((value(lost.mean_power_w) / value(exact.mean_power_w) - 1.0).abs() < 1e-4);
}

/// A start charge takes runs of three times the steps to compare with.
#[test]
fn the_statement_of_a_chaotic_motion_takes_the_work_of_16_runs() {
    let chaotic = [
        ("initial.charge_c", "1e-9"),
        ("excitation.frequency_hz", "20"),
        ("run", "{duration_s=3,settle_s=2}"),
    ];
    let found = stated(&shipped("contact-separation-passive", &chaotic), &single(Options::default()));
    assert!(found.accuracy.chaos.is_some() && found.accuracy.work <= 16.0, "{:?}", found.accuracy);
}

/// The truth of a chaotic mean: 200 accurate runs whose base accelerations differ by multiples of 10⁻⁹.
#[test]
#[ignore = "some minutes"]
fn chaotic_means_are_those_of_200_accurate_runs() {
    let inside = [60, 65, 113, 114, 174, 222, 229, 259, 263, 291].into_iter().filter(|&number| {
        let case = draw_varied(407, number);
        let scene = case.read().expect("a scene");
        let found = stated(&scene, &case.options());
        let fine = Options { halvings: 3, bare: true, ..Options::default() };
        let places: Vec<u32> = (0..200).collect();
        let powers = on_all_cores(&places, |place| {
            let excitation = scene.excitation.scaled(1.0 + 1e-9 * f64::from(*place));
            value(run_scene(&Scene { excitation, ..scene.clone() }, &fine).expect("runs").mean_power_w)
        });
        let mean = powers.iter().sum::<f64>() / 200.0;
        let error = (value(found.mean_power_w) / mean - 1.0).abs();
        let total = value(found.accuracy.total);
        println!("{number}: error {error:.1e}, stated {total:.1e}, {:.1} times", total / error);
        assert!(found.accuracy.chaos.is_some(), "{number}: {:?}", found.accuracy);
        error <= total
    });
    assert!(inside.count() >= 9);
}

/// Peaks of a chaotic motion are those of its own start; those of displaced ones differ.
#[test]
fn peaks_of_a_chaotic_motion_are_announced() {
    let case = draw_varied(407, 147);
    let found = stated(&case.read().expect("a scene"), &case.options());
    assert!(found.accuracy.chaos.is_some() && has_peaks_warned(&found), "{:?}", found.warnings);
}

fn has_peaks_warned(outcome: &Outcome) -> bool {
    outcome.warnings.iter().any(|warning| warning.starts_with("peaks: "))
}

/// The default free steps of 20 µs miss the turns of the fast modes that a start voltage excites.
#[test]
fn a_peak_that_the_steps_miss_is_announced() {
    let start = [
        ("initial.voltage_v", "1e3"),
        ("load.resistance_ohm", "1e4"),
        ("run", "{duration_s=0.005,settle_s=0}"),
    ];
    let scene = bump_stop(&start);
    let peak = |outcome: &Outcome| {
        let clamp = outcome.bump_stop().and_then(|found| found.clamp);
        clamp.expect("a clamp").clamp_stress_peak_pa
    };
    let found = stated(&scene, &Options::default());
    let exact = peak(&run_scene(&scene, &reference()).expect("runs"));
    assert!(peak(&found) < 0.95 * exact && has_peaks_warned(&found), "{:?}", found.warnings);
    let fine = stated(&scene, &Options { step_s: Some(1e-7), ..Options::default() });
    assert!((peak(&fine) / exact - 1.0).abs() < 1e-3 && !has_peaks_warned(&fine), "{:?}", fine.warnings);
}

/// Peaks of a chaotic motion are those of its own start, and excused.
#[test]
#[ignore = "two minutes"]
fn peaks_without_a_warning_are_within_2_percent() {
    let (mut judged, mut off) = (0, Vec::new());
    for number in 0..150 {
        let case = draw_varied(903, number);
        let options = Options { most_attempts: Some(100_000), ..case.options() };
        let Ok(scene) = case.read() else { continue };
        let Ok(found) = run_with_accuracy(&scene, &options) else { continue };
        if is_warned(&found) || has_peaks_warned(&found) || found.accuracy.chaos.is_some() {
            continue;
        }
        let halvings = if found.bump_stop().is_some() { 5 } else { 8 };
        let precision = Some(Precision::F64);
        let fine = Options { precision, halvings, most_attempts: Some(10_000_000), ..case.options() };
        let fine = fields(&run_scene(&scene, &fine).expect("runs"));
        judged += 1;
        for (name, one) in fields(&found) {
            let is_peak = ["peak", "largest_range", "max_"].iter().any(|part| name.contains(part));
            let (one, other) = (one.as_f64(), fine.get(&name).and_then(|other| other.as_f64()));
            let apart = one.zip(other).map_or(0.0, |(one, other)| (one - other).abs() / other.abs());
            if is_peak && apart > 0.02 {
                off.push(format!("{number}: {name} by {apart:.1e}"));
            }
        }
    }
    assert!(judged > 90 && off.is_empty(), "{judged}: {off:?}");
}
