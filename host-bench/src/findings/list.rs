//! The findings in our own words.

use std::sync::LazyLock;

use super::Mark;

/// A result that a paper states, as an assertion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Its number; a letter for what no parameters tried reproduce.
    pub number: &'static str,
    /// Where the paper states it.
    pub source: &'static str,
    pub statement: &'static str,
    /// The scenes that show it, and what is changed in them.
    pub scene: &'static str,
    /// The expected mark.
    pub mark: Mark,
    /// What to know of the mark; empty if nothing.
    pub note: &'static str,
}

/// All findings: the second paper's from 1 to 20, the first paper's from 21 to 43, and what is not reproduced. A line of the
/// list has number, mark, source, scene, statement and note.
pub static FINDINGS: LazyLock<Vec<Finding>> = LazyLock::new(|| {
    let line = |line: &'static str| {
        let mut cells = line.split('|').map(str::trim);
        let mut cell = || cells.next().unwrap_or_default();
        let (number, mark) = (cell(), cell());
        let marks = [Mark::Shown, Mark::Chosen, Mark::NotShown];
        let mark = marks.into_iter().find(|known| known.name() == mark).unwrap_or(Mark::Stopped);
        Finding { number, mark, source: cell(), scene: cell(), statement: cell(), note: cell() }
    };
    include_str!("list.txt").lines().map(line).collect()
});
