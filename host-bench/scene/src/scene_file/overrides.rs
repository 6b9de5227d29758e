//! Values from the command line that replace those of a scene file.

use toml::de::DeTable;

use super::KEYS;
use super::document::{Content, OLD_KEYS, Origin, convert};
use super::key::walk;

/// A value to put into the document before it is read: `a.b=c`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    key: String,
    value: String,
    option: &'static str,
}

impl Override {
    /// The value of `key` shall be `value`, written as in a scene file; quotes may be left out.
    #[must_use]
    pub fn new(key: &str, value: &str) -> Self {
        let parts: Vec<&str> = key.split('.').map(str::trim).collect();
        Self { key: current(&parts).join("."), value: value.trim().to_owned(), option: "--set" }
    }

    /// The same of another option than `--set`, which an error then names.
    #[must_use]
    pub fn by(self, option: &'static str) -> Self {
        Self { option, ..self }
    }

    /// The key, with a dot between its parts.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value, as it was written.
    #[must_use]
    pub fn value(&self) -> &str {
        &self.value
    }

    /// The other keys of the same quantity, which this one replaces.
    pub fn alternatives(&self) -> impl Iterator<Item = String> {
        let (table, last) = self.key.rsplit_once('.').unwrap_or(("", &self.key));
        alternatives(last)
            .map(move |other| if table.is_empty() { other.to_owned() } else { format!("{table}.{other}") })
    }

    pub(super) fn origin(&self) -> Origin {
        Origin::Override(self.option)
    }

    pub(super) fn content(&self) -> Content {
        let parsed = DeTable::parse(&format!("value = {}", self.value)).ok().and_then(|table| {
            let table = table.into_inner();
            // A line break in the value must not smuggle in a second key.
            let only = table.len() == 1;
            let value = table.into_iter().next().filter(|_| only)?.1;
            Some(convert(&value, &|_| self.origin()).content)
        });
        parsed.unwrap_or_else(|| Content::Text(self.value.clone()))
    }
}

impl std::str::FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Self::new(key, value))
            }
            _ => Err("must be KEY=VALUE, for example run.duration_s=5".to_owned()),
        }
    }
}

/// The parts of a key, by the names of this version.
fn current<'a>(parts: &[&'a str]) -> Vec<&'a str> {
    let renamed = OLD_KEYS.iter().find(|[table, old, _]| parts.starts_with(&[table, old]));
    renamed.map_or_else(|| parts.to_vec(), |[table, _, new]| [&[*table, *new], &parts[2..]].concat())
}

/// The other name of the quantity that the last part of a key names.
pub(super) fn alternatives(last: &str) -> impl Iterator<Item = &'static str> {
    let mut other = None;
    walk(&KEYS, &mut |key| {
        if key.name == last {
            other = other.or(key.instead_of);
        }
    });
    other.into_iter()
}

/// Whether setting `key` discards what was set at `before`: the same key, a table around it, or its alternative.
#[must_use]
pub fn replaces(key: &str, before: &str) -> bool {
    let (table, last) = key.rsplit_once('.').map_or(("", key), |(table, last)| (table, last));
    let beside = |other: &str| if table.is_empty() { other.to_owned() } else { format!("{table}.{other}") };
    contains(key, before) || alternatives(last).any(|other| contains(&beside(other), before))
}

/// Whether `key` is `table`, or a key in it.
#[must_use]
pub fn contains(table: &str, key: &str) -> bool {
    key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_replaces_itself_its_parts_and_its_alternative() {
        for (key, before, expected) in [
            ("run.settle_s", "run.settle_s", true),
            ("run.settle_s", "run.settle_periods", true),
            ("load", "load.draw.value", true),
            ("load.draw.value", "load", false),
            ("load.draw", "load.drawn", false),
            ("run.settle_s", "run.duration_s", false),
            ("excitation.tones.0.amplitude_g", "excitation.tones.1.amplitude_m_per_s2", false),
        ] {
            assert_eq!(replaces(key, before), expected, "{key} after {before}");
        }
    }
}
