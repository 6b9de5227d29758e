//! `stability`: the grids of stiff and extreme scenes, and random scenes.

mod days;
mod judged;

use std::path::PathBuf;

use clap::ValueEnum as _;

use super::files::{Outputs, make_folder, report_folder};
use super::{SHIPPED_SCENES, count, json_text, note, print};
use crate::method::Failure;
use crate::outcome::Format;
use crate::stability::{CASES, Case, Effort, Extent, Kind, Row, draw_varied, grid, page, summary};

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: with --grid coarse 1, 3 and 5 minutes for the three scenes, the whole grid 25 minutes, on two cores"
)]
pub struct StabilityArguments {
    /// Which cases
    #[arg(long, value_enum, default_value_t)]
    grid: Extent,
    /// Of which scene only
    #[arg(long, value_enum, value_name = "SCENE")]
    scene: Option<Kind>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Run this many random scenes in place of the grid
    #[arg(long, value_name = "COUNT", value_parser = count::<u64>(1..=1_000_000),
        conflicts_with_all = ["grid", "scene", "report"])]
    random: Option<u64>,
    /// Which random scenes
    #[arg(long, value_name = "N", default_value_t = 0, requires = "random")]
    seed: u64,
    /// Run each shipped scene for 86,400 simulated seconds in f32 and in f64 in place of the grid, and compare the mean powers
    #[arg(long, conflicts_with_all = ["grid", "random", "output", "report"])]
    day: bool,
    /// Append a row for each case to this file; a file with rows of this build is continued
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Folder of the page with the maps of the grid, and of its cases as CSV [default: report/stability]
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

/// The page of the grid.
const PAGE: &str = "index.html";
/// The option that names the file of rows.
const OUTPUT: &str = "--output";
/// Most attempted steps of a run of a grid, and of a random scene.
const MOST_ATTEMPTS: [u64; 2] = [2_000_000, 200_000];
/// Of the grid, every so many-th setting is judged by the reference.
const BY_REFERENCE: usize = 7;

/// Runs all cases, on all cores, and prints what became of them.
///
/// # Errors
/// If a shipped scene cannot be read, if a file cannot be written, or if a case is wrong or broken.
pub fn run(arguments: &StabilityArguments) -> Result<(), Failure> {
    if arguments.day {
        return days::run(arguments.scene, arguments.format);
    }
    let outputs = Outputs::of_shipped(SHIPPED_SCENES);
    if let Some(file) = &arguments.output {
        outputs.check(OUTPUT, file)?;
    }
    let folder = arguments.report.clone().unwrap_or_else(|| report_folder().join("stability"));
    let has_page = arguments.random.is_none();
    if has_page {
        make_folder(&folder)?;
        [PAGE, CASES].iter().try_for_each(|name| outputs.check("--report", &folder.join(name)))?;
    }
    let cases = cases(arguments);
    let rows = judged::rows(&cases, |number| effort(arguments, number), arguments.output.as_deref())?;
    let csv = || rows.iter().fold(Row::heading(), |text, row| text + &row.csv());
    print(&match arguments.format {
        Format::Table => summary(&rows),
        Format::Csv => csv(),
        Format::Json => json_text(&rows)?,
    })?;
    if has_page {
        outputs.write(&folder.join(CASES), csv())?;
        outputs.write(&folder.join(PAGE), page(&cases, &rows))?;
        note(&format!("report: {}", folder.join(PAGE).display()));
    }
    none_fails(&rows)
}

fn cases(arguments: &StabilityArguments) -> Vec<Case> {
    match (arguments.random, arguments.scene) {
        (Some(count), _) => (0..count).map(|number| draw_varied(arguments.seed, number)).collect(),
        (None, Some(kind)) => grid(kind, arguments.grid),
        (None, None) => Kind::value_variants().iter().flat_map(|&kind| grid(kind, arguments.grid)).collect(),
    }
}

/// Of the case of a number. A setting has two numbers, one for each precision.
fn effort(arguments: &StabilityArguments, number: usize) -> Effort {
    let [of_grid, of_random] = MOST_ATTEMPTS;
    if arguments.random.is_some() {
        Effort { most_attempts: of_random, by_reference: true }
    } else {
        Effort { most_attempts: of_grid, by_reference: (number / 2).is_multiple_of(BY_REFERENCE) }
    }
}

fn none_fails(rows: &[Row]) -> Result<(), Failure> {
    let count = rows.iter().filter(|row| row.class.is_failure()).count();
    if count == 0 {
        return Ok(());
    }
    Err(Failure::Step(format!("{count} of {} cases are wrong or broken", rows.len())))
}
