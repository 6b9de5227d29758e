//! How the words of a map are stored, and arrays of proven length from them: a look-up in them needs no other checks than those
//! of its place.

use core::fmt;
use core::ops::Deref;

use super::image::{COLUMN_WORDS, COLUMNS, PARTS};

/// A word as it is stored.
pub trait Word: Copy + fmt::Debug + Eq {
    /// Its number.
    fn number(self) -> u16;
}

impl Word for u16 {
    #[inline(always)]
    fn number(self) -> u16 {
        self
    }
}

/// Two bytes, the lower one first.
impl Word for [u8; 2] {
    #[inline(always)]
    fn number(self) -> u16 {
        u16::from_le_bytes(self)
    }
}

/// The bounds of a part of the columns: of the lower and the upper branch, near its boundary and far from it, the factors of
/// the lower and the upper bound.
pub type Part<T> = [[[T; 2]; 2]; 2];
/// The bounds of a slice.
pub type Bounds<T> = [Part<T>; PARTS];
/// The columns of a slice.
pub type Columns<T> = [[T; COLUMN_WORDS]; COLUMNS];

/// Where the words of a map are: in memory as words, or as little-endian bytes.
pub trait Words: Copy {
    /// One of them.
    type Word: Word;
    /// The columns of a slice.
    type Columns: Deref<Target = Columns<Self::Word>> + Copy + fmt::Debug + Eq;
    /// The bounds of a slice.
    type Bounds: Deref<Target = Bounds<Self::Word>> + Copy + fmt::Debug + Eq;

    /// The word at an index; `None` beyond the end.
    fn at(self, index: usize) -> Option<u16>;

    /// Number of whole words.
    fn count(self) -> usize;

    /// The columns of a slice, from a word on; `None` if they are not all there.
    fn columns(self, from: usize) -> Option<Self::Columns>;

    /// The bounds of a slice, from a word on; `None` if they are not all there.
    fn bounds(self, from: usize) -> Option<Self::Bounds>;

    /// The word at an index; 0 beyond the end.
    fn word(self, index: usize) -> u16 {
        self.at(index).unwrap_or(0)
    }
}

impl<'a> Words for &'a [u16] {
    type Word = u16;
    type Columns = &'a Columns<u16>;
    type Bounds = &'a Bounds<u16>;

    fn at(self, index: usize) -> Option<u16> {
        self.get(index).copied()
    }

    fn count(self) -> usize {
        self.len()
    }

    fn columns(self, from: usize) -> Option<Self::Columns> {
        columns(self, from)
    }

    fn bounds(self, from: usize) -> Option<Self::Bounds> {
        bounds(self, from)
    }
}

impl<'a> Words for &'a [u8] {
    type Word = [u8; 2];
    type Columns = &'a Columns<[u8; 2]>;
    type Bounds = &'a Bounds<[u8; 2]>;

    fn at(self, index: usize) -> Option<u16> {
        self.as_chunks().0.get(index).map(|word| word.number())
    }

    fn count(self) -> usize {
        self.len() / 2
    }

    fn columns(self, from: usize) -> Option<Self::Columns> {
        columns(self.as_chunks().0, from)
    }

    fn bounds(self, from: usize) -> Option<Self::Bounds> {
        bounds(self.as_chunks().0, from)
    }
}

fn columns<T>(words: &[T], from: usize) -> Option<&Columns<T>> {
    words.get(from..)?.as_chunks().0.first_chunk()
}

fn bounds<T>(words: &[T], from: usize) -> Option<&Bounds<T>> {
    let pairs: &[[T; 2]] = words.get(from..)?.as_chunks().0;
    let branches: &[[[T; 2]; 2]] = pairs.as_chunks().0;
    branches.as_chunks().0.first_chunk()
}
