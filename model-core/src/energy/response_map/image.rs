//! The layout of a map as 16-bit words, and the checks that a map passes before it answers.
//!
//! | word | content |
//! | --- | --- |
//! | 0, 1 | [`MAGIC`], [`VERSION`] |
//! | 2 | number of words, the checksum included |
//! | 3, 4 | fingerprint of the scene, the low word first |
//! | 5 | [`CURRENT`], [`LOWER`], [`UPPER`] |
//! | 6 | columns: [`COLUMNS`] |
//! | 7 | slices |
//! | 8, 9 | resonance in units of the frequency, the low word first |
//! | 10 | units of the frequency: 2^−shift Hz |
//! | 11 | slope: 2²⁴ over the half-bandwidth in units |
//! | 12, 13 | detuning of the first column, and from it to the last |
//! | 14, 15 | rows of the lower and of the upper branch, [`ROWS`] together |
//! | 16, 17 | spacing of the rows of the lower and of the upper branch: shift, and bits in the upper byte |
//! | 18, 19 | lowest and highest level of the amplitude |
//! | 20 | levels beside a boundary within which both branches are given |
//! | 21 | octaves by which the levels of values are shifted |
//! | 22 | random points by which the bounds were measured |
//! | 23, 24 | median and 90th percentile of the error at these points, in 10⁻⁴ |
//! | 25 | share of other points at which the bounds hold, in 10⁻⁴ |
//! | 26 | level of the power over the spectral density of broadband vibration, shifted by 40 octaves; 0 if there is none |
//! | 27 | level of the largest density for which that holds, shifted by 24 octaves |
//! | … | level of the voltage of each slice |
//! | … | the columns of each slice, [`COLUMN_WORDS`] words each |
//! | … | the bounds of each slice, for eight parts of its columns 8 words each |
//! | 2 | CRC-32 of all words before it, as little-endian bytes, the low word first |
//!
//! A column has the level of the amplitude at which a rising sweep leaves the lower branch, then that at which a falling sweep
//! leaves the upper one; in a map with one branch, the level from which its rows count, and
//! [`NOWHERE`]. Then come the rows of the lower branch, and those of the upper one, each the level of the value. The rows reach
//! beyond the lowest and the highest amplitude of the map.
//!
//! The words of bounds of a part are those of the lower branch for its first rows ([`NEAR`]), of the lower branch for its other
//! rows, and the same of the upper branch: two words each, the factors from the value to the lower and to the upper bound, as
//! the upper half of a single-precision number. The lower factor is from 1/4 to 1, or 0, which is no bound, the upper one from 1 to 4.

use core::fmt;

use super::coordinate::Spacing;
use crate::snapshot::Fingerprint;

/// First word of a map: `RM`.
pub const MAGIC: u16 = u16::from_le_bytes(*b"RM");
/// Version of the layout.
pub const VERSION: u16 = 2;
/// Bit of word 5: the values are charge per second in A; without it, power in W.
pub const CURRENT: u16 = 1;
/// Bit of word 5: there is a lower branch with values. Without it the lower branch of a map with boundaries gives no power.
pub const LOWER: u16 = 2;
/// Bit of word 5: there is an upper branch.
pub const UPPER: u16 = 4;
/// Words before the voltages of the slices.
pub const HEAD: usize = 28;
/// Octaves by which the level of the power over the density is shifted.
pub const POWER_OCTAVES: i32 = 40;
/// Octaves by which the level of the largest density is shifted.
pub const DENSITY_OCTAVES: i32 = 24;
/// Rows of a column, of both branches together.
pub const ROWS: usize = 24;
/// Columns of a slice.
pub const COLUMNS: usize = (1 << COLUMN_BITS) + 1;
/// Columns less one as a power of two.
pub(super) const COLUMN_BITS: u32 = 5;
pub(super) const COLUMN_WORDS: usize = 2 + ROWS;
/// The falling boundary of a map without an upper branch: above all amplitudes.
pub const NOWHERE: u16 = u16::MAX;
/// Bounds of a branch: eight parts of the columns for the first rows, then eight for the others.
pub const BOUNDS: usize = 16;
/// Parts of the columns that have bounds of their own.
pub const PARTS: usize = BOUNDS / 2;
/// Words of the bounds of a slice: two for each part of either branch.
pub(super) const SLICE_BOUNDS: usize = 4 * BOUNDS;
/// Rows of two in an octave that have bounds of their own, next to the boundary; twice as many of four in an octave.
pub const NEAR: u32 = 4;
/// Words of the checksum.
pub const TAIL: usize = 2;

