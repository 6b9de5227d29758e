//! A recorded acceleration in a CSV file.

use std::path::Path;

use super::bounds::{self, Bound};
use super::document::SceneError;
use super::section::Section;

/// Which column holds the samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Column {
    /// By its name in the first row.
    Name(String),
    /// By its number, from 1; a first row that is not a number there is a heading.
    Number(usize),
}

/// Why a trace was refused, and the key to blame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TraceFault {
    pub(super) key: &'static str,
    pub(super) text: String,
}

impl Column {
    /// Reads the key `column`.
    pub(super) fn read(section: &mut Section<'_>) -> Result<Self, SceneError> {
        const WANTED: &str = "the name of a column, or its number from 1";
        if let Some(name) = section.text("column") {
            return Ok(Self::Name(name.to_owned()));
        }
        let absent = if section.has("column") { "" } else { "is missing; " };
        let number = section.optional_number("column", &Bound::new(1.0, 10_000.0));
        match number {
            Ok(Some(number)) if number.fract() == 0.0 => Ok(Self::Number(number as usize)),
            _ => Err(section.refuse("column", format!("{absent}must be {WANTED}"))),
        }
    }
}

/// The samples of one column in m/s².
pub(super) fn samples(path: &Path, column: &Column, scale: f64) -> Result<Vec<f64>, TraceFault> {
    let fault = |key, text: String| TraceFault { key, text };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| fault("path", one_line(&error)))?;
    let bound = bounds::of("amplitude_m_per_s2").highest;
    let mut wanted = match column {
        Column::Number(number) => Some(number - 1),
        Column::Name(_) => None,
    };
    let mut samples = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| fault("path", one_line(&error)))?;
        let line = record.position().map_or(0, csv::Position::line);
        let index = match (wanted, column) {
            (Some(index), _) => index,
            (None, Column::Number(number)) => number - 1,
            (None, Column::Name(name)) => {
                let found = record.iter().position(|cell| cell.trim_start_matches('\u{feff}') == name);
                wanted = found;
                if found.is_none() {
                    let heads: Vec<&str> = record.iter().take(20).collect();
                    return Err(fault("column", format!("line {line}: no such column in {heads:?}")));
                }
                continue;
            }
        };
        let Some(cell) = record.get(index) else {
            let columns = record.len();
            return Err(fault("column", format!("line {line}: there are {columns} columns")));
        };
        match cell.trim_start_matches('\u{feff}').parse::<f64>() {
            Ok(value) if (value * scale).abs() <= bound => samples.push(value * scale),
            Ok(value) => {
                let text = format!("line {line}: {value} times scale_m_per_s2 must be within {bound:e} m/s2");
                return Err(fault("path", text));
            }
            // A heading.
            Err(_) if row == 0 => {}
            Err(_) => return Err(fault("path", format!("line {line}: {cell:?} is not a number"))),
        }
    }
    if samples.len() < 2 {
        return Err(fault("path", format!("has {} samples, must have at least 2", samples.len())));
    }
    Ok(samples)
}

/// Messages of the CSV reader have no line breaks, but name the file's content.
fn one_line(error: &csv::Error) -> String {
    error.to_string().replace(['\n', '\r'], " ")
}
