//! How the words of a map are stored, and arrays of proven length from them: a look-up in them needs no other checks than those
//! of its place.

use core::fmt;
use core::ops::Deref;

use super::image::{COLUMN_WORDS, COLUMNS, PARTS, Stored};

/// A word as it is stored.
pub trait Word: Copy + fmt::Debug + Eq {
    /// Its number.
    fn number(self) -> u16;
}

impl Word for u16 {
    #[inline]
    fn number(self) -> u16 {
        self
    }
}

/// Two bytes, the lower one first.
impl Word for [u8; 2] {
    #[inline]
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
pub trait WordSource: Copy {
    /// One of them.
    type Word: Word;
    /// The columns of a slice.
    type Columns: Deref<Target = Columns<Self::Word>> + Copy + fmt::Debug + Eq;
    /// The bounds of a slice.
    type Bounds: Deref<Target = Bounds<Self::Word>> + Copy + fmt::Debug + Eq;

    /// All of them.
    fn stored(&self) -> Stored<'_>;

    /// The columns of a slice, from a word on; `None` if they are not all there.
    fn columns(self, from: usize) -> Option<Self::Columns>;

    /// The bounds of a slice, from a word on; `None` if they are not all there.
    fn bounds(self, from: usize) -> Option<Self::Bounds>;
}

impl<'a> WordSource for &'a [u16] {
    type Word = u16;
    type Columns = &'a Columns<u16>;
    type Bounds = &'a Bounds<u16>;

    fn stored(&self) -> Stored<'_> {
        Stored::Words(self)
    }

    fn columns(self, from: usize) -> Option<Self::Columns> {
        columns(self, from)
    }

    fn bounds(self, from: usize) -> Option<Self::Bounds> {
        bounds(self, from)
    }
}

impl<'a> WordSource for &'a [u8] {
    type Word = [u8; 2];
    type Columns = &'a Columns<[u8; 2]>;
    type Bounds = &'a Bounds<[u8; 2]>;

    fn stored(&self) -> Stored<'_> {
        Stored::Bytes(self)
    }

    fn columns(self, from: usize) -> Option<Self::Columns> {
        columns(self.as_chunks().0, from)
    }

    fn bounds(self, from: usize) -> Option<Self::Bounds> {
        bounds(self.as_chunks().0, from)
    }
}

pub(super) const fn columns<T>(words: &[T], from: usize) -> Option<&Columns<T>> {
    match words.split_at_checked(from) {
        Some((_, words)) => words.as_chunks().0.first_chunk(),
        None => None,
    }
}

pub(super) const fn bounds<T>(words: &[T], from: usize) -> Option<&Bounds<T>> {
    let Some((_, words)) = words.split_at_checked(from) else { return None };
    let pairs: &[[T; 2]] = words.as_chunks().0;
    let branches: &[[[T; 2]; 2]] = pairs.as_chunks().0;
    branches.as_chunks().0.first_chunk()
}
