//! A short table of the shipped scene.

use std::path::Path;

use super::*;
use crate::scene_file::{self, Override};

#[test]
fn every_method_converges_and_the_explicit_one_fails_where_it_must() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bump-stop.toml");
    let overrides = [
        ("parameters.beam_modes", "6"),
        ("stop.rod_modes", "2"),
        ("stop.gap_m", "5e-6"),
        ("run.duration_s", "5.67e-3"),
        ("run.settle_s", "0"),
    ]
    .map(|(key, value)| Override::new(key, value));
    let scene = scene_file::read(&file, &overrides).expect("valid");
    let extent = Extent { runs: 1, seconds_per_row: 1.0, whole: false };
    let mut steps = 0;
    let comparison = compare(&scene, &extent, |done| steps += done).expect("runs");
    assert_eq!(steps as usize, length(&scene, &extent));
    assert_eq!(comparison.rows.len(), 7 * FEW_STEPS.len());
    let error = |method: Method, precision: Precision, step: f64, two_rates: bool| {
        let row = comparison.rows.iter().find(|row| {
            let Variant { method: own, precision: bits, step_s, long_step_s } = row.variant;
            own == method && bits == precision && step_s == step && long_step_s.is_some() == two_rates
        });
        row.expect("the row is there").found.map(|found| found.end_error)
    };
    for (method, two_rates) in [
        (Method::DiscreteGradient, false),
        (Method::DiscreteGradient, true),
        (Method::TrBdf2, false),
        (Method::Newmark, false),
        (Method::Rk4, false),
    ] {
        let [coarse, fine] = [1e-6, 5e-8].map(|step| error(method, Precision::F64, step, two_rates));
        let (coarse, fine) = (coarse.expect("runs"), fine.expect("runs"));
        assert!(fine < 1e-3 && fine < 0.1 * coarse, "{method:?}: {coarse} {fine}");
    }
    // The highest frequency in contact is 198 kHz: the explicit method is stable up to 2.2 µs.
    assert_eq!(error(Method::Rk4, Precision::F64, 5e-6, false), None);
    assert!(error(Method::DiscreteGradient, Precision::F32, 1e-6, true).expect("runs") < 0.1);
    let text = comparison.text();
    assert!(text.contains("(6, 2) modes") && text.contains("Newmark"), "{text}");
    let csv = comparison.csv();
    let commas = table::CSV_HEADING.matches(',').count();
    assert!(csv.lines().all(|line| line.matches(',').count() == commas), "{csv}");
}
