//! The layout of a map as 16-bit words, and the checks that a map passes before it answers.
//!
//! | word | content |
//! | --- | --- |
//! | 0, 1 | [`MAGIC`], [`VERSION`] |
//! | 2 | number of words, the checksum included |
//! | 3, 4 | fingerprint of the scene, the low word first |
//! | 5 | [`CURRENT`], [`LOWER`], [`UPPER`] |
//! | 6 | columns − 1 as a power of two, and rows in the upper byte |
//! | 7 | slices |
//! | 8, 9 | resonance in units of the frequency, the low word first |
//! | 10 | units of the frequency: 2^−shift Hz |
//! | 11 | slope: 2²⁴ over the half-bandwidth in units |
//! | 12, 13 | detuning of the first column, and from it to the last |
//! | 14, 15 | factor and shift from a detuning to columns in 2⁻¹⁰ |
//! | 16, 17 | spacing of the rows of the lower and of the upper branch: shift, and bits in the upper byte |
//! | 18, 19 | lowest and highest level of the amplitude |
//! | 20 | levels beside a boundary within which both branches are told |
//! | 21 | octaves by which the levels of values are shifted |
//! | 22 | random points by which the bounds were measured |
//! | 23, 24 | median and 90th percentile of the error at these points, in 10⁻⁴ |
//! | 25 | share of other points at which the bounds hold, in 10⁻⁴ |
//! | 26 | level of the power over the spectral density of broadband shaking, shifted by 40 octaves; 0 if there is none |
//! | 27 | level of the largest density for which that holds, shifted by 24 octaves |
//! | … | level of the voltage of each slice |
//! | … | the slices |
//! | 2 | CRC-32 of all words before it, as little-endian bytes, the low word first |
//!
//! A slice has, if there are both branches, the level of the amplitude for each column at which a rising sweep leaves the
//! lower branch, then that at which a falling sweep leaves the upper one; with one branch, the levels from which its rows
//! count. Then, for each branch, lower first: for each column its rows, each the level of the value, and sixteen words of
//! bounds, eight parts of the columns for the first rows ([`NEAR`]), then eight for the others; a word has the part by which
//! the true value may be higher in its upper byte and that by which it may be lower in its lower byte, in 1/128 octaves;
//! 255 in the lower byte is no lower bound.

use core::fmt;

use super::coordinate::Spacing;
use crate::snapshot::Fingerprint;

/// First word of a map: `RM`.
pub const MAGIC: u16 = u16::from_le_bytes(*b"RM");
/// Version of the layout.
pub const VERSION: u16 = 1;
/// Bit of word 5: the values are charge per second in A; without it, power in W.
pub const CURRENT: u16 = 1;
/// Bit of word 5: there is a lower branch with values. Without it the lower branch of a map with boundaries yields nothing.
pub const LOWER: u16 = 2;
/// Bit of word 5: there is an upper branch.
pub const UPPER: u16 = 4;
/// Words before the voltages of the slices.
pub const HEAD: usize = 28;
/// Octaves by which the level of the power over the density is shifted.
pub const POWER_OCTAVES: i32 = 40;
/// Octaves by which the level of the largest density is shifted.
pub const DENSITY_OCTAVES: i32 = 24;
/// Words of the bounds of one branch.
pub const BOUNDS: usize = 16;
/// Rows of two in an octave that have bounds of their own, next to the boundary; twice as many of four in an octave.
pub const NEAR: u32 = 4;
/// Words of the checksum.
pub const TAIL: usize = 2;

/// Where the words of a map are: in memory as words, or as little-endian bytes.
pub trait Words: Copy {
    /// The word at an index; 0 beyond the end.
    #[inline(always)]
    fn word(self, index: usize) -> u16 {
        u32::try_from(index).ok().and_then(|index| self.at(index)).unwrap_or(0)
    }

    /// The word at an index; `None` beyond the end.
    fn at(self, index: u32) -> Option<u16>;

    /// The words at an index and the next one, and those `stride` behind each; `None` if one of them is beyond the end.
    #[inline(always)]
    fn cell(self, index: u32, stride: u8) -> Option<[[i32; 2]; 2]> {
        let across = index + u32::from(stride);
        // The last one first: its comparison with the end is enough for all.
        let last = i32::from(self.at(across + 1)?);
        let word = |index| Some(i32::from(self.at(index)?));
        Some([[word(index)?, word(index + 1)?], [word(across)?, last]])
    }

    /// Number of whole words.
    fn count(self) -> usize;
}

impl Words for &[u16] {
    #[inline(always)]
    fn at(self, index: u32) -> Option<u16> {
        self.get(index as usize).copied()
    }

    fn count(self) -> usize {
        self.len()
    }
}

impl Words for &[u8] {
    #[inline(always)]
    fn at(self, index: u32) -> Option<u16> {
        let high = self.get(2 * index as usize + 1)?;
        Some(u16::from_le_bytes([*self.get(2 * index as usize)?, *high]))
    }

