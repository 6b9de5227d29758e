//! The coordinates of a map, in integers: the same on every core, and cheap without a floating-point unit.
//!
//! A *level* is the binary logarithm of a positive number in units of 2⁻¹¹ octaves. A *detuning* is the inverse
//! hyperbolic sine of the distance from the resonance in half-bandwidths, in units of 2⁻¹². Both are piecewise linear
//! through the exact values at sixteen (level) or eight (detuning) places in an octave. The host places the nodes by
//! these very functions, so their difference from the exact ones is no error of the map.

/// Units of a level in an octave.
pub const LEVELS_PER_OCTAVE: i32 = 1 << LEVEL_BITS;
const LEVEL_BITS: u32 = 11;
/// Octaves by which the level of an amplitude in m/s², or of a voltage in V, is shifted to be positive.
pub const AMPLITUDE_OCTAVES: i32 = 16;
/// Largest distance from the resonance, in units of the frequency.
pub const FARTHEST: u32 = (1 << 18) - 1;

/// `2¹¹ log2(1 + k/16)`, rounded.
const LOGARITHM: [u32; 17] =
    [0, 179, 348, 508, 659, 803, 941, 1072, 1198, 1319, 1435, 1546, 1653, 1757, 1857, 1954, 2048];

/// `2²³ (2^(k/16) − 1)`, rounded.
const EXPONENTIAL: [u32; 17] = [
    0, 371_395, 759_234, 1_164_243, 1_587_184, 2_028_850, 2_490_071, 2_971_711, 3_474_675, 3_999_908,
    4_548_394, 5_121_164, 5_719_293, 6_343_903, 6_996_167, 7_677_309, 8_388_608,
];

/// `2¹² arsinh(2^e (1 + k/8) − 1)` at `8 e + k` for e and k from 0 to 7, rounded, and that for e = 8, k = 0.
const ARSINH: [u32; 65] = [
    0, 511, 1014, 1502, 1971, 2417, 2839, 3237, 3610, 4291, 4894, 5431, 5913, 6349, 6747, 7112, 7448, 8052,
    8580, 9049, 9472, 9855, 10206, 10530, 10830, 11372, 11852, 12281, 12669, 13024, 13351, 13654, 13936,
    14448, 14902, 15312, 15684, 16025, 16340, 16633, 16906, 17403, 17846, 18246, 18610, 18944, 19254, 19541,
    19810, 20299, 20737, 21132, 21492, 21823, 22129, 22414, 22681, 23167, 23601, 23994, 24352, 24682, 24987,
    25271, 25536,
];

/// Each entry of [`ARSINH`] in the upper 16 bits and the rise to the next one in the lower ones: one load for a chord. Moved
/// by 16 places, so that the index is a number's leading four bits less eight times its leading zeros, modulo 64.
static ARSINH_CHORDS: [u32; 64] = {
    let mut chords = [0; 64];
    let mut index = 0;
    while index < 64 {
        chords[(index + 16) % 64] = ARSINH[index] << 16 | (ARSINH[index + 1] - ARSINH[index]);
        index += 1;
    }
    chords
};

/// Chords of [`LOGARITHM`] less the mantissa, which the bits of a number have already: the offset in 2⁻¹² levels, without the
/// exponent of the least number and with half a level for rounding. Its lowest byte is the slope in levels; the offset is by up to
/// 1/16 level larger for it.
static LOGARITHM_CHORDS: [u32; 16] = {
    let mut chords = [0; 16];
    let mut index = 0;
    while index < 16 {
        let [low, high] = [LOGARITHM[index] as i32, LOGARITHM[index + 1] as i32];
        let offset = ((low - 128 * index as i32) << 12) + (1 << 11) - LEAST as i32;
        let slope = (high - low - 128) as i8;
        chords[index] = offset.cast_unsigned() | slope.cast_unsigned() as u32;
        index += 1;
    }
    chords
};

/// Chords of [`EXPONENTIAL`] less the fraction of the level, in 2⁻¹⁵: offset in the upper half, and in the lower one the slope
/// over 2⁷ levels.
static EXPONENTIAL_CHORDS: [u32; 16] = {
    let mut chords = [0; 16];
    let mut index = 0;
    while index < 16 {
        let low = ((EXPONENTIAL[index] as i32 + 128) >> 8) - ((index as i32) << 11);
        let high = ((EXPONENTIAL[index + 1] as i32 + 128) >> 8) - ((index as i32 + 1) << 11);
        chords[index] = (low.cast_unsigned() << 16) | ((high - low).cast_unsigned() & 0xffff);
        index += 1;
    }
    chords
};

