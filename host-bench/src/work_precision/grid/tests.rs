use super::*;

fn row(accuracy: f64, auto_error: f64, auto_over_best: Option<f64>) -> Row {
    Row {
        scene: "sliding",
        load_ohm: 1e8,
        force_law: "gap-field",
        excitation: "sine",
        accuracy,
        auto_tolerance: 1e-2,
        auto_error,
        auto_attempts_per_s: 400.0,
        auto_ns_per_s: 2e5,
        auto_over_best,
        best_method: auto_over_best.map(|_| "rk4"),
        best_setting: auto_over_best.map(|_| "T/96".to_owned()),
        best_error: None,
        best_attempts_per_s: None,
        auto_over_sure: auto_over_best,
        sure_setting: None,
        cross_check: 1e-8,
    }
}

#[test]
fn the_summary_counts_what_is_dear_and_what_is_off() {
    let grid = Grid::of(vec![
        row(1e-2, 1e-3, Some(1.31)),
        row(1e-3, 1.4e-3, Some(1.1)),
        row(1e-3, 1.6e-3, Some(1.0)),
        row(1e-5, f64::NAN, None),
        Row { cross_check: 2e-6, ..row(1e-5, 1e-4, None) },
    ]);
    assert_eq!(
        grid.summary,
        Summary {
            compared: 3,
            chaotic: 1,
            met_by_none: 1,
            largest_auto_over_best: Some(1.31),
            median_auto_over_best: Some(1.1),
            largest_auto_over_sure: Some(1.31),
            above: 1,
            missed: 2,
        }
    );
    let text = text(&grid);
    assert!(text.contains("rk4") && text.contains("T/96"), "{text}");
    let csv = csv(&grid);
    assert!(
        csv.starts_with("scene,load_ohm,force_law,excitation,accuracy,auto_tolerance,auto_error,"),
        "{csv}"
    );
    assert_eq!(csv.lines().count(), 6);
}

#[test]
fn a_short_slide_has_a_cheapest_choice_that_meets_each_accuracy() {
    let overrides =
        ["run.duration_periods=12", "run.settle_periods=6"].map(|text| text.parse().expect("an override"));
    let cells = cells(&overrides).expect("the shipped scenes are valid");
    assert_eq!(cells.len(), 41);
    let sliding = cells.iter().find(|cell| cell.name == "sliding").expect("there is one");
    let rows = examine(sliding).expect("all runs end");
    assert_eq!(rows.iter().map(|row| row.accuracy).collect::<Vec<_>>(), ACCURACIES);
    for row in &rows {
        assert!(row.cross_check < 1e-5, "{row:?}");
        assert!(row.auto_error <= MET * row.accuracy, "{row:?}");
        assert!(row.best_error.is_some_and(|error| error <= row.accuracy), "{row:?}");
    }
}
