//! A file to which a long command appends a row for each case that is done; an interrupted command goes on from them.
//!
//! Each row ends with a checksum. The command has locked the file by [`Outputs::check`](super::files::Outputs::check).

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::files::{beside, place};
use super::note;
use crate::input;
use crate::method::Failure;
use crate::stability::fnv_1a;

/// Heading of the checksums.
const CHECKSUM: &str = ",checksum_fnv1a";
/// Most bytes of a file of rows: a million rows of `sweep`, with their statements, have less.
const MOST: u64 = 1 << 32;

#[derive(Debug, Clone, Copy)]
pub(super) struct Kind<'a> {
    /// Names the file in errors.
    pub(super) option: &'a str,
    /// Its first line, without the line break and without [`CHECKSUM`].
    pub(super) heading: &'a str,
    /// How the first line began before there were checksums.
    pub(super) earlier: &'a str,
    /// What to say of a file with another first line.
    pub(super) other: &'a str,
}

/// A file to which rows are appended.
pub(super) struct Rows {
    option: String,
    path: PathBuf,
    file: Mutex<Box<dyn Write + Send>>,
}

impl Rows {
    /// Opens or makes the file. Returns its rows by number; `read` makes a row of its text. Standard output has none.
    ///
    /// A row that is torn or damaged is left out with a note, and the file is replaced by one without it.
    ///
    /// # Errors
    /// A file that is of another kind, that `check` refuses, or that cannot be read or written.
    pub(super) fn open<T>(
        path: &Path,
        kind: Kind<'_>,
        read: impl Fn(&str) -> Option<(usize, T)>,
        check: impl Fn(&BTreeMap<usize, T>) -> Result<(), String>,
    ) -> Result<(Self, BTreeMap<usize, T>), Failure> {
        let Kind { option, heading, earlier, other } = kind;
        let refuse = |reason: String| refusal(option, path, &reason);
        let heading = format!("{heading}{CHECKSUM}\n");
        let to = |file: Box<dyn Write + Send>| Self {
            option: option.to_owned(),
            path: path.to_owned(),
            file: Mutex::new(file),
        };
        if path == Path::new(input::STANDARD) {
            let rows = to(Box::new(io::stdout()));
            return rows.write(&heading).map(|()| (rows, BTreeMap::new()));
        }
        let bytes = match input::read(path, MOST) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            read => read.map_err(|error| refuse(format!("cannot be read: {error}")))?,
        };
        let text = String::from_utf8_lossy(&bytes);
        // A full disk may have left less than the heading.
        let is_new = heading.starts_with(&*text);
        if !is_new && !text.starts_with(&heading) {
            let first = text.lines().next().unwrap_or_default();
            let is_earlier = first.starts_with(earlier) && !first.ends_with(CHECKSUM);
            let reason = "has rows without checksums, of an earlier version: remove it, or give another";
            return Err(refuse(if is_earlier { reason } else { other }.to_owned()));
        }
        let (mut known, mut whole, mut dropped) = (BTreeMap::new(), vec![heading.as_str()], 0);
        for line in text.get(heading.len()..).unwrap_or_default().split_inclusive('\n') {
            match checked(line).and_then(&read) {
                Some((number, row)) if !known.contains_key(&number) => {
                    known.insert(number, row);
                    whole.push(line);
                }
                _ => dropped += 1,
            }
        }
        check(&known).map_err(refuse)?;
        if dropped > 0 {
            note(&format!("{}: {dropped} damaged rows are left out and are done again", path.display()));
        }
        let opened = if is_new || dropped > 0 { replace(path, &whole.concat()) } else { Ok(()) };
        let opened = opened.and_then(|()| OpenOptions::new().append(true).open(path));
        let file = opened.map_err(|error| refuse(format!("cannot be written: {error}")))?;
        note(&format!("Ctrl-C keeps what is done, in {}; the same command goes on from it", path.display()));
        Ok((to(Box::new(file)), known))
    }

    /// Appends rows, each without its line break.
    pub(super) fn append(&self, rows: impl IntoIterator<Item = String>) -> Result<(), Failure> {
        self.write(&rows.into_iter().map(|row| line(&row)).collect::<String>())
    }

    fn write(&self, lines: &str) -> Result<(), Failure> {
        // A lock is poisoned by a panic while a row is written only.
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(lines.as_bytes());
        written.map_err(|error| refusal(&self.option, &self.path, &format!("cannot be written: {error}")))
    }

    pub(super) fn remove(self) {
        // A file that stays is that of this command, and does no harm.
        let _ = fs::remove_file(&self.path);
    }
}

