//! Rows of results: one description of the columns gives the table for people, JSON and CSV.

use comfy_table::TableStyle;
use serde::Serialize;
use serde_json::{Value, json};

use crate::outcome::{Fields, Format, fields, flattened, rows_csv, shown, table};

/// How a value is shown to people. A value that is not there is a dash.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Digits {
    /// A number with six digits, and a word as it is.
    Six,
    /// With an exponent, and so many digits behind the point.
    Exponent(usize),
    /// Times a factor, with so many digits behind the point.
    Fixed(f64, usize),
    /// By a function.
    By(fn(f64) -> String),
    /// One of two words.
    Choice([&'static str; 2]),
    /// A word; nothing where it is not there.
    Word,
}

impl Digits {
    fn shown(self, value: Option<&Value>) -> String {
        let value = value.unwrap_or(&Value::Null);
        match (self, value.as_f64()) {
            (Self::Exponent(digits), Some(number)) => format!("{number:.digits$e}"),
            (Self::Fixed(factor, digits), Some(number)) => {
                let text = format!("{:.digits$}", factor * number);
                // No sign of a number that rounds to nothing.
                if text.trim_matches(['-', '0', '.']).is_empty() { format!("{:.digits$}", 0.0) } else { text }
            }
            (Self::By(text), Some(number)) => text(number),
            (Self::Choice([no, yes]), _) => (if value == true { yes } else { no }).to_owned(),
            (Self::Word, _) if value.is_null() => String::new(),
            _ => shown(value),
        }
    }
}

/// A column of the table: its heading, the name of its value in JSON and CSV, and its digits.
pub(crate) type Column<'a> = (&'a str, &'a str, Digits);

pub(crate) fn headings<'a>(columns: &[Column<'a>]) -> Vec<&'a str> {
    columns.iter().map(|(heading, ..)| *heading).collect()
}

/// Rows with names and values in the order of JSON.
#[derive(Debug, Clone)]
pub(crate) struct Rows(pub(crate) Vec<Fields>);

impl Rows {
    pub(crate) fn of<'a, T: Serialize + 'a>(rows: impl IntoIterator<Item = &'a T>) -> Self {
        Self(rows.into_iter().map(|row| fields(row)).collect())
    }

    /// The cells of each row for people.
    pub(crate) fn cells(&self, columns: &[Column<'_>]) -> impl Iterator<Item = Vec<String>> {
        self.0.iter().cloned().map(flattened).map(|row| {
            let cell = |(_, key, digits): &Column<'_>| digits.shown(row.get(*key));
            columns.iter().map(cell).collect()
        })
    }

    /// The table for people, of which the first `words` columns stand at the left.
    pub(crate) fn table(&self, style: TableStyle, columns: &[Column<'_>], words: usize) -> String {
        table(style, headings(columns), self.cells(columns), words)
    }

    /// The names of the first row's values as columns.
    pub(crate) fn plain(&self) -> Vec<Column<'_>> {
        let names = self.0.iter().take(1).flat_map(Fields::keys);
        names.map(|name| (name.as_str(), name.as_str(), Digits::Six)).collect()
    }

    /// As CSV, with the columns of the first row.
    pub(crate) fn csv(&self) -> String {
        let flat: Vec<Fields> = self.0.iter().cloned().map(flattened).collect();
        rows_csv(flat.iter().take(1).flat_map(Fields::keys), &flat)
    }

    /// In a format, line break included; `table` makes the table.
    pub(crate) fn text(&self, format: Format, table: impl FnOnce(&Self) -> String) -> String {
        match format {
            Format::Json => format!("{:#}\n", json!(self.0)),
            Format::Csv => self.csv(),
            Format::Table => table(self),
        }
    }
}
