//! Values from the command line that replace those of a scene file, and a scene file with them put in.

use std::path::Path;

use toml::de::DeTable;

use super::document::{
    Content, Document, Node, OLD_KEYS, Origin, SceneError, convert, entry, kind_of, line_of, nearest,
};
use super::key::{Key, Kind, Value, walk};
use super::{GRAVITY, KEYS, rows_of, shipped_instead};
use crate::input::{MOST_OF_SCENE, read};

/// A value to put into the document before it is read: `a.b=c`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    key: String,
    value: String,
    option: &'static str,
}

impl Override {
    /// The value of `key` shall be `value`, written as in a scene file; quotes may be left out.
    pub fn new(key: &str, value: &str) -> Self {
        let parts: Vec<&str> = key.split('.').map(str::trim).collect();
        let key = current(&parts).join(".");
        // A document has plain numbers.
        let number = number_of(&key, value).ok().filter(|_| value.trim().parse::<f64>().is_err());
        let value = number.map_or_else(|| value.trim().to_owned(), |number| format!("{number:e}"));
        Self { key, value, option: "--set" }
    }

    /// The same of another option than `--set`, which an error then names.
    pub fn by(self, option: &'static str) -> Self {
        Self { option, ..self }
    }

    /// The key, with a dot between its parts.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as a plain number or text: `33k` is `3.3e4`.
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

impl Document {
    pub(super) fn read(file: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let fault = |line, reason: String| SceneError::of_file(file, line, reason);
        let bytes = read(file, MOST_OF_SCENE)
            .or_else(|error| shipped_instead(file, error).map(String::into_bytes))
            .map_err(|error| fault(None, format!("cannot be read: {error}")))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let line = line_of(&String::from_utf8_lossy(&error.as_bytes()[..valid]), valid);
            fault(Some(line), "is not UTF-8 text".to_owned())
        })?;
        let mut document = Self::parse(file, &text)?;
        document.rename_old_keys();
        for change in overrides {
            document.put(change)?;
        }
        Ok(document)
    }

    fn put(&mut self, change: &Override) -> Result<(), SceneError> {
        let node = Node { content: change.content(), origin: change.origin() };
        let key = change.key();
        let refuse = |reason: &str| SceneError::of_value(&self.file, key, &node, reason);
        let (tables, last): (Vec<&str>, &str) = match key.rsplit_once('.') {
            Some((tables, last)) => (tables.split('.').collect(), last.trim()),
            None => (Vec::new(), key),
        };
        let kinds = Kinds::of(&self.content, &tables, last, &node.content);
        let mut content = &mut self.content;
        for part in tables {
            content = match inner(content, part.trim(), change.origin()) {
                Some(node) => &mut node.content,
                None => return Err(refuse(&format!("{part} leads to no table"))),
            };
        }
        if let Content::Table(entries) = &mut *content {
            for other in alternatives(last) {
                entries.retain(|(key, _)| key != other);
            }
            if let Some(kinds) = kinds {
                entries.retain(|(key, node)| matches!(node.origin, Origin::Override(_)) || kinds.keep(key));
            }
        }
        match inner(content, last, change.origin()) {
            Some(found) => *found = node,
            None => return Err(refuse("leads to no table")),
        }
        Ok(())
    }
}

/// The kind that a table has, and the one that an override gives it.
#[derive(Debug, Clone, Copy)]
struct Kinds {
    before: &'static Kind,
    after: &'static Kind,
}

impl Kinds {
    /// The kinds of the table that `tables` leads to, if the value of its key `last` says its kind.
    fn of(content: &Content, tables: &[&str], last: &str, value: &Content) -> Option<Self> {
        // The tables of one scene are not those of another.
        if tables.is_empty() {
            return None;
        }
        let (mut table, mut content) = (&KEYS, content);
        for part in tables.iter().map(|part| part.trim()) {
            content = match content {
                Content::List(items) => &items.get(part.parse::<usize>().ok()?)?.content,
                _ => {
                    let key = table.key(part, kind_of(table, content))?;
                    table = key.table()?;
                    entry(content, part)?
                }
            };
        }
        let (before, Content::Text(word)) = (kind_of(table, content)?, value) else { return None };
        (last == table.selector).then_some(())?;
        Some(Self { before, after: table.kind(word)? })
    }

    /// Whether a key of the file means the same in both kinds; what is unknown is kept, to be refused.
    fn keep(self, name: &str) -> bool {
        let of = |kind: &'static Kind| kind.keys.iter().find(|key| key.name == name);
        match (of(self.before), of(self.after)) {
            (Some(before), Some(after)) => before.unit == after.unit,
            (before, _) => before.is_none(),
        }
    }
}