/// How well a map was found to agree with the full model, at random places off its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Agreement {
    /// Number of places by which the bounds were measured.
    pub places: u32,
    /// Median of the relative error.
    pub median: f32,
    /// 90th percentile of the relative error.
    pub percentile_90: f32,
    /// Share of other places at which the bounds hold.
    pub bounds_hold: f32,
}

/// The reason why a map is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MapError {
    /// The words do not begin as a map does.
    NotAMap,
    /// The map has another layout.
    ForeignVersion {
        /// Version of that layout.
        version: u16,
    },
    /// There are fewer words than the map has.
    TooShort {
        /// Number of words of the map.
        needed: usize,
        /// Number of words given.
        given: usize,
    },
    /// The checksum does not match.
    Corrupt,
    /// The checksum matches, and a word is outside its bounds.
    Malformed {
        /// Index of the word.
        word: usize,
    },
    /// A valid map of another harvester.
    ForeignHarvester {
        /// Fingerprint of the harvester of the map.
        of: u32,
    },
}

impl fmt::Display for MapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAMap => write!(f, "no response map"),
            Self::ForeignVersion { version } => {
                write!(f, "a response map of version {version}, not {VERSION}")
            }
            Self::TooShort { needed, given } => {
                write!(f, "a response map of {needed} words ends after {given}")
            }
            Self::Corrupt => write!(f, "the checksum does not match"),
            Self::Malformed { word } => write!(f, "word {word} of the response map is outside its bounds"),
            Self::ForeignHarvester { of } => write!(f, "a response map of another harvester, {of:#010x}"),
        }
    }
}

impl core::error::Error for MapError {}

/// Words, or their bytes, the lower one first.
#[derive(Debug, Clone, Copy)]
pub enum Stored<'a> {
    /// As words.
    Words(&'a [u16]),
    /// As bytes.
    Bytes(&'a [u8]),
}

impl Stored<'_> {
    /// Number of whole words.
    pub(super) const fn count(self) -> usize {
        match self {
            Self::Words(words) => words.len(),
            Self::Bytes(bytes) => bytes.len() / 2,
        }
    }

    /// The word at an index; 0 beyond the end.
    pub(super) const fn word(self, index: usize) -> u16 {
        // By patterns: `get` is no `const fn`, and an index would link a panic where the check before it is not seen.
        match self {
            Self::Words(words) => match words.split_at_checked(index) {
                Some((_, [word, ..])) => *word,
                _ => 0,
            },
            Self::Bytes(bytes) => match bytes.as_chunks().0.split_at_checked(index) {
                Some((_, [word, ..])) => u16::from_le_bytes(*word),
                _ => 0,
            },
        }
    }
}

/// CRC-32 of the first `count` words, as little-endian bytes.
const fn checksum(words: Stored<'_>, count: usize) -> u32 {
    let (mut checksum, mut index) = (Fingerprint::new(), 0);
    while index < count {
        checksum.bytes(&words.word(index).to_le_bytes());
        index += 1;
    }
    checksum.value()
}

/// Writes the number of words and the checksum into a map whose other words are set.
pub fn seal(words: &mut [u16]) {
    let count = words.len();
    if let Some(word) = words.get_mut(2) {
        *word = u16::try_from(count).unwrap_or(0);
    }
    let value = checksum(Stored::Words(words), count.saturating_sub(TAIL));
    if let Some([low, high]) = words.last_chunk_mut::<TAIL>() {
        [*low, *high] = [value as u16, (value >> 16) as u16];
    }
}

/// The numbers of a map, unpacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) is_current: bool,
    pub(super) slices: usize,
    /// Resonance in units of the frequency.
    pub(super) resonance: i32,
    pub(super) frequency_shift: i32,
    pub(super) slope: u32,
    pub(super) first: i32,
    pub(super) span: u32,
    /// Rows of the lower and the upper branch; 0 of a branch without values.
    pub(super) rows: [u32; 2],
    pub(super) spacings: [Spacing; 2],
    pub(super) lowest: i32,
    pub(super) highest: i32,
    pub(super) margin: i32,
    pub(super) value_octaves: i32,
}

impl Head {
    /// First word of the columns of the slices.
    pub(super) const fn columns_from(&self) -> usize {
        self.slices.wrapping_add(HEAD)
    }

    /// First word of their bounds.
    pub(super) const fn parts_from(&self) -> usize {
        self.slices.wrapping_mul(1 + COLUMNS * COLUMN_WORDS).wrapping_add(HEAD)
    }

