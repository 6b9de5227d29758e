//! A short table of the shipped scene.

use super::super::{compare, table, work};
use super::*;
use crate::scene_file::read_shipped;

#[test]
fn every_method_converges_and_the_explicit_one_fails_where_it_must() {
    let changes = [
        ("parameters.beam_modes", "6"),
        ("stop.rod_modes", "2"),
        ("stop.gap_m", "5e-6"),
        ("run.duration_s", "5.67e-3"),
        ("run.settle_s", "0"),
    ];
    let scene = read_shipped("bump-stop", &changes).expect("valid");
    let extent = Extent { runs: 1, seconds_per_row: 1.0, backends: 5, whole: false };
    let steps = std::cell::Cell::new(0);
    let comparison = compare(&scene, &extent, |work| steps.set(steps.get() + work)).expect("runs");
    assert_eq!(steps.get(), work(&scene, &extent));
    assert_eq!(comparison.rows.len(), 7 * FEW_STEPS.len());
    let error = |method: Method, precision: Precision, step: f64, two_rates: bool| {
        let row = comparison.rows.iter().find(|row| {
            let Variant { method: own, precision: bits, .. } = row.variant;
            let [step_s, long_step_s] = steps_of(&row.variant);
            own == method && bits == precision && step_s == Some(step) && long_step_s.is_some() == two_rates
        });
        row.expect("the row is there").error(END)
    };
    for method in [Method::DiscreteGradient, Method::TrBdf2, Method::Newmark, Method::Rk4] {
        let [coarse, fine] = [1e-6, 5e-8].map(|step| error(method, Precision::F64, step, false));
        let (coarse, fine) = (coarse.expect("runs"), fine.expect("runs"));
        assert!(fine < 1e-3 && fine < 0.1 * coarse, "{method:?}: {coarse} {fine}");
    }
    // The long step leaves an error of its own, of the voltage that is linear over it in flight.
    let two_rates = error(Method::DiscreteGradient, Precision::F64, 5e-8, true).expect("runs");
    assert!(two_rates < 0.02, "{two_rates}");
    // The highest frequency in contact is 198 kHz: the explicit method is stable up to 2.2 µs.
    assert_eq!(error(Method::Rk4, Precision::F64, 5e-6, false), None);
    assert!(error(Method::DiscreteGradient, Precision::F32, 1e-6, true).expect("runs") < 0.1);
    let text = comparison.text();
    assert!(text.contains("(6, 2) modes") && text.contains("Newmark"), "{text}");
    let csv = table::csv(&[comparison]);
    let commas = csv.lines().next().map_or(0, |heading| heading.matches(',').count());
    assert_eq!(commas, 17);
    assert!(csv.lines().all(|line| line.matches(',').count() == commas), "{csv}");
}
