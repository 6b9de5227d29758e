//! What the two papers find, measured on the shipped scenes: each finding has its expected mark.

use host_bench::findings::{Row, measure};

/// Measures findings and asserts their marks.
fn as_expected(numbers: &str) -> Vec<Row> {
    let numbers: Vec<String> = numbers.split_whitespace().map(str::to_owned).collect();
    let rows = measure(&numbers, true, &|_| ()).unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!(rows.len(), numbers.len());
    for row in &rows {
        for check in &row.checks {
            println!("{}: {}: {} {}", row.finding.number, check.quantity, check.shown(), check.assertion());
        }
    }
    for row in &rows {
        assert!(row.is_as_expected(), "{} is {}", row.finding.number, row.mark().name());
    }
    rows
}

/// The values of a quantity of a finding.
fn values<'a>(rows: &'a [Row], number: &str, quantity: &str) -> &'a [f64] {
    let row = rows.iter().find(|row| row.finding.number == number).expect("it was measured");
    let check = row.checks.iter().find(|check| check.quantity.starts_with(quantity));
    &check.unwrap_or_else(|| panic!("{number} has {quantity}")).values
}

/// Also the ratios that another program finds, with the stop at the tip and at mid-span.
#[test]
fn contacts_forces_and_voltages_of_the_second_paper() {
    let rows = as_expected("1 2 3 4 5 5a 6 7 8 9 10 11 12 13");
    for (number, quantity, expected, tolerance) in [
        ("8", "RMS voltage in contact", [0.435, 0.670], 0.02),
        ("9", "RMS voltage out of contact", [0.921, 0.931], 0.02),
        ("9", "correlation", [0.944, 0.980], 0.02),
        ("4", "longest contact", [0.54, 0.43], 0.1),
        ("10", "mean power", [0.431, 0.622], 0.02),
        ("7", "power above", [0.0067, 0.0031], 0.002),
    ] {
        for (found, expected) in values(&rows, number, quantity).iter().zip(expected) {
            assert!((found - expected).abs() < tolerance, "{number}: {found} instead of {expected}");
        }
    }
}

#[test]
fn the_charge_of_the_second_paper() {
    as_expected("16");
}

#[test]
fn the_resonance_of_the_first_paper_over_charge() {
    as_expected("21 22 23 24");
}

#[test]
fn the_resonance_of_the_first_paper_over_resistance() {
    as_expected("25 26");
}

#[test]
fn impacts_and_parasitic_capacitance_of_the_first_paper() {
    as_expected("37 38 39 42");
}

#[test]
#[ignore = "nightly: twenty seconds"]
fn modes_and_steps_of_the_second_paper_and_the_impacting_band_of_the_first() {
    as_expected("18 19 33 34 35 36 40 41 43");
}

#[test]
fn shapes_and_storage_of_the_second_paper() {
    as_expected("14 15 17 20");
}

#[test]
#[ignore = "nightly: ten seconds"]
fn large_charge_and_shunting_of_the_first_paper() {
    as_expected("27 28 29 30 31 32 a");
}

#[test]
fn what_no_parameters_reproduce() {
    as_expected("c d");
}
