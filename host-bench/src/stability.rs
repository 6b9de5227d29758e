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

use crate::method::Failure;
use crate::outcome::{csv_line, number};
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
    /// A run that was judged.
    type Finding: Finding;

    /// Its heading in the terminal.
    const HEADING: &'static str;
    /// Its name in scene files.
    const SCENE: &'static str;

    /// The cases of a grid.
    fn settings(grid: Grid) -> Vec<Self::Setting>;

    /// Runs a case, made of the shipped scene `base`, in each precision and at each step, and judges the runs.
    fn examine(base: &Scene, setting: Self::Setting, grid: Grid) -> Vec<Self::Finding>;

    /// Counts of each class, and the runs that stand out.
    fn text(findings: &[Self::Finding]) -> String;
}

/// A run that was judged, as a row of CSV.
pub(crate) trait Finding: Serialize + Send {
    /// Names and values of the columns that tell the run from all others of its scene.
    fn case(&self) -> Vec<(&'static str, String)>;

    /// Names and values of the columns that say what became of the run.
    fn verdict(&self) -> Vec<(&'static str, String)>;

    /// Whether the run is wrong and nothing explains it.
    fn is_failure(&self) -> bool;

    /// The options that make `run` run the case.
    fn options(&self) -> String;
}

/// A run and whether it failed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    /// Name of the scene.
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
///
/// # Errors
/// If a finding has no form in JSON.
pub(crate) fn examine<K: Subject>(
    base: &Scene,
    grid: Grid,
    done: impl Fn() + Sync,
) -> Result<Report, Failure> {
    let findings: Vec<K::Finding> = K::settings(grid)
        .into_par_iter()
        .flat_map_iter(|setting| {
            let findings = K::examine(base, setting, grid);
            done();
            findings
        })
        .collect();
    let json: serde_json::Result<_> = findings.iter().map(serde_json::to_value).collect();
    Ok(Report {
        text: format!("{}\n\n{}", K::HEADING, K::text(&findings)),
        csv_heading: findings.first().map_or_else(String::new, csv_heading),
        csv_rows: findings.iter().map(csv_row).collect(),
        json: json.map_err(|error| Failure::Input(format!("--format json: {error}")))?,
        runs: findings.iter().map(|finding| run::<K>(finding)).collect(),
    })
}

fn csv_heading(finding: &impl Finding) -> String {
    let columns = finding.case().into_iter().chain(finding.verdict());
    csv_line(columns.map(|(name, _)| name.to_owned()).chain(["options".to_owned()]))
}

fn csv_row(finding: &impl Finding) -> String {
    let columns = finding.case().into_iter().chain(finding.verdict());
    csv_line(columns.map(|(_, value)| value).chain([finding.options()]))
}

fn run<K: Subject>(finding: &K::Finding) -> Run {
    let columns = finding.case().into_iter().filter(|(name, value)| *name != "scene" && !value.is_empty());
    Run {
        scene: K::SCENE,
        case: columns.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" "),
        is_failure: finding.is_failure(),
        options: finding.options(),
    }
}

/// A resistance in Ω as a cell, infinity included.
fn ohms(resistance: f64) -> String {
    if resistance.is_finite() { number(resistance) } else { "inf".to_owned() }
}

/// `|one − other|` over the larger magnitude. Not-a-number, which agrees with nothing, stays what it is.
fn difference(one: f64, other: f64) -> f64 {
    let larger = one.abs().max(other.abs());
    if larger <= 1e-30 { 0.0 } else { (one - other).abs() / larger }
}
