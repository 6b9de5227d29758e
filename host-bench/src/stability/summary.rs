//! What became of the cases, as tables for a terminal and a page.

use std::collections::BTreeMap;

use clap::ValueEnum as _;
use comfy_table::presets;

use super::cause::cause;
use super::{Class, Quantity, Row};
use crate::outcome::{name, small, table};

/// The kinds of scenes: the beginning of the name of their shipped scenes.
const KINDS: [&str; 3] = ["contact-separation", "sliding", "bump-stop"];
const PRECISIONS: [&str; 2] = ["f32", "f64"];

/// Counts of each class, of each cause of a named error, how the statements compare with the errors, and each failing
/// case.
pub(crate) fn summary(rows: &[Row]) -> String {
    let failing = rows.iter().filter(|row| row.class.is_failure());
    let lines = failing.map(|row| format!("\n{}: {}\n{}\n", row.number, row.reason, row.arguments));
    let classes = aligned(&classes(rows));
    let causes = causes(rows);
    let causes = if causes.len() > 1 { format!("\n{}", aligned(&causes)) } else { String::new() };
    format!("{classes}{causes}\n{}\n{}", statements(rows), lines.collect::<String>())
}

fn aligned(rows: &[Vec<String>]) -> String {
    rows.split_first().map_or_else(String::new, |(headings, rows)| {
        table(presets::NOTHING, headings.clone(), rows.to_vec(), 1)
    })
}

/// A row for each class, below the headings.
pub(super) fn classes(rows: &[Row]) -> Vec<Vec<String>> {
    let classes = Class::value_variants().iter().map(|class| {
        let these: Vec<&Row> = rows.iter().filter(|row| row.class == *class).collect();
        (name(class).replace('-', " "), these)
    });
    counted("class", classes)
}

/// A row for each cause of a named error, the most frequent first, below the headings.
pub(super) fn causes(rows: &[Row]) -> Vec<Vec<String>> {
    let mut causes: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.class == Class::NamedError) {
        causes.entry(cause(&row.reason)).or_default().push(row);
    }
    let mut causes: Vec<(String, Vec<&Row>)> = causes.into_iter().collect();
    causes.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
    counted("named error", causes)
}

/// The number of the rows of each group by scene and precision, below the headings.
fn counted<'a>(word: &str, groups: impl IntoIterator<Item = (String, Vec<&'a Row>)>) -> Vec<Vec<String>> {
    let columns = || KINDS.iter().flat_map(|kind| PRECISIONS.iter().map(move |precision| (kind, precision)));
    let headings = columns().map(|(kind, precision)| format!("{kind} {precision}"));
    let headings = std::iter::once(word.to_owned()).chain(headings).chain(["all".to_owned()]).collect();
    let lines = groups.into_iter().map(|(group, rows)| {
        let count = |(kind, precision): (&&str, &&str)| {
            let these =
                rows.iter().filter(|row| row.scene.starts_with(*kind) && row.precision == **precision);
            these.count().to_string()
        };
        std::iter::once(group).chain(columns().map(count)).chain([rows.len().to_string()]).collect()
    });
    std::iter::once(headings).chain(lines).collect()
}

/// How the statements compare with the errors, and by what the cases were judged.
pub(super) fn statements(rows: &[Row]) -> String {
    let stated = |row: &&Row| row.quantity == Some(Quantity::Power) && row.stated.is_some();
    let judged: Vec<&Row> = rows.iter().filter(stated).collect();
    let pairs: Vec<(f64, f64)> = judged.iter().filter_map(|row| Some((row.error?, row.stated?))).collect();
    let within = pairs.iter().filter(|(error, stated)| error <= stated).count();
    let mut ratios: Vec<f64> =
        pairs.iter().filter(|(error, _)| *error > 0.0).map(|(error, stated)| stated / error).collect();
    ratios.sort_by(f64::total_cmp);
    let by_reference = judged.iter().filter(|row| row.by_reference).count();
    let motions = rows.iter().filter(|row| row.quantity == Some(Quantity::Motion)).count();
    format!(
        "{} cases with an error and a statement, {by_reference} of them by the reference: {within} errors within the \
         statement; median of statement / error {}. {motions} without power were judged by their motion and voltage.",
        pairs.len(),
        small(ratios.get(ratios.len() / 2).copied()),
    )
}