    /// Reads and checks a map.
    pub(super) const fn read(words: Stored<'_>, fingerprint: u32) -> Result<Self, MapError> {
        if words.word(0) != MAGIC {
            return Err(MapError::NotAMap);
        }
        if words.word(1) != VERSION {
            return Err(MapError::ForeignVersion { version: words.word(1) });
        }
        let count = words.word(2) as usize;
        if words.count() < count || count < HEAD + TAIL {
            return Err(MapError::TooShort { needed: count, given: words.count() });
        }
        if checksum(words, count - TAIL) != wide(words, count - TAIL) {
            return Err(MapError::Corrupt);
        }
        let head = Self {
            is_current: words.word(5) & CURRENT != 0,
            slices: words.word(7) as usize,
            resonance: wide(words, 8).cast_signed(),
            frequency_shift: words.word(10).cast_signed() as i32,
            slope: words.word(11) as u32,
            first: words.word(12).cast_signed() as i32,
            span: words.word(13) as u32,
            rows: [words.word(14) as u32, words.word(15) as u32],
            spacings: [Spacing::of(words.word(16)), Spacing::of(words.word(17))],
            lowest: words.word(18) as i32,
            highest: words.word(19) as i32,
            margin: words.word(20) as i32,
            value_octaves: words.word(21).cast_signed() as i32,
        };
        if let Some(word) = head.malformed(words) {
            return Err(MapError::Malformed { word });
        }
        let of = wide(words, 3);
        if of == fingerprint { Ok(head) } else { Err(MapError::ForeignHarvester { of }) }
    }

    /// The first word with which a look-up would overflow or read beyond the map, or whose bound does not enclose the value.
    const fn malformed(&self, words: Stored<'_>) -> Option<usize> {
        let (flags, [lower, upper], [lower_spacing, upper_spacing]) =
            (words.word(5), self.rows, self.spacings);
        let has_lower = if flags & LOWER == 0 { lower == 0 } else { lower >= 2 };
        let has_upper = if flags & UPPER == 0 { upper == 0 } else { upper >= 2 };
        let tail = self.slices.wrapping_mul(SLICE_BOUNDS).wrapping_add(self.parts_from());
        let mut conditions: &[(usize, bool)] = &[
            (5, flags & (LOWER | UPPER) != 0),
            (6, words.word(6) as usize == COLUMNS),
            (7, 1 <= self.slices && self.slices <= 16),
            (8, 0 <= self.resonance && self.resonance < 1 << 30),
            (10, -20 <= self.frequency_shift && self.frequency_shift <= 30),
            (11, 1 <= self.slope && self.slope <= 1 << 13),
            (13, self.span > 0),
            (14, has_lower),
            (15, has_upper && lower.wrapping_add(upper) == ROWS as u32),
            (16, lower_spacing.is_stored()),
            (17, upper_spacing.is_stored()),
            // Smaller numbers have no level of their own.
            (18, self.lowest > 0),
            (19, self.lowest < self.highest),
            (20, upper > 0 || self.highest.wrapping_add(self.margin) < NOWHERE as i32),
            (21, -80 <= self.value_octaves && self.value_octaves <= 60),
            (2, tail.wrapping_add(TAIL) == words.word(2) as usize),
        ];
        while let [(word, holds), rest @ ..] = conditions {
            if !*holds {
                return Some(*word);
            }
            conditions = rest;
        }
        // Each amplitude of the map is between two rows: boundaries are not beyond them.
        let (lower_reach, upper_reach) = (lower_spacing.reach(lower), upper_spacing.reach(upper));
        let (mut word, end) = (self.columns_from(), self.parts_from());
        while word < end {
            let (rising, falling) = (words.word(word) as i32, words.word(word + 1) as i32);
            if rising.wrapping_sub(self.lowest) >= lower_reach {
                return Some(word);
            }
            if upper == 0 && falling != NOWHERE as i32 || self.highest.wrapping_sub(falling) >= upper_reach {
                return Some(word + 1);
            }
            word = word.wrapping_add(COLUMN_WORDS);
        }
        while word < tail {
            let (low, high) = (words.word(word), words.word(word + 1));
            if low != 0 && !(factor(0.25) <= low && low <= factor(1.0)) {
                return Some(word);
            }
            if !(factor(1.0) <= high && high <= factor(4.0)) {
                return Some(word + 1);
            }
            word = word.wrapping_add(2);
        }
        None
    }
}

/// A number of two words, the low one first.
const fn wide(words: Stored<'_>, index: usize) -> u32 {
    words.word(index) as u32 | (words.word(index.wrapping_add(1)) as u32) << 16
}

/// The word of a factor that has no more than eight significant bits.
const fn factor(number: f32) -> u16 {
    (number.to_bits() >> 16) as u16
}
