//! What became of the cases, as tables for a terminal and a page.

use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::{env, fs};

use clap::ValueEnum as _;
use comfy_table::presets;

use super::{Case, Class, Effort, Finding, Judge, Quantity};
use crate::outcome::{cell, csv_line, fields, name, small, table};

/// The kinds of scenes: the beginning of the name of their shipped scenes.
const KINDS: [&str; 3] = ["contact-separation", "sliding", "bump-stop"];
const PRECISIONS: [&str; 2] = ["f32", "f64"];

/// Counts of each class, of each cause of a named error, how the statements compare with the errors, and each failing case.
pub(crate) fn summary(rows: &[Finding]) -> String {
    let failing = rows.iter().filter(|row| row.class.is_failure());
    let lines = failing.map(|row| format!("\n{}: {}\n{}\n", row.number, row.reason, row.arguments));
    let classes = aligned(&classes(rows));
    let causes = causes(rows);
    let causes = if causes.len() > 1 { format!("\n{}", aligned(&causes)) } else { String::new() };
    format!("{classes}{causes}\n{}\n{}", aligned(&statements(rows)), lines.collect::<String>())
}

fn aligned(rows: &[Vec<String>]) -> String {
    rows.split_first().map_or_else(String::new, |(headings, rows)| {
        table(presets::NOTHING, headings.clone(), rows.to_vec(), 1)
    })
}

/// A row for each class, below the headings.
pub(super) fn classes(rows: &[Finding]) -> Vec<Vec<String>> {
    let classes = Class::value_variants().iter().map(|class| {
        let these: Vec<&Finding> = rows.iter().filter(|row| row.class == *class).collect();
        (name(class).replace('-', " "), these)
    });
    counted("class", classes)
}

/// A row for each cause of a named error, the most frequent first, below the headings.
pub(super) fn causes(rows: &[Finding]) -> Vec<Vec<String>> {
    let mut causes: BTreeMap<String, Vec<&Finding>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.class == Class::NamedError) {
        causes.entry(cause(&row.reason)).or_default().push(row);
    }
    let mut causes: Vec<(String, Vec<&Finding>)> = causes.into_iter().collect();
    causes.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
    counted("named error", causes)
}

/// The columns of scenes and precisions, and of all.
fn columns() -> impl Iterator<Item = Option<(&'static str, &'static str)>> {
    let pairs = KINDS.into_iter().flat_map(|kind| PRECISIONS.map(|precision| Some((kind, precision))));
    pairs.chain([None])
}

/// Whether a row belongs to a column.
fn stands_in(row: &Finding, column: Option<(&str, &str)>) -> bool {
    column.is_none_or(|(kind, precision)| row.scene.starts_with(kind) && row.precision == precision)
}

/// A heading for each column, a word before them.
fn headings(word: &str) -> Vec<String> {
    let name = |column: Option<(&str, &str)>| {
        column.map_or_else(|| "all".to_owned(), |(kind, precision)| format!("{kind} {precision}"))
    };
    std::iter::once(word.to_owned()).chain(columns().map(name)).collect()
}

/// The number of the rows of each group by scene and precision, below the headings.
fn counted<'a>(word: &str, groups: impl IntoIterator<Item = (String, Vec<&'a Finding>)>) -> Vec<Vec<String>> {
    let lines = groups.into_iter().map(|(group, rows)| {
        let count = |column| rows.iter().filter(|row| stands_in(row, column)).count().to_string();
        std::iter::once(group).chain(columns().map(count)).collect()
    });
    std::iter::once(headings(word)).chain(lines).collect()
}

/// Errors below which a warning of the accuracy is a false one, and above which statements are compared with them.
const COMPARED: [f64; 2] = [5e-4, 1e-5];

