//! Short tables of the shipped scenes.

use super::triboelectric::{self, MEAN_POWER};
use super::*;
use crate::scene_file::read_shipped;

fn shipped(resistance_ohm: &str) -> Scene {
    let changes = [("load.resistance_ohm", resistance_ohm), ("run", "{duration_s=1.0,settle_s=0.5}")];
    read_shipped("contact-separation", &changes).expect("the shipped scene is valid")
}

#[test]
fn the_error_falls_with_the_step_and_rows_that_do_not_differ_are_left_out() {
    let scene = shipped("1e8");
    let comparison =
        compare(&scene, &Extent { runs: 1, seconds_per_row: 0.0, backends: 5, whole: false }, |_| ())
            .expect("the reference runs");
    let power_error = |steps: u32| {
        let row = comparison.rows.iter().find(|row| {
            row.variant.method == Method::TrBdf2
                && row.variant.precision == Precision::F64
                && matches!(row.variant.control, Control::PerPeriod { steps: own, .. } if own == steps)
        });
        row.and_then(|row| row.error(MEAN_POWER)).expect("the row is there")
    };
    assert!(power_error(3200) < 0.2 * power_error(800), "{} {}", power_error(3200), power_error(800));
    assert!(power_error(3200) < 1e-3);
    let radau_error = |control: Control| {
        let mut rows = comparison.rows.iter().filter(|row| row.variant.method == Method::ExponentialRadau);
        let row =
            rows.find(|row| row.variant.control == control && row.variant.math == Some(Math::Polynomial));
        row.and_then(|row| row.error(MEAN_POWER)).expect("the row is there")
    };
    let [coarse, fine] = [6e-2, 6e-4].map(|tolerance| radau_error(Control::Tolerance(tolerance)));
    assert!(fine < 1e-2 * coarse && fine < 1e-5, "{fine} {coarse}");
    let period_s = triboelectric::period(&scene);
    let [coarse, fine] = [32, 128].map(|steps| radau_error(Control::PerPeriod { steps, period_s }));
    assert!(fine < 0.05 * coarse && fine < 1e-3, "{fine} {coarse}");
    let double = comparison.omitted.iter().find(|entry| entry.precision == Precision::F64);
    let double = double.expect("libm was tried in double precision");
    assert_eq!((double.rows, double.of), (10, 10));
    assert!(comparison.rows.iter().any(|row| triboelectric::method_name(&row.variant) == "reference"));
}

#[test]
fn the_explicit_method_is_shown_where_it_fails_and_where_it_does_not() {
    let explicit = |resistance| {
        triboelectric::variants(&shipped(resistance), &Extent::SHORT)
            .into_iter()
            .filter(|variant| variant.method == Method::Rk4 && variant.precision == Precision::F64)
            .map(|variant| variant.control.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(explicit("1e8"), ["T/100", "T/200", "T/400", "T/800", "T/1600"]);
    assert_eq!(explicit("1e6").len(), 5);
    // Too stiff for any step worth trying: it fails at the implicit method's steps.
    assert_eq!(explicit("1"), ["T/100", "T/200", "T/400", "T/800", "T/1600"]);
}

#[test]
fn the_median_of_an_even_number_is_the_mean_of_the_middle_two() {
    assert_eq!(median(vec![4.0, 1.0, 2.0, 8.0]), 3.0);
    assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
    assert!(median(Vec::new()).is_nan());
}

#[test]
fn a_time_is_the_least_with_its_spread() {
    assert_eq!(least(&[3.0, 1.0, 2.0]), (1.0, Some(2.0)));
    assert_eq!(least(&[3.0]), (3.0, None));
    assert!(least(&[]).0.is_nan());
}

#[test]
fn a_slider_is_compared_by_its_amplitude() {
    let changes = [("run", "{duration_s=0.6,settle_s=0.3}")];
    let scene = read_shipped("sliding", &changes).expect("the shipped scene is valid");
    let comparison =
        compare(&scene, &Extent { runs: 1, seconds_per_row: 0.0, backends: 5, whole: false }, |_| ())
            .expect("the reference runs");
    let error = |method: Method, steps: u32| {
        let row = comparison.rows.iter().find(|row| {
            row.variant.method == method
                && row.variant.precision == Precision::F64
                && matches!(row.variant.control, Control::PerPeriod { steps: own, .. } if own == steps)
        });
        row.and_then(|row| row.error("amplitude_error")).expect("the row is there")
    };
    assert!(error(Method::TrBdf2, 3200) < 0.1 * error(Method::TrBdf2, 800));
    assert!(error(Method::Rk4, 400) < 0.01 * error(Method::TrBdf2, 800));
    assert!(comparison.title().contains("amplitude ") && comparison.reference.contact_separation().is_none());
}