    fn count(self) -> usize {
        self.len() / 2
    }
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

/// CRC-32 of the first `count` words, as little-endian bytes.
fn checksum<W: Words>(words: W, count: usize) -> u32 {
    let mut checksum = Fingerprint::new();
    for index in 0..count {
        checksum.numbers(&[words.word(index)]);
    }
    checksum.value()
}

/// Writes the number of words and the checksum into a map whose other words are set.
pub fn seal(words: &mut [u16]) {
    let count = words.len();
    if let Some(word) = words.get_mut(2) {
        *word = u16::try_from(count).unwrap_or(0);
    }
    let value = checksum(&*words, count.saturating_sub(TAIL));
    if let Some([low, high]) = words.last_chunk_mut::<TAIL>() {
        [*low, *high] = [value as u16, (value >> 16) as u16];
    }
}

/// The numbers of a map, unpacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) is_current: bool,
    /// Whether there is a lower branch with values.
    pub(super) lower: bool,
    pub(super) upper: bool,
    /// Columns less one as a power of two.
    pub(super) column_bits: u32,
    pub(super) rows: u32,
    pub(super) slices: usize,
    /// Resonance in units of the frequency.
    pub(super) resonance: i32,
    pub(super) frequency_shift: i32,
    pub(super) slope: u32,
    pub(super) first: i32,
    pub(super) span: u32,
    pub(super) factor: u32,
    pub(super) factor_shift: u32,
    /// Of the rows of the lower and the upper branch.
    pub(super) spacings: [Spacing; 2],
    pub(super) lowest: i32,
    pub(super) highest: i32,
    pub(super) margin: i32,
    pub(super) value_octaves: i32,
}

impl Head {
    pub(super) fn columns(&self) -> usize {
        (1 << self.column_bits.min(6)) + 1
    }

    /// Words of a branch without its bounds.
    pub(super) fn nodes(&self) -> usize {
        self.columns() * self.rows as usize
    }

    /// Words of the boundaries of a slice.
    pub(super) fn curves(&self) -> usize {
        (1 + usize::from(self.upper)) * self.columns()
    }

    /// Words of a slice.
    pub(super) fn slice(&self) -> usize {
        let branches = usize::from(self.lower) + usize::from(self.upper);
        self.curves() + branches * (self.nodes() + BOUNDS)
    }

    /// Reads and checks a map.
    pub(super) fn read<W: Words>(words: W, fingerprint: u32) -> Result<Self, MapError> {
        let word = |index: usize| words.word(index);
        let wide = |index: usize| u32::from(word(index)) | (u32::from(word(index + 1)) << 16);
        let signed = |index: usize| i32::from(word(index).cast_signed());
        if word(0) != MAGIC {
            return Err(MapError::NotAMap);
        }
        if word(1) != VERSION {
            return Err(MapError::ForeignVersion { version: word(1) });
        }
        let count = usize::from(word(2));
        if words.count() < count || count < HEAD + TAIL {
            return Err(MapError::TooShort { needed: count, given: words.count() });
        }
        if checksum(words, count - TAIL) != wide(count - TAIL) {
            return Err(MapError::Corrupt);
        }
        let head = Self {
            is_current: word(5) & CURRENT != 0,
            lower: word(5) & LOWER != 0,
            upper: word(5) & UPPER != 0,
            column_bits: u32::from(word(6) & 0xff),
            rows: u32::from(word(6) >> 8),
            slices: usize::from(word(7)),
            resonance: wide(8).cast_signed(),
            frequency_shift: signed(10),
            slope: u32::from(word(11)),
            first: signed(12),
            span: u32::from(word(13)),
            factor: u32::from(word(14)),
            factor_shift: u32::from(word(15)),
            spacings: [16, 17].map(|index| Spacing {
                shift: u32::from(word(index) & 0xff),
                bits: u32::from(word(index) >> 8),
            }),
            lowest: i32::from(word(18)),
            highest: i32::from(word(19)),
            margin: i32::from(word(20)),
            value_octaves: signed(21),
        };
        head.check(count)?;
        let of = wide(3);
        if of == fingerprint { Ok(head) } else { Err(MapError::ForeignHarvester { of }) }
    }

    /// Refuses numbers with which a look-up would overflow or read beyond the map.
    fn check(&self, count: usize) -> Result<(), MapError> {
        let spaced = |of: Spacing| (1..=2).contains(&of.bits) && (of.bits..=12).contains(&of.shift);
        let last = (u64::from(self.span) * u64::from(self.factor)) >> self.factor_shift.min(63);
        let conditions = [
            (5, self.lower || self.upper),
            (6, (3..=6).contains(&self.column_bits) && (2..=32).contains(&self.rows)),
            (7, (1..=16).contains(&self.slices)),
            (8, (0..1 << 30).contains(&self.resonance)),
            (10, (-20..=30).contains(&self.frequency_shift)),
            (11, (1..=1 << 13).contains(&self.slope)),
            (13, self.span > 0),
            (14, last <= 1024 << self.column_bits.min(6)),
            (15, (self.factor_shift as usize) < 32),
            (16, spaced(self.spacings[0])),
            (17, spaced(self.spacings[1])),
            // Smaller numbers have no level of their own.
            (18, self.lowest > 0),
            (19, self.lowest < self.highest),
            (21, (-80..=60).contains(&self.value_octaves)),
            (2, HEAD + self.slices * (1 + self.slice()) + TAIL == count),
        ];
        match conditions.iter().find(|(_, holds)| !holds) {
            Some(&(word, _)) => Err(MapError::Malformed { word }),
            None => Ok(()),
        }
    }
}
