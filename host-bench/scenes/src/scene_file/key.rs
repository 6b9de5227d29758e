//! The tables of the keys of a scene file: unit, bounds, default and meaning of each.
//!
//! The readers check by these tables; the pages about the keys, the templates and the schema are made of them.

use std::fmt;

use model_core::bounds::Bounds;

/// A key of a scene file.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name, with the unit.
    pub name: &'static str,
    /// Unit of its value; empty where it has none.
    pub unit: &'static str,
    /// What its value may be.
    pub value: Value,
    /// What holds where it is not given.
    pub default: Default,
    /// The key that gives the same quantity otherwise: only one of the two may be given.
    pub instead_of: Option<&'static str>,
    /// A bound by other keys; empty where there is none.
    pub limit: &'static str,
    /// One line.
    pub meaning: &'static str,
}

/// What the value of a key may be.
#[derive(Debug, Clone, Copy)]
pub enum Value {
    Number(Bounds<f64>),
    /// A number, 0 or infinity.
    NumberOrLimits(Bounds<f64>),
    /// A whole number.
    Whole(Bounds<f64>),
    /// One of a few whole numbers.
    Among(&'static [usize]),
    /// A list of numbers, one for each of these.
    Numbers(Bounds<f64>, &'static str),
    /// A list of pairs of a frequency in Hz and a number, from two to so many.
    Points(Bounds<f64>, usize),
    /// One of a few words.
    Words(&'static [&'static str]),
    /// The word of a part of the market, one of these.
    Part(fn() -> Vec<&'static str>),
    /// `true` or `false`.
    Flag,
    Text,
    /// A list of texts.
    Texts,
    /// A list of `KEY` or `KEY=LOW:HIGH`, or a table of the keys with `true` or `[LOW, HIGH]`.
    FreeKeys,
    /// A column by its name or its number.
    Column(Bounds<f64>),
    /// A column, or `false` for none.
    ColumnOrFalse(Bounds<f64>),
    Table(&'static Table),
    /// A list of tables, at least one.
    Tables(&'static Table),
}

/// What holds where a key is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Default {
    /// It must be given.
    Required,
    Number(f64),
    Flag(bool),
    /// What the text says.
    Said(&'static str),
}

/// A table of a scene file.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// Keys of every kind.
    pub keys: &'static [Key],
    /// The key that says the kind; empty where there is one kind only.
    pub selector: &'static str,
    pub kinds: &'static [&'static Kind],
}

/// A kind of a table.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// The value of the selector.
    pub word: &'static str,
    /// Its keys, beside those of every kind.
    pub keys: &'static [Key],
    /// One line.
    pub meaning: &'static str,
}

impl Table {
    /// A table of one kind.
    pub(super) const fn of(keys: &'static [Key]) -> Self {
        Self { keys, selector: "", kinds: &[] }
    }

    /// A table whose key `kind` says its kind.
    pub(super) const fn of_kinds(kinds: &'static [&'static Kind]) -> Self {
        Self { keys: &[], selector: "kind", kinds }
    }

    pub fn kind(&self, word: &str) -> Option<&'static Kind> {
        self.kinds.iter().copied().find(|kind| kind.word == word)
    }

    /// The key with this name, of the given kind if it is not of every one.
    pub fn key(&self, name: &str, kind: Option<&Kind>) -> Option<&'static Key> {
        let of_kind = kind.map_or(&[][..], |kind| kind.keys);
        of_kind.iter().chain(self.keys).find(|key| key.name == name)
    }
}

const fn key(name: &'static str, unit: &'static str, value: Value, meaning: &'static str) -> Key {
    Key { name, unit, value, default: Default::Required, instead_of: None, limit: "", meaning }
}

/// A number that must be given.
pub(super) const fn number(
    name: &'static str,
    unit: &'static str,
    bounds: Bounds<f64>,
    meaning: &'static str,
) -> Key {
    key(name, unit, Value::Number(bounds), meaning)
}

/// A whole number that must be given.
pub(super) const fn whole(
    name: &'static str,
    unit: &'static str,
    bounds: Bounds<f64>,
    meaning: &'static str,
) -> Key {
    key(name, unit, Value::Whole(bounds), meaning)
}

/// A value without a unit that must be given.
pub(super) const fn other(name: &'static str, value: Value, meaning: &'static str) -> Key {
    key(name, "", value, meaning)
}

impl Key {
    /// What its value may be, in words.
    pub(crate) fn bounds(&self) -> String {
        let value = match self.value {
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
        if self.limit.is_empty() { value } else { format!("{value}; {}", self.limit) }
    }

    /// The table that follows it.
    pub(crate) fn table(&self) -> Option<&'static Table> {
        match self.value {
            Value::Table(table) | Value::Tables(table) => Some(table),
            _ => None,
        }
    }

    pub(super) const fn or(mut self, default: Default) -> Self {
        self.default = default;
        self
    }

    pub(super) const fn or_number(self, default: f64) -> Self {
        self.or(Default::Number(default))
    }

    pub(super) const fn or_said(self, default: &'static str) -> Self {
        self.or(Default::Said(default))
    }

    pub(super) const fn instead_of(mut self, other: &'static str) -> Self {
        self.instead_of = Some(other);
        self
    }

    pub(super) const fn limit(mut self, limit: &'static str) -> Self {
        self.limit = limit;
        self
    }

