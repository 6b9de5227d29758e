//! A TOML document as a tree that remembers the line of every value.

use std::collections::BTreeSet;
use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use strsim::damerau_levenshtein;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::KEYS;
use super::key::{Kind, Table, Value};
use crate::name::Name;

/// Table, old name and new name of the keys that version 0.2 renamed.
pub(super) const OLD_KEYS: [[&str; 3]; 1] = [["node", "listen", "burst"]];
/// Files with an old key that has been named.
static WARNED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// Longest value that a message repeats in full.
const SHOWN: usize = 60;

/// What is wrong with a scene, in one line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct SceneError {
    file: PathBuf,
    origin: Option<Origin>,
    key: Option<String>,
    value: Option<String>,
    reason: String,
}

impl SceneError {
    /// Something wrong with the file as a whole, or at one of its lines.
    pub(super) fn of_file(file: &Path, line: Option<usize>, reason: impl Into<String>) -> Self {
        let origin = line.map(Origin::Line);
        Self { file: file.to_owned(), origin, key: None, value: None, reason: reason.into() }
    }

    /// Something wrong with a key that is not there.
    pub(super) fn of_absent(file: &Path, key: &str, reason: impl Into<String>) -> Self {
        let key = Some(key.to_owned());
        Self { file: file.to_owned(), origin: None, key, value: None, reason: reason.into() }
    }

    /// The same without the value, which the user did not give.
    pub fn without_value(self) -> Self {
        Self { value: None, ..self }
    }

    pub(super) fn of_value(file: &Path, key: &str, node: &Node, reason: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            origin: Some(node.origin),
            key: Some(key.to_owned()),
            value: Some(node.content.to_string()),
            reason: reason.into(),
        }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = match self.origin {
            Some(Origin::Line(line)) => format!(":{line}: "),
            Some(Origin::Override(option)) => format!(": {option} "),
            None => ": ".to_owned(),
        };
        let value = self.value.as_ref().map(|value| format!(" = {value}")).unwrap_or_default();
        let key = self.key.as_ref().map(|key| format!("{key}{value}: ")).unwrap_or_default();
        // In one line, whatever stands in the names.
        let text = format!("{}{place}{key}{}", self.file.display(), self.reason);
        f.write_str(&Name::new(text).line())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// A line of the file, from 1.
    Line(usize),
    /// An override, by this option.
    Override(&'static str),
}

/// A value and where it was written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) content: Content,
    pub(super) origin: Origin,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content {
    /// A number, integer or not; not-a-number if it is too large for one. And as it was written.
    Number(f64, String),
    Text(String),
    Boolean(bool),
    Date(String),
    List(Vec<Node>),
    Table(Vec<(String, Node)>),
}

impl Content {
    pub(super) fn number(&self) -> Option<f64> {
        if let Self::Number(value, _) = self { Some(*value) } else { None }
    }

    pub(super) fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// The numbers of a list of two.
    pub(super) fn pair(&self) -> Option<[f64; 2]> {
        let Self::List(items) = self else { return None };
        let [first, second] = &items[..] else { return None };
        Some([first.content.number()?, second.content.number()?])
    }

    /// Multiplies each number by the factor of its key, which has a dot between its parts. The numbers of a list stay.
    pub(super) fn scale(&mut self, key: &str, factor: &dyn Fn(&str) -> f64) {
        match self {
            Self::Number(value, text) if factor(key) != 1.0 => {
                *value *= factor(key);
                *text = value.to_string();
            }
            Self::Table(entries) => entries.iter_mut().for_each(|(name, node)| {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                node.content.scale(&key, factor);
            }),
            _ => {}
        }
    }
}

#[cfg(test)]
impl Content {
    pub(super) fn as_json(&self) -> serde_json::Value {
        match self {
            Self::Number(value, _) => value.clamp(f64::MIN, f64::MAX).into(),
            Self::Text(text) | Self::Date(text) => text.as_str().into(),
            Self::Boolean(value) => (*value).into(),
            Self::List(items) => items.iter().map(|item| item.content.as_json()).collect(),
            Self::Table(entries) => {
                let entries = entries.iter().map(|(key, node)| (key.clone(), node.content.as_json()));
                serde_json::Value::Object(entries.collect())
            }
        }
    }
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(_, text) | Self::Date(text) => write!(f, "{}", shortened(text)),
            // Quoted, so that a line break in it does not break the line.
            Self::Text(text) => write!(f, "{:?}", shortened(text)),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::List(items) => write!(f, "[a list of {}]", items.len()),
            Self::Table(entries) => write!(f, "{{a table of {}}}", entries.len()),
        }
    }
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= SHOWN {
        return text.to_owned();
    }
    text.chars().take(SHOWN).chain("...".chars()).collect()
}

