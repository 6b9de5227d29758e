//! A judged case as a row of CSV and an object of JSON, and the identity of the program: rows of different builds do not
//! belong to one result.

use std::sync::OnceLock;
use std::{env, fs};

use serde::{Deserialize, Serialize};

use super::{Case, Class, Effort, Finding, Judge, Quantity};
use crate::outcome::{cell, csv_line, fields};

/// A case with what became of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Number of the case in its list.
    pub(crate) number: usize,
    pub(crate) scene: String,
    pub(crate) precision: String,
    pub(crate) class: Class,
    /// What was compared.
    pub(crate) quantity: Option<Quantity>,
    /// Relative error of the quantity.
    pub(crate) error: Option<f64>,
    /// The statement of the relative error of the mean power.
    pub(crate) stated: Option<f64>,
    pub(crate) is_warned: bool,
    pub(crate) by_reference: bool,
    pub(crate) is_chaotic: bool,
    /// Steps of the runs of the statement over those of the run.
    pub(crate) work: f64,
    pub(crate) reason: String,
    /// The arguments with which the command line runs the case.
    pub(crate) arguments: String,
    /// The program that judged it, as by [`build`](build).
    pub(crate) build: String,
}

impl Row {
    /// Judges cases that differ in nothing but precision; each has its number.
    pub(crate) fn judged(twins: &[(usize, &Case)], effort: Effort) -> Vec<Self> {
        let Some((_, first)) = twins.first() else { return Vec::new() };
        let judge = Judge::new(first, effort);
        let row = |&(number, case): &(usize, &Case)| Self::of(number, case, judge.finding(case.precision));
        twins.iter().map(row).collect()
    }

    fn of(number: usize, case: &Case, finding: Finding) -> Self {
        let Finding { class, quantity, error, stated, is_warned, by_reference, is_chaotic, work, reason } =
            finding;
        Self {
            number,
            scene: case.scene.to_owned(),
            precision: case.precision.name().to_owned(),
            class,
            quantity,
            error,
            stated,
            is_warned,
            by_reference,
            is_chaotic,
            work,
            // A row is one line.
            reason: reason.replace(char::is_control, " "),
            arguments: case.arguments(),
            build: build().to_owned(),
        }
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

    /// The rows of a table of CSV with the heading of [`Row::heading`].
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

/// The 64-bit hash FNV-1a.
pub(crate) fn fnv_1a(content: &[u8]) -> u64 {
    content.iter().fold(OFFSET, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_survives_its_line() {
        let row = Row {
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
        assert_eq!(Row::heading(), columns);
        let judged = Row { number: 8, quantity: Some(Quantity::Motion), error: Some(1e-3), ..row.clone() };
        let text = Row::heading() + &row.csv() + &judged.csv();
        assert_eq!(Row::read(&text), Ok(vec![row, judged]));
        assert!(Row::read("a,b\n1,2\n").is_err());
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