/// What a key (or, in a list, a number from 0) leads to; a key that is not there is made, as an empty
/// table. `None` if there are no keys here.
fn inner<'a>(content: &'a mut Content, key: &str, origin: Origin) -> Option<&'a mut Node> {
    match content {
        Content::Table(entries) => {
            let index = entries.iter().position(|(name, _)| name == key).unwrap_or_else(|| {
                let node = Node { content: Content::Table(Vec::new()), origin };
                entries.push((key.to_owned(), node));
                entries.len() - 1
            });
            entries.get_mut(index).map(|(_, node)| node)
        }
        Content::List(items) => items.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    }
}

/// Prefixes of units, each a thousand times the one before it; the blank is none.
const PREFIXES: &str = "fpnum kMGT";

/// A number for a key on a command line. An error is what to say of the unit of the text, nothing where it does not begin with a number
/// or the key takes none.
pub(super) fn number_of(key: &str, text: &str) -> Result<f64, String> {
    use Value::{Among, Number, NumberOrLimits, Whole};
    number_in(text, || {
        let rows = rows_of(key);
        let unknown = || {
            let mut known = Vec::new();
            walk(&KEYS, &mut |key| known.push(key.name));
            let meant = nearest(key.rsplit('.').next().unwrap_or(key), &known);
            let meant = meant.map_or_else(String::new, |meant| format!(", probably {meant} misspelt"));
            format!("; {key} is an unknown key{meant}, the command keys lists all")
        };
        let unit = rows.first().ok_or_else(unknown)?.unit;
        let is_of_number =
            |row: &Key| matches!(row.value, Number(_) | NumberOrLimits(_) | Whole(_) | Among(_));
        // A key whose unit depends on its kind takes a prefix alone.
        let unit = if unit != "1" && rows.iter().all(|row| row.unit == unit) { unit } else { "" };
        if rows.iter().all(|row| is_of_number(row)) { Ok(unit) } else { Err(String::new()) }
    })
}

/// A number in a unit: plain, or with a prefix, with the unit, or with both, such as `10M`, `33kΩ`, `20us` or, for an acceleration or
/// a mass, `0.2g`. A letter that is a prefix is one: `5m` of a length is 5 mm.
fn number_in(text: &str, unit: impl FnOnce() -> Result<&'static str, String>) -> Result<f64, String> {
    let text = text.trim();
    if let Ok(plain) = text.parse() {
        return Ok(plain);
    }
    let is_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let mut parts = text.char_indices().rev().map(|(at, _)| text.split_at(at));
    let (digits, own) =
        parts.find(|(head, _)| is_number(head) && head.parse::<f64>().is_ok()).ok_or_else(String::new)?;
    // The ohm has two signs and two spellings, the micro two signs and a letter.
    let suffix = own.trim().replace('\u{2126}', "Ω").replace("Ohm", "ohm").replace(['µ', 'μ'], "u");
    let (suffix, unit) = (suffix.replace("^2", "2").replace("^3", "3"), unit()?);
    let ascii = unit.replace('Ω', "ohm").replace('²', "2").replace('³', "3");
    let gram = if unit == "kg" { 1e-3 } else { GRAVITY };
    let units = [("", 1.0), (unit, 1.0), (ascii.as_str(), 1.0), ("g", gram)];
    let units = if ["m/s²", "kg"].contains(&unit) { &units[..] } else { &units[..3] };
    let found = units.iter().find_map(|(unit, factor)| {
        // The prefix of a square metre is squared.
        let is_square = unit.starts_with("m²") || unit.starts_with("m2");
        let power = match suffix.strip_suffix(unit)? {
            "" => 0,
            "c" if is_square => -4,
            "m" if is_square => -6,
            prefix if !is_square && prefix.len() == 1 => 3 * PREFIXES.find(prefix)? as i32 - 15,
            _ => return None,
        };
        Some((power, factor))
    });
    let of_unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
    let (power, factor) =
        found.ok_or_else(|| format!(",{of_unit} with a prefix or without, not in {}", own.trim()))?;
    // The digits with their power of ten are read together, so that no rounding is between.
    let value = match digits.contains(['e', 'E']) {
        true => digits.parse::<f64>().map(|digits| digits * 10f64.powi(power)),
        false => format!("{digits}e{power}").parse(),
    };
    value.map(|value| value * factor).map_err(|error| error.to_string())
}

