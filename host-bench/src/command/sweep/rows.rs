//! The points of a command as they are done: one that was interrupted goes on from them.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::command::rows::{self, Kind, Parts};
use crate::method::Failure;
use crate::outcome::Fields;

/// The file beside the table of a command, one JSON object a line, then its checksum. It is removed when the table is whole.
pub(super) fn file_of(command: &str) -> String {
    format!("{command}.rows.jsonl")
}

/// The points that are done, in a file.
pub(super) struct Rows {
    file: rows::Rows,
    known: BTreeMap<usize, Result<Fields, String>>,
}

impl Rows {
    /// Opens the file in this folder, or makes it. `identity` says of which points it is; others are refused.
    pub(super) fn open(
        folder: &Path,
        command: &str,
        identity: &str,
        parts: (Parts, usize),
    ) -> Result<Self, Failure> {
        let kind = Kind {
            option: "--output",
            heading: &json!({ command: identity }).to_string(),
            other: &format!(
                "has the points of another {command}, or of another build; remove it, or give another folder"
            ),
        };
        let (file, known) = rows::Rows::open(&folder.join(file_of(command)), parts, kind, point, |_| Ok(()))?;
        Ok(Self { file, known })
    }

    pub(super) fn count(&self) -> usize {
        self.known.len()
    }

    /// A point that was done before.
    pub(super) fn known(&self, number: usize) -> Option<Result<Fields, String>> {
        self.known.get(&number).cloned()
    }

    /// Writes a point that is done.
    pub(super) fn add(&self, number: usize, found: &Result<Fields, String>) -> Result<(), Failure> {
        self.file.append([line(number, found)])
    }

    /// Removes the file: the table is whole.
    pub(super) fn remove(self) {
        self.file.remove();
    }
}

fn line(number: usize, found: &Result<Fields, String>) -> String {
    let point = match found {
        Ok(fields) => json!({ "point": number, "fields": exact(Value::Object(fields.clone())) }),
        Err(error) => json!({ "point": number, "error": error }),
    };
    point.to_string()
}

/// The point of a line; `None` if the line is none, or has no fields.
fn point(line: &str) -> Option<(usize, Result<Fields, String>)> {
    let value: Value = serde_json::from_str(line).ok()?;
    let number = usize::try_from(value.get("point")?.as_u64()?).ok()?;
    if let Some(error) = value.get("error") {
        return Some((number, Err(error.as_str()?.to_owned())));
    }
    match restored(value.get("fields")?.clone()) {
        Value::Object(fields) if !fields.is_empty() => Some((number, Ok(fields))),
        _ => None,
    }
}

/// Before the bits of a number, in a text.
const BITS: &str = "bits:";

/// The value with its numbers that are no integers as texts of their bits: a number in decimals may be read as its neighbour.
fn exact(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => {
            let bits = number.as_f64().map(|value| format!("{BITS}{:016x}", value.to_bits()));
            bits.map_or(Value::Null, Value::String)
        }
        Value::Array(items) => items.into_iter().map(exact).collect(),
        Value::Object(fields) => {
            Value::Object(fields.into_iter().map(|(name, value)| (name, exact(value))).collect())
        }
        other => other,
    }
}

/// The inverse of [`exact`].
fn restored(value: Value) -> Value {
    match value {
        Value::String(text) => {
            let bits = text.strip_prefix(BITS).and_then(|digits| u64::from_str_radix(digits, 16).ok());
            bits.map_or(Value::String(text), |bits| f64::from_bits(bits).into())
        }
        Value::Array(items) => items.into_iter().map(restored).collect(),
        Value::Object(fields) => {
            Value::Object(fields.into_iter().map(|(name, value)| (name, restored(value))).collect())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_read_as_it_was_written() {
        let fields = json!({
            "power": 1.174_870_123_456_789e-5, "count": 3, "whole": 2.0, "none": null, "name": "bits of text",
            "nested": { "error": 0.1 + 0.2 }, "list": ["a", 1e-300],
        });
        let Value::Object(fields) = fields else { panic!("an object") };
        for found in [Ok(fields), Err("stopped at 1 s".to_owned())] {
            assert_eq!(point(&line(7, &found)), Some((7, found)));
        }
        for text in ["{\"point\": 3, \"fie", "{\"point\": 3, \"fields\": {}}"] {
            assert_eq!(point(text), None, "{text}");
        }
    }
}
