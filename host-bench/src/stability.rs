//! Whether the core gives a right answer, or says that it does not, over the whole range of stiff and extreme scenes.
//!
//! A scene supplies its cases and judges their runs ([`Subject`]); running the grid, printing and the list of known
//! failures are the same for all.

pub(crate) mod bump_stop;
pub(crate) mod known;
mod table;
pub(crate) mod triboelectric;

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

use crate::outcome::{cell, csv_line, fields};
use crate::scene_file::Scene;

/// Which cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub(crate) enum Grid {
    /// All, in each precision: 3648 of contact-separation, 4032 of sliding.
    #[default]
    Whole,
    /// Of contact-separation every third decade of the resistance, of sliding every other value.
    Coarse,
}

/// A scene whose range is examined.
pub(crate) trait Subject {
    /// What differs from the shipped scene.
    type Setting: Copy + Send + Sync;
    type Finding: Finding;

    /// Its heading in the terminal.
    const HEADING: &'static str;
    const SCENE: &'static str;

    fn settings(grid: Grid) -> Vec<Self::Setting>;

    /// Runs a case, made of the shipped scene `base`, in each precision and at each step, and judges the runs.
    fn examine(base: &Scene, setting: Self::Setting, grid: Grid) -> Vec<Self::Finding>;

    /// Counts of each class, and the runs that stand out.
    fn text(findings: &[Self::Finding]) -> String;
}

/// A run that was judged, as an object of JSON and a row of CSV.
pub(crate) trait Finding: Serialize + Send {
    /// Columns of CSV that tell the run from all others of its scene.
    const CASE: &'static [&'static str];
    /// Columns of CSV that say what became of the run: the first is [`Finding::verdict`].
    const RESULT: &'static [&'static str];

    /// The name of what became of the run.
    fn verdict(&self) -> String;

    /// Whether the run is wrong and nothing explains it.
    fn is_failure(&self) -> bool;

    /// The options that make `run` run the case.
    fn options(&self) -> String;
}

/// A run and whether it failed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) scene: &'static str,
    /// The case: `name=value` of each column of CSV that tells it from the others.
    pub(crate) case: String,
    pub(crate) is_failure: bool,
    /// The options that make `run` run the case.
    pub(crate) options: String,
}

/// What became of all cases of a scene.
pub(crate) struct Report {
    /// For a terminal.
    pub(crate) text: String,
    pub(crate) csv_heading: String,
    pub(crate) csv_rows: String,
    /// One object for each run.
    pub(crate) json: Vec<Value>,
    pub(crate) runs: Vec<Run>,
}

/// Runs all cases of a grid, made of the shipped scene `base`, on all cores; calls `done` after each case.
pub(crate) fn examine<K: Subject>(base: &Scene, grid: Grid, done: impl Fn() + Sync) -> Report {
    let findings: Vec<K::Finding> = K::settings(grid)
        .into_par_iter()
        .flat_map_iter(|setting| {
            let findings = K::examine(base, setting, grid);
            done();
            findings
        })
        .collect();
    Report {
        text: format!("{}\n\n{}", K::HEADING, K::text(&findings)),
        csv_heading: csv_heading::<K>(),
        csv_rows: findings.iter().map(csv_row::<K>).collect(),
        json: findings.iter().map(|finding| fields(finding).into()).collect(),
        runs: findings.iter().map(run::<K>).collect(),
    }
}

fn csv_heading<K: Subject>() -> String {
    let columns = K::Finding::CASE.iter().chain(K::Finding::RESULT).chain(&["options"]);
    csv_line(columns.map(|&name| name.to_owned()))
}

fn csv_row<K: Subject>(finding: &K::Finding) -> String {
    let (case, result) = (cells::<K>(finding, K::Finding::CASE), cells::<K>(finding, K::Finding::RESULT));
    csv_line(case.into_iter().chain(result).chain([finding.options()]))
}

/// The cells of some columns: the values in JSON, empty where the finding has none.
fn cells<K: Subject>(finding: &K::Finding, columns: &[&str]) -> Vec<String> {
    let fields = fields(finding);
    let of = |&column: &&str| match (column, fields.get(column)) {
        ("scene", _) => K::SCENE.to_owned(),
        (verdict, _) if verdict == K::Finding::RESULT[0] => finding.verdict(),
        // JSON has no number for infinity.
        ("resistance_ohm", Some(Value::Null)) => "inf".to_owned(),
        (_, value) => value.map_or_else(String::new, cell),
    };
    columns.iter().map(of).collect()
}

fn run<K: Subject>(finding: &K::Finding) -> Run {
    let columns = K::Finding::CASE.iter().zip(cells::<K>(finding, K::Finding::CASE));
    let columns = columns.filter(|(name, value)| **name != "scene" && !value.is_empty());
    Run {
        scene: K::SCENE,
        case: columns.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" "),
        is_failure: finding.is_failure(),
        options: finding.options(),
    }
}

/// `|one − other|` over the larger magnitude. Not-a-number, which agrees with nothing, stays what it is.
fn difference(one: f64, other: f64) -> f64 {
    let larger = one.abs().max(other.abs());
    if larger <= 1e-30 { 0.0 } else { (one - other).abs() / larger }
}
