//! `stability`: the stiff and extreme table, and random scenes.

mod random;

use std::path::PathBuf;

use super::files::Outputs;
use super::{SHIPPED_SCENES, json_text, one_more, print, progress, tell};
use crate::method::Failure;
use crate::outcome::{Format, csv_sections};
use crate::scene_file;
use crate::stability::bump_stop::BumpStop;
use crate::stability::known::Known;
use crate::stability::triboelectric::{ContactSeparationSetting, SlidingSetting};
use crate::stability::{Grid, Report, Run, Subject, examine};

#[derive(Debug, Clone, clap::Args)]
pub struct StabilityArguments {
    /// Which cases
    #[arg(long, value_enum, default_value_t)]
    grid: Grid,
    /// Of which scene only
    #[arg(long, value_enum, value_name = "SCENE")]
    scene: Option<Kind>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// List of known failing cases: exactly these must fail
    #[arg(long, value_name = "FILE.csv")]
    known: Option<PathBuf>,
    /// Write the list of failing cases to this file
    #[arg(long, value_name = "FILE.csv", conflicts_with = "known")]
    write_known: Option<PathBuf>,
    /// Run this many random scenes in place of the grid, each judged by the reference or a tighter run
    #[arg(long, value_name = "COUNT", conflicts_with_all = ["grid", "scene", "format", "known", "write_known"])]
    random: Option<u64>,
    /// Which random scenes
    #[arg(long, value_name = "N", default_value_t = 0, requires = "random")]
    seed: u64,
    /// Append a row for each random scene to this file; a file with rows is continued
    #[arg(long, value_name = "FILE.csv", requires = "random")]
    output: Option<PathBuf>,
}

/// Of which scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// Contact-separation.
    ContactSeparation,
    /// Sliding.
    Sliding,
    /// Bump-stop.
    BumpStop,
}

const SCENES: [&str; 3] = [ContactSeparationSetting::SCENE, SlidingSetting::SCENE, BumpStop::SCENE];

/// Runs all cases, on all cores, and prints what became of them.
///
/// # Errors
/// If a shipped scene cannot be read, or if a case fails; with a list of known failing cases, if others fail than are
/// listed.
pub fn run(arguments: &StabilityArguments) -> Result<(), Failure> {
    if let Some(count) = arguments.random {
        return random::run(count, arguments.seed, arguments.output.as_deref());
    }
    let known = arguments.known.as_ref().map(|file| Known::read(file, &SCENES)).transpose()?;
    let outputs = Outputs::of_shipped(SHIPPED_SCENES);
    if let Some(file) = &arguments.write_known {
        outputs.check("--write-known", file)?;
    }
    let kinds = arguments
        .scene
        .map_or(vec![Kind::ContactSeparation, Kind::Sliding, Kind::BumpStop], |kind| vec![kind]);
    let reports: Vec<Report> =
        kinds.into_iter().map(|kind| kind.report(arguments.grid)).collect::<Result<_, _>>()?;
    print(&match arguments.format {
        Format::Table => reports.iter().map(|report| report.text.as_str()).collect::<Vec<_>>().join("\n"),
        Format::Csv => {
            csv_sections(reports.iter().map(|report| (report.csv_heading.clone(), report.csv_rows.clone())))
        }
        Format::Json => json_text(&reports.iter().flat_map(|report| &report.json).collect::<Vec<_>>())?,
    })?;
    let runs: Vec<Run> = reports.into_iter().flat_map(|report| report.runs).collect();
    match (&arguments.write_known, known) {
        (Some(file), _) => outputs.write(file, &Known::of(&runs).text()),
        (None, Some(known)) => agree(&known, &runs),
        (None, None) => none_fails(&runs),
    }
}

impl Kind {
    fn report(self, grid: Grid) -> Result<Report, Failure> {
        match self {
            Self::ContactSeparation => report::<ContactSeparationSetting>(grid),
            Self::Sliding => report::<SlidingSetting>(grid),
            Self::BumpStop => report::<BumpStop>(grid),
        }
    }
}

/// Runs the cases of a scene, with a progress bar.
fn report<K: Subject>(grid: Grid) -> Result<Report, Failure> {
    let base = scene_file::read(&scene_file::shipped(K::SCENE), &[])?;
    let bar = progress(K::settings(grid).len());
    let report = examine::<K>(&base, grid, || one_more(&bar));
    bar.finish_and_clear();
    Ok(report)
}

/// Refuses runs that differ from the list of known failing cases.
fn agree(known: &Known, runs: &[Run]) -> Result<(), Failure> {
    let differences = known.differences(runs);
    for difference in &differences {
        tell(difference);
    }
    match differences.len() {
        0 => Ok(()),
        count => Err(Failure::Step(format!("{count} cases are not as the list of known failing cases says"))),
    }
}

fn none_fails(runs: &[Run]) -> Result<(), Failure> {
    let failing: Vec<&Run> = runs.iter().filter(|run| run.is_failure).collect();
    match failing.first() {
        None => Ok(()),
        Some(first) => Err(Failure::Step(format!(
            "{} of {} runs are off without an explanation, the first of {} with {}",
            failing.len(),
            runs.len(),
            first.scene,
            first.options,
        ))),
    }
}
