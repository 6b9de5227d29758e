//! The scene file with the fitted values.

use std::path::Path;

use toml_edit::{DocumentMut, Item, Table, Value};

use crate::input::{self, MOST_OF_SCENE};
use crate::method::Failure;
use crate::scene_file::{Override, shipped_instead};

/// A number of a scene file, and what to say of it.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) value: f64,
    pub(crate) comment: String,
}

/// The text of a scene file with the values of some keys and their comments. All other lines stay as they are.
///
/// `overrides` are put in first. A recording that the scene reads is named from the root, if `moved` to another folder.
pub(crate) fn fitted_scene(
    file: &Path,
    overrides: &[Override],
    entries: &[Entry],
    moved: bool,
) -> Result<String, Failure> {
    let refuse = |reason: String| Failure::Input(format!("{}: {reason}", file.display()));
    let text = input::text(file, MOST_OF_SCENE)
        .or_else(|error| shipped_instead(file, error))
        .map_err(|error| refuse(format!("cannot be read: {error}")))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut document: DocumentMut = text.parse().map_err(|error| refuse(format!("is not TOML: {error}")))?;
    for change in overrides {
        let value: Value = change.value().parse().unwrap_or_else(|_| Value::from(change.value()));
        for other in change.alternatives() {
            remove(document.as_item_mut(), &other);
        }
        put(document.as_item_mut(), change.key(), value, None).map_err(&refuse)?;
    }
    for Entry { key, value, comment } in entries {
        let number = crate::outcome::number(*value).parse().unwrap_or(Value::from(*value));
        for other in Override::new(key, "0").alternatives() {
            remove(document.as_item_mut(), &other);
        }
        put(document.as_item_mut(), key, number, Some(comment)).map_err(&refuse)?;
    }
    if moved {
        let folder = file.parent().unwrap_or(Path::new(""));
        let folder = std::fs::canonicalize(if folder == Path::new("") { Path::new(".") } else { folder })
            .map_err(|error| refuse(error.to_string()))?;
        let rooted = |name: &str| folder.join(name).to_string_lossy().into_owned();
        if let Some(path) =
            document.get("excitation").and_then(|table| table.get("path")).and_then(Item::as_str)
        {
            let path = rooted(path);
            document["excitation"]["path"] = toml_edit::value(path);
        }
        if let Some(list) =
            document.get_mut("fit").and_then(|table| table.get_mut("data")).and_then(Item::as_array_mut)
        {
            for item in list.iter_mut() {
                if let Some(name) = item.as_str() {
                    *item = Value::from(rooted(name));
                }
            }
        }
    }
    Ok(document.to_string())
}

/// Puts a value at a key; a comment goes to the end of its line, before one that is there.
fn put(root: &mut Item, key: &str, value: Value, comment: Option<&str>) -> Result<(), String> {
    let no_table = || format!("{key}: leads to no table");
    let (tables, last) = key
        .rsplit_once('.')
        .map_or((Vec::new(), key), |(tables, last)| (tables.split('.').collect::<Vec<_>>(), last));
    // The innermost item that stands in lines of its own takes the comment.
    let mut depth_of_line = 0;
    let mut item = &mut *root;
    for (depth, part) in tables.iter().enumerate() {
        item = match part.parse::<usize>() {
            Ok(index) if item.is_array_of_tables() || item.is_array() => {
                item.get_mut(index).ok_or_else(no_table)?
            }
            _ => {
                let table = item.as_table_like_mut().ok_or_else(no_table)?;
                if !table.contains_key(part) {
                    table.insert(part, Item::Table(Table::new()));
                }
                table.get_mut(part).ok_or_else(no_table)?
            }
        };
        if item.is_table() || item.is_array_of_tables() {
            depth_of_line = depth + 1;
        }
    }
    let is_line = depth_of_line == tables.len();
    match last.parse::<usize>() {
        Ok(index) if item.is_array() => {
            let found = item.as_array_mut().and_then(|list| list.get_mut(index)).ok_or_else(no_table)?;
            replace(found, value);
        }
        _ => {
            let table = item.as_table_like_mut().ok_or_else(no_table)?;
            match table.get_mut(last).and_then(Item::as_value_mut) {
                Some(found) => replace(found, value),
                None => {
                    table.insert(last, Item::Value(value));
                }
            }
        }
    }
    let Some(comment) = comment else { return Ok(()) };
    let mut line = root;
    let parts: Vec<&str> = key.split('.').collect();
    let until = if is_line { parts.len() } else { depth_of_line + 1 };
    for part in &parts[..until.min(parts.len())] {
        line = match part.parse::<usize>() {
            Ok(index) if line.is_array_of_tables() => line.get_mut(index).ok_or_else(no_table)?,
            _ => line.get_mut(part).ok_or_else(no_table)?,
        };
    }
    if let Some(value) = line.as_value_mut() {
        let named = if is_line { comment.to_owned() } else { format!("{key}: {comment}") };
        let old = value.decor().suffix().and_then(|suffix| suffix.as_str()).unwrap_or("").trim().to_owned();
        let old = if old.is_empty() { old } else { format!("; {}", old.trim_start_matches('#').trim()) };
        value.decor_mut().set_suffix(format!("  # {named}{old}"));
    }
    Ok(())
}

/// Replaces a value and keeps what stands around it.
fn replace(found: &mut Value, value: Value) {
    let decor = found.decor().clone();
    *found = value;
    *found.decor_mut() = decor;
}

fn remove(root: &mut Item, key: &str) {
    let parts: Vec<&str> = key.split('.').collect();
    let Some((last, tables)) = parts.split_last() else { return };
    let mut item = root;
    for part in tables {
        let Some(inner) = item.get_mut(part) else { return };
        item = inner;
    }
    if let Some(table) = item.as_table_like_mut() {
        table.remove(last);
    }
}
