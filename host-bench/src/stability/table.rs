//! Counts of classes by group, as a table for a terminal.

use clap::ValueEnum;
use comfy_table::presets;

use crate::outcome::{name, table};

/// A quantity of which the largest value in a group is printed: its heading, its value and how it is printed.
pub(super) type Largest<F> = (&'static str, fn(&F) -> Option<f64>, fn(Option<f64>) -> String);

/// A table with a row for each group of findings: the words that name the group, the number of findings of each class,
/// and the largest values.
pub(super) fn counts<F, C: ValueEnum + PartialEq, const W: usize>(
    words: [&str; W],
    groups: Vec<([String; W], Vec<&F>)>,
    class: fn(&F) -> C,
    largest: [Largest<F>; 2],
) -> String {
    let classes = C::value_variants();
    let headings = words.into_iter().map(str::to_owned).chain(classes.iter().map(name));
    let headings: Vec<String> =
        headings.chain(largest.iter().map(|(heading, ..)| (*heading).to_owned())).collect();
    let rows = groups.into_iter().map(|(words, findings)| {
        let of = |wanted: &C| findings.iter().filter(|finding| class(finding) == *wanted).count().to_string();
        let largest = largest
            .iter()
            .map(|(_, of, shown)| shown(findings.iter().filter_map(|finding| of(finding)).reduce(f64::max)));
        words.into_iter().chain(classes.iter().map(of)).chain(largest).collect::<Vec<String>>()
    });
    table(presets::ASCII_MARKDOWN, headings, rows, 2)
}