/// A finite number for a key, as by `--set`.
///
/// # Errors
/// Why it is none; `name` is blamed.
pub fn finite_number_of(key: &str, name: &str, text: &str) -> Result<f64, String> {
    finite(number_of(key, text), name, text)
}

/// Reads finite numbers in a unit, as by `--set`; an error blames `name`.
pub fn finite_number_in(
    unit: &'static str,
    name: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| finite(number_in(text, || Ok(unit)), name, text)
}

fn finite(found: Result<f64, String>, name: &str, text: &str) -> Result<f64, String> {
    let found = found.and_then(|value| if value.is_finite() { Ok(value) } else { Err(String::new()) });
    found.map_err(|of_unit| format!("{name} = {text:?} must be a finite number{of_unit}"))
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
pub fn replaces(key: &str, before: &str) -> bool {
    let (table, last) = key.rsplit_once('.').map_or(("", key), |(table, last)| (table, last));
    let beside = |other: &str| if table.is_empty() { other.to_owned() } else { format!("{table}.{other}") };
    contains(key, before) || alternatives(last).any(|other| contains(&beside(other), before))
}

pub fn contains(table: &str, key: &str) -> bool {
    key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_the_prefix_of_a_unit_and_the_unit_of_its_key() {
        for (key, text, expected) in [
            ("load.resistance_ohm", "10M", Some(10e6)),
            ("load.resistance_ohm", "33kΩ", Some(33e3)),
            ("load.resistance_ohm", "4.7 kohm", Some(4700.0)),
            ("load.resistance_ohm", "33kOhm", Some(33e3)),
            ("load.resistance_ohm", "1e3k", Some(1e6)),
            ("load.resistance_ohm", "inf", Some(f64::INFINITY)),
            ("stop.gap_m", "5m", Some(5e-3)),
            ("stop.gap_m", "20u", Some(20e-6)),
            ("stop.gap_m", "20µm", Some(20e-6)),
            ("stop.gap_m", "20 um", Some(20e-6)),
            ("excitation.frequency_hz", "20Hz", Some(20.0)),
            ("excitation.tones.0.frequency_hz", "1kHz", Some(1e3)),
            ("excitation.amplitude_m_per_s2", "0.2g", Some(1.962)),
            ("excitation.amplitude_m_per_s2", "200mg", Some(1.962)),
            ("excitation.amplitude_m_per_s2", "2m/s^2", Some(2.0)),
            ("excitation.amplitude_g", "0.2g", Some(0.2)),
            ("excitation.lines", "1k", Some(1e3)),
            ("parameters.mass_kg", "5g", Some(5e-3)),
            ("parameters.mass_kg", "5mg", Some(5e-6)),
            ("parameters.mass_kg", "0.1kg", Some(0.1)),
            // A prefix of a square is squared.
            ("parameters.electrode_area_m2", "4e-4m2", Some(4e-4)),
            ("parameters.electrode_area_m2", "400mm2", Some(4e-4)),
            ("parameters.electrode_area_m2", "4 cm²", Some(4e-4)),
            ("parameters.electrode_area_m2", "4cm^2", Some(4e-4)),
            ("stop.density_kg_per_m3", "7800 kg/m^3", Some(7800.0)),
            ("parameters.electrode_area_m2", "4km²", None),
            ("parameters.relative_permittivity", "4k1", None),
            ("load.resistance_ohm", "5V", None),
            ("load.resistance_ohm", "2g", None),
            ("load.resistance_ohm", "M", None),
            ("load.resistance_ohm", "10 K", None),
            ("excitation.path", "5m", None),
            ("excitation.column", "5m", None),
            ("no.key", "5m", None),
            // In ohms, amperes or watts.
            ("load.draw.value", "3u", Some(3e-6)),
            ("load.draw.value", "3uW", None),
        ] {
            let found = number_of(key, text).ok();
            let is_same = match (found, expected) {
                (Some(found), Some(expected)) => {
                    found == expected || (found / expected - 1.0_f64).abs() < 1e-15
                }
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(is_same, "{key} = {text}: {found:?}");
        }
        assert_eq!(Override::new("load.resistance_ohm", "33k").value(), "3.3e4");
        assert_eq!(finite_number_in("s", "S")("20 us"), Ok(20e-6));
        assert_eq!(finite_number_in("", "REL")("1m"), Ok(1e-3));
        let refused = finite_number_in("s", "S")("1mV").expect_err("volts");
        assert_eq!(Err(refused), finite_number_of("run.duration_s", "S", "1mV"));
        assert_eq!(Override::new("load.resistance_ohm", "33_000").value(), "33_000");
        assert_eq!(Override::new("excitation.path", "5m").value(), "5m");
    }

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
