//! The choice of rows, and what is printed of them.

use super::{Comparison, Row, cases, csv, draw, is_counted, reaching, text};

/// A row with an error, and a cost of so many instructions and of as many µs.
fn row(method: &'static str, peer: bool, error: Option<f64>, cost: f64) -> Row {
    Row {
        scene: "contact-1M",
        load_ohm: Some(1e6),
        method,
        package: peer.then_some("diffsol"),
        peer,
        tolerance: Some(1e-3),
        steps_per_period: None,
        error,
        instructions_per_simulated_second: Some(cost),
        seconds_per_simulated_second: Some(1e-6 * cost),
        time_spread: None,
        steps_per_simulated_second: Some(100.0),
        failure: error.is_none().then(|| "gave up".to_owned()),
    }
}

/// Rows of a method by their errors, each twice as dear as the one before.
fn ladder(method: &'static str, peer: bool, cost: f64, errors: &[f64]) -> Vec<Row> {
    let costs = (0..).map(|k| cost * 2f64.powi(k));
    errors.iter().zip(costs).map(|(&error, cost)| row(method, peer, Some(error), cost)).collect()
}

fn comparison() -> Comparison {
    Comparison {
        case: cases(&["contact-1M".to_owned()]).expect("a case")[0],
        mean_power_w: 1e-6,
        methods: vec![
            ladder("core TR-BDF2", false, 1e6, &[5e-3, 2e-2, 9e-3, 8e-4, 2e-4]),
            ladder("diffsol BDF", true, 8e6, &[9e-3, 8e-4, 7e-4, 9e-6, 8e-6]),
            ladder("DOPRI5", true, 1e6, &[0.5, 0.4, 0.3]),
            vec![row("DOP853", true, None, 1e6)],
        ],
        by_count: true,
    }
}

#[test]
fn a_setting_counts_if_the_next_one_meets_the_error_too() {
    let rows = ladder("core TR-BDF2", false, 1.0, &[5e-3, 2e-2, 9e-3, 8e-4, 2e-4]);
    let cost = |target| reaching(&rows, target).and_then(|row| row.cost(true));
    // The first row is right by chance; the last one has none after it.
    assert_eq!([1e-2, 1e-3, 5e-4].map(cost), [Some(4.0), Some(8.0), None]);
    let counted = |duration_s| rows.iter().filter(|row| is_counted(row, &rows, duration_s)).count();
    assert_eq!(counted(1.0), 2);
    let slow = ladder("DOP853", true, 1e6, &[9e-3, 2e-3, 9e-4, 2e-4, 1e-4]);
    let counted = |duration_s| slow.iter().filter(|row| is_counted(row, &slow, duration_s)).count();
    // Of long runs only those whose costs are compared.
    assert_eq!((counted(1e-3), counted(1.0)), (4, 2));
}

#[test]
fn ratios_are_of_the_best_peer_to_the_best_of_the_core() {
    let comparison = comparison();
    assert_eq!([1e-2, 1e-3, 1e-5].map(|target| comparison.ratio(target)), [Some(2.0), Some(2.0), None]);
    let text = text(std::slice::from_ref(&comparison));
    for part in ["wrong", "fails (1)", "(1) DOP853: gave up.", "not reached", "diffsol BDF / core TR-BDF2"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn every_row_is_in_the_files() {
    let comparisons = [comparison()];
    let csv = csv(&comparisons);
    let mut lines = csv.lines();
    let columns = lines.next().map_or(0, |heading| heading.split(',').count());
    assert!(lines.clone().all(|line| line.split(',').count() == columns), "{csv}");
    assert_eq!(lines.count(), 14);
    let rows: Vec<&Row> = comparisons[0].methods.iter().flatten().collect();
    let json = serde_json::to_value(rows).expect("JSON");
    for key in "scene load_ohm method error instructions_per_simulated_second seconds_per_simulated_second \
            peer"
        .split(' ')
    {
        assert!(json[0].get(key).is_some_and(|value| !value.is_null()), "{key}");
    }
    let picture = draw(&comparisons).expect("a picture");
    assert!(picture.contains("contact-1M") && picture.contains("diffsol BDF"));
}