/// How the statements compare with the errors, by scene and precision, below the headings.
pub(super) fn statements(rows: &[Finding]) -> Vec<Vec<String>> {
    let judged: Vec<&Finding> = rows
        .iter()
        .filter(|row| row.quantity == Some(Quantity::Power) && row.error.is_some_and(f64::is_finite))
        .collect();
    let line = |name: &str, value: &dyn Fn(&[&Finding]) -> String| {
        let of =
            |column| value(&judged.iter().copied().filter(|row| stands_in(row, column)).collect::<Vec<_>>());
        std::iter::once(name.to_owned()).chain(columns().map(of)).collect()
    };
    let [false_below, above] = COMPARED;
    let error = |row: &Finding| row.error.unwrap_or(0.0);
    let share = |part: usize, of: usize| {
        if of == 0 { "-".to_owned() } else { format!("{:.1} %", 100.0 * part as f64 / of as f64) }
    };
    let warned = |rows: &[&Finding]| -> Vec<f64> {
        rows.iter().filter(|row| row.is_warned).map(|row| error(row)).collect()
    };
    let ratio = |part: f64| {
        move |rows: &[&Finding]| {
            let compared = rows.iter().filter(|row| error(row) > above);
            quantile(part, compared.filter_map(|row| Some(row.stated? / error(row))))
        }
    };
    let work = |chaotic: bool, part: f64| {
        move |rows: &[&Finding]| {
            quantile(part, rows.iter().filter(|row| row.is_chaotic == chaotic).map(|row| row.work))
        }
    };
    vec![
        headings("statements of the mean power"),
        line("judged", &|rows| rows.len().to_string()),
        line("inside", &|rows| {
            let inside = rows.iter().filter(|row| row.stated.is_some_and(|stated| error(row) <= stated));
            share(inside.count(), rows.len())
        }),
        line("unknown", &|rows| rows.iter().filter(|row| row.stated.is_none()).count().to_string()),
        line("statement / error, median", &ratio(0.5)),
        line("90th percentile", &ratio(0.9)),
        line("warned", &|rows| warned(rows).len().to_string()),
        line("of them right to 5e-4", &|rows| {
            let warned = warned(rows);
            share(warned.iter().filter(|error| **error < false_below).count(), warned.len())
        }),
        line("chaotic", &|rows| rows.iter().filter(|row| row.is_chaotic).count().to_string()),
        line("work of a statement, in runs: median", &work(false, 0.5)),
        line("95th percentile", &work(false, 0.95)),
        line("largest of a chaotic motion", &work(true, 1.0)),
    ]
}

/// The value below which a part of some values lies, in two digits.
fn quantile(part: f64, values: impl Iterator<Item = f64>) -> String {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    small(values.get((part * last as f64).round() as usize).copied())
}

/// The beginning of a named error, and the cause in words.
const CAUSES: [(&str, &str); 4] = [
    ("displacement = ", "left the overlap of the patches"),
    ("gap coordinate = ", "the motion of the beam grew beyond every number"),
    ("the step shrank to nothing", "step underflow"),
    ("events follow one another without end", "events without end"),
];

/// The cause of a named error of a run, in words.
pub fn cause(reason: &str) -> String {
    let known = CAUSES.iter().find(|(beginning, _)| reason.starts_with(beginning));
    // Of an error without a cause here, the words before its first number.
    let words = || reason.split(" at ").next().unwrap_or(reason).to_owned();
    known.map_or_else(words, |(_, cause)| (*cause).to_owned())
}

// A judged case as a row of CSV and an object of JSON, and the program: rows of different builds must not be mixed.

impl Finding {
    /// Judges cases that differ in nothing but precision; each has its number.
    pub(crate) fn judged(twins: &[(usize, &Case)], effort: Effort) -> Vec<Self> {
        let Some((_, first)) = twins.first() else { return Vec::new() };
        let judge = Judge::new(first, effort);
        let row = |&(number, case): &(usize, &Case)| {
            let finding = judge.finding(case.precision);
            // A row is one line.
            let reason = finding.reason.replace(char::is_control, " ");
            let [scene, precision, build] = [case.scene, case.precision.name(), build()].map(str::to_owned);
            Self { number, scene, precision, reason, arguments: case.arguments(), build, ..finding }
        };
        twins.iter().map(row).collect()
    }