pub(super) struct Document {
    pub(super) file: PathBuf,
    /// The table at the top.
    pub(super) content: Content,
}

impl Document {
    /// Renames the keys of version 0.1 of a file, with a line on standard error when a file is read first.
    pub(super) fn rename_old_keys(&mut self) {
        for [table, old, new] in OLD_KEYS {
            let Content::Table(root) = &mut self.content else { return };
            let within = root.iter_mut().find(|(name, _)| name == table).map(|(_, node)| &mut node.content);
            let Some(Content::Table(entries)) = within else { continue };
            if !entries.iter().any(|(name, _)| name == new)
                && let Some((name, _)) = entries.iter_mut().find(|(name, _)| name == old)
            {
                new.clone_into(name);
                if WARNED.lock().is_ok_and(|mut warned| warned.insert(self.file.clone())) {
                    let file = Name::new(self.file.display().to_string()).line();
                    let text = format!("warning: {file}: {table}.{old} is now named {table}.{new}");
                    // Without a standard error nothing can be printed.
                    let _ = writeln!(std::io::stderr(), "{text}");
                }
            }
        }
    }

    /// The tree of a text; `file` is blamed.
    pub(super) fn parse(file: &Path, text: &str) -> Result<Self, SceneError> {
        let fault = |line, reason: String| SceneError::of_file(file, line, reason);
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let table = DeTable::parse(text).map_err(|error| {
            let line = error.span().map(|span| line_of(text, span.start));
            let reason = format!("is not TOML: {}", error.message().replace('\n', "; "));
            // The line has the key that the parser's message lacks.
            match line.and_then(|line| text.lines().nth(line - 1)) {
                Some(content) if !content.trim().is_empty() => {
                    fault(line, format!("{reason}, at {:?}", shortened(content.trim())))
                }
                _ => fault(line, reason),
            }
        })?;
        let breaks: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
        let origin = |start: usize| Origin::Line(breaks.partition_point(|at| *at < start) + 1);
        let content = Content::Table(convert_table(table.get_ref(), &origin));
        Ok(Self { file: file.to_owned(), content })
    }

    /// What a key leads to, with a dot between its parts and a number for an element of a list.
    pub(super) fn at(&self, key: &str) -> Option<&Node> {
        let mut content = &self.content;
        let mut found = None;
        for part in key.split('.') {
            let node = match content {
                Content::Table(entries) => &entries.iter().find(|(name, _)| name == part)?.1,
                Content::List(items) => items.get(part.parse::<usize>().ok()?)?,
                _ => return None,
            };
            (content, found) = (&node.content, Some(node));
        }
        found
    }

    /// The keys of the scene whose last part is `name`, or else the nearest to it, those of its kinds only.
    pub(super) fn paths_of(&self, name: &str) -> Vec<String> {
        let mut found = Vec::new();
        add_paths(&KEYS, Some(&self.content), "", &mut found);
        let meant = nearest(name, &found.iter().map(|(_, last)| *last).collect::<Vec<_>>());
        found.into_iter().filter(|(_, last)| meant == Some(*last)).map(|(path, _)| path).collect()
    }
}

pub(super) fn kind_of(table: &Table, content: &Content) -> Option<&'static Kind> {
    table.kind(entry(content, table.selector)?.text()?)
}

