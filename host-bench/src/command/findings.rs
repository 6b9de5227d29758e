//! `findings` and `figures`: what the two papers find, on the shipped scenes; `validation`: published measurements.

use std::path::PathBuf;

use clap::ValueEnum;
use comfy_table::presets;
use serde_json::{Value, json};

use super::files::{Outputs, make_folder, report_folder};
use super::{count, fail_after_result, json_text, note, print, progress, with_progress};
use crate::figures::{self, Chapter, Figure, Subject};
use crate::findings::{self, Check, Finding, Mark, Robustness, Row, wanted};
use crate::method::Failure;
use crate::outcome::{Format, csv, folded, table};
use crate::rows::{Column, Digits, Rows};
use crate::validation;

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: half a minute on two cores; with --robustness 15 s for each draw")]
pub struct FindingsArguments {
    /// Numbers of the findings to measure, such as 8,9 or 5-8 [default: all]
    #[arg(long, value_delimiter = ',', value_name = "NUMBERS")]
    only: Vec<String>,
    /// Leave out the runs from displaced starts, which seek other motions at the points from which numbers are taken
    #[arg(long)]
    single_start: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Measure in which part of some draws of the parameters the mark of each finding stays, in place of the marks; in CSV y, n or u for each draw: it holds, does not, unknown
    #[arg(long, conflicts_with = "single_start")]
    robustness: bool,
    /// Number of draws
    #[arg(long, value_name = "COUNT", default_value_t = 200, value_parser = count::<u64>(1..=999_999), requires = "robustness")]
    draws: u64,
    /// Number of the first draw; the stored ones begin at 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = count::<u64>(0..=999_999), requires = "robustness")]
    from: u64,
}

/// Measures the findings on all cores and prints them.
pub(super) fn run(arguments: &FindingsArguments) -> Result<(), Failure> {
    let FindingsArguments { only, single_start, format, .. } = arguments;
    if arguments.robustness {
        return robustness(arguments);
    }
    let rows = with_progress("findings", wanted(only)?.len(), |bar| {
        findings::measure(only, *single_start, &|count| bar.inc(count as u64))
    })?;
    print(&match format {
        Format::Table => text(&rows),
        Format::Json => json_text(&rows.iter().map(object).collect::<Vec<_>>())?,
        Format::Csv => csv_text(&rows),
    })?;
    let other: Vec<&str> =
        rows.iter().filter(|row| !row.is_as_expected()).map(|row| row.finding.number).collect();
    if other.is_empty() {
        return Ok(());
    }
    fail_after_result(format!("findings: the mark is not the expected one: {}", other.join(", ")))
}

/// Measures draws of the parameters and prints in which of them each mark stays.
fn robustness(arguments: &FindingsArguments) -> Result<(), Failure> {
    let FindingsArguments { only, draws, from, .. } = arguments;
    let found = with_progress("draws", wanted(only)?.len() * *draws as usize, |bar| {
        findings::drawn(only, *from..from + draws, &|count| bar.inc(count as u64))
    })?;
    let of = |(finding, letters): &(&Finding, String)| Robustness::of(letters, finding.mark);
    let line = |row: &(&Finding, String)| {
        format!("{:>3}  {}; {} unknown\n", row.0.number, of(row).text(), of(row).unknown)
    };
    let object =
        |row: &(&Finding, String)| json!({ "number": row.0.number, "robustness": of(row), "draws": row.1 });
    print(&match arguments.format {
        Format::Table => found.iter().map(line).collect(),
        Format::Json => json_text(&found.iter().map(object).collect::<Vec<_>>())?,
        Format::Csv => csv("number,draws", found.iter().map(|row| [row.0.number.to_owned(), row.1.clone()])),
    })
}

/// The rows for people: number, mark and statement, then each quantity with its values and what is asserted.
pub(super) fn text(rows: &[Row]) -> String {
    let count = |mark: Mark| rows.iter().filter(|row| row.mark() == mark).count();
    let totals = format!(
        "{} shown, {} chosen (shown only with chosen parameters), {} not shown{}\n",
        count(Mark::Shown),
        count(Mark::Chosen),
        count(Mark::NotShown),
        match count(Mark::Stopped) {
            0 => String::new(),
            stopped => format!(", {stopped} stopped (a run did not reach its end)"),
        }
    );
    rows.iter().map(row_text).collect::<String>() + "\n" + &totals
}

