//! Grids.

use std::fs::{read_to_string, write};
use std::path::Path;

use super::interrupted::{rows, with_checksum};
use super::tool::{PASSIVE, SHIPPED, accepted, folder, json, number, outcome, printed, refused};

const SHORT: [&str; 4] = ["--set", "run.duration_s=0.5", "--set", "run.settle_s=0.3"];

fn sweep<'a>(options: &[&'a str]) -> Vec<&'a str> {
    [&["sweep", SHIPPED, "--method", "reference"], &SHORT[..], options].concat()
}

const GRID: [&str; 3] =
    ["--over=load.resistance_ohm=1e6:1e8:3:log", "--over=excitation.frequency_hz=19:20:2", "--format=csv"];

/// A grid of six points with its files in a folder.
fn grid<'a>(folder: &'a Path, options: &[&'a str]) -> Vec<&'a str> {
    sweep(&[&GRID[..], &["--output", folder.to_str().expect("a plain path")], options].concat())
}

#[test]
fn a_grid_has_a_row_for_each_point_and_a_picture() {
    let folder = folder("grid");
    let output = folder.join("made");
    let text = accepted(&grid(&output, &[]));
    let written = read_to_string(output.join("sweep.csv")).expect("the table");
    assert_eq!(rows(&text), rows(&written));
    let rows = rows(&text);
    let cell = |at: usize, name: &str| rows[at][name].as_str();
    let point = |at: usize| (cell(at, "load.resistance_ohm"), cell(at, "excitation.frequency_hz"));
    assert_eq!(rows.len(), 6);
    assert_eq!((point(0), point(1)), (("1000000.0", "19.0"), ("1000000.0", "20.0")));
    assert_eq!(point(5), ("100000000.0", "20.0"));
    // The last point is the run of that point.
    let alone = outcome(SHIPPED, &["run.duration_s=0.5", "run.settle_s=0.3"]);
    let power: f64 = cell(5, "mean_power_w").parse().expect("a number");
    assert_eq!(Some(power), alone["mean_power_w"].as_f64());
    let picture = read_to_string(output.join("sweep.svg")).expect("the picture");
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
    let page = read_to_string(output.join("sweep.html")).expect("the page");
    assert!(page.contains("load resistance = 10 MΩ") && !page.contains("src="), "a page needs no other file");
    for label in ["load resistance [Ω]", "excitation frequency [Hz]", "mean power [µW]", "10⁷", "19.5"] {
        assert!(picture.contains(label), "{label} is in the picture");
    }
    assert!(picture.matches("<rect").count() > 6);
}

#[test]
fn one_axis_makes_curves() {
    let folder = folder("curve");
    let path = folder.to_str().expect("a plain path");
    let over = "parameters.charge_density_c_per_m2=1e-5:3e-5:3";
    let points = json(&sweep(&["--over", over, "--output", path]));
    let points = points.as_array().expect("an array");
    let found: Vec<f64> = points.iter().filter_map(|point| point["rms_voltage_v"].as_f64()).collect();
    assert_eq!(found.len(), 3);
    assert!(found[0] < found[1] && found[1] < found[2]);
    let middle = number(&points[1], "parameters.charge_density_c_per_m2");
    assert!((middle / 2e-5 - 1.0).abs() < 1e-14);
    let picture = read_to_string(folder.join("sweep.svg")).expect("the picture");
    assert!(picture.matches("<polyline").count() > 2);
    assert_eq!(picture.matches("h0").count(), 6, "three points, two quantities");
    let table = accepted(&sweep(&["--over", over]));
    let is_row = |line: &&str| line.trim_start().starts_with(|letter: char| letter.is_ascii_digit());
    assert_eq!(table.lines().filter(is_row).count(), 3, "{table}");
}

#[test]
fn each_point_states_its_accuracy_unless_told_not_to() {
    let over = ["--over", "load.resistance_ohm=1e7:1e8:2:log", "--format", "csv"];
    let stated = |options: &[&str]| -> Vec<f64> {
        let text = accepted(&[&["sweep", SHIPPED], &SHORT[..], &over, options].concat());
        rows(&text).iter().filter_map(|row| row["accuracy_total"].parse().ok()).collect()
    };
    let totals = stated(&[]);
    assert!(totals.len() == 2 && totals.iter().all(|total| (1e-5..5e-3).contains(total)), "{totals:?}");
    assert_eq!(stated(&["--no-accuracy"]), Vec::<f64>::new());
    let table = accepted(&[&["sweep", SHIPPED], &SHORT[..], &over[..2]].concat());
    assert!(table.lines().next().is_some_and(|line| line.contains("stated_error")), "{table}");
}

/// The best of these points is a lucky run of a chaotic motion.
#[test]
fn the_best_point_is_told_with_its_stated_error_and_is_doubted_where_its_motion_has_no_period() {
    let told = |over: &str, options: &[&str]| {
        let arguments = [&["sweep", PASSIVE, "--over", over], options].concat();
        let [_, told] = printed(&arguments);
        told
    };
    let chaotic = told("excitation.frequency_hz=20.04:20.07:4", &["--no-accuracy"]);
    assert!(chaotic.contains("warning: the best point has no steady motion of one period"), "{chaotic}");
    assert!(chaotic.contains("which may be a lucky one: ") && !chaotic.contains("stated error"), "{chaotic}");
    let periodic = told("excitation.frequency_hz=20.4:20.6:3", &["--set=run={duration_s=3.0,settle_s=2.0}"]);
    let best = periodic.lines().find(|line| line.starts_with("largest mean_power_w ")).expect("it is told");
    let error = best.split(", stated error ").nth(1).and_then(|error| error.parse::<f64>().ok());
    assert!(error.is_some_and(|error| error > 0.0), "{best}");
    assert!(!periodic.contains("lucky"), "{periodic}");
    // The motion at these frequencies is chaotic, and the error of its mean large.
    let doubtful = told("excitation.frequency_hz=19.75:20.5:2", &[]);
    let place = "at 1 of 2 points, the first at excitation.frequency_hz = 19.75: accuracy:";
    assert!(doubtful.contains(place), "{doubtful}");
}

#[test]
fn a_bad_grid_is_refused_and_nothing_is_written() {
    let folder = folder("bad-grid");
    let named = folder.join("sw.csv");
    refused(&grid(&named, &[]), &["--output", "sw.csv", "must be a folder", "is named as a file"]);
    assert!(!named.exists());
    let output = folder.join("made");
    let path = output.to_str().expect("a plain path");
    for (over, parts) in [
        (vec!["load.resistance_ohm"], vec!["--over", "KEY=FROM:TO:COUNT"]),
        (vec!["load.resistance_ohm=1:2"], vec!["--over", "KEY=FROM:TO:COUNT"]),
        (vec!["load.resistance_ohm=1:2:x"], vec!["--over", "COUNT = \"x\""]),
        (vec!["load.resistance_ohm=1:2:0"], vec!["--over", "COUNT = \"0\""]),
        (vec!["load.resistance_ohm=1:2:-3"], vec!["--over", "COUNT = \"-3\""]),
        (vec!["load.resistance_ohm=nan:2:3"], vec!["--over", "FROM = \"nan\""]),
        (vec!["load.resistance_ohm=1:3 mm:3"], vec!["--over", "TO = \"3 mm\""]),
        (vec!["load.resistance_ohm=0:2:3:log"], vec!["--over", "above 0 with log"]),
        (vec!["load.resistance=1:2:3"], vec!["load.resistance = 1", "unknown key"]),
        (vec!["load.resistance_ohm=-1:1:3"], vec!["load.resistance_ohm = -1", "from 1e-9 to 1e30"]),
        (vec!["run.settle_s=0:0.5:3"], vec!["run.settle_s = 0.5", "before the end"]),
        (vec!["parameters.force_law=1:2:2"], vec!["parameters.force_law = 1", "transferred-charge"]),
        (vec!["load.resistance_ohm=1:2:2", "load.resistance_ohm=3:4:2"], vec!["load.resistance_ohm", "once"]),
        (vec!["load.resistance_ohm=1:2:100000", "run.settle_s=0:0.1:11"], vec!["--over", "at most 1000000"]),
    ] {
        let axes: Vec<&str> = over.iter().flat_map(|axis| ["--over", *axis]).collect();
        refused(&sweep(&[&axes[..], &["--output", path]].concat()), &parts);
        assert!(!output.exists(), "{over:?} wrote something");
    }
    refused(&sweep(&[]), &["--over"]);
}

#[test]
fn an_interrupted_sweep_goes_on_from_its_points() {
    let folder = folder("resumed");
    let path = folder.to_str().expect("a plain path");
    let grid = grid(&folder, &[]);
    let read = |name: &str| read_to_string(folder.join(name));
    accepted(&grid);
    let whole = read("sweep.csv").expect("the table");
    assert!(read("sweep.rows.jsonl").is_err(), "nothing is left of a whole sweep");
    // A sweep is stopped after some points, in the middle of a line.
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_host-bench"))
        .args(&grid)
        .stdout(std::process::Stdio::null())
        .spawn()
        .expect("the binary starts");
    let began = std::time::Instant::now();
    let stopped = loop {
        let rows = read("sweep.rows.jsonl").unwrap_or_default();
        if rows.lines().count() > 2 || began.elapsed().as_secs() > 60 {
            // It may have ended meanwhile.
            let _ = child.kill();
            break rows;
        }
        std::thread::yield_now();
    };
    child.wait().expect("it is stopped");
    let lines: Vec<&str> = stopped.lines().collect();
    assert!(lines.len() > 2, "{stopped}");
    // As the rows were at that time, with a last line that is cut, and a number that no run gives.
    let (row, _) = lines[1].rsplit_once(',').expect("a checksum");
    let marked = row.replacen("\"steps\":", "\"steps\":7000000", 1);
    assert_ne!(marked, row);
    let marked = with_checksum(&marked);
    write(folder.join("sweep.rows.jsonl"), format!("{}\n{marked}\n{{\"point\": 3, \"fie", lines[0]))
        .expect("rows");
    let resumed = accepted(&grid);
    assert_eq!(resumed.lines().count(), whole.lines().count());
    // The point that was done is not run again; the others are those of the whole sweep.
    let (one, other) = (rows(&whole), rows(&resumed));
    let differing: Vec<usize> = (0..one.len()).filter(|row| one[*row] != other[*row]).collect();
    assert_eq!(differing.len(), 1, "{differing:?}");
    assert!(other[differing[0]]["steps"].starts_with("7000000"), "{other:?}");
    // Points of another sweep are refused.
    write(folder.join("sweep.rows.jsonl"), format!("{}\n", lines[0])).expect("rows");
    let another = sweep(&["--over", "load.resistance_ohm=1e6:1e8:2", "--output", path]);
    refused(&another, &["sweep.rows.jsonl", "another sweep"]);
}

#[test]
fn parts_of_a_sweep_merge_into_the_rows_and_pictures_of_the_whole() {
    let [whole, parts] = ["whole", "parts"].map(|name| folder(&format!("sweep-{name}")));
    let part = |options: &[&str]| accepted(&grid(&parts, options));
    let merged = |options: &[&str], reasons: &[&str]| refused(&grid(&parts, options), reasons);
    let expected = accepted(&grid(&whole, &[]));
    for name in ["4/4", "1/4", "2/4"] {
        assert_eq!(part(&["--part", name]), "", "the result waits for the other parts");
    }
    let file = |part: u32| parts.join(format!("sweep.rows.part-{part}-of-4.jsonl"));
    let lacks = |part: u32, counts: &str| {
        let [name, has] = [format!("part-{part}-of-4.jsonl"), format!("of part {part}/4, has {counts}")];
        merged(&["--merge=4"], &["--output", &name, "must have all ", &has, "give its command again"]);
    };
    lacks(3, "0");
    part(&["--part=3/4"]);
    // A part that was killed within a row goes on.
    let text = read_to_string(file(1)).expect("the rows");
    write(file(1), &text[..text.len() - 9]).expect("the rows");
    lacks(1, "1");
    part(&["--part=1/4"]);
    let heading = text.split_once('\n').expect("a heading").0;
    let (_, build) = heading.split_once(": \"").or(heading.split_once(":\"")).expect("a build");
    for other in [heading.replacen(build, &format!("other-{build}"), 1), heading.replace("sweep", "other")] {
        let now = read_to_string(file(2)).expect("the rows");
        write(file(2), now.replacen(heading, &other, 1)).expect("the rows");
        merged(&["--merge=4"], &["part-2-of-4.jsonl", "of another sweep, or of another build"]);
        write(file(2), now).expect("the rows");
    }
    merged(&["--merge=4", "--single-start"], &["part-1-of-4.jsonl", "of another sweep"]);
    merged(&["--merge=4", "--part=1/4"], &["--merge", "--part"]);
    for wrong in ["0/4", "5/4", "1/0", "4", "a/b"] {
        merged(&["--part", wrong], &["--part", wrong, "must be K/N with K from 1 to N"]);
    }
    refused(&sweep(&[&GRID[..], &["--part=1/4"]].concat()), &["--output"]);
    let merged = part(&["--merge=4"]);
    assert_eq!(rows(&merged), rows(&expected));
    for name in ["sweep.csv", "sweep.svg"] {
        let [one, other] = [&whole, &parts].map(|folder| read_to_string(folder.join(name)).expect("a file"));
        assert!(if name == "sweep.csv" { rows(&one) == rows(&other) } else { one == other }, "{name}");
    }
    assert!(!parts.join("sweep.rows.jsonl").exists() && file(1).exists(), "the parts stay");
}
