//! Which column of a recorded acceleration is read, and the rate that its times give.

use std::path::Path;

use serde_json::Value;

use super::tool::{file, folder, outcome, refused};
use super::traces::scene;

/// Intervals of the recordings.
const INTERVALS: u32 = 200;

/// A sine of 10 Hz at 400 samples a second: the rows that `row` makes of a time in s and a number, below `heading`.
fn table(heading: &str, row: impl Fn(f64, f64) -> String) -> String {
    let rows = (0..=INTERVALS).map(|at| {
        let time = f64::from(at) / 400.0;
        row(time, (20.0 * std::f64::consts::PI * time).sin()) + "\n"
    });
    heading.to_owned() + &rows.collect::<String>()
}

/// What a run by the keys of `excitation` finds.
fn found(folder: &Path, data: &str, keys: &str) -> Value {
    file(folder, "trace.csv", data);
    let found = outcome(&scene(folder, &format!("path = \"trace.csv\"\n{keys}")), &[]);
    found["peak_gap_m"].clone()
}

#[track_caller]
fn refused_by(folder: &Path, data: &str, keys: &str, parts: &[&str]) {
    file(folder, "trace.csv", data);
    let scene = scene(folder, &format!("path = \"trace.csv\"\n{keys}"));
    refused(&["run", &scene, "--method", "reference"], &[&[scene.as_str()], parts].concat());
}

#[test]
fn the_rate_follows_from_the_times_however_they_are_written() {
    let folder = folder("columns");
    let plain = table("", |_, number| format!("{number}"));
    let expected = found(&folder, &plain, "column = 1\nrate_hz = 400");
    assert!(expected.as_f64().is_some_and(|gap| gap > 3e-3));
    let comma = |number: f64| number.to_string().replace('.', ",");
    let by_comma = table("t,x\n", |time, number| format!("{time},{number}"));
    for (data, keys) in [
        (by_comma.clone(), "column = 2"),
        (by_comma.clone(), "column = \"x\"\nrate_hz = 400"),
        (by_comma.clone(), ""),
        (by_comma, "column = \"x\"\ntime_column = \"t\""),
        (table("Time (ms),x\n", |time, number| format!("{},{number}", 1e3 * time)), "column = 2"),
        (table("time (min),x\n", |time, number| format!("{},{number}", time / 60.0)), "column = 2"),
        (table("Time [h],x\n", |time, number| format!("{},{number}", time / 3600.0)), "column = 2"),
        (table("", |time, number| format!("{time},{number}")), ""),
        (table("", |time, number| format!("{},{number}", time + 7.0)), "column = 2"),
        (table("x,y,elapsed_s\n", |time, number| format!("{number},5,{time}")), "column = \"x\""),
        (table("time_s,voltage_v,x\n", |time, number| format!("{time},5,{number}")), "column = \"x\""),
        (table("Zeit;x\n", |time, number| format!("{};{}", comma(time), comma(number))), "column = \"x\""),
        (table("", |time, number| format!("{};{}", comma(time), comma(number))), "column = 2"),
        (table("time\tx\n", |time, number| format!("{}\t{}", comma(time), comma(number))), ""),
        (table("time;x\n", |time, number| format!("{time};{number}")), ""),
        // A column of counts is no time, and a column that is told not to be one is none.
        (
            table("", |time, number| format!("{},{number}", (400.0 * time).round())),
            "column = 2\nrate_hz = 400",
        ),
        (
            table("t,x\n", |time, number| format!("{},{number}", 3.0 * time)),
            "column = 2\nrate_hz = 400\ntime_column = false",
        ),
    ] {
        let gap = found(&folder, &data, keys);
        let ratio = gap.as_f64().unwrap_or(f64::NAN) / expected.as_f64().unwrap_or(f64::NAN);
        // The rate of printed times may be rounded.
        assert!((ratio - 1.0).abs() < 1e-9, "{keys:?}, {:?}: {gap}", &data[..40]);
    }
}

#[test]
fn what_contradicts_the_times_is_refused() {
    let folder = folder("contradicted");
    let fast = table("time_s,x\n", |time, number| format!("{},{number}", 0.4 * time));
    let bare = table("", |time, number| format!("{},{number}", 0.4 * time));
    for data in [&fast, &bare] {
        let line = if data.starts_with('t') { "line 3" } else { "line 2" };
        let parts = [
            "excitation.rate_hz = 400",
            line,
            "0.001 s must be 0.0025 s",
            "of 1000 Hz",
            "time_column = false",
        ];
        refused_by(&folder, data, "column = 2\nrate_hz = 400", &parts);
        refused_by(
            &folder,
            data,
            "column = 1\nrate_hz = 1000",
            &["excitation.column = 1", "these are times"],
        );
        refused_by(&folder, data, "column = 1", &["excitation.column = 1", "these are times"]);
    }
    let told = "column = 2\nrate_hz = 400\ntime_column = 1";
    refused_by(
        &folder,
        &fast,
        told,
        &["excitation.time_column = 1", "line 3", "rate_hz = 400", "of 1000 Hz"],
    );
    refused_by(&folder, &fast, "column = 2\ntime_column = true", &["time_column = true", "or false"]);
    refused_by(&folder, &fast, "column = 2\ntime_column = false", &["excitation.rate_hz: is missing"]);
}

