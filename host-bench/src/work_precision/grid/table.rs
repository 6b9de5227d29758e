//! The grid as text.

use comfy_table::presets;

use super::super::table::{grouped, ratio, resistance};
use super::{AGREED, Grid, MET, NEAR, Row, Summary, is_known};
use crate::rows::{Column, Digits, Rows};

const COLUMNS: [Column<'_>; 14] = [
    ("scene", "scene", Digits::Word),
    ("load", "load_ohm", Digits::By(resistance)),
    ("force law", "force_law", Digits::Word),
    ("excitation", "excitation", Digits::Word),
    ("accuracy", "accuracy", Digits::Exponent(0)),
    ("auto: tolerance", "auto_tolerance", Digits::Exponent(1)),
    ("error", "auto_error", Digits::Exponent(1)),
    ("attempts per simulated s", "auto_attempts_per_s", Digits::By(grouped)),
    ("ns per simulated s", "auto_ns_per_s", Digits::By(grouped)),
    ("over best", "auto_over_best", OVER),
    ("best", "best", Digits::Word),
    ("its error", "best_error", Digits::Exponent(1)),
    ("its attempts per simulated s", "best_attempts_per_s", Digits::By(grouped)),
    ("over sure best", "auto_over_sure", OVER),
];
/// Columns at the left that hold words.
const WORDS: usize = 4;
/// A ratio of run times.
const OVER: Digits = Digits::By(|value| ratio(Some(value)));

impl Row {
    /// The cheapest choice.
    fn best(&self) -> String {
        match (self.best_method, &self.best_setting) {
            (Some(method), Some(setting)) => format!("{method} {setting}"),
            _ => "none".to_owned(),
        }
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
    let mut rows = Rows::of(&grid.rows);
    for (shown, row) in rows.0.iter_mut().zip(&grid.rows) {
        shown.insert("best".to_owned(), row.best().into());
    }
    let table = rows.table(presets::ASCII_MARKDOWN, &COLUMNS, WORDS);
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
    Rows::of(&grid.rows).csv()
}
