//! The reports on standard output: tables with notes, or one JSON array of rows.

use clap::ValueEnum;
use comfy_table::presets;
use serde_json::Value;

use super::rows::{Column, Row};
use crate::outcome;

/// How to print a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum Format {
    /// Tables for people.
    #[default]
    Table,
    /// One JSON array with an object for each row.
    Json,
}

/// Prints tables at once; collects JSON rows until the end.
#[derive(Debug)]
pub(super) struct Output {
    format: Format,
    objects: Vec<Value>,
}

impl Output {
    pub(super) fn new(format: Format) -> Self {
        Self { format, objects: Vec::new() }
    }

    /// A table of measured rows, the first `text` columns to the left, and a note below it.
    pub(super) fn rows(&mut self, rows: &[Row], columns: &[Column], text: usize, note: &str) {
        let cells = |row: &Row| columns.iter().map(|(_, cell)| cell(row)).collect();
        let header = columns.iter().map(|(heading, _)| *heading).collect();
        self.table(header, rows.iter().map(cells).collect(), text, note);
        self.objects.extend(rows.iter().map(Row::json));
    }

    /// A table for people only.
    pub(super) fn table(&mut self, header: Vec<&str>, rows: Vec<Vec<String>>, text: usize, note: &str) {
        if self.format == Format::Json {
            return;
        }
        println!("{}{note}\n", outcome::table(presets::ASCII_MARKDOWN, header, rows, text));
    }

    /// A row of the JSON array.
    pub(super) fn object(&mut self, object: Value) {
        self.objects.push(object);
    }

    /// Prints the JSON array.
    pub(super) fn finish(self) {
        if self.format == Format::Json {
            println!("{:#}", Value::Array(self.objects));
        }
    }
}
