//! The keys of scene files as rows of text.

use model_core::bounds::Bounds;

use crate::scene_file::KEYS;
use crate::scene_file::Short;
use crate::scene_file::key::{Default, Key, Kind, Table, Value};

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
#[must_use]
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
    let values = keys.iter().filter(|key| inner(key).is_none());
    let tables = keys.iter().filter(|key| inner(key).is_some());
    for key in values {
        rows.push(row(key, scene, kind, path));
    }
    for key in tables {
        rows.push(row(key, scene, kind, path));
        let Some(of) = inner(key) else { continue };
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

fn inner(key: &Key) -> Option<&'static Table> {
    match key.value {
        Value::Table(table) | Value::Tables(table) => Some(table),
        _ => None,
    }
}

fn row(key: &'static Key, scene: Option<&'static str>, kind: Option<&'static Kind>, path: &str) -> Row {
    let range = match key.value {
        Value::Number(range)
        | Value::NumberOrLimits(range)
        | Value::Whole(range)
        | Value::Numbers(range, _)
        | Value::Points(range, _) => Some(range),
        _ => None,
    };
    let finite = |bound: f64| Some(bound).filter(|bound| bound.is_finite());
    Row {
        scene,
        table: path.to_owned(),
        kind: kind.map(|kind| kind.word),
        key: key.name,
        unit: key.unit,
        lowest: range.and_then(|range| finite(range.lowest)),
        highest: range.and_then(|range| finite(range.highest)),
        bounds: bounds(key),
        default: default(key),
        meaning: key.meaning,
        is_table: inner(key).is_some(),
    }
}

/// What the value of a key may be.
pub(crate) fn bounds(key: &Key) -> String {
    let value = match key.value {
        Value::Number(range) => span(range),
        Value::NumberOrLimits(range) => format!("0, `inf`, or {}", span(range)),
        Value::Whole(range) => format!("a whole number from {} to {}", range.lowest, range.highest),
        Value::Among(numbers) => {
            let all: Vec<String> = numbers.iter().map(usize::to_string).collect();
            all.join(", ")
        }
        Value::Numbers(range, each) => format!("a list, one for each {each}, each {}", span(range)),
        Value::Points(range, most) => {
            format!("a list of 2 to {most} points `[Hz, density]`, densities {}", span(range))
        }
        Value::Words(words) => quoted(words),
        Value::Part(words) => quoted(&words()),
        Value::Flag => "`true`, `false`".to_owned(),
        Value::Text => "a text".to_owned(),
        Value::Texts => "a list of texts".to_owned(),
        Value::FreeKeys => {
            "a list of `\"KEY\"` or `\"KEY=LOW:HIGH\"`, or a table with `true` or `[LOW, HIGH]` for each key"
                .to_owned()
        }
        Value::Column(range) => {
            format!("a name, or a whole number from {} to {}", range.lowest, range.highest)
        }
        Value::ColumnOrFalse(range) => {
            format!("a name, a whole number from {} to {}, or `false`", range.lowest, range.highest)
        }
        Value::Table(_) => "a table".to_owned(),
        Value::Tables(_) => "a list of tables".to_owned(),
    };
    if key.limit.is_empty() { value } else { format!("{value}; {}", key.limit) }
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

fn span(range: Bounds<f64>) -> String {
    let Bounds { lowest, highest } = range;
    if highest.is_finite() {
        format!("{} to {}", Short(lowest), Short(highest))
    } else {
        format!("{} to `inf`", Short(lowest))
    }
}

fn quoted(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
    quoted.join(", ")
}
