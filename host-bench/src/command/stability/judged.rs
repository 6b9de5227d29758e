//! Judges a list of cases on all cores. With a file, the row of a case is appended when the case is judged, and a case
//! whose row the file has is not run again. A file with rows of another build is refused.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use super::OUTPUT;
use crate::command::rows::{Kind, Rows};
use crate::command::{one_more, progress};
use crate::method::Failure;
use crate::stability::{Case, Effort, Row, build};

/// A large odd number: its multiples modulo 2⁶⁴ have no order.
const SHUFFLE: u64 = 0x9e37_79b9_7f4a_7c15;

/// The rows of all cases, by number.
pub(super) fn rows(
    cases: &[Case],
    effort: impl Fn(usize) -> Effort + Sync,
    output: Option<&Path>,
) -> Result<Vec<Row>, Failure> {
    let (file, done) = match output {
        Some(path) => taken_up(path, cases).map(|(file, done)| (Some(file), done))?,
        None => (None, BTreeMap::new()),
    };
    let left: Vec<(usize, &Case)> =
        cases.iter().enumerate().filter(|(number, _)| !done.contains_key(number)).collect();
    let bar = progress(left.len());
    let mut groups: Vec<&[(usize, &Case)]> =
        left.chunk_by(|(_, one), (_, other)| one.is_twin_of(other)).collect();
    // Cases of like cost are beside each other: shuffled, the time that is left can be told from the time that is gone.
    groups.sort_by_key(|group| group.first().map_or(0, |(number, _)| (*number as u64).wrapping_mul(SHUFFLE)));
    let new: Result<Vec<Vec<Row>>, Failure> = groups
        .into_par_iter()
        .map(|twins| {
            let number = twins.first().map_or(0, |(number, _)| *number);
            let rows = Row::judged(twins, effort(number));
            rows.iter().for_each(|_| one_more(&bar));
            file.as_ref().map_or(Ok(()), |file| file.append(rows.iter().map(Row::line)))?;
            Ok(rows)
        })
        .collect();
    bar.finish_and_clear();
    let mut rows: Vec<Row> = done.into_values().chain(new?.into_iter().flatten()).collect();
    rows.sort_by_key(|row| row.number);
    Ok(rows)
}

/// The rows of a file that an earlier run began. A file that is not there is made, with its heading.
fn taken_up(path: &Path, cases: &[Case]) -> Result<(Rows, BTreeMap<usize, Row>), Failure> {
    let heading = Row::heading();
    let kind = Kind {
        option: OUTPUT,
        heading: heading.trim_end(),
        earlier: heading.trim_end(),
        other: "must be a file of stability, or not be there",
    };
    let read = |line: &str| {
        let row = Row::read(&format!("{heading}{line}\n")).ok()?.pop()?;
        Some((row.number, row))
    };
    Rows::open(path, kind, read, |rows| {
        let is_another =
            |row: &&Row| cases.get(row.number).is_none_or(|case| case.arguments() != row.arguments);
        if let Some(row) = rows.values().find(|row| row.build != build()) {
            let [other, own] = [row.build.as_str(), build()];
            let rest = "remove it or give another file";
            return Err(format!("has rows of another build ({other}, this one is {own}): {rest}"));
        }
        match rows.values().find(is_another) {
            Some(row) => Err(format!("has another case {} than this list of cases", row.number)),
            None => Ok(()),
        }
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::stability::{draw, fnv_1a};

    /// Few attempts: most of these cases are given up at once.
    const EFFORT: Effort = Effort { most_attempts: 10, by_reference: false };

    fn cases(seed: u64) -> Vec<Case> {
        (0..4).map(|number| draw(seed, number)).collect()
    }

    #[test]
    fn a_file_is_taken_up_without_a_line_that_is_not_whole() {
        let path = std::env::temp_dir().join(format!("judged-cases-{}.csv", std::process::id()));
        let _ = fs::remove_file(&path);
        let all = rows(&cases(3), |_| EFFORT, Some(&path)).expect("the file was made");
        assert!(all.iter().map(|row| row.number).eq(0..4));
        // The order in the file is that in which the cases were judged.
        let text = fs::read_to_string(&path).expect("is there");
        let (whole, last) = text.trim_end().rsplit_once('\n').expect("has rows");
        let taken_up = |seed: u64| {
            let rows = super::taken_up(&path, &cases(seed));
            rows.map(|(_, rows)| rows.len()).map_err(|error| error.to_string())
        };
        fs::write(&path, format!("{whole}\n{}", &last[..5])).expect("is writable");
        assert_eq!(taken_up(3), Ok(3));
        assert_eq!(fs::read_to_string(&path).expect("is there"), format!("{whole}\n"));
        assert_eq!(rows(&cases(3), |_| EFFORT, Some(&path)), Ok(all));
        assert!(taken_up(4).is_err_and(|told| told.contains("another case")));
        let of_another = |line: &str| {
            let row = line.rsplit_once(',').expect("a checksum").0.replace(build(), "0.0.9-unknown");
            format!("{row},{:016x}\n", fnv_1a(row.as_bytes()))
        };
        let text = fs::read_to_string(&path).expect("is there");
        let (heading, lines) = text.split_once('\n').expect("a heading");
        fs::write(&path, format!("{heading}\n{}", lines.lines().map(of_another).collect::<String>()))
            .expect("is writable");
        let other = taken_up(3).expect_err("another build");
        assert!(other.contains("rows of another build (0.0.9-unknown, "), "{other}");
        fs::write(&path, "a,b\n1,2\n").expect("is writable");
        assert!(taken_up(3).is_err());
        let _ = fs::remove_file(&path);
    }
}