/// Adds the keys of a table and of those in it, each with its last part; `prefix` leads to the table.
fn add_paths(
    table: &'static Table,
    content: Option<&Content>,
    prefix: &str,
    found: &mut Vec<(String, &'static str)>,
) {
    let kind = content.and_then(|content| kind_of(table, content));
    for key in kind.map_or(&[][..], |kind| kind.keys).iter().chain(table.keys) {
        let path = format!("{prefix}{}", key.name);
        let inside = content.and_then(|content| entry(content, key.name));
        match key.value {
            Value::Table(inner) => add_paths(inner, inside, &format!("{path}."), found),
            Value::Tables(inner) => {
                if let Some(Content::List(items)) = inside {
                    let first = items.first().map(|node| &node.content);
                    add_paths(inner, first, &format!("{path}.0."), found);
                }
            }
            _ => {}
        }
        found.push((path, key.name));
    }
}

/// Most letters by which a misspelt key differs.
const MOST_EDITS: usize = 2;
/// The units in which the names of keys end, and others that are written in their place.
const UNITS: &str = " m m2 s g kg hz ohm v a w f c j n pa min h in ";

/// The known name from which what was written differs least, in its unit or in a few letters.
pub fn nearest<'a>(written: &str, known: &[&'a str]) -> Option<&'a str> {
    let close = known.iter().copied().filter(|name| is_close(written, name));
    close.min_by_key(|name| damerau_levenshtein(written, name))
}

/// Whether what was written differs from a key in its unit, in a few letters, or in both.
pub(super) fn is_close(written: &str, key: &str) -> bool {
    let written = written.to_lowercase();
    let is_near = |one: &str, other: &str| damerau_levenshtein(one, other) <= MOST_EDITS.min(other.len() / 3);
    let [(quantity, unit), (own, _)] = [&written, key].map(split);
    let first = key.split_once('_').map(|(quantity, _)| quantity);
    [first, Some(own)].contains(&Some(&*written))
        || is_near(&written, key)
        || (!unit.is_empty() && is_near(quantity, own))
}

/// The quantity and the unit, with a prefix or without, in the name of a key; the unit is empty where there is none.
pub(super) fn split(name: &str) -> (&str, &str) {
    let (head, per) = name.split_once("_per_").unwrap_or((name, ""));
    let is_unit = |unit: &str| {
        let bare = unit.strip_prefix(|prefix| "fpnuµμmckgt".contains(prefix)).unwrap_or(unit);
        !per.is_empty() || [unit, bare].iter().any(|unit| UNITS.contains(&format!(" {unit} ")))
    };
    let at = head.rfind('_').filter(|at| is_unit(&head[at + 1..].to_lowercase()));
    at.map_or((name, ""), |at| (&name[..at], &name[at + 1..]))
}

pub(super) fn entry<'a>(content: &'a Content, key: &str) -> Option<&'a Content> {
    match content {
        Content::Table(entries) => {
            entries.iter().find(|(name, _)| name == key).map(|(_, node)| &node.content)
        }
        _ => None,
    }
}

/// The line, from 1, that holds the byte at `offset`.
pub(super) fn line_of(text: &str, offset: usize) -> usize {
    text.as_bytes().iter().take(offset).filter(|byte| **byte == b'\n').count() + 1
}

pub(super) fn convert(value: &Spanned<DeValue<'_>>, origin: &dyn Fn(usize) -> Origin) -> Node {
    let content = match value.get_ref() {
        DeValue::String(text) => Content::Text(text.to_string()),
        DeValue::Integer(integer) => {
            // Signed and wide enough for every integer that TOML writes; larger ones are no number.
            let number = i128::from_str_radix(integer.as_str(), integer.radix());
            Content::Number(number.map_or(f64::NAN, |number| number as f64), integer.to_string())
        }
        DeValue::Float(float) => {
            let text = float.as_str();
            let number = text.parse().unwrap_or(f64::NAN);
            let overflown = f64::is_infinite(number) && !text.contains("inf");
            Content::Number(if overflown { f64::NAN } else { number }, text.to_owned())
        }
        DeValue::Boolean(value) => Content::Boolean(*value),
        DeValue::Datetime(date) => Content::Date(date.to_string()),
        DeValue::Array(items) => Content::List(items.iter().map(|item| convert(item, origin)).collect()),
        DeValue::Table(table) => Content::Table(convert_table(table, origin)),
    };
    Node { content, origin: origin(value.span().start) }
}

fn convert_table(table: &DeTable<'_>, origin: &dyn Fn(usize) -> Origin) -> Vec<(String, Node)> {
    let entries = table.iter();
    entries.map(|(key, value)| (key.get_ref().to_string(), convert(value, origin))).collect()
}