    pub(crate) fn heading() -> String {
        csv_line(fields(&Self::default()).into_iter().map(|(name, _)| name))
    }

    /// Its line of CSV without the line break.
    pub(crate) fn line(&self) -> String {
        self.csv().trim_end_matches('\n').to_owned()
    }

    pub(crate) fn csv(&self) -> String {
        csv_line(fields(self).values().map(cell))
    }

    /// The rows of a table of CSV with the heading of [`Finding::heading`].
    pub(crate) fn read(text: &str) -> Result<Vec<Self>, String> {
        let rows: Result<Vec<Self>, _> = csv::Reader::from_reader(text.as_bytes()).deserialize().collect();
        rows.map_err(|error| error.to_string())
    }
}

/// Offset and prime of the 64-bit hash of Fowler, Noll and Vo (FNV-1a).
const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0100_0000_01b3;

/// The version, and a hash of the executable file; `unknown` in its place if the file cannot be read.
pub(crate) fn build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        let content = env::current_exe().and_then(fs::read);
        let hash =
            content.map_or_else(|_| "unknown".to_owned(), |content| format!("{:016x}", fnv_1a(&content)));
        format!("{}-{hash}", env!("CARGO_PKG_VERSION"))
    })
}

pub(crate) fn fnv_1a(content: &[u8]) -> u64 {
    content.iter().fold(OFFSET, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::super::{Case, Class, Effort, judge};
    use super::*;
    use crate::method::Precision;

    #[test]
    fn a_slider_that_is_shaken_too_much_leaves_the_overlap() {
        let changes = [
            "parameters.kinetic_friction_active=0",
            "parameters.kinetic_friction_inert=0",
            "excitation.amplitude_m_per_s2=30",
            "run={duration_s=0.5,settle_s=0}",
        ];
        let effort = Effort { most_attempts: 100_000, by_reference: false, chaotic_pairs: 16 };
        let found = judge(&Case::of("sliding", &changes, Precision::F64), effort);
        assert_eq!(found.class, Class::NamedError, "{found:?}");
        assert_eq!(cause(&found.reason), "left the overlap of the patches");
    }

    #[test]
    fn an_unknown_error_is_its_own_cause() {
        assert_eq!(cause("the store is flat at 0.5 s: gap_m 1e-3"), "the store is flat");
    }

    #[test]
    fn a_row_survives_its_line() {
        let row = Finding {
            number: 7,
            scene: "sliding".to_owned(),
            precision: "f32".to_owned(),
            class: Class::NamedError,
            quantity: None,
            error: None,
            stated: Some(0.25),
            is_warned: true,
            by_reference: false,
            is_chaotic: false,
            work: 2.0,
            reason: "a, \"b\"".to_owned(),
            arguments: "run x --set 'load={kind=\"dc-bus\"}'".to_owned(),
            build: "0.1.0-0123".to_owned(),
        };
        let columns = "number,scene,precision,class,quantity,error,stated,is_warned,by_reference,is_chaotic,work,reason,arguments,build\n";
        assert_eq!(Finding::heading(), columns);
        let judged =
            Finding { number: 8, quantity: Some(Quantity::Motion), error: Some(1e-3), ..row.clone() };
        let text = Finding::heading() + &row.csv() + &judged.csv();
        assert_eq!(Finding::read(&text), Ok(vec![row, judged]));
        assert!(Finding::read("a,b\n1,2\n").is_err());
    }

    #[test]
    fn the_hash_is_the_published_one_and_the_program_has_it() {
        // Test vectors of the authors.
        let vectors = [("", OFFSET), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)];
        for (text, hash) in vectors {
            assert_eq!(fnv_1a(text.as_bytes()), hash, "{text}");
        }
        assert!(
            build().starts_with(env!("CARGO_PKG_VERSION")) && !build().ends_with("unknown"),
            "{}",
            build()
        );
    }
}