#[test]
fn times_that_are_not_even_are_refused_with_the_line() {
    let folder = folder("jitter");
    let jittered = |off: f64| {
        table("time_s,x\n", |time, number| {
            format!("{},{number}", if time == 0.1 { time + off / 400.0 } else { time })
        })
    };
    assert!(found(&folder, &jittered(0.2), "column = 2").as_f64().is_some());
    for off in [0.3, -0.3, 1.5] {
        refused_by(
            &folder,
            &jittered(off),
            "column = 2",
            &["excitation.path", "line 4", "even to 0.25 intervals"],
        );
        let told = "column = 2\nrate_hz = 400";
        refused_by(&folder, &jittered(off), told, &["excitation.rate_hz = 400", "line 42", "must be 0.1 s"]);
    }
    // A pause of five samples, which the mean rate hides.
    let pause =
        table("t,x\n", |time, number| format!("{},{number}", if time > 0.3 { time + 0.0125 } else { time }));
    refused_by(&folder, &pause, "column = 2", &["line 123", "0.015000 s after the one before"]);
    let resampled = "column = 2\nresample_hz = 400";
    refused_by(
        &folder,
        &pause,
        resampled,
        &["longest_gap_samples", "line 123", "0.015000 s after the one before: 5 samples are missing"],
    );
    let slow = "column = 2\nresample_hz = 300\nlongest_gap_samples = 5";
    refused_by(&folder, &pause, slow, &["resample_hz = 300", "at least 360"]);
    refused_by(
        &folder,
        &pause,
        &format!("{resampled}\nrate_hz = 400"),
        &["resample_hz", "must not be beside rate_hz"],
    );
    let falling = table("t,x\n", |time, number| format!("{},{number}", 1.0 - time));
    refused_by(&folder, &falling, "column = 2", &["excitation.path", "do not rise"]);
    let clock = table("Timestamp,x\n", |_, number| format!("12:00,{number}"));
    refused_by(
        &folder,
        &clock,
        "column = 2\nrate_hz = 400",
        &["line 2", "\"12:00\" is not", "time_column = false"],
    );
    let slow = table("t,x\n", |time, number| format!("{},{number}", 1e9 * time));
    refused_by(&folder, &slow, "column = 2", &["4e-7 Hz", "from 1e-3 to 1e6"]);
}

/// Of times off by up to 0.4 intervals the cubic errs by at most `3/128 (1.8 ωh)⁴` = 1.5e-4 of a sine of 40 samples a period,
/// and its power by twice as much.
#[test]
fn a_run_on_a_resampled_recording_has_the_power_of_the_even_one() {
    let folder = folder("resampled");
    let of = |jitter: f64, keys: &str| {
        let rows = (0..=INTERVALS).map(|at| {
            let time = (f64::from(at) + jitter * (0.7 * f64::from(at * at)).sin()) / 400.0;
            format!("{time},{}\n", (20.0 * std::f64::consts::PI * time).sin())
        });
        file(&folder, "trace.csv", rows.collect::<String>());
        outcome(&scene(&folder, &format!("path = \"trace.csv\"\ncolumn = 2\n{keys}")), &[])
    };
    let [even, found] = [of(0.0, ""), of(0.4, "resample_hz = 400")];
    let power = |found: &Value| found["mean_power_w"].as_f64().expect("a power");
    let apart = power(&found) / power(&even) - 1.0;
    assert!(apart.abs() < 3e-4, "{apart}");
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("resample_hz = 400: of 201 samples 195 are moved"), "{warnings}");
}

#[test]
fn columns_that_cannot_be_told_apart_are_refused() {
    let folder = folder("which-column");
    let several = table("time_s,x,y\n", |time, number| format!("{time},{number},0"));
    refused_by(&folder, &several, "", &["excitation.column: is missing", "\"time_s\", \"x\", \"y\""]);
    refused_by(&folder, &several, "colum = 2", &["scene.toml:", "colum = 2", "probably column misspelt"]);
    let twice = table("time_s,x,x\n", |time, number| format!("{time},{number},0"));
    refused_by(&folder, &twice, "column = 2", &["line 1", "column \"x\": must be there once"]);
    let days = table("time (d),x\n", |time, number| format!("{time},{number}"));
    refused_by(&folder, &days, "column = 2", &["line 1", "\"time (d)\": its unit must be h, min, s"]);
    let unnamed = table("a,b\n", |time, number| format!("{number},{time}"));
    refused_by(&folder, &unnamed, "rate_hz = 400", &["excitation.column: is missing", "\"a\", \"b\""]);
    let noise = table("", |time, number| format!("{number},{}", number * time));
    refused_by(&folder, &noise, "rate_hz = 400", &["excitation.column: is missing"]);
    let count = table("", |time, number| format!("{},{number}", (400.0 * time).round()));
    refused_by(&folder, &count, "column = 2", &["excitation.rate_hz: is missing", "column of times"]);
    // A decimal comma in a file of one column makes two of it, and two marks make two meanings.
    let comma = table("x\n", |_, number| number.to_string().replace('.', ","));
    refused_by(&folder, &comma, "column = \"x\"\nrate_hz = 400", &["line 3", "2 columns", "decimal commas"]);
    refused_by(&folder, "t;x\n0;1,5\n1;1.500\n2;0\n", "column = 2", &["line 3", "decimal mark '.'"]);
    for (data, clock, parts) in [
        ("0,1\nnan,2\n0.2,3\n", "1", ["excitation.time_column = 1", "line 2: time NaN s must be finite"]),
        ("0,1\n0.1,2\n", "3", ["excitation.time_column = 3", "line 1: there are 2 columns"]),
        ("s,x\n0.1,2\n", "\"t\"", ["excitation.time_column = \"t\"", "\"s\", \"x\""]),
        ("0,1\n", "0", ["excitation.time_column = 0", "number from 1"]),
    ] {
        refused_by(&folder, data, &format!("column = 2\ntime_column = {clock}"), &parts);
    }
}
