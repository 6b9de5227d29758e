//! A file to which a long command appends a row for each case that is done; an interrupted command goes on from them. Jobs of an
//! array do a part of the cases each, and a last command merges their files.
//!
//! Each row ends with a checksum. The command has locked the file by [`Outputs::check`](super::files::Outputs::check).

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use super::files::{beside, place, refusal};
use super::{count, note};
use crate::input;
use crate::method::Failure;
use crate::stability::fnv_1a;

/// Heading of the checksums.
const CHECKSUM: &str = ",checksum_fnv1a";
/// Most bytes of a file of rows: a million rows of `sweep`, with their statements, have less.
const MOST: u64 = 1 << 32;

/// Which of its cases a command does.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(super) struct Parts {
    /// Do every N-th point alone, from the K-th on, and keep them in a file of their own in --output, for an array of N jobs
    #[arg(long, value_name = "K/N", requires = "output", conflicts_with = "merge")]
    part: Option<Part>,
    /// Take the points that N parts have kept in --output; all must be there, of this build and of these arguments
    #[arg(long, value_name = "N", requires = "output", value_parser = count::<usize>(1..=MOST_PARTS))]
    pub(super) merge: Option<usize>,
}

/// Most parts: a grid has no more points.
const MOST_PARTS: u64 = 1_000_000;

/// A part of the cases: its number from 1, and how many there are.
#[derive(Debug, Clone, Copy)]
struct Part {
    number: usize,
    of: usize,
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(one, all)| Some((one.parse().ok()?, all.parse().ok()?)));
        let part = numbers.map(|(number, of)| Self { number, of });
        part.filter(|part| (1..=part.of).contains(&part.number) && part.of as u64 <= MOST_PARTS)
            .ok_or_else(|| format!("must be K/N with K from 1 to N, and N at most {MOST_PARTS}"))
    }
}

/// A file of rows, the part that it is of, and its text.
type PartText = (PathBuf, Option<Part>, String);

impl Part {
    /// Whether it has the case of a number from 0. Cases of like cost are beside each other, and are spread over the parts.
    fn has(self, number: usize) -> bool {
        number % self.of == self.number - 1
    }

    /// Its file beside that of all rows.
    fn file(self, path: &Path) -> PathBuf {
        let own = path.extension().map_or_else(String::new, |own| format!(".{}", own.to_string_lossy()));
        path.with_extension(format!("part-{}-of-{}{own}", self.number, self.of))
    }
}

impl Parts {
    /// Whether the command does one part.
    pub(super) fn is_one(self) -> bool {
        self.part.is_some()
    }

    /// Whether the command does the case of a number from 0.
    pub(super) fn has(self, number: usize) -> bool {
        self.part.is_none_or(|part| part.has(number))
    }

    /// The first merged part that lacks one of so many cases, and why it is refused.
    fn lacking(self, cases: usize, is_done: impl Fn(usize) -> bool) -> Option<(Part, String)> {
        let of = self.merge?;
        let number = 1 + (0..cases).find(|case| !is_done(*case))? % of;
        let own = (0..cases).filter(|case| Part { number, of }.has(*case));
        let (all, done) = (own.clone().count(), own.filter(|case| is_done(*case)).count());
        let reason =
            format!("must have all {all} points of part {number}/{of}, has {done}: give its command again");
        Some((Part { number, of }, reason))
    }

    /// The files of merged parts, each with its text.
    fn texts(self, path: &Path, kind: Kind<'_>, heading: &str) -> Result<Vec<PartText>, Failure> {
        let each = self.merge.into_iter().flat_map(|of| (1..=of).map(move |number| Part { number, of }));
        let text = |part: Part| {
            let file = part.file(path);
            kind.text(&file, heading).map(|text| (file, Some(part), text))
        };
        each.map(text).collect()
    }

    /// The file of rows of the command. Standard output is that of a part, too.
    pub(super) fn file(self, path: &Path) -> PathBuf {
        let part = self.part.filter(|_| path != Path::new(input::STANDARD));
        part.map_or_else(|| path.to_owned(), |part| part.file(path))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Kind<'a> {
    /// Names the file in errors.
    pub(super) option: &'a str,
    /// Its first line, without the line break and without [`CHECKSUM`].
    pub(super) heading: &'a str,
    /// What to say of a file with another first line.
    pub(super) other: &'a str,
}

impl Kind<'_> {
    /// The text of a file, empty where there is none; refuses one that is of another kind.
    fn text(self, path: &Path, heading: &str) -> Result<String, Failure> {
        let refuse = |reason: &str| refusal(self.option, path, reason);
        let bytes = match input::read(path, MOST) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            read => read.map_err(|error| refuse(&format!("cannot be read: {error}")))?,
        };
        let text = String::from_utf8_lossy(&bytes);
        // A full disk may have left less than the heading.
        if heading.starts_with(&*text) || text.starts_with(heading) {
            return Ok(text.into_owned());
        }
        Err(refuse(self.other))
    }
}

