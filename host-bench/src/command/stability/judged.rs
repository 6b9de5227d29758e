//! Judges a list of cases on all cores. With a file, the row of a case is appended when the case is judged, and a case
//! whose row the file has is not run again. A file with rows of another build is refused.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::OUTPUT;
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
    let mut rows = output.map_or_else(|| Ok(Vec::new()), |path| taken_up(path, cases))?;
    let file = output.map(Appended::open).transpose()?;
    let done: BTreeSet<usize> = rows.iter().map(|row| row.number).collect();
    let left: Vec<(usize, &Case)> =
        cases.iter().enumerate().filter(|(number, _)| !done.contains(number)).collect();
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
            file.as_ref().map_or(Ok(()), |file| file.append(&rows))?;
            Ok(rows)
        })
        .collect();
    bar.finish_and_clear();
    rows.extend(new?.into_iter().flatten());
    rows.sort_by_key(|row| row.number);
    Ok(rows)
}

/// The rows of a file that an earlier run began; its last line is removed if it is not whole. A file that is not
/// there is made, with its heading.
fn taken_up(path: &Path, cases: &[Case]) -> Result<Vec<Row>, Failure> {
    let heading = Row::heading();
    let write = |text: &str| {
        fs::write(path, text).map_err(|error| refuse(path, format!("cannot be written: {error}")))
    };
    if !path.exists() {
        write(&heading)?;
        return Ok(Vec::new());
    }
    let text = fs::read_to_string(path).map_err(|error| refuse(path, format!("cannot be read: {error}")))?;
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    if !whole.starts_with(&heading) {
        return Err(refuse(path, "must be a file of stability, or not be there".to_owned()));
    }
    let rows = Row::read(whole).map_err(|error| refuse(path, error))?;
    let is_another = |row: &&Row| cases.get(row.number).is_none_or(|case| case.arguments() != row.arguments);
    if let Some(row) = rows.iter().find(is_another) {
        return Err(refuse(path, format!("has another case {} than this list of cases", row.number)));
    }
    if let Some(row) = rows.iter().find(|row| row.build != build()) {
        let reason = format!(
            "has rows of another build ({}, this one is {}): remove it or give another file",
            row.build,
            build()
        );
        return Err(refuse(path, reason));
    }
    if whole.len() < text.len() {
        write(whole)?;
    }
    Ok(rows)
}

/// A file to which rows are appended.
struct Appended<'a> {
    path: &'a Path,
    file: Mutex<File>,
}

impl<'a> Appended<'a> {
    fn open(path: &'a Path) -> Result<Self, Failure> {
        let file = OpenOptions::new().append(true).open(path);
        let file = file.map_err(|error| refuse(path, format!("cannot be written: {error}")))?;
        Ok(Self { path, file: Mutex::new(file) })
    }

    fn append(&self, rows: &[Row]) -> Result<(), Failure> {
        let lines: String = rows.iter().map(Row::csv).collect();
        // A lock is poisoned by a panic while a line is written only.
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(lines.as_bytes());
        written.map_err(|error| refuse(self.path, format!("cannot be written: {error}")))
    }
}

fn refuse(path: &Path, reason: String) -> Failure {
    Failure::Input(format!("{OUTPUT} {}: {reason}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::draw;

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
        fs::write(&path, format!("{whole}\n{}", &last[..5])).expect("is writable");
        assert_eq!(taken_up(&path, &cases(3)).map(|rows| rows.len()), Ok(3));
        assert_eq!(fs::read_to_string(&path).expect("is there"), format!("{whole}\n"));
        assert_eq!(rows(&cases(3), |_| EFFORT, Some(&path)), Ok(all));
        let other = taken_up(&path, &cases(4)).expect_err("other cases").to_string();
        assert!(other.contains("another case"), "{other}");
        let of_another = fs::read_to_string(&path).expect("is there").replace(build(), "0.0.9-unknown");
        fs::write(&path, of_another).expect("is writable");
        let other = taken_up(&path, &cases(3)).expect_err("another build").to_string();
        assert!(other.contains("rows of another build (0.0.9-unknown, "), "{other}");
        fs::write(&path, "a,b\n1,2\n").expect("is writable");
        assert!(taken_up(&path, &cases(3)).is_err());
        let _ = fs::remove_file(&path);
    }
}
