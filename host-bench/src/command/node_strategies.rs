//! `node-strategies`: ways by which a node knows its income and decides on its actions, beside each other.

use std::path::{Path, PathBuf};

use clap::ValueEnum as _;
use clap::builder::PossibleValuesParser;
use comfy_table::presets;
use serde::Serialize;

use super::files::Outputs;
use super::map::counted_on;
use super::{count, one_more, print, with_progress};
use crate::method::Failure;
use crate::outcome::{Format, folded};
use crate::rows::Rows;
use crate::simulated_node::{
    Course, Extent, Kind, PARTS, Quarter, ROWS, STORAGES, Storage, picture, rows, summary, timelines, years,
};

/// The names of the storages, each once.
fn names() -> Vec<&'static str> {
    let mut names: Vec<&str> = STORAGES.iter().map(|storage| storage.name).collect();
    names.dedup();
    names
}

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: a minute of CPU, most of it the trajectories; it grows with hours and seeds. Of a scene file half a minute \
    more, for its response map"
)]
pub struct NodeStrategiesArguments {
    /// Which harvester only: contact-separation (node.toml), sliding, bump-stop (bump-stop-none.toml), or a scene file with one sine
    /// and a resistor
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// What shakes the harvester; may be repeated [default: random, truck, speed and walking]
    #[arg(long, value_enum)]
    course: Vec<Course>,
    /// Which storage only, by its name in the rows; batteries by their words in a scene file
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(names()))]
    storage: Option<String>,
    /// Which market part only
    #[arg(long, value_parser = PossibleValuesParser::new(PARTS))]
    part: Option<String>,
    /// Harvesters as designed only
    #[arg(long)]
    as_designed: bool,
    /// Hours of each timeline, as many of a harvester as designed and of one that is off
    #[arg(long, value_name = "COUNT", default_value_t = 4, value_parser = count::<usize>(1..=240))]
    hours: usize,
    /// Noises of the ADC and true parts with which each timeline is run
    #[arg(long, value_name = "COUNT", default_value_t = 2, value_parser = count::<u64>(1..=1000))]
    seeds: u64,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the first timeline by each strategy to this file, a picture (.svg) or a page with zoom (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    page: Option<PathBuf>,
}

/// The harvester of a name, or of a scene file, of which a response map is made.
fn harvester(scene: &str) -> Result<Kind, Failure> {
    let of_file = |_| with_progress("map", 0, |bar| Kind::of_file(Path::new(scene), &counted_on(bar)));
    Kind::from_str(scene, false).or_else(of_file)
}

/// Runs all strategies on all timelines and prints the rows.
pub(super) fn run(arguments: &NodeStrategiesArguments) -> Result<(), Failure> {
    let outputs = Outputs::of_shipped(["node", "sliding", "bump-stop-none"])
        .and(&arguments.scene.iter().map(PathBuf::from).collect::<Vec<_>>());
    outputs.check_picture("--page", &arguments.page)?;
    let courses = match &arguments.course[..] {
        [] => vec![Course::Random, Course::Truck, Course::Speed, Course::Walking],
        some => some.to_vec(),
    };
    let is_wanted = |one: &Storage| arguments.storage.as_deref().is_none_or(|name| name == one.name);
    let is_part = |part: &&str| arguments.part.as_deref().is_none_or(|name| name == *part);
    let only = arguments.scene.as_deref().map(harvester).transpose()?;
    let extent = Extent {
        kinds: only.map_or_else(|| Kind::value_variants().to_vec(), |kind| vec![kind]),
        courses,
        parts: PARTS.into_iter().filter(is_part).collect(),
        storages: STORAGES.into_iter().filter(is_wanted).collect(),
        as_designed: arguments.as_designed,
        hours: arguments.hours,
        seeds: arguments.seeds,
    };
    let lines = timelines(&extent)?;
    if lines.is_empty() {
        let text = "--course: must not be truck, rail or walking alone for a slider, which they do not move";
        return Err(Failure::Input(text.to_owned()));
    }
    let count = ROWS * extent.parts.len() * extent.storages.len();
    let rows = with_progress("timelines", count, |bar| rows(&extent, &lines, || one_more(bar)));
    print_rows(&rows, arguments.format, 3)?;
    if arguments.format == Format::Table {
        print(&format!("\n{}\n", folded(&summary(&rows), 0)))?;
    }
    if let Some(file) = &arguments.page {
        let scene = arguments.scene.as_deref().unwrap_or("contact-separation");
        outputs.keep(file, picture::picture(scene, &extent, &lines[0]).of_file(file)?);
    }
    outputs.ended()
}

/// Prints rows of the same keys, of which the first few are words.
fn print_rows<T: Serialize>(rows: &[T], format: Format, words: usize) -> Result<(), Failure> {
    print(&Rows::of(rows).text(format, |rows| rows.table(presets::NOTHING, &rows.plain(), words)))
}

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Exit code 3 if an hour has no number, does not read its storage for hours, or refuses its image\n\
    Run time: minutes of CPU for ten years, on all cores"
)]
pub struct NodeYearsArguments {
    /// Years
    #[arg(long, value_name = "COUNT", default_value_t = 10, value_parser = count::<u32>(1..=50))]
    years: u32,
    /// Output format; the table has of each node the quarter with the fewest hours inside
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the quarters of each tier and storage to this file, a picture (.svg) or a page with zoom (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    page: Option<PathBuf>,
}

pub(super) fn run_years(arguments: &NodeYearsArguments) -> Result<(), Failure> {
    let outputs = Outputs::of_shipped(["node"]);
    outputs.check_picture("--page", &arguments.page)?;
    let quarters = years(365 * arguments.years, &STORAGES[..6])?;
    let of_a_node = |one: &Quarter, other: &Quarter| other.quarter > one.quarter;
    let worst =
        |node: &[Quarter]| node.iter().min_by(|one, other| one.inside.total_cmp(&other.inside)).copied();
    let worst: Vec<Quarter> = quarters.chunk_by(of_a_node).filter_map(worst).collect();
    let shown = if arguments.format == Format::Table { &worst } else { &quarters };
    print_rows(shown, arguments.format, 2)?;
    if let Some(file) = &arguments.page {
        outputs.keep(file, picture::of_years(&quarters).of_file(file)?);
    }
    outputs.ended()?;
    quarters.iter().try_for_each(Quarter::check)
}
