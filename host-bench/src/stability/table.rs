//! Counts of classes by group, as a table for a terminal.

use comfy_table::{CellAlignment, Table, presets};

/// A quantity of which the largest value in a group is printed.
pub(super) struct Largest<F> {
    pub(super) heading: &'static str,
    pub(super) of: fn(&F) -> Option<f64>,
    pub(super) shown: fn(Option<f64>) -> String,
}

/// A table with a row for each group of findings: the words that name the group, the number of findings of each class,
/// and the largest values.
pub(super) fn counts<F, C: Copy + PartialEq, const N: usize, const W: usize>(
    words: [&str; W],
    groups: Vec<([String; W], Vec<&F>)>,
    (classes, class): ([C; N], fn(&F) -> C),
    name: fn(C) -> &'static str,
    largest: [Largest<F>; 2],
) -> String {
    let mut table = Table::new();
    let headings = words.into_iter().chain(classes.map(name)).chain(largest.iter().map(|one| one.heading));
    table.load_style(presets::ASCII_MARKDOWN).set_header(headings);
    for (words, findings) in groups {
        let of = |wanted: C| findings.iter().filter(|finding| class(finding) == wanted).count().to_string();
        let largest = largest.iter().map(|one| {
            let values = findings.iter().filter_map(|finding| (one.of)(finding));
            (one.shown)(values.reduce(f64::max))
        });
        table.add_row(words.into_iter().chain(classes.map(of)).chain(largest));
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}
