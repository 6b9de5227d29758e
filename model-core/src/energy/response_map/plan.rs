//! What a look-up needs of a map, folded once when the map is checked: edges as the bits of floating-point numbers, so that
//! one subtraction and one comparison find out whether a number is within them, and the constants of both coordinates.

use super::coordinate::{
    FARTHEST, FoldedSpacing, LEVELS_PER_OCTAVE, RAISED, bits_of_raised, detuning_within, fixed,
    fixed_of_bits, level, level_of_bits,
};
use super::image::{COLUMN_BITS, COLUMN_WORDS, COLUMNS, Head, NEAR, SLICE_BOUNDS};
use super::words::Word;
use super::{Bounded, Outside, Spacing};

/// A place on the axis of the columns, in 2⁻²⁷ of their distance.
#[derive(Clone, Copy)]
pub(super) struct Place(u32);

impl Place {
    /// The column to the left.
    #[inline]
    pub(super) fn column(self) -> usize {
        (self.0 >> (32 - COLUMN_BITS)) as usize
    }

    /// The part of the columns that has bounds of its own.
    #[inline]
    pub(super) fn part(self) -> usize {
        (self.0 >> 29) as usize
    }

    /// The place to the right of the column, in 2⁻¹⁰ of the distance.
    #[inline]
    fn right(self) -> i32 {
        (self.0 >> (22 - COLUMN_BITS) & 1023).cast_signed()
    }
}

/// The bits of the least number within two edges, and by how much those of the largest are greater. Positive numbers rise with
/// their bits; those of all others are greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Edges {
    least: u32,
    span: u32,
}

impl Edges {
    /// The numbers of an axis from `lowest` to `highest`; `None` if there are none.
    const fn of(axis: Axis<'_>, lowest: i32, highest: i32) -> Option<Self> {
        let (least, beyond) = (axis.first(lowest), axis.first(highest.wrapping_add(1)));
        if beyond > least { Some(Self { least, span: beyond - least - 1 }) } else { None }
    }

    #[inline]
    const fn contain(self, bits: u32) -> bool {
        bits.wrapping_sub(self.least) <= self.span
    }
}

/// An axis of a map.
#[derive(Clone, Copy)]
enum Axis<'a> {
    Level,
    /// The detuning from the first column.
    Detuning(&'a Head),
}

impl Axis<'_> {
    /// The place of a number, by its bits, with which it rises; one that is no detuning is beyond all others.
    const fn place(self, bits: u32) -> i32 {
        let Self::Detuning(head) = self else { return level_of_bits(bits) };
        let nearest = FARTHEST.cast_signed();
        match fixed(f32::from_bits(bits), head.frequency_shift) {
            None => i32::MAX,
            Some(0) => i32::MIN,
            Some(units) => match units.cast_signed().wrapping_sub(head.resonance) {
                distance if distance > nearest => i32::MAX,
                distance if distance < -nearest => i32::MIN,
                distance => detuning_within(distance, head.slope).wrapping_sub(head.first),
            },
        }
    }

    /// The bits of the first normal number at this place or above.
    const fn first(self, place: i32) -> u32 {
        let (mut low, mut high) = (f32::MIN_POSITIVE.to_bits(), f32::INFINITY.to_bits());
        while low < high {
            let middle = low.midpoint(high);
            if self.place(middle) >= place { high = middle } else { low = middle.wrapping_add(1) }
        }
        low
    }
}

/// Where the rows of a branch are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Side {
    /// Numbers of the rows begin with the first one's word in its column.
    spacing: FoldedSpacing,
    /// Word of the first row that has the bounds of those far from the boundary.
    far: u32,
}

impl Side {
    const fn new(first: u32, rows: u32, spacing: Spacing) -> Self {
        // A branch without values has its rows behind the column.
        let first = if rows == 0 { COLUMN_WORDS as u32 } else { first };
        let near = (NEAR / 2).wrapping_shl(spacing.bits);
        Self { spacing: spacing.folded(first), far: first.wrapping_add(near) }
    }
}

