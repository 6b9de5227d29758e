//! `figures`: the papers' figures, rebuilt.

use std::path::PathBuf;

use clap::ValueEnum;
use comfy_table::presets;

use super::files::{Outputs, make_folder, report_folder};
use super::{note, print, progress};
use crate::figures::{self, Chapter, Figure, Subject};
use crate::method::Failure;
use crate::outcome::table;

/// The page of a harvester.
const PAGE: &str = "index.html";

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: about 20 s on two cores")]
pub struct FiguresArguments {
    /// Make the figures of one harvester only; may be repeated [default: all]
    #[arg(long, value_enum, value_name = "HARVESTER")]
    only: Vec<Subject>,
    /// Folder in which each harvester gets one for its pictures, their numbers and the page [default:
    /// report/figures]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Leave out the runs from displaced starts, which seek other motions at the points that the pages name
    #[arg(long)]
    single_start: bool,
}

/// Runs all that the figures need, then writes pictures, numbers and a page for each harvester, and prints
/// the tables.
///
/// # Errors
/// A folder that cannot be written to, or a run that fails; then nothing of that harvester is written.
pub fn run(arguments: &FiguresArguments) -> Result<(), Failure> {
    let root = arguments.output.clone().unwrap_or_else(|| report_folder().join("figures"));
    let wanted = |subject: &Subject| arguments.only.is_empty() || arguments.only.contains(subject);
    let subjects: Vec<Subject> = Subject::value_variants().iter().copied().filter(wanted).collect();
    let outputs = Outputs::of_shipped(subjects.iter().flat_map(|subject| subject.scenes()));
    // Made before the runs, so that a bad path is refused at once.
    for subject in &subjects {
        let folder = root.join(subject.name());
        make_folder(&folder)?;
        outputs.check("", &folder.join(PAGE))?;
    }
    let bar = progress(subjects.iter().map(|subject| subject.runs()).sum());
    for subject in subjects {
        let chapter = subject.build(arguments.single_start, &|| bar.inc(1))?;
        let folder = root.join(subject.name());
        for figure in &chapter.figures {
            outputs.write(&folder.join(format!("{}.csv", figure.stem())), &figure.csv)?;
            for panel in &figure.panels {
                outputs.write(&folder.join(format!("{}.svg", panel.name)), panel.svg()?)?;
            }
        }
        let page = folder.join(PAGE);
        outputs.write(&page, figures::page(&chapter)?)?;
        let labels: Vec<&str> = chapter.figures.iter().map(|figure| figure.label).collect();
        bar.suspend(|| {
            note(&format!("figures: {}: {}: {}", subject.name(), labels.join(", "), page.display()));
            print(&tables(&chapter))
        })?;
    }
    bar.finish_and_clear();
    Ok(())
}

/// The tables of a chapter, aligned.
fn tables(chapter: &Chapter) -> String {
    chapter.figures.iter().filter(|figure| !figure.table.is_empty()).map(aligned).collect()
}

fn aligned(figure: &Figure) -> String {
    let Some((headings, rows)) = figure.table.split_first() else { return String::new() };
    let table = table(presets::NOTHING, headings, rows, headings.len());
    format!("\n{}. {}\n{table}", figure.label, figure.title)
}
