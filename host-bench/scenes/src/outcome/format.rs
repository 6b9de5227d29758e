//! An outcome as text: a table for people, JSON and CSV for programs.

use std::collections::BTreeSet;
use std::iter::once;

use clap::ValueEnum;
use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, Row, Table, TableStyle, Width};
use serde::Serialize;
use serde_json::{Map, Value};

use super::{Outcome, Recording};

/// How to print a result. The texts are those of `--help`, for all commands: a run is an object and a row, a command with
/// several results has an array or an object of arrays, and a row of CSV for each of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// Text for people.
    #[default]
    Table,
    /// One JSON value.
    Json,
    /// A heading, and a row for each result.
    Csv,
}

impl Outcome {
    /// The outcome as text, line break at its end included.
    pub fn text(&self, format: Format) -> String {
        text(self, format)
    }
}

/// Names and values in the order of JSON.
pub type Fields = Map<String, Value>;

/// Names and values of a struct or a map, none of anything else.
pub fn fields(of: &impl Serialize) -> Fields {
    match serde_json::to_value(of) {
        Ok(Value::Object(fields)) => fields,
        _ => Fields::new(),
    }
}

/// Names and values as text, line break at its end included.
pub fn text(of: &impl Serialize, format: Format) -> String {
    let fields = fields(of);
    match format {
        Format::Json => format!("{:#}\n", Value::Object(fields)),
        Format::Csv => {
            let fields = flattened(fields);
            rows_csv(fields.keys(), std::slice::from_ref(&fields))
        }
        Format::Table => {
            let fields = flattened(fields);
            let width = fields.keys().map(String::len).max().unwrap_or(0);
            let line = |(name, value): (&String, &Value)| {
                folded(&format!("{name:<width$}  {}", shown(value)), width + 2) + "\n"
            };
            fields.iter().map(line).collect()
        }
    }
}

/// The fields with those of a nested object in its place, as `object_field`; those of an object with a name, in a list, as
/// `list_name_field`.
pub fn flattened(all: Fields) -> Fields {
    let named = |prefix: &str, nested: Fields| -> Vec<(String, Value)> {
        nested.into_iter().map(|(field, value)| (format!("{prefix}_{field}"), value)).collect()
    };
    let of = |(name, value): (String, Value)| match value {
        Value::Object(nested) => named(&name, nested),
        Value::Array(items) if items.iter().any(|item| item.get("name").is_some()) => {
            let item = |item: Value| {
                let mut nested = fields(&item);
                let own = nested.remove("name").as_ref().map(cell).unwrap_or_default();
                named(&format!("{name}_{own}"), nested)
            };
            items.into_iter().flat_map(item).collect()
        }
        other => vec![(name, other)],
    };
    all.into_iter().flat_map(of).collect()
}

/// Some columns of rows as CSV; a cell is empty where its row has no such field.
pub fn rows_csv<'a>(columns: impl IntoIterator<Item = &'a String>, rows: &[Fields]) -> String {
    let columns: Vec<&String> = columns.into_iter().collect();
    let line =
        |row: &Fields| csv_line(columns.iter().map(|column| row.get(*column).map(cell).unwrap_or_default()));
    rows.iter().fold(csv_line(columns.iter().map(|&name| name.clone())), |text, row| text + &line(row))
}

/// Tables of CSV, each with its heading and its rows; a heading stands where the columns change.
pub fn csv_sections(sections: impl Iterator<Item = (String, String)>) -> String {
    let (mut text, mut last) = (String::new(), String::new());
    for (heading, rows) in sections {
        if heading != last {
            text.push_str(if text.is_empty() { "" } else { "\n" });
            text.push_str(&heading);
            last = heading;
        }
        text.push_str(&rows);
    }
    text
}

/// Most columns of a text for people.
pub const WIDTH: usize = 100;

/// A text in lines of at most [`WIDTH`] columns, broken at spaces, further ones behind `indent` spaces; a longer word has its own line.
pub fn folded(text: &str, indent: usize) -> String {
    wrapped(text.split(' '), " ", indent, WIDTH)
}