/// A file to which rows are appended.
pub(super) struct Rows {
    option: String,
    path: PathBuf,
    file: Mutex<Box<dyn Write + Send>>,
}

impl Rows {
    /// Opens or makes the file of these parts of so many cases. Returns its rows by number; `read` makes a row of its text. Standard
    /// output has none.
    ///
    /// A row that is torn or damaged is left out with a note, and the file is replaced by one without it. The files of merged parts
    /// stay. Refuses a file of another kind, or that `check` refuses, and a merged part that lacks a case.
    pub(super) fn open<T>(
        path: &Path,
        (parts, cases): (Parts, usize),
        kind: Kind<'_>,
        read: impl Fn(&str) -> Option<(usize, T)>,
        check: impl Fn(&BTreeMap<usize, T>) -> Result<(), String>,
    ) -> Result<(Self, BTreeMap<usize, T>), Failure> {
        let path = &*parts.file(path);
        let Kind { option, heading, .. } = kind;
        let refuse = |reason: String| refusal(option, path, &reason);
        let heading = format!("{heading}{CHECKSUM}\n");
        let to = |file: Box<dyn Write + Send>| Self {
            option: option.to_owned(),
            path: path.to_owned(),
            file: Mutex::new(file),
        };
        if path == Path::new(input::STANDARD) {
            if parts.merge.is_some() {
                return Err(refuse("must be a file with --merge".to_owned()));
            }
            let rows = to(Box::new(io::stdout()));
            return rows.write(&heading).map(|()| (rows, BTreeMap::new()));
        }
        let own = (path.to_owned(), parts.part, kind.text(path, &heading)?);
        let is_new = own.2.len() < heading.len();
        let merged = parts.texts(path, kind, &heading)?;
        for one in merged.iter().chain([&own]) {
            let (rows, ..) = taken_up(std::slice::from_ref(one), &heading, &read);
            check(&rows).map_err(|reason| refusal(option, &one.0, &reason))?;
        }
        let texts = if parts.merge.is_some() { merged } else { vec![own] };
        let (known, whole, dropped) = taken_up(&texts, &heading, &read);
        if let Some((part, reason)) = parts.lacking(cases, |case| known.contains_key(&case)) {
            return Err(refusal(option, &part.file(path), &reason));
        }
        if dropped > 0 {
            note(&format!(
                "{}: {dropped} rows that are damaged, or of another part, are left out",
                path.display()
            ));
        }
        let is_other = is_new || dropped > 0 || parts.merge.is_some();
        let opened = if is_other { replace(path, &whole.concat()) } else { Ok(()) };
        let opened = opened.and_then(|()| OpenOptions::new().append(true).open(path));
        let file = opened.map_err(|error| refuse(format!("cannot be written: {error}")))?;
        if parts.merge.is_none() {
            note(&format!(
                "Ctrl-C keeps what is done, in {}; the same command goes on from it",
                path.display()
            ));
        }
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

/// The whole rows of the files of parts by number, with the lines of the heading and of them, and how many others there are.
fn taken_up<'t, T>(
    texts: &'t [PartText],
    heading: &'t str,
    read: impl Fn(&str) -> Option<(usize, T)>,
) -> (BTreeMap<usize, T>, Vec<&'t str>, usize) {
    let (mut known, mut whole, mut dropped) = (BTreeMap::new(), vec![heading], 0);
    for (_, part, text) in texts {
        for line in text.get(heading.len()..).unwrap_or_default().split_inclusive('\n') {
            // A copy of another part's file has rows that are not of this one.
            let is_new =
                |number: &usize| part.is_none_or(|part| part.has(*number)) && !known.contains_key(number);
            match checked(line).and_then(&read).filter(|(number, _)| is_new(number)) {
                Some((number, row)) => {
                    known.insert(number, row);
                    whole.push(line);
                }
                None => dropped += 1,
            }
        }
    }
    (known, whole, dropped)
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
        let kind = Kind { option: "--output", heading: "number,cell", other: "is another" };
        let read = |row: &str| Some((row.split_once(',')?.0.parse().ok()?, ()));
        let opened = Rows::open(path, (Parts::default(), 0), kind, read, |_| Ok(()));
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
        for text in ["number,cell\n1,a\n", "a,b\n"] {
            fs::write(&path, text).expect("a file");
            assert!(open(&path).is_err_and(|error| error.contains("is another")), "{text}");
            assert_eq!(fs::read_to_string(&path).expect("it is there"), text);
        }
        assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 1, "nothing is left beside it");
        fs::remove_dir_all(&folder).expect("my own folder");
    }
}
