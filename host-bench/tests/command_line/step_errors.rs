//! A run that cannot be finished: an explicit method with a step a thousand times too long for the load.

use super::tool::{SHIPPED, folder, host_bench};

const BLOWS_UP: [&str; 4] = ["--method", "rk4", "--step", "1e-3"];

#[test]
fn a_run_ends_with_code_3_and_one_line() {
    let folder = folder("step-error");
    let trace = folder.join("trace.csv");
    let trace = trace.to_str().expect("a plain path");
    let more =
        ["--set", "load.resistance_ohm=1e3", "--format", "json", "--trace", trace, "--trace-every", "0.01"];
    let output = host_bench(&[&["run", SHIPPED], &BLOWS_UP[..], &more[..]].concat());
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(output.stdout.is_empty());
    assert_eq!(told.lines().count(), 1, "{told}");
    // The time and the state.
    for part in [" at 0.00", " s", "gap", "m/s"] {
        assert!(told.contains(part), "{part:?} is not in {told}");
    }
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0, "no trace is written");
}

#[test]
fn a_sweep_keeps_the_points_that_got_to_the_end() {
    let over = ["--over", "load.resistance_ohm=1e3:1e9:3:log", "--set", "run.duration_s=1"];
    let window = ["--set", "run.settle_s=0", "--format", "csv"];
    let output = host_bench(&[&["sweep", SHIPPED], &BLOWS_UP[..], &over[..], &window[..]].concat());
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(told.contains("2 of 3 points failed, the first at load.resistance_ohm = 1000"), "{told}");
    let mut reader = csv::Reader::from_reader(&output.stdout[..]);
    let heading = reader.headers().expect("a heading").clone();
    let column = |name: &str| heading.iter().position(|head| head == name).expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 3);
    for (row, failed) in rows.iter().zip([true, true, false]) {
        assert_eq!(row[column("mean_power_w")].is_empty(), failed);
        assert_eq!(row[column("error")].contains(" at 0.00"), failed);
    }
}
