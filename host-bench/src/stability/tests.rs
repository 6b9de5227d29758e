//! A few cases of the grid, and the rules by which they are judged.

use std::path::Path;

use super::*;
use crate::scene_file::{self, ForceLaw};

fn shipped() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/contact-separation.toml");
    scene_file::read(&file, &[]).expect("the shipped scene is valid")
}

fn setting(resistance_ohm: f64) -> Setting {
    Setting {
        resistance_ohm,
        charge_density_c_per_m2: 50e-6,
        force_law: ForceLaw::TransferredCharge,
        parasitic_capacitance_f: 1e-12,
        restitution: 0.5,
    }
}

#[test]
fn the_ends_of_the_range_of_resistances_are_right_or_say_so() {
    for resistance in [1e-3, 1e15] {
        for finding in examine(&shipped(), setting(resistance), false) {
            assert_ne!(finding.class, Class::Silent, "{finding:?}");
        }
    }
}

#[test]
fn the_grid_has_the_cases_that_it_says() {
    let settings = Grid::Whole.settings();
    assert_eq!(settings.len(), 19 * 8 * 2 * 3 * 4);
    assert_eq!(settings.iter().filter(|setting| setting.is_for_reference()).count(), 19 * 8 * 2);
}

#[test]
fn agreement_is_relative_and_refuses_what_is_no_number() {
    let statistics = |power, gap| Statistics { power, gap };
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
    let wrong = Statistics { power: 2.0 * tight.1.power, gap: tight.1.gap };
    let judge = Judge {
        scene: &scene,
        tight: Some(tight),
        reference: None,
        shifted: OnceCell::new(),
        finer: OnceCell::new(),
    };
    assert_eq!(judge.class(&wrong, true, None).0, Class::Silent);
    assert_eq!(judge.class(&tight.1, true, None).0, Class::Converged);
    assert_eq!(judge.class(&wrong, false, None).0, Class::Flagged);
}
