//! `stability --random`: random scenes, each judged by a more accurate run.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;

use clap::ValueEnum as _;
use comfy_table::presets;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::command::files::Outputs;
use crate::command::{SHIPPED_SCENES, one_more, print, progress};
use crate::method::Failure;
use crate::outcome::{cell, csv_line, fields, name, small, table};
use crate::random_scenes::{Case, Class, Effort, Finding, judge};

/// Most attempted steps of a run.
const MOST_ATTEMPTS: u64 = 200_000;
const OPTION: &str = "--output";

/// A row of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    seed: u64,
    number: u64,
    scene: String,
    class: Class,
    /// Relative error of the mean power.
    error: Option<f64>,
    /// The statement of the relative error.
    stated: Option<f64>,
    is_warned: bool,
    by_reference: bool,
    reason: String,
    /// The arguments with which the command line runs the case.
    arguments: String,
}

const COLUMNS: [&str; 10] = [
    "seed",
    "number",
    "scene",
    "class",
    "error",
    "stated",
    "is_warned",
    "by_reference",
    "reason",
    "arguments",
];

impl Row {
    fn of(seed: u64, number: u64) -> Self {
        let case = Case::draw(seed, number);
        let effort = Effort { most_attempts: MOST_ATTEMPTS, by_reference: true };
        let Finding { class, error, stated, is_warned, by_reference, reason } = judge(&case, effort);
        let (scene, arguments) = (case.scene.to_owned(), case.arguments());
        Self { seed, number, scene, class, error, stated, is_warned, by_reference, reason, arguments }
    }

    fn csv(&self) -> String {
        csv_line(fields(self).values().map(cell))
    }
}

/// Runs the cases from 0 to below `count` under a seed. With a file, the row of a case is appended when the case is judged,
/// and a case whose row the file has is not run again.
pub(super) fn run(count: u64, seed: u64, output: Option<&Path>) -> Result<(), Failure> {
    let mut rows = match output {
        Some(path) => {
            Outputs::of_shipped(SHIPPED_SCENES).check(OPTION, path)?;
            taken_up(path, seed)?
        }
        None => Vec::new(),
    };
    rows.retain(|row| row.number < count);
    let file = output.map(appended).transpose()?.map(Mutex::new);
    let done: BTreeSet<u64> = rows.iter().map(|row| row.number).collect();
    let left: Vec<u64> = (0..count).filter(|number| !done.contains(number)).collect();
    let bar = progress(left.len());
    let new: Result<Vec<Row>, Failure> = left
        .into_par_iter()
        .map(|number| {
            let row = Row::of(seed, number);
            one_more(&bar);
            if let (Some(file), Some(path)) = (&file, output) {
                append(file, path, &row.csv())?;
            }
            Ok(row)
        })
        .collect();
    bar.finish_and_clear();
    rows.extend(new?);
    print(&summary(&rows))?;
    none_fails(&rows)
}

/// The rows of a file that an earlier run began; its last line is removed if it is not whole. A file that is not there is
/// made, with its heading.
fn taken_up(path: &Path, seed: u64) -> Result<Vec<Row>, Failure> {
    let heading = csv_line(COLUMNS.map(str::to_owned));
    let write = |text: &str| {
        fs::write(path, text).map_err(|error| refuse(path, format!("cannot be written: {error}")))
    };
    if !path.exists() {
        write(&heading)?;
        return Ok(Vec::new());
    }
    let text = fs::read_to_string(path).map_err(|error| refuse(path, format!("cannot be read: {error}")))?;
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    if !whole.starts_with(&heading) {
        return Err(refuse(path, "must be a file of stability --random, or not be there".to_owned()));
    }
    let rows: Result<Vec<Row>, _> = csv::Reader::from_reader(whole.as_bytes()).deserialize().collect();
    let rows = rows.map_err(|error| refuse(path, error.to_string()))?;
    if let Some(other) = rows.iter().find(|row| row.seed != seed) {
        return Err(refuse(path, format!("has cases of seed {}, must be of --seed {seed}", other.seed)));
    }
    if whole.len() < text.len() {
        write(whole)?;
    }
    Ok(rows)
}