fn refusal(option: &str, path: &Path, reason: &str) -> Failure {
    Failure::Input(format!("{option} {}: {reason}", path.display()))
}

/// A row with its checksum and its line break.
fn line(row: &str) -> String {
    format!("{row},{:016x}\n", fnv_1a(row.as_bytes()))
}

/// The row of a line, if it is whole.
fn checked(text: &str) -> Option<&str> {
    let (row, _) = text.rsplit_once(',')?;
    (line(row) == text).then_some(row)
}

/// Replaces a file, so that a kill leaves the old one or the new one.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let part = beside(&target, "new");
    // One that a kill has left is of no use, and a link is not followed.
    drop(fs::remove_file(&part));
    let file = File::create_new(&part)?;
    let placed = place(&file, text.as_bytes(), fs::metadata(&target).ok().as_ref(), &part, &target);
    placed.inspect_err(|_| drop(fs::remove_file(&part)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(path: &Path) -> Result<Vec<usize>, String> {
        let kind =
            Kind { option: "--output", heading: "number,cell", earlier: "number,", other: "is another" };
        let read = |row: &str| Some((row.split_once(',')?.0.parse().ok()?, ()));
        let opened = Rows::open(path, kind, read, |_| Ok(()));
        opened.map(|(_, known)| known.into_keys().collect()).map_err(|error| error.to_string())
    }

    #[test]
    fn only_whole_rows_are_taken_up_and_other_files_are_refused() {
        let folder = std::env::temp_dir().join(format!("rows-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("rows.csv");
        // Checksums of FNV-1a, computed apart from this program.
        let (heading, one, two) =
            ("number,cell,checksum_fnv1a\n", "1,a,45760018182799e3\n", "2,b,60828e1827c6fa5b\n");
        let flipped = one.replacen("1,a", "1,c", 1);
        for (before, after, numbers) in [
            ("", heading.to_owned(), vec![]),
            ("number,ce", heading.to_owned(), vec![]),
            (&format!("{heading}{one}{two}"), format!("{heading}{one}{two}"), vec![1, 2]),
            (&format!("{heading}{one}{}", &two[..9]), format!("{heading}{one}"), vec![1]),
            (&format!("{heading}{one}{}", two.trim_end()), format!("{heading}{one}"), vec![1]),
            (&format!("{heading}{flipped}{two}"), format!("{heading}{two}"), vec![2]),
            (&format!("{heading}{one}{one}{two}"), format!("{heading}{one}{two}"), vec![1, 2]),
        ] {
            fs::write(&path, before).expect("a file");
            assert_eq!(open(&path), Ok(numbers), "{before}");
            assert_eq!(fs::read_to_string(&path).expect("it is there"), after, "{before}");
        }
        for (text, reason) in [("number,cell\n1,a\n", "of an earlier version"), ("a,b\n", "is another")] {
            fs::write(&path, text).expect("a file");
            assert!(open(&path).is_err_and(|error| error.contains(reason)), "{text}");
            assert_eq!(fs::read_to_string(&path).expect("it is there"), text);
        }
        assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 1, "nothing is left beside it");
        fs::remove_dir_all(&folder).expect("my own folder");
    }
}