/// Parts with `joint` between them, in lines of at most `width` columns, the further ones behind `indent` spaces; a longer part
/// has a line of its own. Spaces at the end of a part may reach beyond.
fn wrapped<'a>(parts: impl Iterator<Item = &'a str>, joint: &str, indent: usize, width: usize) -> String {
    let (mut all, mut column) = (String::new(), 0);
    for (index, part) in parts.enumerate() {
        let joint = if index == 0 { "" } else { joint };
        if column > indent && column + joint.len() + part.trim_end().chars().count() > width {
            all += &format!("\n{:indent$}", "");
            column = indent;
        } else {
            all += joint;
            column += joint.len();
        }
        all += part;
        column += part.chars().count();
    }
    all
}

/// Least columns of a name that is broken where it has no room.
const LONG: usize = 20;
/// What a heading may be broken behind.
const BREAKS: [char; 5] = ['_', '-', '.', ' ', '/'];

/// The most columns of a part of some texts, which are broken behind such characters.
fn widest(texts: impl Iterator<Item = String>, breaks: &[char]) -> usize {
    let of_part = |part: &str| part.trim_end().chars().count();
    texts.filter_map(|text| text.split_inclusive(breaks).map(of_part).max()).max().unwrap_or(0)
}

/// A table for a terminal, line break included: the columns beyond the first `words` stand at the right. Where it would be wider
/// than [`WIDTH`], headings and words take several lines, and numbers one. Where that has no room either, what is the same in all
/// rows is said once, and the other columns follow in parts, each behind the words and what else tells rows apart.
pub fn table<R: Into<Row>>(
    style: TableStyle,
    headings: impl Into<Row>,
    rows: impl IntoIterator<Item = R>,
    words: usize,
) -> String {
    let cells = |row: Row| row.cell_iter().map(Cell::content).collect::<Vec<String>>();
    let headings = cells(headings.into());
    let rows: Vec<Vec<String>> = rows.into_iter().map(|row| cells(row.into())).collect();
    let of = |headings: &Vec<String>, columns: &[usize], words: usize| {
        let some = |row: &Vec<String>| columns.iter().map(|&at| row[at].clone()).collect::<Vec<_>>();
        let text = whole_table(style, some(headings), rows.iter().map(some), words);
        (text.lines().all(|line| line.chars().count() <= WIDTH), text)
    };
    if let (true, text) = of(&headings, &Vec::from_iter(0..headings.len()), words) {
        return text;
    }
    // Of headings that several columns have, each takes that of its group before it: the parts tear groups apart.
    let is_own = |at: &usize| headings.iter().filter(|other| **other == headings[*at]).count() == 1;
    let group = |at: usize| (0..at).rev().find(is_own).filter(|_| !is_own(&at));
    let whole = |(at, own): (usize, &String)| match group(at) {
        Some(group) => format!("{}: {own}", headings[group]),
        None => own.clone(),
    };
    let headings: Vec<String> = headings.iter().enumerate().map(whole).collect();
    let distinct = |keys: &[usize]| {
        let of_row = rows.iter().map(|row| keys.iter().map(|key| &row[*key]).collect::<Vec<_>>());
        of_row.collect::<BTreeSet<_>>().len()
    };
    let left = if words < headings.len() { words } else { 1 };
    let (mut same, mut keys, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    for (at, heading) in headings.iter().enumerate() {
        let more = [&keys[..], &[at]].concat();
        if rows.len() > 1 && distinct(&[at]) == 1 && !rows[0][at].is_empty() {
            same.push(format!("{heading} {}", rows[0][at]));
        } else if at < left || distinct(&more) > distinct(&keys) {
            keys = more;
        } else {
            rest.push(at);
        }
    }
    let words = if words < headings.len() { keys.partition_point(|key| *key < words) } else { words };
    let said = folded(&format!("In all rows: {}", same.join(", ")), 2) + "\n\n";
    let mut text = if same.is_empty() { String::new() } else { said };
    loop {
        let part = |count: usize| {
            let (fits, part) = of(&headings, &[&keys[..], &rest[..count]].concat(), words);
            (fits || count < 2).then_some((count, part))
        };
        let (count, part) = (0..=rest.len()).rev().find_map(part).unwrap_or_default();
        rest.drain(..count);
        text += &part;
        if rest.is_empty() {
            return text;
        }
        text.push('\n');
    }
}

/// A table with all columns beside each other.
fn whole_table(
    style: TableStyle,
    headings: impl Into<Row>,
    rows: impl Iterator<Item = Vec<String>>,
    words: usize,
) -> String {
    let mut table = Table::new();
    let headings: Row = headings.into();
    table.load_style(style).set_header(headings.clone()).add_rows(rows);
    if table.trim_fmt().lines().any(|line| line.chars().count() > WIDTH) {
        let width = |(column, heading): (usize, &Cell), breaks: &[char]| {
            let cells = table.row_iter().filter_map(|row| row.cell_iter().nth(column));
            widest(cells.map(Cell::content), breaks).max(widest(once(heading.content()), &BREAKS))
        };
        let widths = |breaks: &[char]| -> Vec<usize> {
            headings.cell_iter().enumerate().map(|heading| width(heading, breaks)).collect()
        };
        let (mut least, whole) = (widths(&[' ']), widths(&[]));
        let taken = |widths: &[usize]| widths.iter().map(|width| width + 3).sum::<usize>();
        // Names are not broken where numbers follow, unless they are long and the numbers leave no room.
        let keeps_names = words < whole.len() && (whole[0] <= 12 || taken(&whole) < WIDTH);
        let is_whole = |column: usize| column >= words || (column == 0 && keeps_names);
        for (column, least) in least.iter_mut().enumerate().filter(|(column, _)| is_whole(*column)) {
            *least = whole[column];
        }
        let broken = headings
            .cell_iter()
            .zip(&whole)
            .map(|(cell, width)| wrapped(cell.content().split_inclusive(BREAKS), "", 0, *width))
            .collect::<Vec<_>>();
        // Long names are broken where they have no room. A table whose words have none is wider: no word is broken.
        let all = taken(&least);
        if let Some(names) = least.first_mut().filter(|_| !is_whole(0)) {
            *names = LONG.max((WIDTH + *names).saturating_sub(all + 2)).min(*names);
        }
        let width = taken(&least).max(WIDTH);
        table.set_header(broken).set_content_arrangement(ContentArrangement::Dynamic).set_width(width as u16);
        for (column, least) in table.column_iter_mut().zip(least) {
            let width = Width::Fixed((least + usize::from(column.padding_width())) as u16);
            column.set_constraint(ColumnConstraint::LowerBoundary(width));
        }
    }
    for column in table.column_iter_mut().skip(words) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

/// The name that the command line has for a value.
pub fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl Recording {
    /// The rows as CSV, heading first.
    pub fn csv(&self) -> String {
        csv(&self.columns.join(","), self.rows.iter().map(|row| row.iter().copied().map(number)))
    }
}

/// A number that reads back to the same bits; empty if it is not finite.
pub fn number(value: f64) -> String {
    serde_json::Number::from_f64(value).map_or_else(String::new, |number| number.to_string())
}

/// A [`number`], empty for none.
pub fn optional_number(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

/// A number in two digits, a dash for none.
pub fn small(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1e}"))
}

/// Rows of CSV below a heading.
pub fn csv<R: IntoIterator<Item = String>>(heading: &str, rows: impl IntoIterator<Item = R>) -> String {
    rows.into_iter().fold(format!("{heading}\n"), |text, row| text + &csv_line(row))
}

/// A line of CSV, line break included. A cell with a comma, a quotation mark or a line break is quoted. A text that a
/// spreadsheet would take for a formula has an apostrophe before it.
pub fn csv_line(cells: impl IntoIterator<Item = String>) -> String {
    let is_number = |cell: &str| cell.split(' ').all(|part| part.parse::<f64>().is_ok());
    let quoted = |cell: String| {
        let is_formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && !is_number(&cell);
        let cell = if is_formula { format!("'{cell}") } else { cell };
        if cell.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell
        }
    };
    cells.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// A value as a cell of a CSV file, an empty one for `null`.
pub fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        // A list, such as the natural frequencies or the warnings, is one cell. No warning has a vertical bar.
        Value::Array(items) if !items.iter().any(Value::is_object) => {
            let between = if items.iter().any(Value::is_string) { " | " } else { " " };
            items.iter().map(cell).collect::<Vec<_>>().join(between)
        }
        // A list of objects stays JSON.
        other => other.to_string(),
    }
}