    pub(super) const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }
}

/// What a host has of the rows of a macro of numbers of the core, such as `model_core::contact_separation_numbers`: a part of
/// the table of keys, a struct, what reads it from a section, the core's struct from it, or its numbers by the core's names.
#[doc(hidden)]
#[macro_export]
macro_rules! of_rows {
    (keys [$($field:tt $key:ident
        ($unit:literal $meaning:literal $lowest:literal $highest:literal $($limit:literal)?);)+]) => {
        [$(number(stringify!($key), $unit, between($lowest, $highest), $meaning)$(.limit($limit))?),+]
    };
    ($(#[$meta:meta])* $visible:vis struct $name:ident { $($rest:tt)* }
    [$($field:tt $key:ident ($unit:literal $meaning:literal $($bounds:tt)*);)+]) => {
        $(#[$meta])*
        $visible struct $name {
            $(#[doc = concat!($meaning, "; unit ", $unit, ".")]
            pub $key: f64,)+
            $($rest)*
        }
    };
    (read $section:ident $($name:ident)::+ { $($rest:tt)* } [$($field:tt $key:ident $meaning:tt;)+]) => {
        $($name)::+ { $($key: $section.number(stringify!($key))?,)+ $($rest)* }
    };
    (core $from:ident $name:ident { $($rest:tt)* } [$(($field:ident) $key:ident $meaning:tt;)+]) => {
        $name { $($field: S::from_f64($from.$key),)+ $($rest)* }
    };
    (names $from:ident [$(($field:ident) $key:ident $meaning:tt;)+]) => {
        [$((stringify!($field), $from.$key)),+]
    };
}
pub(super) use of_rows;

/// The keys of some lists, in their order.
pub(super) const fn joined<const N: usize>(lists: &[&[Key]]) -> [Key; N] {
    let mut all = [lists[0][0]; N];
    let (mut list, mut row, mut index) = (0, 0, 0);
    while index < N {
        if row == lists[list].len() {
            (list, row) = (list + 1, 0);
        }
        all[index] = lists[list][row];
        (row, index) = (row + 1, index + 1);
    }
    assert!(list + 1 == lists.len() && row == lists[list].len());
    all
}

pub(super) const fn words<T: Copy, const N: usize>(choices: &[(&'static str, T); N]) -> [&'static str; N] {
    let mut words = [""; N];
    let mut index = 0;
    while index < N {
        words[index] = choices[index].0;
        index += 1;
    }
    words
}

/// The bounds that the core has for one of its parameters, by the name that the core's errors have.
pub(super) const fn core(table: CoreTable, name: &str) -> Bounds<f64> {
    let mut index = 0;
    while index < table.len() {
        if same(table[index].0, name) {
            return table[index].1;
        }
        index += 1;
    }
    panic!("the core has no parameter of this name")
}

/// Whether two texts are the same, where the compiler computes.
const fn same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

/// Shows all keys of a table and of the tables in it.
pub fn walk(table: &'static Table, seen: &mut dyn FnMut(&'static Key)) {
    let of_kinds = table.kinds.iter().flat_map(|kind| kind.keys);
    for key in of_kinds.chain(table.keys) {
        seen(key);
        key.table().into_iter().for_each(|inner| walk(inner, seen));
    }
}

/// The core's names of parameters and their bounds in SI units.
pub(super) type CoreTable = &'static [(&'static str, Bounds<f64>)];

pub(super) const fn between(lowest: f64, highest: f64) -> Bounds<f64> {
    Bounds { lowest, highest }
}

/// The values that a key may have, ends included.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    pub(crate) range: Bounds<f64>,
    /// Whether 0 and infinity are allowed beside the range.
    or_limits: bool,
}

impl Bound {
    /// Nothing is within.
    pub(super) const NOTHING: Self = Self { range: between(f64::NAN, f64::NAN), or_limits: false };

    /// The bound of each number of a key's value; nothing is within that of a key which is no number.
    pub(crate) fn of(key: &Key) -> Self {
        let (range, or_limits) = match key.value {
            Value::NumberOrLimits(range) => (range, true),
            Value::Number(range)
            | Value::Whole(range)
            | Value::Numbers(range, _)
            | Value::Points(range, _)
            | Value::Column(range)
            | Value::ColumnOrFalse(range) => (range, false),
            _ => return Self::NOTHING,
        };
        Self { range, or_limits }
    }

    /// Whether the value is allowed; not-a-number never is.
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.range.lowest..=self.range.highest).contains(&value)
            || self.or_limits && (value == 0.0 || value == f64::INFINITY)
    }
}

impl From<Bounds<f64>> for Bound {
    fn from(range: Bounds<f64>) -> Self {
        Self { range, or_limits: false }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = if self.or_limits { "0, inf, or " } else { "" };
        let Bounds { lowest, highest } = self.range;
        write!(f, "{limits}a number from {} to {}", Short(lowest), Short(highest))
    }
}

/// A number as short as it can be written exactly.
pub(crate) struct Short(pub(crate) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (plain, scientific) = (self.0.to_string(), format!("{:e}", self.0));
        write!(f, "{}", if plain.len() <= scientific.len() { plain } else { scientific })
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

pub(crate) fn quoted(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
    quoted.join(", ")
}
