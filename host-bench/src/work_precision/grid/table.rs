//! The grid as text.

use comfy_table::presets;

use super::super::table::{grouped, ratio, resistance};
use super::{AGREED, Grid, MET, NEAR, Row, Summary, is_known};
use crate::outcome::{fields, rows_csv, small, table};

const HEADINGS: [&str; 14] = [
    "scene",
    "load",
    "force law",
    "excitation",
    "accuracy",
    "auto: tolerance",
    "error",
    "attempts per simulated s",
    "ns per simulated s",
    "over best",
    "best",
    "its error",
    "its attempts per simulated s",
    "over sure best",
];
/// Columns at the left that hold words.
const WORDS: usize = 4;

impl Row {
    fn cells(&self) -> [String; HEADINGS.len()] {
        let best = match (self.best_method, &self.best_setting) {
            (Some(method), Some(setting)) => format!("{method} {setting}"),
            _ => "none".to_owned(),
        };
        [
            self.scene.to_owned(),
            resistance(self.load_ohm),
            self.force_law.to_owned(),
            self.excitation.to_owned(),
            format!("{:.0e}", self.accuracy),
            format!("{:.1e}", self.auto_tolerance),
            small(Some(self.auto_error)),
            grouped(self.auto_attempts_per_s),
            grouped(self.auto_ns_per_s),
            ratio(self.auto_over_best),
            best,
            small(self.best_error),
            self.best_attempts_per_s.map_or_else(|| "-".to_owned(), grouped),
            ratio(self.auto_over_sure),
        ]
    }
}

impl Summary {
    fn text(&self) -> String {
        format!(
            "Run time of auto over that of the cheapest choice: at most {}, median {}, above {NEAR} in {} of {} \
             rows; at most {} over the cheapest that all finer settings confirm. No choice meets the accuracy in {} rows. The error of auto is more than {MET} times the \
             accuracy in {} rows. In {} rows more the motion is chaotic: the references differ by more than {AGREED} \
             times the accuracy.",
            ratio(self.largest_auto_over_best),
            ratio(self.median_auto_over_best),
            self.above,
            self.compared,
            ratio(self.largest_auto_over_sure),
            self.met_by_none,
            self.missed,
            self.chaotic,
        )
    }
}

/// The table for a terminal, with what it says below.
pub(crate) fn text(grid: &Grid) -> String {
    let table = table(presets::ASCII_MARKDOWN, HEADINGS.to_vec(), grid.rows.iter().map(Row::cells), WORDS);
    let known = grid.rows.iter().filter(|row| is_known(row.cross_check, row.accuracy));
    let largest = known.map(|row| row.cross_check).fold(0.0, f64::max);
    format!(
        "{table}\n{}\nErrors are of the mean power, relative to exponential Radau in f64 at tolerance {:.0e}, from \
         which the independent reference differs by at most {largest:.1e} where it is not chaotic. The cheapest choice is the coarsest \
         setting of a ladder of exponential Radau, TR-BDF2 or RK4 that meets the accuracy with the next finer one. \
         Run times are the shortest of several runs without energy ledger.\n",
        grid.summary.text(),
        super::REFERENCE_TOLERANCE,
    )
}

/// The rows as CSV.
pub(crate) fn csv(grid: &Grid) -> String {
    let rows: Vec<_> = grid.rows.iter().map(fields).collect();
    let columns: Vec<String> = rows.first().map(|row| row.keys().cloned().collect()).unwrap_or_default();
    rows_csv(&columns, &rows)
}
