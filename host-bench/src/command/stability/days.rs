//! `stability --day`: a day of each shipped scene in single against double precision.

use comfy_table::presets;
use rayon::prelude::*;

use crate::command::{one_more, print, progress};
use crate::method::Failure;
use crate::outcome::{Format, Outcome};
use crate::rows::Rows;
use crate::stability::{COLUMNS, Compared, DAY_S, Kind, pairs};

/// Runs all pairs on all cores and prints them.
///
/// # Errors
/// If a run does not come to its end, or if a pair differs by more than it claims.
pub(super) fn run(kind: Option<Kind>, format: Format) -> Result<(), Failure> {
    let pairs = pairs(kind, DAY_S);
    let runs: Vec<(usize, usize)> =
        (0..pairs.len()).flat_map(|pair| [0, 1].map(|precision| (pair, precision))).collect();
    let bar = progress(runs.len());
    // One task each, and not a slice of the list: some take a hundred times as long as others.
    let outcomes: Result<Vec<Outcome>, Failure> = runs
        .into_par_iter()
        .with_max_len(1)
        .map(|(pair, precision)| {
            let outcome = pairs[pair].run(precision);
            one_more(&bar);
            outcome
        })
        .collect();
    bar.finish_and_clear();
    let outcomes = outcomes?;
    let both = outcomes.chunks_exact(2).zip(&pairs);
    let rows: Result<Vec<Compared>, Failure> =
        both.map(|(runs, pair)| pair.compared([&runs[0], &runs[1]])).collect();
    let rows = rows?;
    print(&Rows::of(&rows).text(format, |rows| rows.table(presets::NOTHING, &COLUMNS, 2)))?;
    let apart = rows.iter().filter(|row| !row.agrees()).count();
    if apart == 0 {
        Ok(())
    } else {
        Err(Failure::Step(format!("{apart} of {} pairs differ by more than they claim", rows.len())))
    }
}