/// The level of an amplitude in m/s² or of a voltage in V, shifted by [`AMPLITUDE_OCTAVES`]: 0 at 2⁻¹⁶ and less, below
/// 2¹⁹ for every finite number; `None` for a negative number and for one that is not finite.
#[inline]
#[must_use]
pub fn level(number: f32) -> Option<i32> {
    let bits = number.to_bits();
    // All negative numbers but −0 and all that are not finite have larger bits.
    if bits >= f32::INFINITY.to_bits() {
        return if number == 0.0 { Some(0) } else { None };
    }
    if bits < LEAST {
        return Some(0);
    }
    Some(level_of_bits(bits))
}

/// Bits of 2⁻¹⁶, the least number with a level of its own.
const LEAST: u32 = (127 - AMPLITUDE_OCTAVES.cast_unsigned()) << 23;

/// The level of a finite number of at least 2⁻¹⁶, by its bits.
#[inline]
pub(super) const fn level_of_bits(bits: u32) -> i32 {
    let chord = LOGARITHM_CHORDS[(bits >> 19 & 15) as usize];
    let slope = chord as i8 as i32;
    let above = (slope * (bits & 0x7_ffff).cast_signed()) >> 7;
    bits.wrapping_add(chord).cast_signed().wrapping_add(above) >> 12
}

/// The number of a level that is not shifted, within the normal numbers.
#[inline]
#[must_use]
pub fn number(level: i32) -> f32 {
    f32::from_bits(bits_of_raised(level.clamp(-126 << LEVEL_BITS, (128 << LEVEL_BITS) - 1) + RAISED))
}

/// What is added to a level for [`bits_of_raised`].
pub(super) const RAISED: i32 = 127 << LEVEL_BITS;

/// The bits of the number of a level that is raised by [`RAISED`] and then from 1 octave to below 255: sixteen significant
/// bits, the others are 0.
#[inline]
pub(super) fn bits_of_raised(level: i32) -> u32 {
    let chord = EXPONENTIAL_CHORDS.get((level >> 7 & 15) as usize).copied().unwrap_or(0).cast_signed();
    let fraction = (chord >> 16) + ((i32::from(chord as i16) * (level & 127)) >> 7);
    (level << 4).wrapping_add(fraction).cast_unsigned() << 8
}

/// A frequency in units of 2^−`shift` Hz, rounded down; `None` unless positive and below 2³⁰ units.
#[inline]
#[must_use]
pub const fn fixed(frequency: f32, shift: i32) -> Option<u32> {
    let bits = frequency.to_bits();
    // Numbers that are subnormal, negative or not finite.
    if bits < f32::MIN_POSITIVE.to_bits() || bits >= f32::INFINITY.to_bits() {
        return None;
    }
    // Of the leading bit above bit 31: the mantissa lies at the upper end.
    let right = (158 - (bits >> 23).cast_signed()).saturating_sub(shift);
    if right <= 1 {
        return None;
    }
    Some(if right < 32 { fixed_of_bits(bits, right.cast_unsigned()) } else { 0 })
}

/// A normal number in units, by its bits: its mantissa at the upper end of a word, moved `right` by up to 31.
#[inline]
pub(super) const fn fixed_of_bits(bits: u32, right: u32) -> u32 {
    (bits << 8 | 1 << 31).wrapping_shr(right)
}

/// The detuning of a frequency `distance` units from the resonance, that of [`FARTHEST`] beyond; `slope` is 2²⁴ over the
/// half-bandwidth in units, 2¹³ where it is larger.
#[inline]
#[must_use]
pub fn detuning(distance: i32, slope: u32) -> i32 {
    let farthest = FARTHEST.cast_signed();
    detuning_within(distance.clamp(-farthest, farthest), slope.min(1 << 13))
}

/// As [`detuning`] within those bounds, without a meaning beyond.
#[inline]
pub(super) const fn detuning_within(distance: i32, slope: u32) -> i32 {
    // Half-bandwidths and one more, in 2⁻²⁴: 1 has seven leading zeros.
    let beside = distance.unsigned_abs().wrapping_mul(slope).wrapping_add(1 << 24);
    let zeros = beside.leading_zeros();
    let top = beside.wrapping_shl(zeros);
    let index = (top >> 28).wrapping_sub(8 * zeros) % 64;
    let chord = ARSINH_CHORDS[index as usize];
    let magnitude = ((chord >> 16) + (((chord & 0xffff) * (top << 4 >> 23) + 256) >> 9)).cast_signed();
    if distance < 0 { -magnitude } else { magnitude }
}

/// The rows of a branch: how close they lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spacing {
    /// The first octave of rows is 2^`shift` levels long; at least `bits`.
    pub shift: u32,
    /// An octave has 2^`bits` rows.
    pub bits: u32,
}

