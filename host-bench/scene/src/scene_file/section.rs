//! One table of a scene file, read key by key; what nobody asked for is refused.

use strsim::damerau_levenshtein;

use super::bounds::{Bound, Short, Table, row};
use super::document::{Content, Document, Node, Origin, SceneError};
use super::scene::{ForceLaw, StickCharge};

/// Most letters by which a misspelt key differs.
const MOST_EDITS: usize = 2;

/// A table and the keys that were asked of it.
#[derive(Debug)]
pub(super) struct Section<'a> {
    document: &'a Document,
    /// Keys that lead here, each with its dot.
    prefix: String,
    entries: &'a [(String, Node)],
    known: Vec<&'static str>,
    /// The bounds of its numbers.
    tables: &'static [Table],
}

/// Reads what a table says with one of the words of a choice.
pub(super) type Reader<T> = fn(&mut Section<'_>) -> Result<T, SceneError>;

/// A struct of numbers that are read from the keys of their names, and of other fields after a `;`.
macro_rules! numbers {
    ($section:ident, $($name:ident)::+ { $($key:ident),+; $($rest:tt)* }) => {
        $($name)::+ { $($key: $section.number(stringify!($key))?,)+ $($rest)* }
    };
}
pub(super) use numbers;

impl<'a> Section<'a> {
    /// The whole document.
    pub(super) fn root(document: &'a Document) -> Self {
        let entries: &[_] = match &document.content {
            Content::Table(entries) => entries,
            _ => &[],
        };
        Self { document, prefix: String::new(), entries, known: Vec::new(), tables: &[] }
    }

    /// The full name of a key here.
    fn name(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    fn find(&mut self, key: &'static str) -> Option<&'a Node> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.peek(key)
    }

    fn peek(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    /// Whether the key is there.
    pub(super) fn has(&mut self, key: &'static str) -> bool {
        self.find(key).is_some()
    }

    /// An error about the value of a key, or about its absence.
    pub(super) fn refuse(&self, key: &str, reason: impl Into<String>) -> SceneError {
        let name = self.name(key);
        match self.peek(key) {
            Some(node) => SceneError::of_value(&self.document.file, &name, node, reason),
            None => SceneError::of_absent(&self.document.file, &name, reason),
        }
    }

    /// An error about a key that must be there and is not.
    pub(super) fn missing(&self, key: &'static str, wanted: &str) -> SceneError {
        self.missing_of(&[key], wanted)
    }

    /// An error about a quantity that must be there under one of its `keys` and is not; the first is blamed, or a
    /// key in the file that is probably one of them misspelt.
    pub(super) fn missing_of(&self, keys: &[&'static str], wanted: &str) -> SceneError {
        let meant = keys.iter().find_map(|key| Some((key, self.misspelt(key)?)));
        if let Some((key, (written, node))) = meant {
            let reason = format!("unknown key, probably {key} misspelt, which is missing; must be {wanted}");
            return SceneError::of_value(&self.document.file, &self.name(written), node, reason);
        }
        match keys {
            [key, other] => self.refuse(key, format!("is missing, and so is {other}; must be {wanted}")),
            _ => self.refuse(keys.first().unwrap_or(&""), format!("is missing; must be {wanted}")),
        }
    }

    /// An error about a key that is missing or has another value than is wanted.
    pub(super) fn must_be(&self, key: &'static str, wanted: &str) -> SceneError {
        match self.peek(key) {
            Some(_) => self.refuse(key, format!("must be {wanted}")),
            None => self.missing(key, wanted),
        }
    }

    /// A key of the file that nobody asked for, that has not the bounds of another, and that differs from `key` in its
    /// unit or in a few letters.
    fn misspelt(&self, key: &str) -> Option<(&'a str, &'a Node)> {
        let close = |written: &str| {
            let same_quantity = key.split_once('_').is_some_and(|(quantity, _)| written == quantity)
                || key.rsplit_once('_').is_some_and(|(quantity, _)| written == quantity);
            let edits = damerau_levenshtein(&written.to_lowercase(), key);
            same_quantity || edits <= MOST_EDITS.min(key.len() / 3)
        };
        let name = |key: &str| row(key, self.tables).map(|(name, _)| name);
        let is_another = |written: &str| {
            self.known.contains(&written) || name(written).is_some() && name(written) != name(key)
        };
        let mut entries = self.entries.iter().map(|(written, node)| (written.as_str(), node));
        entries.find(|(written, _)| !is_another(written) && close(written))
    }

    /// The file of the scene.
    pub(super) fn file(&self) -> &'a std::path::Path {
        &self.document.file
    }

    /// The bound of a key.
    pub(super) fn bound(&self, key: &str) -> Bound {
        Bound::of(key, self.tables)
    }

    /// Reads the numbers from here on by these bounds.
    pub(super) fn bounded_by(&mut self, tables: &'static [Table]) {
        self.tables = tables;
    }

    /// A number, if the key is there.
    pub(super) fn optional_number(&mut self, key: &'static str) -> Result<Option<f64>, SceneError> {
        let bound = self.bound(key);
        match self.find(key).map(|node| &node.content) {
            None => Ok(None),
            Some(Content::Number(value, _)) if bound.contains(*value) => Ok(Some(*value)),
            Some(_) => Err(self.refuse(key, format!("must be {bound}"))),
        }
    }

    /// A number that must be there.
    pub(super) fn number(&mut self, key: &'static str) -> Result<f64, SceneError> {
        self.number_or(key, None)
    }

    /// A number that must be there unless there is a `default` for it.
    pub(super) fn number_or(&mut self, key: &'static str, default: Option<f64>) -> Result<f64, SceneError> {
        let given = self.optional_number(key)?;
        given.or(default).ok_or_else(|| self.missing(key, &self.bound(key).to_string()))
    }

    /// A whole number that must be there.
    pub(super) fn whole_number(&mut self, key: &'static str) -> Result<usize, SceneError> {
        let bound = self.bound(key);
        let wanted = format!("a whole number from {} to {}", bound.range.lowest, bound.range.highest);
        match self.find(key).map(|node| &node.content) {
            None => Err(self.missing(key, &wanted)),
            Some(Content::Number(value, _)) if bound.contains(*value) && value.fract() == 0.0 => {
                Ok(*value as usize)
            }
            Some(_) => Err(self.refuse(key, format!("must be {wanted}"))),
        }
    }

    /// A list of `count` numbers, one for `each`, if the key is there.
    pub(super) fn optional_numbers(
        &mut self,
        key: &'static str,
        count: usize,
        each: &str,
    ) -> Result<Option<Vec<f64>>, SceneError> {
        let bound = self.bound(key);
        let (lowest, highest) = (Short(bound.range.lowest), Short(bound.range.highest));
        let wanted = format!("{count} numbers, each from {lowest} to {highest}");
        let items = match self.find(key).map(|node| &node.content) {
            None => return Ok(None),
            Some(Content::List(items)) => items,
            Some(_) => return Err(self.refuse(key, format!("must be a list of {wanted}"))),
        };
        let value = |item: &Node| match &item.content {
            Content::Number(value, _) if bound.contains(*value) => Some(*value),
            _ => None,
        };
        let values: Vec<f64> = items.iter().map_while(value).collect();
        let found = values.len();
        match items.get(found) {
            Some(bad) => Err(self.refuse(key, format!("item {found} is {}: must be {wanted}", bad.content))),
            None if found == count => Ok(Some(values)),
            None => {
                let reason = format!("must be {count} numbers, one for each {each}; are {found}");
                Err(self.refuse(key, reason))
            }
        }
    }

    /// A list of pairs of numbers, from two to `most`, which must be there.
    pub(super) fn points(&mut self, key: &'static str, most: usize) -> Result<Vec<[f64; 2]>, SceneError> {
        let wanted = format!("a list of 2 to {most} points, each a list of two numbers");
        let items = match self.find(key).map(|node| &node.content) {
            None => return Err(self.missing(key, &wanted)),
            Some(Content::List(items)) if (2..=most).contains(&items.len()) => items,
            Some(_) => return Err(self.refuse(key, format!("must be {wanted}"))),
        };
        let point = |item: &Node| match &item.content {
            Content::List(pair) => match pair.as_slice() {
                [
                    Node { content: Content::Number(x, _), .. },
                    Node { content: Content::Number(y, _), .. },
                ] => Some([*x, *y]),
                _ => None,
            },
            _ => None,
        };
        let points: Vec<[f64; 2]> = items.iter().map_while(point).collect();
        match items.get(points.len()) {
            None => Ok(points),
            Some(bad) => {
                let index = points.len();
                Err(self.refuse(key, format!("item {index} is {}: must be {wanted}", bad.content)))
            }
        }
    }

    /// A text, if the value is one.
    pub(super) fn text(&mut self, key: &'static str) -> Option<&'a str> {
        match self.find(key).map(|node| &node.content) {
            Some(Content::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// `true` or `false`; `default` if the key is not there.
    pub(super) fn flag(&mut self, key: &'static str, default: bool) -> Result<bool, SceneError> {
        match self.find(key).map(|node| &node.content) {
            None => Ok(default),
            Some(Content::Boolean(value)) => Ok(*value),
            Some(_) => Err(self.refuse(key, "must be true or false")),
        }
    }

    /// Whether the key is there and `false`.
    pub(super) fn is_false(&mut self, key: &'static str) -> bool {
        self.find(key).is_some_and(|node| node.content == Content::Boolean(false))
    }

    /// `true` or `false`, which must be there.
    pub(super) fn required_flag(&mut self, key: &'static str) -> Result<bool, SceneError> {
        if !self.has(key) {
            return Err(self.missing(key, "true or false"));
        }
        self.flag(key, false)
    }

    /// The electrostatic force law of a triboelectric harvester.
    pub(super) fn force_law(&mut self) -> Result<ForceLaw, SceneError> {
        let laws = [
            ("transferred-charge", ForceLaw::TransferredCharge),
            ("gap-field", ForceLaw::GapField),
            ("none", ForceLaw::None),
        ];
        self.choice("force_law", &laws)
    }

    /// What the charge of a triboelectric harvester does in stick.
    pub(super) fn stick_charge(&mut self) -> Result<StickCharge, SceneError> {
        let choices = [("frozen", StickCharge::Frozen), ("relaxing", StickCharge::Relaxing)];
        self.choice("stick_charge", &choices)
    }

    /// One of a few words.
    pub(super) fn choice<T: Copy>(
        &mut self,
        key: &'static str,
        choices: &[(&str, T)],
    ) -> Result<T, SceneError> {
        let words: Vec<String> = choices.iter().map(|(word, _)| format!("{word:?}")).collect();
        let wanted = words.join(" or ");
        if !self.has(key) {
            return Err(self.missing(key, &wanted));
        }
        let word = self.text(key);
        let found = choices.iter().find(|(name, _)| Some(*name) == word);
        found.map(|(_, value)| *value).ok_or_else(|| self.refuse(key, format!("must be {wanted}")))
    }

    /// A table, if the key is there.
    pub(super) fn optional_table(&mut self, key: &'static str) -> Result<Option<Section<'a>>, SceneError> {
        match self.find(key).map(|node| &node.content) {
            None => Ok(None),
            Some(Content::Table(entries)) => Ok(Some(self.inner(&self.name(key), entries))),
            Some(_) => Err(self.refuse(key, "must be a table")),
        }
    }

    /// A table that must be there.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Section<'a>, SceneError> {
        self.optional_table(key)?.ok_or_else(|| self.missing(key, "a table"))
    }

    /// A table without a key, in place of one that may be left out.
    pub(super) fn empty(&self, key: &'static str) -> Section<'a> {
        self.inner(&self.name(key), &[])
    }

    /// A list of tables, not empty.
    pub(super) fn tables(&mut self, key: &'static str) -> Result<Vec<Section<'a>>, SceneError> {
        const WANTED: &str = "a list of tables, at least one";
        let items = match self.find(key).map(|node| &node.content) {
            None => return Err(self.missing(key, WANTED)),
            Some(Content::List(items)) if !items.is_empty() => items,
            Some(_) => return Err(self.refuse(key, format!("must be {WANTED}"))),
        };
        let inner = items.iter().enumerate().map(|(index, item)| match &item.content {
            Content::Table(entries) => Ok(self.inner(&format!("{}[{index}]", self.name(key)), entries)),
            _ => Err(self.refuse(key, format!("must be {WANTED}"))),
        });
        inner.collect()
    }

    fn inner(&self, name: &str, entries: &'a [(String, Node)]) -> Section<'a> {
        Section {
            document: self.document,
            prefix: format!("{name}."),
            entries,
            known: Vec::new(),
            tables: &[],
        }
    }

    /// Refuses what nobody asked for.
    pub(super) fn finish(self) -> Result<(), SceneError> {
        match self.entries.iter().find(|(key, _)| !self.known.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, node)) => {
                // An override makes the tables that lead to it: blame the key that was given.
                let (mut name, mut node) = (self.name(key), node);
                while let (Origin::Override, Content::Table(entries)) = (node.origin, &node.content) {
                    let Some((key, inner)) = entries.first() else { break };
                    name = format!("{name}.{key}");
                    node = inner;
                }
                let reason = format!("unknown key; known here: {}", self.known.join(", "));
                Err(SceneError::of_value(&self.document.file, &name, node, reason))
            }
        }
    }
}
