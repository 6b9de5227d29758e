//! A few cases of the grids, and the rules by which they are judged.

use std::path::Path;

use super::judge::{Judge, MOST_ATTEMPTS, Statistics, TIGHT, examine, first_of};
use super::*;
use crate::method::{Failure, Options};
use crate::reference::{self, ReferenceOptions};
use crate::run::run_scene;
use crate::scene_file;

fn shipped() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/contact-separation.toml");
    scene_file::read(&file, &[]).expect("the shipped scene is valid")
}

fn setting(resistance_ohm: f64) -> ContactSeparationSetting {
    ContactSeparationSetting {
        resistance_ohm,
        charge_density_c_per_m2: 50e-6,
        force_law: ForceLaw::TransferredCharge,
        parasitic_capacitance_f: 1e-12,
        restitution: 0.5,
    }
}

fn shipped_sliding() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/sliding.toml");
    scene_file::read(&file, &[]).expect("the shipped scene is valid")
}

fn sliding_setting(resistance_ohm: f64, frequency_hz: f64) -> SlidingSetting {
    SlidingSetting {
        resistance_ohm,
        charge_density_c_per_m2: 120e-6,
        force_law: ForceLaw::TransferredCharge,
        relaxing: false,
        friction: 0.3,
        amplitude_m_per_s2: 3.5,
        frequency_hz,
    }
}

#[test]
fn a_slider_is_right_at_the_ends_of_the_range_of_resistances() {
    for resistance in [0.0, 1.0, f64::INFINITY] {
        for finding in examine(&shipped_sliding(), sliding_setting(resistance, 10.0), true) {
            assert_eq!(finding.class, Class::Converged, "{finding:?}");
            assert_eq!(finding.reference_agrees, Some(true), "{finding:?}");
        }
    }
}

#[test]
fn a_wrong_sliding_run_is_not_excused() {
    let scene = sliding_setting(1e8, 18.373).scene(&shipped_sliding());
    let tight = first_of(&scene, &TIGHT).expect("the scene runs");
    let wrong = Statistics { motion: 1.1 * tight.1.motion, ..tight.1 };
    let judge = Judge::new(&scene, Some(tight), None);
    assert_eq!(judge.class(&wrong, true, None).0, Class::Silent);
    assert_eq!(judge.class(&tight.1, true, None).0, Class::Converged);
}

#[test]
fn contact_separation_converges_at_the_ends_of_the_range_of_resistances() {
    for resistance in [1e-3, 1e15] {
        for finding in examine(&shipped(), setting(resistance), false) {
            assert_eq!(finding.class, Class::Converged, "{finding:?}");
            assert_eq!(finding.reference_agrees, None, "{finding:?}");
        }
    }
}

#[test]
fn a_run_that_takes_too_many_steps_is_given_up() {
    let scene = shipped();
    let options = Options { most_attempts: Some(1000), ..Options::default() };
    let Err(Failure::StepLimitExceeded(told)) = run_scene(&scene, &options) else {
        panic!("it takes more steps")
    };
    assert!(told.contains("1000 attempted steps") && told.contains(" at 0."), "{told}");
    let options = Options { most_attempts: Some(MOST_ATTEMPTS), ..Options::default() };
    assert_eq!(
        run_scene(&scene, &options).expect("it takes fewer").mean_power_w,
        run_scene(&scene, &Options::default()).expect("runs").mean_power_w
    );
    let options = ReferenceOptions { most_steps: Some(1000), ..ReferenceOptions::default() };
    let failure = reference::run(&scene, &options).expect_err("it takes more steps");
    assert!(failure.reason.contains("given up"), "{failure}");
}

#[test]
fn the_grid_has_the_cases_that_it_says() {
    let settings = SlidingSetting::all(Grid::Whole);
    assert_eq!(settings.len(), 9 * 4 * 2 * 2 * 4 * 7);
    assert_eq!(SlidingSetting::all(Grid::Coarse).len(), 5 * 2 * 2 * 4 * 7);
    let settings = ContactSeparationSetting::all(Grid::Whole);
    assert_eq!(settings.len(), 19 * 8 * 2 * 3 * 4);
    assert_eq!(settings.iter().filter(|setting| setting.is_for_reference()).count(), 19 * 8 * 2);
}

#[test]
fn agreement_is_relative_and_refuses_what_is_no_number() {
    let statistics = |power, motion| Statistics { power, motion };
    assert!(statistics(1.0, 2.0).agree(&statistics(1.009, 2.0)));
    assert!(!statistics(1.0, 2.0).agree(&statistics(1.02, 2.0)));
    assert!(statistics(0.0, 2.0).agree(&statistics(0.0, 2.0)));
    assert!(!statistics(f64::NAN, 2.0).agree(&statistics(1.0, 2.0)));
    let runs = [statistics(1.0, 2.0), statistics(0.9, 2.0), statistics(1.1, 2.0)];
    assert!(statistics(1.35, 2.0).within(&runs) && !statistics(1.5, 2.0).within(&runs));
    assert!(!statistics(1.0, 2.1).within(&runs));
}

#[test]
fn a_wrong_run_is_not_excused_by_accurate_runs_that_agree() {
    let scene = setting(1e8).scene(&shipped());
    let tight = first_of(&scene, &TIGHT).expect("the scene runs");
    let wrong = Statistics { power: 2.0 * tight.1.power, motion: tight.1.motion };
    let judge = Judge::new(&scene, Some(tight), None);
    assert_eq!(judge.class(&wrong, true, None).0, Class::Silent);
    assert_eq!(judge.class(&tight.1, true, None).0, Class::Converged);
    assert_eq!(judge.class(&wrong, false, None).0, Class::Flagged);
}
