//! Templates of scene files: the values of a shipped scene, each key with what it may be.

use super::document::{Content, Document, Node};
use super::key::{Default, Key, Kind, Table, Value};
use super::{KEYS, shipped, shipped_text};

/// The names of the templates, each with the values of a scene of this name; of `contact-separation` the passive one.
pub const TEMPLATES: [&str; 8] = [
    "contact-separation",
    "contact-separation-truck",
    "sliding",
    "bump-stop",
    "bump-stop-none",
    "bump-stop-tip-mass",
    "rectified",
    "node",
];

/// A template: every key with unit, bounds and meaning; those that may be left out and have no value are comments. `None`
/// if there is none of this name.
pub fn template(name: &str) -> Option<String> {
    let name = *TEMPLATES.iter().find(|known| **known == name)?;
    let file = shipped(if name == "contact-separation" { "contact-separation-passive" } else { name });
    let document = Document::parse(&file, shipped_text(&file)?).ok()?;
    let mut lines = Lines(Vec::new());
    lines.0.extend(
        [
            "#:schema scene.schema.json",
            "# Units are SI. Behind each value: unit, bounds, meaning. A line of \"# \" and a key is optional.",
            "# Editors complete the keys by the schema: host-bench keys --format schema > scene.schema.json",
            "",
        ]
        .map(str::to_owned),
    );
    lines.table(&KEYS, Some(&document.content), "", false);
    Some(lines.0.join("\n") + "\n")
}

struct Lines(Vec<String>);

impl Lines {
    /// The keys of a table, then the tables in it; `absent`: all of them are comments.
    fn table(&mut self, table: &'static Table, content: Option<&Content>, path: &str, absent: bool) {
        let entries: &[(String, Node)] = match content {
            Some(Content::Table(entries)) => entries,
            _ => &[],
        };
        let given = |name: &str| entries.iter().find(|(key, _)| key == name).map(|(_, node)| &node.content);
        let kind = given(table.selector).and_then(Content::text).and_then(|word| table.kind(word));
        if !table.kinds.is_empty() {
            self.selector(table, kind, absent);
        }
        let keys = || kind.map_or(&[][..], |kind: &Kind| kind.keys).iter().chain(table.keys);
        for key in keys().filter(|key| key.table().is_none()) {
            self.value(key, given(key.name), absent);
        }
        for key in keys().filter(|key| key.table().is_some()) {
            let path = if path.is_empty() { key.name.to_owned() } else { format!("{path}.{}", key.name) };
            self.inner(key, given(key.name), &path, absent);
        }
    }

    fn selector(&mut self, table: &Table, kind: Option<&Kind>, absent: bool) {
        let others: Vec<String> = table
            .kinds
            .iter()
            .filter(|other| kind.is_none_or(|kind| kind.word != other.word))
            .map(|other| format!("{:?}", other.word))
            .collect();
        let value = kind.map_or(String::new(), |kind| format!("{:?}", kind.word));
        let comment = match kind {
            Some(kind) => format!("{}; or with other keys {}", kind.meaning, others.join(", ")),
            None => others.join(", "),
        };
        self.line(table.selector, &value, &comment, absent || kind.is_none());
    }

    fn value(&mut self, key: &Key, given: Option<&Content>, absent: bool) {
        let value = match (given, key.default) {
            (Some(content), _) => written(content),
            (None, Default::Number(number)) => number.to_string(),
            (None, Default::Flag(flag)) => flag.to_string(),
            (None, _) => String::new(),
        };
        let unit = if key.unit.is_empty() { String::new() } else { format!("{}, ", key.unit) };
        let default = match (key.instead_of, key.default) {
            (Some(other), _) if given.is_none() => format!("; instead of {other}"),
            (_, Default::Said(text)) => format!("; default: {text}"),
            (_, Default::Number(number)) => format!("; default: {number}"),
            (_, Default::Flag(flag)) => format!("; default: {flag}"),
            _ => String::new(),
        };
        let comment = format!("{unit}{}: {}{default}", key.bounds(), key.meaning);
        self.line(key.name, &value, &comment, absent || given.is_none());
    }

    fn line(&mut self, key: &str, value: &str, comment: &str, absent: bool) {
        let sign = if absent { "# " } else { "" };
        let line = format!("{sign}{key} = {value}");
        self.0.push(format!("{line:<40}  # {}", comment.replace('`', "")));
    }

    fn inner(&mut self, key: &Key, given: Option<&Content>, path: &str, absent: bool) {
        let Some(table) = key.table() else { return };
        let items: Vec<Option<&Content>> = match given {
            Some(Content::List(items)) => items.iter().map(|item| Some(&item.content)).collect(),
            other => vec![other],
        };
        let header = match key.value {
            Value::Tables(_) => format!("[[{path}]]"),
            _ => format!("[{path}]"),
        };
        for content in items {
            let absent = absent || content.is_none();
            let sign = if absent { "# " } else { "" };
            let header = format!("{sign}{header}");
            self.0.push(String::new());
            self.0.push(format!("{header:<40}  # {}", key.meaning));
            self.table(table, content, path, absent);
        }
    }
}

fn written(content: &Content) -> String {
    match content {
        Content::Number(_, text) | Content::Date(text) => text.clone(),
        Content::Text(text) => format!("{text:?}"),
        Content::Boolean(value) => value.to_string(),
        Content::List(items) => {
            let items: Vec<String> = items.iter().map(|item| written(&item.content)).collect();
            format!("[{}]", items.join(", "))
        }
        // Tables have lines of their own.
        Content::Table(_) => String::new(),
    }
}
