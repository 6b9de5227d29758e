//! What a look-up needs of a map, folded once when the map is checked: edges as the bits of floating-point numbers, so that
//! one subtraction and one comparison find out whether a number is within them, offsets of the curves and branches, and the
//! constants of both coordinates.

use super::coordinate::{
    FARTHEST, FoldedSpacing, LEVELS_PER_OCTAVE, RAISED, bits_of_raised, detuning, fixed, fixed_of_bits,
    level, level_of_bits, row_distance,
};
use super::image::{BOUNDS, HEAD, Head, NEAR, Words};
use super::{Bounded, Outside, Spacing};

/// Between two columns: the column below, and the place above it in 2⁻¹⁰ of their distance.
#[derive(Clone, Copy)]
pub(super) struct Column {
    below: u32,
    place: i32,
}

/// The bits of the least number within two edges, and by how much those of the largest are greater. Positive numbers rise with
/// their bits; those of all others are greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Edges {
    least: u32,
    span: u32,
}

impl Edges {
    /// Between the first bits that have `begun` and the last ones that are not `over`: both are monotonic. `None` if there
    /// are none.
    fn of(begun: impl Fn(u32) -> bool, over: impl Fn(u32) -> bool) -> Option<Self> {
        let least = first(begun);
        let span = first(over).checked_sub(1)?.checked_sub(least)?;
        Some(Self { least, span })
    }

    #[inline(always)]
    fn contain(self, bits: u32) -> bool {
        bits.wrapping_sub(self.least) <= self.span
    }
}

/// The first bits of a normal number of which a condition is true that is true of all greater ones.
fn first(holds: impl Fn(u32) -> bool) -> u32 {
    let (mut low, mut high) = (f32::MIN_POSITIVE.to_bits(), f32::INFINITY.to_bits());
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// From a detuning to columns in 2⁻²⁵; the last column is just beyond the last detuning, so that each place is in a cell.
fn factor(head: &Head) -> u32 {
    let factor = match 15_u32.checked_sub(head.factor_shift) {
        Some(left) => head.factor << left,
        None => head.factor >> (head.factor_shift - 15),
    };
    factor.min(((1_u32 << (25 + head.column_bits)) - 1).checked_div(head.span).unwrap_or(0))
}

/// Where the values of a branch are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Side {
    /// Its first node, from the start of its slice; 0 if it has no values.
    nodes: u16,
    spacing: FoldedSpacing,
    /// Distance of its last row from the boundary in levels.
    farthest: u16,
    /// Rows that have the bounds next to the boundary.
    near: u32,
}

/// All that a look-up needs beside the words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) is_current: bool,
    pub(super) has_upper: bool,
    amplitudes: Edges,
    frequencies: Edges,
    /// By how much a frequency is moved right at the exponent 0.
    right: u32,
    resonance: i32,
    slope: u32,
    /// Detuning of the first column.
    first: i32,
    /// From a detuning to columns in 2⁻²⁵.
    factor: u32,
    columns: u8,
    /// Eighths of the columns in eight cells.
    eighths: u8,
    rows: u8,
    sides: [Side; 2],
    /// Levels beside a boundary within which both branches are told.
    pub(super) margin: i32,
    /// What is added to the level of a value.
    raised: i32,
    pub(super) slices: u16,
    /// First word of the first slice.
    start: u16,
    /// Words of a slice.
    slice: u16,
    /// Words of a branch without its bounds.
    nodes: u16,
}

impl Plan {
    /// The plan of a checked head; `None` if no frequency is within the map.
    pub(super) fn new(head: &Head) -> Option<Self> {
        let amplitudes =
            Edges::of(|bits| level_of_bits(bits) >= head.lowest, |bits| level_of_bits(bits) > head.highest)?;
        // Detuning from the first column; beyond what is a detuning, one that is farther away.
        let from_first = |bits: u32| match fixed(f32::from_bits(bits), head.frequency_shift) {
            None => i32::MAX,
            Some(0) => i32::MIN,
            Some(units) => {
                let distance = units.cast_signed() - head.resonance;
                let nearest = FARTHEST.cast_signed();
                match distance {
                    _ if distance > nearest => i32::MAX,
                    _ if distance < -nearest => i32::MIN,
                    _ => detuning(distance, head.slope) - head.first,
                }
            }
        };
        let span = head.span.cast_signed();
        let frequencies = Edges::of(|bits| from_first(bits) >= 0, |bits| from_first(bits) > span)?;
        // A map has less than 2¹⁶ words.
        let offset = |words: usize| words as u16;
        let lower_nodes = head.curves();
        let upper_nodes = lower_nodes + if head.lower { head.nodes() + BOUNDS } else { 0 };
        let side = |has: bool, nodes: usize, spacing: Spacing| Side {
            nodes: if has { offset(nodes) } else { 0 },
            spacing: spacing.folded(),
            // Two levels are not farther from each other.
            farthest: u16::try_from(row_distance(head.rows - 1, spacing)).unwrap_or(u16::MAX),
            near: NEAR << (spacing.bits - 1),
        };
        let [lower, upper] = head.spacings;
        Some(Self {
            is_current: head.is_current,
            has_upper: head.upper,
            amplitudes,
            frequencies,
            right: (158 - head.frequency_shift).cast_unsigned(),
            resonance: head.resonance,
            slope: head.slope,
            first: head.first,
            factor: factor(head),
            columns: head.columns() as u8,
            eighths: 64 >> head.column_bits,
            rows: head.rows as u8,
            sides: [side(head.lower, lower_nodes, lower), side(head.upper, upper_nodes, upper)],
            margin: head.margin,
            raised: head.value_octaves * LEVELS_PER_OCTAVE + RAISED,
            slices: offset(head.slices),
            start: offset(HEAD + head.slices),
            slice: offset(head.slice()),
            nodes: offset(head.nodes()),
        })
    }