impl Spacing {
    /// Of a word of a map.
    pub(super) const fn of(word: u16) -> Self {
        Self { shift: (word & 0xff) as u32, bits: (word >> 8) as u32 }
    }

    /// Whether a map may have it.
    pub(super) const fn is_stored(self) -> bool {
        1 <= self.bits && self.bits <= 2 && self.bits <= self.shift && self.shift <= 12
    }

    /// Distance of the last of some rows from the boundary, in levels; the largest one without rows.
    pub(super) const fn reach(self, rows: u32) -> i32 {
        match rows.checked_sub(1) {
            Some(last) => row_distance(last, self).cast_signed(),
            None => i32::MAX,
        }
    }

    /// For look-ups among rows of which the first has the number `start`.
    pub(super) const fn folded(self, start: u32) -> FoldedSpacing {
        let Self { shift, bits } = self;
        FoldedSpacing {
            first: 1_u32.wrapping_shl(shift),
            octave: 1_u32.wrapping_shl(bits),
            from: 30_u32.wrapping_sub(shift).wrapping_shl(bits).wrapping_add(start),
        }
    }
}

/// A [`Spacing`] as a look-up takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FoldedSpacing {
    /// Levels of the first octave of rows.
    first: u32,
    /// Rows in an octave.
    octave: u32,
    /// Rows up to the leading bit of a number without leading zeros.
    from: u32,
}

impl FoldedSpacing {
    /// As [`row`], with the number of the first row added.
    #[inline]
    pub(super) fn row(self, distance: u32) -> (u32, u32) {
        let beside = distance.wrapping_add(self.first);
        let zeros = beside.leading_zeros();
        // The leading bit is 2¹⁶, so that the upper word counts the rows of an octave from `octave`.
        let rows = (beside.wrapping_shl(zeros) >> 15).wrapping_mul(self.octave);
        (self.from.wrapping_sub(zeros.wrapping_mul(self.octave)).wrapping_add(rows >> 16), rows >> 6 & 1023)
    }
}

/// The row and the place above it, in 2⁻¹⁰ of the distance to the next row, of a level at a distance from the boundary.
///
/// The rows lie evenly in each octave of the distance increased by 2^`shift`: with two of them in an octave 0, ½, 1, 2, 3, 5,
/// 7, 11, 15, … times 2^`shift` levels from the boundary. A distance of 2³¹ and more, a `shift` above 30 and `bits` above 15
/// count as 2³¹ − 1, 30 and 15.
#[inline]
#[must_use]
pub fn row(distance: u32, Spacing { shift, bits }: Spacing) -> (u32, u32) {
    Spacing { shift: shift.min(30), bits: bits.min(15) }.folded(0).row(distance.min(u32::MAX >> 1))
}

