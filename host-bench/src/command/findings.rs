//! `findings`: what the two papers find, measured on the shipped scenes.

use serde_json::{Value, json};

use super::{json_text, print, progress};
use crate::findings::{self, Check, Finding, Mark, Row, wanted};
use crate::method::Failure;
use crate::outcome::{Format, csv};

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: half a minute on two cores")]
pub struct FindingsArguments {
    /// Numbers of the findings to measure, such as 8,9 [default: all]
    #[arg(long, value_delimiter = ',', value_name = "NUMBERS")]
    only: Vec<String>,
    /// Leave out the runs from displaced starts, which seek other motions at the points from which numbers are taken
    #[arg(long)]
    single_start: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Measures the findings on all cores and prints them.
///
/// # Errors
/// An unknown number, a scene that is refused, or a finding whose mark is not the expected one.
pub fn run(arguments: &FindingsArguments) -> Result<(), Failure> {
    let bar = progress(wanted(&arguments.only)?.len());
    let rows = findings::measure(&arguments.only, arguments.single_start, &|count| bar.inc(count as u64))?;
    bar.finish_and_clear();
    print(&match arguments.format {
        Format::Table => text(&rows),
        Format::Json => json_text(&rows.iter().map(object).collect::<Vec<_>>())?,
        Format::Csv => csv_text(&rows),
    })?;
    let other: Vec<&str> =
        rows.iter().filter(|row| !row.is_as_expected()).map(|row| row.finding.number).collect();
    if other.is_empty() {
        return Ok(());
    }
    Err(Failure::Step(format!("findings: the mark is not the expected one: {}", other.join(", "))))
}

/// Width of the columns of quantity and measured values.
const QUANTITY: usize = 62;
const MEASURED: usize = 36;

/// The rows for people: number, statement and mark, then a line for each quantity with its values and what is asserted.
pub fn text(rows: &[Row]) -> String {
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
    let mut text = format!("{:>3}  {mark}{expected}: {}\n", finding.number, finding.statement);
    text += &format!("     {}; {}\n", finding.source, finding.scene);
    if !finding.note.is_empty() {
        text += &format!("     {}\n", finding.note);
    }
    for check in &row.checks {
        let (quantity, shown, assertion) = (&check.quantity, check.shown(), check.assertion());
        let line = format!("     {quantity:<QUANTITY$}  {shown:<MEASURED$}  {assertion}");
        text += line.trim_end();
        text += "\n";
    }
    text
}

/// A row as an object of JSON.
fn object(row: &Row) -> Value {
    let check = |check: &Check| {
        json!({
            "quantity": check.quantity,
            "assertion": check.assertion(),
            "values": check.values,
            "holds": check.holds(),
        })
    };
    let Finding { number, source, statement, scene, mark, note } = row.finding;
    json!({
        "number": number,
        "source": source,
        "statement": statement,
        "scene": scene,
        "mark": row.mark(),
        "expected": mark,
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
            ]
        })
    });
    csv("number,statement,scene,quantity,assertion,values,mark", lines)
}