    /// The first word of a slice.
    #[inline(always)]
    pub(super) fn start(&self, slice: u16) -> u32 {
        u32::from(self.start) + u32::from(slice) * u32::from(self.slice)
    }

    /// Whether the map reaches over a frequency, by its bits.
    #[inline(always)]
    pub(super) fn has_frequency(&self, bits: u32) -> bool {
        self.frequencies.contain(bits)
    }

    /// Which edge a place outside the map is beyond.
    pub(super) fn edge(&self, amplitude: f32, frequency: f32) -> Outside {
        let bits = frequency.to_bits();
        if level(amplitude).is_none() || !(frequency.is_normal() && frequency > 0.0) {
            Outside::NoNumber
        } else if bits < self.frequencies.least {
            Outside::FrequencyBelow
        } else if !self.has_frequency(bits) {
            Outside::FrequencyAbove
        } else if amplitude == 0.0 || amplitude.to_bits() < self.amplitudes.least {
            Outside::AmplitudeBelow
        } else {
            Outside::AmplitudeAbove
        }
    }

    /// Level of the amplitude and place of the frequency, by the bits of both; `None` outside the map.
    #[inline(always)]
    pub(super) fn place(&self, amplitude: u32, frequency: u32) -> Option<(i32, Column)> {
        if !self.amplitudes.contain(amplitude) || !self.frequencies.contain(frequency) {
            return None;
        }
        let units = fixed_of_bits(frequency, self.right.wrapping_sub(frequency >> 23));
        let distance = units.cast_signed().wrapping_sub(self.resonance);
        let from_first = (detuning(distance, self.slope) - self.first).cast_unsigned();
        let columns = from_first.wrapping_mul(self.factor);
        let column = Column { below: columns >> 25, place: (columns >> 15 & 1023).cast_signed() };
        Some((level_of_bits(amplitude), column))
    }

    /// The levels of the rising and of the falling boundary, whose words begin at `start`.
    #[inline(always)]
    pub(super) fn curves<W: Words>(
        &self,
        words: W,
        start: u32,
        Column { below, place }: Column,
    ) -> Option<[i32; 2]> {
        let cell = words.cell(start + below, self.columns)?;
        Some(cell.map(|[left, right]| left + (((right - left) * place) >> 10)))
    }

    /// The value of a branch, 0 or 1, of the slice at `start`, at a distance in levels from its boundary, with its bounds.
    #[inline(always)]
    pub(super) fn branch<W: Words>(
        &self,
        words: W,
        start: u32,
        which: usize,
        distance: i32,
        Column { below, place }: Column,
    ) -> Option<Bounded> {
        let [lower, upper] = &self.sides;
        let side = if which == 0 { lower } else { upper };
        if side.nodes == 0 {
            return Some(Bounded::default());
        }
        // The rows reach over the whole map. Beyond the last one is the next column's first one, which counts nothing there.
        let distance = distance.max(0).min(i32::from(side.farthest)).cast_unsigned();
        let (row, above) = side.spacing.row(distance);
        let above = above.cast_signed();
        let start = start + u32::from(side.nodes);
        let node = start + below * u32::from(self.rows) + (row & 63);
        let across = |[left, right]: [i32; 2], part: i32| left + (((right - left) * part + 512) >> 10);
        let [left, right] = words.cell(node, self.rows)?;
        let level = across([across(left, above), across(right, above)], place) + self.raised;
        let part =
            ((below * u32::from(self.eighths)) >> 3) + if row < side.near { 0 } else { BOUNDS as u32 / 2 };
        let bounds = i32::from(words.at(start + u32::from(self.nodes) + part)?);
        // From 1/128 octaves to levels.
        let (lower, higher) = ((bounds & 0xff) << 4, (bounds >> 8) << 4);
        let number = |level: i32| f32::from_bits(bits_of_raised(level));
        // The largest byte is no bound: the model may yield nothing.
        let low = if bounds & 0xff == 0xff { 0.0 } else { number(level - lower) };
        Some(Bounded { value: number(level), low, high: number(level + higher) })
    }
}
