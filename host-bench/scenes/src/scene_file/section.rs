//! One table of a scene file, read key by key; what has no row in the table of its keys is refused.

use super::document::{Content, Document, Node, Origin, SceneError, is_close, nearest, split};
use super::key::{Bound, Default, Key, Kind, Short, Table, Value};
use super::overrides::number_of;
use super::rows_of;

/// Most keys of other tables that an error names.
const MOST_PATHS: usize = 3;

/// A table of the file, and the keys that it may have.
pub(super) struct Section<'a> {
    document: &'a Document,
    /// Keys that lead here, each with its dot.
    prefix: String,
    entries: &'a [(String, Node)],
    pub(super) table: &'static Table,
    /// Its kind, once that is read.
    kind: Option<&'static Kind>,
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
    /// The whole document, with the keys of `table`.
    pub(super) fn root(document: &'a Document, table: &'static Table) -> Self {
        let entries: &[_] = match &document.content {
            Content::Table(entries) => entries,
            _ => &[],
        };
        Self { document, prefix: String::new(), entries, table, kind: None }
    }

    /// The full name of a key here.
    fn name(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    fn row(&self, key: &str) -> Option<&'static Key> {
        let row = self.table.key(key, self.kind);
        assert!(row.is_some() || key == self.table.selector, "{}: has no row", self.name(key));
        row
    }

    /// The names of the keys that may be here.
    fn known(&self) -> impl Iterator<Item = &'static str> {
        let selector = Some(self.table.selector).filter(|name| !name.is_empty());
        let of_kind = self.kind.map_or(&[][..], |kind| kind.keys);
        selector.into_iter().chain(of_kind.iter().chain(self.table.keys).map(|key| key.name))
    }

    fn peek(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.peek(key).is_some()
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
        let meant = keys.iter().filter_map(|key| Some((key, self.misspelt(key)?)));
        let mut meant = meant.filter(|(key, (written, _))| nearest(written, keys) == Some(**key));
        if let Some((key, (written, node))) = meant.next() {
            let meant = self.meant(key, written, node);
            let reason = format!("unknown key{meant}, which is missing; must be {wanted}");
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

    /// A key of the file that is unknown, and that differs from `key` in its unit or in a few letters.
    fn misspelt(&self, key: &str) -> Option<(&'a str, &'a Node)> {
        let is_another = |written: &str| self.known().any(|name| name == written);
        let mut entries = self.entries.iter().map(|(written, node)| (written.as_str(), node));
        entries.find(|(written, _)| !is_another(written) && is_close(written, key))
    }

    /// The key that was meant, with the number in its unit where what was written ends in another one.
    fn meant(&self, key: &str, written: &str, node: &Node) -> String {
        format!(", probably {key} misspelt{}", of_unit(&plain(&self.name(key)), written, node))
    }

    /// The number of a text for a key, or what to say of its unit.
    fn number_of(&self, key: &str, text: &str) -> Result<f64, String> {
        number_of(&plain(&self.name(key)), text)
    }

    pub(super) fn file(&self) -> &'a std::path::Path {
        &self.document.file
    }

    pub(super) fn bound(&self, key: &str) -> Bound {
        // A key without a row must not pass unchecked.
        self.row(key).map_or(Bound::NOTHING, Bound::of)
    }

    /// The number that a key has by its row where it is not given.
    fn default(&self, key: &str) -> Option<f64> {
        match self.row(key)?.default {
            Default::Number(number) => Some(number),
            _ => None,
        }
    }

    pub(super) fn optional_number(&mut self, key: &'static str) -> Result<Option<f64>, SceneError> {
        let bound = self.bound(key);
        let Some(content) = self.content(key) else { return Ok(None) };
        let value = content.number().filter(|value| bound.contains(*value));
        // A file has no units.
        let is_of_file = self.peek(key).is_none_or(|node| matches!(node.origin, Origin::Line(_)));
        let of_unit = content.text().filter(|_| !is_of_file).and_then(|text| self.number_of(key, text).err());
        let of_unit = of_unit.unwrap_or_default();
        value.map(Some).ok_or_else(|| self.refuse(key, format!("must be {bound}{of_unit}")))
    }

    /// A number that must be there unless its row has a default.
    pub(super) fn number(&mut self, key: &'static str) -> Result<f64, SceneError> {
        self.number_or(key, None)
    }

    /// A number that must be there unless there is a `default` for it.
    pub(super) fn number_or(&mut self, key: &'static str, default: Option<f64>) -> Result<f64, SceneError> {
        let given = self.optional_number(key)?;
        given.or(default).or(self.default(key)).ok_or_else(|| self.missing(key, &self.bound(key).to_string()))
    }

    /// A whole number that must be there unless its row has a default.
    pub(super) fn whole_number(&mut self, key: &'static str) -> Result<usize, SceneError> {
        let (bound, among) = match self.row(key).map(|row| row.value) {
            Some(Value::Among(numbers)) => (Bound::NOTHING, numbers),
            _ => (self.bound(key), &[][..]),
        };
        let wanted = match among.split_last() {
            Some((last, others)) => {
                let others: Vec<String> = others.iter().map(usize::to_string).collect();
                format!("{} or {last}", others.join(", "))
            }
            None => format!("a whole number from {} to {}", bound.range.lowest, bound.range.highest),
        };
        match self.content(key) {
            None => self.default(key).map(|value| value as usize).ok_or_else(|| self.missing(key, &wanted)),
            Some(Content::Number(value, _))
                if value.fract() == 0.0
                    && (bound.contains(*value) || among.iter().any(|number| *number as f64 == *value)) =>
            {
                Ok(*value as usize)
            }
            Some(_) => Err(self.refuse(key, format!("must be {wanted}"))),
        }
    }

    /// A list of `count` numbers, if the key is there.
    pub(super) fn optional_numbers(
        &mut self,
        key: &'static str,
        count: usize,
    ) -> Result<Option<Vec<f64>>, SceneError> {
        let bound = self.bound(key);
        let each = match self.row(key).map(|row| row.value) {
            Some(Value::Numbers(_, each)) => each,
            _ => "",
        };
        let (lowest, highest) = (Short(bound.range.lowest), Short(bound.range.highest));
        let wanted = format!("{count} numbers, each from {lowest} to {highest}");
        let Some(items) = self.list(key, &format!("a list of {wanted}"))? else { return Ok(None) };
        let value = |item: &Node| item.content.number().filter(|value| bound.contains(*value));
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

    /// A list of pairs of numbers, which must be there.
    pub(super) fn points(&mut self, key: &'static str) -> Result<Vec<[f64; 2]>, SceneError> {
        let most = match self.row(key).map(|row| row.value) {
            Some(Value::Points(_, most)) => most,
            _ => 0,
        };
        let wanted = format!("a list of 2 to {most} points, each a list of two numbers");
        let items = self.list(key, &wanted)?.ok_or_else(|| self.missing(key, &wanted))?;
        if !(2..=most).contains(&items.len()) {
            return Err(self.refuse(key, format!("must be {wanted}")));
        }
        let points: Vec<[f64; 2]> = items.iter().map_while(|item| item.content.pair()).collect();
        match items.get(points.len()) {
            None => Ok(points),
            Some(bad) => {
                let index = points.len();
                Err(self.refuse(key, format!("item {index} is {}: must be {wanted}", bad.content)))
            }
        }
    }

    pub(super) fn text(&mut self, key: &'static str) -> Option<&'a str> {
        self.content(key)?.text()
    }

    /// The items of a list, if the key is there.
    fn list(&self, key: &'static str, wanted: &str) -> Result<Option<&'a [Node]>, SceneError> {
        match self.content(key) {
            None => Ok(None),
            Some(Content::List(items)) => Ok(Some(items)),
            Some(_) => Err(self.refuse(key, format!("must be {wanted}"))),
        }
    }

    /// A list of texts, if the key is there.
    pub(super) fn texts(&mut self, key: &'static str) -> Result<Option<Vec<&'a str>>, SceneError> {
        const WANTED: &str = "a list of texts";
        let Some(items) = self.list(key, WANTED)? else { return Ok(None) };
        let texts: Option<Vec<&str>> = items.iter().map(|item| item.content.text()).collect();
        texts.map(Some).ok_or_else(|| self.refuse(key, format!("must be {WANTED}")))
    }

    /// The value of a key, whatever it is.
    pub(super) fn content(&self, key: &str) -> Option<&'a Content> {
        self.peek(key).map(|node| &node.content)
    }

    /// `true` or `false`, which must be there unless its row has a default.
    pub(super) fn flag(&mut self, key: &'static str) -> Result<bool, SceneError> {
        match (self.content(key), self.row(key).map(|row| row.default)) {
            (None, Some(Default::Flag(default))) => Ok(default),
            (None, _) => Err(self.missing(key, "true or false")),
            (Some(Content::Boolean(value)), _) => Ok(*value),
            (Some(_), _) => Err(self.refuse(key, "must be true or false")),
        }
    }

    pub(super) fn is_false(&mut self, key: &'static str) -> bool {
        self.peek(key).is_some_and(|node| node.content == Content::Boolean(false))
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

    /// The part of the market that a key names by its word.
    pub(super) fn part<T>(
        &mut self,
        key: &'static str,
        words: fn() -> Vec<&'static str>,
        named: fn(&str) -> Option<T>,
    ) -> Result<T, SceneError> {
        let words: Vec<(&str, &str)> = words().into_iter().map(|word| (word, word)).collect();
        let word = self.choice(key, &words)?;
        named(word).ok_or_else(|| self.refuse(key, "is not a part".to_owned()))
    }

    /// What is read with the kind that the selector names; the keys from here on are those of this kind.
    pub(super) fn kind<T: Copy>(&mut self, kinds: &[(&'static Kind, T)]) -> Result<T, SceneError> {
        let choices: Vec<(&str, (&'static Kind, T))> =
            kinds.iter().map(|(kind, read)| (kind.word, (*kind, *read))).collect();
        let (kind, read) = self.choice(self.table.selector, &choices)?;
        self.kind = Some(kind);
        Ok(read)
    }

    pub(super) fn optional_table(&mut self, key: &'static str) -> Result<Option<Section<'a>>, SceneError> {
        match self.content(key) {
            None => Ok(None),
            Some(Content::Table(entries)) => Ok(Some(self.inner(key, &self.name(key), entries))),
            Some(_) => Err(self.refuse(key, "must be a table")),
        }
    }

    /// A table that must be there.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Section<'a>, SceneError> {
        self.optional_table(key)?.ok_or_else(|| self.missing(key, "a table"))
    }

    /// A table without a key, in place of one that may be left out.
    pub(super) fn empty(&self, key: &'static str) -> Section<'a> {
        self.inner(key, &self.name(key), &[])
    }

    /// A list of tables, not empty.
    pub(super) fn tables(&mut self, key: &'static str) -> Result<Vec<Section<'a>>, SceneError> {
        const WANTED: &str = "a list of tables, at least one";
        let items = self.list(key, WANTED)?.ok_or_else(|| self.missing(key, WANTED))?;
        if items.is_empty() {
            return Err(self.refuse(key, format!("must be {WANTED}")));
        }
        let inner = items.iter().enumerate().map(|(index, item)| match &item.content {
            Content::Table(entries) => Ok(self.inner(key, &format!("{}[{index}]", self.name(key)), entries)),
            _ => Err(self.refuse(key, format!("must be {WANTED}"))),
        });
        inner.collect()
    }

    fn inner(&self, key: &str, name: &str, entries: &'a [(String, Node)]) -> Section<'a> {
        static NO_KEYS: Table = Table::of(&[]);
        let table = self.row(key).and_then(Key::table).unwrap_or(&NO_KEYS);
        Section { document: self.document, prefix: format!("{name}."), entries, table, kind: None }
    }

    /// Refuses what has no row.
    pub(super) fn finish(self) -> Result<(), SceneError> {
        match self.entries.iter().find(|(key, _)| !self.known().any(|name| name == key)) {
            None => Ok(()),
            Some((key, node)) => {
                // An override makes the tables that lead to it: blame the key that was given.
                let (mut name, mut node) = (self.name(key), node);
                while let (Origin::Override(_), Content::Table(entries)) = (node.origin, &node.content) {
                    let Some((key, inner)) = entries.first() else { break };
                    name = format!("{name}.{key}");
                    node = inner;
                }
                let known: Vec<&str> = self.known().collect();
                let meant = nearest(key, &known);
                let probably = meant.map_or_else(String::new, |meant| self.meant(meant, key, node));
                let elsewhere = match meant {
                    None => self.document.paths_of(name.rsplit('.').next().unwrap_or(key)),
                    Some(_) => Vec::new(),
                };
                let elsewhere = match &elsewhere[..elsewhere.len().min(MOST_PATHS)] {
                    [] => String::new(),
                    paths @ [path, ..] => {
                        format!("; did you mean {}{}?", paths.join(" or "), of_unit(path, &name, node))
                    }
                };
                let known = known.join(", ");
                let reason = format!("unknown key{probably}; known here: {known}{elsewhere}");
                Err(SceneError::of_value(&self.document.file, &name, node, reason))
            }
        }
    }
}

/// The name of a key with a dot before the number of an item.
fn plain(name: &str) -> String {
    name.replace('[', ".").replace(']', "")
}

/// The unit of the key of a name, with the number in it, where what was written ends in another one.
fn of_unit(name: &str, written: &str, node: &Node) -> String {
    let key = name.rsplit('.').next().unwrap_or(name);
    let unit = rows_of(name).first().map_or("", |row| row.unit);
    let [own, end] = [key, written].map(|name| split(name).1);
    let lower = end.to_lowercase();
    if own.is_empty() || end.is_empty() || own == lower || ["", "1"].contains(&unit) {
        return String::new();
    }
    // The end is no prefix by accident: `duration_m` is for minutes.
    let prefix = lower.strip_suffix(own).map(|prefix| &end[..prefix.len()]);
    let suffix = prefix.or(Some(end).filter(|end| end.ends_with('g')));
    let value = suffix.and_then(|suffix| number_of(name, &format!("{}{suffix}", node.content)).ok());
    let short = |value| format!(": {}", Short(format!("{value:.9e}").parse().unwrap_or(value)));
    format!(", in {unit} and not in {end}{}", value.map_or_else(String::new, short))
}
