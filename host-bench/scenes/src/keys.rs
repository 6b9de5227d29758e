//! What the tables of the keys say, as text for people, as rows, and as a schema for editors.

mod page;
mod schema;

pub use self::page::text;
pub use self::schema::schema;

use crate::scene_file::KEYS;
use crate::scene_file::key::{Bound, Default, Key, Kind, Short, Table, Value, quoted};

/// The names of the scenes.
pub fn scenes() -> Vec<&'static str> {
    KEYS.kinds.iter().map(|kind| kind.word).collect()
}

/// A key, or the table that follows it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Row {
    /// The scene that has it; `None` for all.
    pub scene: Option<&'static str>,
    /// Path of its table; empty for the file as a whole.
    pub table: String,
    /// The kind of its table that has it; `None` for all.
    pub kind: Option<&'static str>,
    /// Its name.
    pub key: &'static str,
    /// Unit; empty where there is none.
    pub unit: &'static str,
    /// Least value of a number.
    pub lowest: Option<f64>,
    /// Largest value of a number.
    pub highest: Option<f64>,
    /// What its value may be, in words.
    pub bounds: String,
    /// What holds where it is not given, in words.
    pub default: String,
    /// One line.
    pub meaning: &'static str,
    /// Whether its value is a table or a list of tables, whose keys follow.
    #[serde(skip)]
    pub is_table: bool,
}

/// The keys of one scene, or of all.
pub fn rows(scene: Option<&str>) -> Vec<Row> {
    let mut rows = vec![selector(&KEYS, None, "")];
    for kind in KEYS.kinds.iter().filter(|kind| scene.is_none_or(|scene| scene == kind.word)) {
        table(kind.keys, Some(kind.word), None, "", &mut rows);
    }
    table(KEYS.keys, None, None, "", &mut rows);
    rows
}

/// The key that says the kind of a table.
fn selector(table: &Table, scene: Option<&'static str>, path: &str) -> Row {
    let words: Vec<&'static str> = table.kinds.iter().map(|kind| kind.word).collect();
    Row {
        scene,
        table: path.to_owned(),
        kind: None,
        key: table.selector,
        unit: "",
        lowest: None,
        highest: None,
        bounds: quoted(&words),
        default: "required".to_owned(),
        meaning: "Which of these the table describes",
        is_table: false,
    }
}

/// Rows of keys, each table among them followed by its own.
fn table(
    keys: &'static [Key],
    scene: Option<&'static str>,
    kind: Option<&'static Kind>,
    path: &str,
    rows: &mut Vec<Row>,
) {
    let values = keys.iter().filter(|key| key.table().is_none());
    let tables = keys.iter().filter(|key| key.table().is_some());
    for key in values {
        rows.push(row(key, scene, kind, path));
    }
    for key in tables {
        rows.push(row(key, scene, kind, path));
        let Some(of) = key.table() else { continue };
        let path = if path.is_empty() { key.name.to_owned() } else { format!("{path}.{}", key.name) };
        if !of.kinds.is_empty() {
            rows.push(selector(of, scene, &path));
        }
        // First the values of all kinds, so that the rows of a table are together.
        let mut nested = Vec::new();
        for (keys, kind) in of.kinds.iter().map(|kind| (kind.keys, Some(*kind))).chain([(of.keys, None)]) {
            let mut found = Vec::new();
            table(keys, scene, kind, &path, &mut found);
            let first = found.iter().position(|row| row.is_table).unwrap_or(found.len());
            nested.extend(found.split_off(first));
            rows.extend(found);
        }
        rows.extend(nested);
    }
}

fn row(key: &'static Key, scene: Option<&'static str>, kind: Option<&'static Kind>, path: &str) -> Row {
    let is_column = matches!(key.value, Value::Column(_) | Value::ColumnOrFalse(_));
    let range = Bound::of(key).range;
    let finite = |bound: f64| Some(bound).filter(|bound| bound.is_finite() && !is_column);
    Row {
        scene,
        table: path.to_owned(),
        kind: kind.map(|kind| kind.word),
        key: key.name,
        unit: key.unit,
        lowest: finite(range.lowest),
        highest: finite(range.highest),
        bounds: key.bounds(),
        default: default(key),
        meaning: key.meaning,
        is_table: key.table().is_some(),
    }
}

/// What holds where a key is not given.
fn default(key: &Key) -> String {
    let default = match key.default {
        Default::Required => "required".to_owned(),
        Default::Number(number) => Short(number).to_string(),
        Default::Flag(flag) => format!("`{flag}`"),
        Default::Said(text) => text.to_owned(),
    };
    match key.instead_of {
        Some(other) => format!("{default}; or `{other}`"),
        None => default,
    }
}

#[cfg(test)]
mod tests;