/// A value for people: six digits.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::Number(number) if number.is_f64() => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            let plain = (1e-3..1e6).contains(&value.abs()) || value == 0.0;
            let rounded = || format!("{value:.6}").parse::<f64>().unwrap_or(value);
            if plain { rounded().to_string() } else { format!("{value:.5e}") }
        }
        Value::Array(items) => {
            let is_long = items.iter().filter_map(Value::as_str).any(|text| text.contains([',', ';']));
            items.iter().map(shown).collect::<Vec<_>>().join(if is_long { " | " } else { ", " })
        }
        Value::Object(fields) => {
            let parts = fields.iter().map(|(name, value)| format!("{name} {}", shown(value)));
            parts.collect::<Vec<_>>().join(" ")
        }
        other => cell(other),
    }
}

#[cfg(test)]
mod tests {
    use comfy_table::presets;

    use super::*;

    #[test]
    fn a_wide_table_breaks_no_word_where_there_is_room() {
        let headings =
            ["quantity", "contact-separation f32", "contact-separation f64", "sliding f32", "bump-stop f64"];
        let rows = [
            ["statement over error, 90th percentile", "163 / 169", "162 / 163", "30 / 31", "90 / 94"],
            ["warned, of them below a tenth", "16 / 169", "16 / 163", "3 / 31", "9 / 94"],
        ];
        for (names, style) in
            [(0, presets::ASCII_MARKDOWN), (1, presets::ASCII_MARKDOWN), (1, presets::NOTHING)]
        {
            let wide = rows.map(|row| [&row[..], &row[1..3]].concat());
            let heading = [&headings[..], &headings[1..3]].concat();
            let text = table(style, heading, wide, names);
            let words = |texts: &mut dyn Iterator<Item = &str>| -> Vec<String> {
                let parts = texts.flat_map(|text| text.split(|letter: char| !letter.is_alphanumeric()));
                parts.filter(|part| !part.is_empty()).map(str::to_owned).collect()
            };
            let whole = words(&mut headings.into_iter().chain(rows.iter().flatten().copied()));
            let found = words(&mut text.lines());
            let broken: Vec<&String> = found.iter().filter(|word| !whole.contains(word)).collect();
            assert!(broken.is_empty(), "{broken:?} in\n{text}");
        }
        // Columns that have no room follow below, behind what tells rows apart; what all rows have is said once.
        let many: Vec<String> = (10..40).map(|column| format!("column_{column}")).collect();
        let row = |key: &str| {
            let own = ["a", "x", key].map(str::to_owned);
            own.into_iter().chain((13..40).map(|column| format!("{column}_{key}"))).collect::<Vec<String>>()
        };
        let text = table(presets::NOTHING, many.clone(), ["1", "2"].map(row), 1);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!((13..40).all(|column| text.contains(&format!("{column}_2"))), "{text}");
        let starts = ["In all rows: column_10 a, column_11 x", "1 ", "2 "];
        let found =
            starts.map(|start| text.lines().filter(|line| line.trim_start().starts_with(start)).count());
        assert_eq!(found, [1, 3, 3], "{text}");
        // Columns of the same heading are told apart by that of their group.
        let groups =
            ["at 1e-2", "at 1e-3"].map(|group| ["scene", group, "best peer", "x"].map(str::to_owned));
        let headings: Vec<String> = groups.concat().into_iter().chain(many).collect();
        let row = |key: &str| {
            let own = ["a", key, "CVODE", key, "a", key, "SDIRK", key].map(str::to_owned);
            own.into_iter().chain((10..40).map(|column| format!("{column}_{key}"))).collect::<Vec<String>>()
        };
        let text = table(presets::NOTHING, headings, ["1", "2"].map(row), 1);
        assert!(
            text.contains("at 1e-2: best peer CVODE, ") && text.contains("at 1e-3: best peer SDIRK"),
            "{text}"
        );
    }
}
