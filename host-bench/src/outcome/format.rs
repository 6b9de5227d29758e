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
            // An outcome is a plain struct: it always becomes an object.
            _ => Vec::new(),
        }
    }

    /// The whole text, line break at its end included.
    #[must_use]
    pub fn text(&self, format: Format) -> String {
        text(self.fields(), format)
    }
}

/// Names and values as text, line break at its end included.
#[must_use]
pub fn text(fields: Vec<(String, Value)>, format: Format) -> String {
    match format {
        Format::Json => {
            let object: serde_json::Map<_, _> = fields.into_iter().collect();
            format!("{:#}\n", Value::Object(object))
        }
        Format::Csv => {
            let names: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
            let values: Vec<String> = fields.iter().map(|(_, value)| cell(value)).collect();
            format!("{}\n{}\n", names.join(","), values.join(","))
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
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(|value| number(*value)).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}

/// A number that reads back to the same bits; nothing if it is not finite.
#[must_use]
pub fn number(value: f64) -> String {
    serde_json::Number::from_f64(value).map_or_else(String::new, |number| number.to_string())
}

/// A value as a cell of a CSV file; `null` is an empty one.
#[must_use]
pub fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        // A list (natural frequencies) stays in one cell.
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