/// All that a look-up needs beside the words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plan {
    amplitudes: Edges,
    frequencies: Edges,
    /// By how much a frequency is moved right at the exponent 0.
    pub(super) right: u32,
    pub(super) resonance: i32,
    slope: u32,
    /// From a detuning to a [`Place`], and the place of the resonance.
    factor: u32,
    middle: u32,
    /// Levels beside a boundary within which both branches are given.
    pub(super) margin: i32,
    /// What is added to the level of a value.
    raised: i32,
    pub(super) lower: Side,
    pub(super) upper: Side,
    /// First word of the columns, and of the bounds.
    starts: [u16; 2],
    pub(super) slices: u16,
    pub(super) is_current: bool,
}

impl Plan {
    /// The plan of a checked head; `None` if no frequency is within the map.
    pub(super) const fn new(head: &Head) -> Option<Self> {
        let amplitudes = Edges::of(Axis::Level, head.lowest, head.highest);
        let frequencies = Edges::of(Axis::Detuning(head), 0, head.span.cast_signed());
        // The last column is just beyond the last detuning, so that each place is between two columns.
        let (Some(amplitudes), Some(frequencies), Some(factor)) =
            (amplitudes, frequencies, u32::MAX.checked_div(head.span))
        else {
            return None;
        };
        let ([lower_rows, upper_rows], [lower, upper]) = (head.rows, head.spacings);
        Some(Self {
            amplitudes,
            frequencies,
            right: 158_i32.wrapping_sub(head.frequency_shift).cast_unsigned(),
            resonance: head.resonance,
            slope: head.slope,
            factor,
            middle: head.first.wrapping_neg().cast_unsigned().wrapping_mul(factor),
            margin: head.margin,
            raised: head.value_octaves.wrapping_mul(LEVELS_PER_OCTAVE).wrapping_add(RAISED),
            // The boundaries are before the rows.
            lower: Side::new(2, lower_rows, lower),
            upper: Side::new(lower_rows.wrapping_add(2), upper_rows, upper),
            // A map has less than 2¹⁶ words.
            starts: [head.columns_from() as u16, head.parts_from() as u16],
            slices: head.slices as u16,
            is_current: head.is_current,
        })
    }

    /// Whether the map reaches over a frequency, by its bits.
    #[inline]
    pub(super) const fn has_frequency(&self, bits: u32) -> bool {
        self.frequencies.contain(bits)
    }

    /// Which edge a place outside the map is beyond.
    #[cold]
    #[inline(never)]
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
    #[inline]
    pub(super) fn place(&self, amplitude: u32, frequency: u32) -> Option<(i32, Place)> {
        if !self.amplitudes.contain(amplitude) || !self.frequencies.contain(frequency) {
            return None;
        }
        let units = fixed_of_bits(frequency, self.right.wrapping_sub(frequency >> 23));
        let distance = units.cast_signed().wrapping_sub(self.resonance);
        let from_middle = detuning_within(distance, self.slope).cast_unsigned();
        let place = Place(from_middle.wrapping_mul(self.factor).wrapping_add(self.middle));
        Some((level_of_bits(amplitude), place))
    }

    /// First word of the columns of a slice, and of its bounds.
    pub(super) fn slice(&self, slice: u16) -> [usize; 2] {
        let ([columns, bounds], slice) = (self.starts, usize::from(slice));
        [usize::from(columns) + slice * COLUMNS * COLUMN_WORDS, usize::from(bounds) + slice * SLICE_BOUNDS]
    }