/// Distance of a row from the boundary, in levels: the inverse of [`row`]; `u32::MAX` from 2³² levels on.
#[must_use]
pub const fn row_distance(row: u32, Spacing { shift, bits }: Spacing) -> u32 {
    let (shift, bits) = (if shift < 30 { shift } else { 30 }, if bits < 15 { bits } else { 15 });
    let within = row & ((1 << bits) - 1);
    match 1_u32.checked_shl((row >> bits).saturating_add(shift)) {
        Some(start) => within.wrapping_mul(start >> bits).wrapping_add(start).wrapping_sub(1 << shift),
        None => u32::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_logarithms_and_numbers_their_inverse() {
        let mut number_of = 1.6e-5_f32;
        while number_of < 6e4 {
            let exact = (f64::from(number_of).log2() + 16.0) * 2048.0;
            let found = level(number_of).expect("positive");
            // The chord of a sixteenth of an octave is at most 7.1e-4 octaves low, and entries are rounded.
            assert!((-2.9..1.1).contains(&(f64::from(found) - exact)), "{number_of}: {found} {exact}");
            let back = number(found - AMPLITUDE_OCTAVES * LEVELS_PER_OCTAVE);
            assert!((f64::from(back / number_of) - 1.0).abs() < 1.4e-3, "{number_of}: {back}");
            number_of *= 1.003;
        }
        for level in (-60_000..60_000).step_by(7) {
            let exact = (f64::from(level) / 2048.0).exp2();
            assert!((f64::from(number(level)) / exact - 1.0).abs() < 2.5e-4, "{level}");
            assert!(number(level + 7) > number(level));
        }
    }

    #[test]
    fn what_is_no_amplitude_or_frequency_has_no_level() {
        for refused in [-1.0, f32::NAN, f32::INFINITY, -f32::INFINITY, -1e-40] {
            assert_eq!(level(refused), None, "{refused}");
            assert_eq!(fixed(refused, 15), None, "{refused}");
        }
        for least in [0.0, -0.0, 1e-40, 1e-6] {
            assert_eq!(level(least), Some(0));
        }
        assert_eq!(fixed(0.0, 15), None);
        assert_eq!((fixed(1e30, 15), fixed(1e-30, 15)), (None, Some(0)));
    }

    #[test]
    fn a_fixed_frequency_is_the_frequency_in_units() {
        for shift in -4..18 {
            for frequency in [0.3_f32, 1.0, 20.131, 239.7, 8765.4] {
                let exact = f64::from(frequency) * f64::from(shift).exp2();
                match fixed(frequency, shift) {
                    Some(found) => {
                        assert!((0.0..1.0).contains(&(exact - f64::from(found))), "{frequency} {shift}")
                    }
                    None => assert!(exact >= 1.0_f64 * 0.5 * f64::from(1 << 30)),
                }
            }
        }
    }

    #[test]
    fn detunings_are_odd_rise_and_follow_the_inverse_hyperbolic_sine() {
        for unit in [2048.0_f64, 3000.0, 4095.0] {
            let slope = (f64::from(1 << 24) / unit).round() as u32;
            let mut before = -1;
            for distance in (0..FARTHEST.cast_signed()).step_by(13) {
                let exact = (f64::from(distance) / unit).asinh() * 4096.0;
                let found = detuning(distance, slope);
                // The chords of an eighth of an octave lie 3e-3 low; entries are rounded.
                assert!(
                    (-16.0..2.0).contains(&(f64::from(found) - exact)),
                    "{distance} {unit}: {found} {exact}"
                );
                assert!(found >= before);
                before = found;
                assert_eq!(detuning(-distance, slope), -found);
            }
        }
    }

    #[test]
    fn rows_and_their_distances_are_inverse() {
        for (shift, bits) in (2..12).flat_map(|shift| [(shift, 1), (shift, 2)]) {
            let spacing = Spacing { shift, bits };
            for index in 0..20 {
                let distance = row_distance(index, spacing);
                assert_eq!(row(distance, spacing), (index, 0));
                let next = row_distance(index + 1, spacing);
                let middle = distance.midpoint(next);
                let (found, place) = row(middle, spacing);
                let exact = f64::from(middle - distance) / f64::from(next - distance) * 1024.0;
                assert_eq!(found, index);
                assert!((f64::from(place) - exact).abs() < 1.0, "{shift} {index}");
            }
        }
        let two = Spacing { shift: 4, bits: 1 };
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|row| row_distance(row, two)), [0, 8, 16, 32, 48, 80, 112]);
    }

    #[test]
    fn numbers_outside_the_ranges_are_those_at_their_ends() {
        let edges = [0, 1, 12, 30, 31, 32, 33, 1 << 13, (1 << 13) + 1, FARTHEST + 1, 1 << 31, u32::MAX];
        for (distance, slope) in edges.into_iter().flat_map(|one| edges.map(|other| (one, other))) {
            let within = detuning(distance.min(FARTHEST).cast_signed(), slope.min(1 << 13));
            // 2³¹ and more are negative.
            let expected = if distance > i32::MAX.cast_unsigned() {
                -detuning(
                    distance.cast_signed().unsigned_abs().min(FARTHEST).cast_signed(),
                    slope.min(1 << 13),
                )
            } else {
                within
            };
            assert_eq!(detuning(distance.cast_signed(), slope), expected, "{distance} {slope}");
            for frequency in [f32::MIN_POSITIVE, 1.0, f32::MAX] {
                let units = f64::from(frequency).log2() + f64::from(distance.cast_signed());
                let found = fixed(frequency, distance.cast_signed());
                assert!(
                    if units < 0.0 { found == Some(0) } else { found.is_some() == (units < 30.0) },
                    "{distance}"
                );
            }
            for bits in [0, 1, 2, 15, 16, u32::MAX] {
                let spacing = Spacing { shift: slope, bits };
                let [shift, bits] = [slope.min(30), bits.min(15)];
                let (octave, part) =
                    (u128::from(distance >> bits) + u128::from(shift), distance % (1 << bits));
                let start = 1_u128 << octave.min(64);
                let exact = start + (start >> bits) * u128::from(part) - (1 << shift);
                let expected = if octave < 32 { exact } else { u128::from(u32::MAX) };
                assert_eq!(u128::from(row_distance(distance, spacing)), expected, "{distance} {spacing:?}");
                let (index, place) = row(distance, spacing);
                let far = row(distance.min(u32::MAX >> 1), Spacing { shift, bits });
                assert!((index, place) == far && place < 1024, "{distance} {spacing:?}");
            }
        }
    }
}