fn row_text(row: &Row) -> String {
    let finding = row.finding;
    let mark = row.mark().name();
    let expected = if row.is_as_expected() { "" } else { " (not as expected)" };
    let robustness = finding.robustness.text();
    let line = |text: String, indent: usize| folded(&format!("     {text}"), indent) + "\n";
    let mut text = format!("{:>3}  {mark}{expected}, {robustness}: {}", finding.number, finding.statement);
    text = folded(&text, 5) + "\n" + &line(format!("{}; {}", finding.source, finding.scene), 5);
    if !finding.note.is_empty() {
        text += &line(finding.note.to_owned(), 5);
    }
    for check in &row.checks {
        let asserted = match check.assertion() {
            none if none.is_empty() => none,
            assertion => format!(" ({assertion})"),
        };
        text += &line(format!("{}: {}{asserted}", check.quantity, check.shown()), 9);
    }
    text
}

fn object(row: &Row) -> Value {
    let check = |check: &Check| {
        json!({
            "quantity": check.quantity,
            "assertion": check.assertion(),
            "values": check.values,
            "holds": check.holds(),
        })
    };
    let Finding { number, source, statement, scene, mark, note, robustness } = row.finding;
    json!({
        "number": number,
        "source": source,
        "statement": statement,
        "scene": scene,
        "mark": row.mark(),
        "expected": mark,
        "robustness": robustness,
        "note": note,
        "checks": row.checks.iter().map(check).collect::<Vec<_>>(),
    })
}

/// A line for each quantity.
fn csv_text(rows: &[Row]) -> String {
    let lines = rows.iter().flat_map(|row| {
        let finding = row.finding;
        row.checks.iter().map(move |check| {
            let values: Vec<String> = check.values.iter().map(|value| format!("{value}")).collect();
            [
                finding.number.to_owned(),
                finding.statement.to_owned(),
                finding.scene.to_owned(),
                check.quantity.clone(),
                check.assertion(),
                values.join(" "),
                row.mark().name().to_owned(),
                finding.robustness.share.map_or_else(String::new, |share| share.to_string()),
            ]
        })
    });
    csv("number,statement,scene,quantity,assertion,values,mark,robustness", lines)
}

const PAGE: &str = "index.html";

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: about 20 s on two cores")]
pub struct FiguresArguments {
    /// Make the figures of one harvester only; may be repeated [default: all]
    #[arg(long, value_enum, value_name = "HARVESTER")]
    only: Vec<Subject>,
    /// Folder in which each harvester gets one for its pictures, their numbers and the page [default: report/figures]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Leave out the runs from displaced starts, which seek other motions at the points that the pages name
    #[arg(long)]
    single_start: bool,
}

/// Runs all that the figures need, then writes pictures, numbers and a page for each harvester, and prints
/// the tables. Of a harvester whose run fails nothing is written.
pub(super) fn run_figures(arguments: &FiguresArguments) -> Result<(), Failure> {
    let root = arguments.output.clone().unwrap_or_else(|| report_folder().join("figures"));
    let wanted = |subject: &Subject| arguments.only.is_empty() || arguments.only.contains(subject);
    let subjects: Vec<Subject> = Subject::value_variants().iter().copied().filter(wanted).collect();
    let outputs = Outputs::of_shipped(subjects.iter().flat_map(|subject| subject.scenes()));
    // Made before the runs, so that a bad path is refused at once.
    make_folder(&root)?;
    for subject in &subjects {
        let folder = root.join(subject.name());
        make_folder(&folder)?;
        outputs.check("", &folder.join(PAGE))?;
    }
    let bar = progress("figures", subjects.iter().map(|subject| subject.runs()).sum());
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

fn tables(chapter: &Chapter) -> String {
    chapter.figures.iter().filter(|figure| !figure.table.is_empty()).map(aligned).collect()
}

fn aligned(figure: &Figure) -> String {
    let Some((headings, rows)) = figure.table.split_first() else { return String::new() };
    let table = table(presets::NOTHING, headings, rows, headings.len());
    format!("\n{}. {}\n{table}", figure.label, figure.title)
}

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: a few seconds")]
pub struct ValidationArguments {
    /// Write power over load and over the capacitor with the measured points (.svg), or a page with zoom (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

const VALIDATION: [Column<'_>; 7] = [
    ("source", "source", Digits::Word),
    ("quantity", "quantity", Digits::Word),
    ("start", "start", Digits::Word),
    ("measured", "measured", Digits::Six),
    ("ours", "ours", Digits::Six),
    ("off %", "relative_difference", Digits::Fixed(100.0, 1)),
    ("fitted", "fitted", Digits::Choice(["no", "yes"])),
];

/// Prints each published figure beside that of the model.
pub(super) fn run_validation(arguments: &ValidationArguments) -> Result<(), Failure> {
    let outputs = Outputs::of_shipped(validation::SCENES);
    outputs.check_picture("--picture", &arguments.picture)?;
    if let Some(file) = &arguments.picture {
        outputs.keep(file, validation::picture()?.of_file(file)?);
    }
    let rows = Rows::of(&validation::figures()?);
    print(&rows.text(arguments.format, |rows| rows.table(presets::NOTHING, &VALIDATION, 3)))?;
    outputs.ended()
}