    /// The output power of a branch between two columns, at a distance in levels from its boundary, beyond it that at the boundary;
    /// `None` of a branch without values.
    #[inline(always)]
    pub(super) fn income<T: Word>(
        &self,
        side: &Side,
        [left, right]: [&[T; COLUMN_WORDS]; 2],
        [near, far]: &[[T; 2]; 2],
        distance: i32,
        place: Place,
    ) -> Option<Bounded> {
        let (row, above) = side.spacing.row(distance.max(0).cast_unsigned());
        let row = row as usize;
        // The rows of a checked map reach over all of its amplitudes.
        if row >= COLUMN_WORDS - 1 {
            return None;
        }
        let along = |column: &[T; COLUMN_WORDS]| {
            let [low, high] = [row, row.wrapping_add(1)].map(|row| column.get(row).map_or(0, number));
            between(low, high, above.cast_signed())
        };
        let level = between(along(left), along(right), place.right()).wrapping_add(self.raised);
        let value = f32::from_bits(bits_of_raised(level));
        let [low, high] = if row < side.far as usize { near } else { far };
        Some(Bounded { value, low: product(value, *low), high: product(value, *high) })
    }

    /// As [`Plan::income`] of both branches.
    #[inline(never)]
    pub(super) fn both<T: Word>(
        &self,
        columns: [&[T; COLUMN_WORDS]; 2],
        [lower, upper]: [&[[T; 2]; 2]; 2],
        [below, above]: [i32; 2],
        place: Place,
    ) -> [Bounded; 2] {
        let lower = self.income(&self.lower, columns, lower, below, place).unwrap_or_default();
        let upper = self.income(&self.upper, columns, upper, above, place).unwrap_or_default();
        [lower, upper]
    }
}

/// The levels of the rising and the falling boundary.
#[inline]
pub(super) fn boundaries<T: Word>([left, right]: [&[T; COLUMN_WORDS]; 2], place: Place) -> [i32; 2] {
    let ([rising, falling, ..], [next_rising, next_falling, ..]) = (left, right);
    let across = |left: &T, right: &T| between(number(left), number(right), place.right());
    [across(rising, next_rising), across(falling, next_falling)]
}

#[inline]
fn number<T: Word>(word: &T) -> i32 {
    i32::from(word.number())
}

/// A part of the way in 2⁻¹⁰ from one number to another, rounded down.
#[inline]
fn between(from: i32, to: i32, part: i32) -> i32 {
    from.wrapping_add(to.wrapping_sub(from).wrapping_mul(part) >> 10)
}

/// The product of a value of at most sixteen significant bits and the factor of a bound, of at most eight and 0 or from 1/4 to 4: exact, so that
/// integers give the same bits, on a core without floating point in a fifth of the instructions.
#[inline]
pub(super) fn product<T: Word>(value: f32, factor: T) -> f32 {
    let factor = factor.number();
    if cfg!(all(target_arch = "arm", not(target_abi = "eabihf"))) {
        product_in_integers(value, factor)
    } else {
        value * f32::from_bits(u32::from(factor) << 16)
    }
}

/// As [`product`].
#[inline]
fn product_in_integers(value: f32, factor: u16) -> f32 {
    if factor == 0 {
        return 0.0;
    }
    let (bits, factor) = (value.to_bits(), u32::from(factor));
    // From 2²² to below 2²⁴.
    let significand = ((bits >> 8 & 0x7fff) | 1 << 15) * ((factor & 0x7f) | 1 << 7);
    let exponent = ((bits >> 23) + (factor >> 7)).wrapping_sub(127) << 23;
    // The leading bit counts in the exponent.
    let fraction = if significand < 1 << 23 { 2 * significand - (1 << 23) } else { significand };
    f32::from_bits(exponent.wrapping_add(fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_and_floating_point_have_the_same_product() {
        // 0, and from 1/4 to 4.
        for factor in [0].into_iter().chain(0x3e80..=0x4080_u16) {
            // Sixteen significant bits, the lowest and the highest among them, from 10⁻²⁴ to 10²³, as of maps.
            for significand in [1 << 15, (1 << 16) - 1, 0x9e37, 0xb504, 0xb505, 0xd1b7] {
                for exponent in [-95, -60, -20, 0, 62] {
                    let value = significand as f32 * (exponent as f32).exp2();
                    let product = value * f32::from_bits(u32::from(factor) << 16);
                    let bits = product_in_integers(value, factor).to_bits();
                    assert_eq!(bits, product.to_bits(), "{value} {factor:#x}");
                }
            }
        }
    }
}
