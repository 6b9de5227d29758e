//! A few cases of the grid.

use std::path::Path;

use super::*;
use crate::scene_file;

fn shipped() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bump-stop.toml");
    scene_file::read(&file, &[]).expect("the shipped scene is valid")
}

#[test]
fn under_each_law_long_steps_stay_finite_and_resolving_ones_agree() {
    for contact in grid::LAWS {
        let findings = examine(&shipped(), Setting::middle(contact), &[1e-6, 1e-3]);
        let expected =
            if contact == Contact::DisplacementConstraint { Verdict::NoReference } else { Verdict::Agrees };
        let verdicts: Vec<Verdict> = findings.iter().map(|finding| finding.verdict).collect();
        assert_eq!(verdicts, [expected, expected, Verdict::Unresolved, Verdict::Unresolved], "{findings:?}");
        let table = table::text(&findings);
        assert!(table.contains(grid::law_name(contact)), "{table}");
        let csv: String = findings
            .iter()
            .map(super::super::csv_row::<BumpStop>)
            .chain([super::super::csv_heading::<BumpStop>()])
            .collect();
        assert_eq!(csv.lines().count(), 5);
    }
}

#[test]
fn a_wrong_run_is_not_passed() {
    let scene = Setting::middle(Contact::ResidualFlexibility).scene(&shipped());
    let options = Options { trace_every_s: Some(1e-3), ..Options::default() };
    let outcome = run_scene(&scene, &options).expect("runs");
    let exact = Reference { rms_voltage: outcome.rms_voltage_v.expect("a number"), is_sensitive: false };
    let middle = Setting::middle(Contact::ResidualFlexibility);
    let finding = |difference| BumpStopFinding {
        setting: middle,
        step_s: 1e-6,
        precision: Precision::F64,
        verdict: Verdict::Error,
        reason: String::new(),
        voltage_difference: Some(difference),
        energy_residual: None,
        contacts: None,
    };
    assert_eq!(judge(&outcome, &finding(0.01), Some(exact)).0, Verdict::Agrees);
    assert_eq!(judge(&outcome, &finding(0.2), Some(exact)).0, Verdict::Off);
    assert_eq!(judge(&outcome, &finding(f64::NAN), Some(exact)).0, Verdict::Off);
    let open = Outcome { energy_residual: Some(1e-6), ..outcome.clone() };
    assert_eq!(judge(&open, &finding(0.01), Some(exact)).0, Verdict::Broken);
    let mut pulling = outcome.clone();
    pulling.trace.as_mut().expect("recorded").rows[3][FORCE] = -1e-9;
    assert_eq!(judge(&pulling, &finding(0.01), Some(exact)).0, Verdict::Broken);
    let lost = Outcome { peak_voltage_v: None, ..outcome };
    assert_eq!(judge(&lost, &finding(0.01), Some(exact)).0, Verdict::Broken);
}

#[test]
fn the_grid_has_the_cases_that_it_says() {
    // The middle once, and of each range what is not the middle.
    assert_eq!(settings().len(), 3 * (1 + 9 + 10 + 1 + 6 + 4 + 6 + 5));
    assert_eq!(steps(Grid::Whole).len(), 6);
}
