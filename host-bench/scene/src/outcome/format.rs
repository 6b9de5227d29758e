//! An outcome as text: a table for people, JSON and CSV for programs.

use serde_json::Value;

use super::{Outcome, Recording};

/// How to print an outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// Names and values in two columns.
    #[default]
    Table,
    /// One JSON object.
    Json,
    /// A heading and one row.
    Csv,
}

impl Outcome {
    /// Names and values in the order of the JSON object.
    #[must_use]
    pub fn fields(&self) -> Vec<(String, Value)> {
        match serde_json::to_value(self) {
            Ok(Value::Object(fields)) => fields.into_iter().collect(),
            // An outcome is a struct, which is always an object.
            _ => Vec::new(),
        }
    }

    /// The outcome as text, line break at its end included.
    #[must_use]
    pub fn text(&self, format: Format) -> String {
        text(self.fields(), format)
    }
}

/// Names and values as text, line break at its end included.
pub fn text(fields: Vec<(String, Value)>, format: Format) -> String {
    match format {
        Format::Json => {
            let object: serde_json::Map<_, _> = fields.into_iter().collect();
            format!("{:#}\n", Value::Object(object))
        }
        Format::Csv => {
            let (names, values): (Vec<String>, Vec<Value>) = fields.into_iter().unzip();
            csv_line(names) + &csv_line(values.iter().map(cell))
        }
        Format::Table => {
            let width = fields.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
            let line = |(name, value): &(String, Value)| format!("{name:<width$}  {}\n", shown(value));
            fields.iter().map(line).collect()
        }
    }
}

impl Recording {
    /// The rows as CSV, heading first.
    #[must_use]
    pub fn csv(&self) -> String {
        let heading = csv_line(self.columns.iter().map(|&name| name.to_owned()));
        heading + &self.rows.iter().map(|row| csv_line(row.iter().copied().map(number))).collect::<String>()
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

/// A line of CSV, line break included. A cell with a comma, a quotation mark or a line break is quoted.
pub fn csv_line(cells: impl IntoIterator<Item = String>) -> String {
    let quoted = |cell: String| {
        if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
    };
    cells.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// A value as a cell of a CSV file, an empty one for `null`.
pub fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        // A list, such as the natural frequencies, is one cell.
        Value::Array(items) => items.iter().map(cell).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

/// A value for people: six digits.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::Number(number) if number.is_f64() => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            let plain = (1e-3..1e6).contains(&value.abs()) || value == 0.0;
            if plain { short(&format!("{value:.6}")) } else { format!("{value:.5e}") }
        }
        Value::Array(items) => items.iter().map(shown).collect::<Vec<_>>().join(", "),
        other => cell(other),
    }
}

fn short(text: &str) -> String {
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