fn appended(path: &Path) -> Result<File, Failure> {
    let file = OpenOptions::new().append(true).open(path);
    file.map_err(|error| refuse(path, format!("cannot be written: {error}")))
}

fn append(file: &Mutex<File>, path: &Path, line: &str) -> Result<(), Failure> {
    // A lock is poisoned by a panic while a line is written only.
    let mut file = file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    file.write_all(line.as_bytes()).map_err(|error| refuse(path, format!("cannot be written: {error}")))
}

fn refuse(path: &Path, reason: String) -> Failure {
    Failure::Input(format!("{OPTION} {}: {reason}", path.display()))
}

/// Counts of each class by scene, how the statements compare with the errors, and each failing case.
fn summary(rows: &[Row]) -> String {
    let mut text = counts(rows);
    let judged: Vec<(f64, f64)> = rows.iter().filter_map(|row| Some((row.error?, row.stated?))).collect();
    let within = judged.iter().filter(|(error, stated)| error <= stated).count();
    let mut ratios: Vec<f64> =
        judged.iter().filter(|(error, _)| *error > 0.0).map(|(error, stated)| stated / error).collect();
    ratios.sort_by(f64::total_cmp);
    let by_reference = rows.iter().filter(|row| row.by_reference && row.stated.is_some()).count();
    text.push_str(&format!(
        "\n{} cases with an error and a statement, {by_reference} of them by the reference: {within} errors within the \
         statement; median of statement / error {}.\n",
        judged.len(),
        small(ratios.get(ratios.len() / 2).copied()),
    ));
    let failing = rows.iter().filter(|row| row.class.is_failure());
    let lines = failing.map(|row| format!("\n{}: {}\n{}\n", row.number, row.reason, row.arguments));
    text + &lines.collect::<String>()
}

fn counts(rows: &[Row]) -> String {
    let kinds = ["contact-separation", "sliding", "bump-stop", ""];
    let lines = Class::value_variants().iter().map(|class| {
        let count = |kind: &&str| {
            let these = rows.iter().filter(|row| row.class == *class && row.scene.starts_with(*kind));
            these.count().to_string()
        };
        std::iter::once(name(class)).chain(kinds.iter().map(count)).collect::<Vec<String>>()
    });
    let headings = ["class", "contact-separation", "sliding", "bump-stop", "all"];
    table(presets::NOTHING, headings, lines, 1)
}

fn none_fails(rows: &[Row]) -> Result<(), Failure> {
    let count = rows.iter().filter(|row| row.class.is_failure()).count();
    if count == 0 {
        return Ok(());
    }
    Err(Failure::Step(format!("{count} of {} random scenes are wrong or broken", rows.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(number: u64) -> Row {
        Row {
            seed: 3,
            number,
            scene: "sliding".to_owned(),
            class: Class::NamedError,
            error: None,
            stated: Some(0.25),
            is_warned: true,
            by_reference: false,
            reason: "a, \"b\"".to_owned(),
            arguments: "run x --set 'load={kind=\"dc-bus\"}'".to_owned(),
        }
    }

    #[test]
    fn a_file_is_taken_up_without_a_line_that_is_not_whole() {
        let path = std::env::temp_dir().join(format!("random-scenes-{}.csv", std::process::id()));
        let _ = fs::remove_file(&path);
        assert_eq!(taken_up(&path, 3), Ok(Vec::new()));
        let heading = fs::read_to_string(&path).expect("the file was made");
        let whole = heading + &row(0).csv() + &row(7).csv();
        fs::write(&path, format!("{whole}3,8,slid")).expect("is writable");
        assert_eq!(taken_up(&path, 3), Ok(vec![row(0), row(7)]));
        assert_eq!(fs::read_to_string(&path).expect("is there"), whole);
        let other = taken_up(&path, 4).expect_err("another seed").to_string();
        assert!(other.contains("seed 3"), "{other}");
        fs::write(&path, "a,b\n1,2\n").expect("is writable");
        assert!(taken_up(&path, 3).is_err());
        let _ = fs::remove_file(&path);
    }

    #[test]
    fn the_columns_are_those_of_a_row() {
        assert!(fields(&row(0)).keys().eq(COLUMNS));
    }
}
