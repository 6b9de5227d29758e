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
/// Units of a detuning in 1.
pub const DETUNING_UNIT: i32 = 1 << DETUNING_BITS;
const DETUNING_BITS: u32 = 12;
/// Largest distance from the resonance, in units of the frequency.
pub const FARTHEST: u32 = (1 << 18) - 1;

/// `2¹¹ log2(1 + k/16)`, rounded.
const LOGARITHM: [u16; 17] =
    [0, 179, 348, 508, 659, 803, 941, 1072, 1198, 1319, 1435, 1546, 1653, 1757, 1857, 1954, 2048];

/// `2²³ (2^(k/16) − 1)`, rounded.
const EXPONENTIAL: [u32; 17] = [
    0, 371_395, 759_234, 1_164_243, 1_587_184, 2_028_850, 2_490_071, 2_971_711, 3_474_675, 3_999_908,
    4_548_394, 5_121_164, 5_719_293, 6_343_903, 6_996_167, 7_677_309, 8_388_608,
];

/// `2¹² arsinh(2^e (1 + k/8) − 1)` at `8 e + k` for e and k from 0 to 7, rounded, and that for e = 8, k = 0.
const ARSINH: [u16; 65] = [
    0, 511, 1014, 1502, 1971, 2417, 2839, 3237, 3610, 4291, 4894, 5431, 5913, 6349, 6747, 7112, 7448, 8052,
    8580, 9049, 9472, 9855, 10206, 10530, 10830, 11372, 11852, 12281, 12669, 13024, 13351, 13654, 13936,
    14448, 14902, 15312, 15684, 16025, 16340, 16633, 16906, 17403, 17846, 18246, 18610, 18944, 19254, 19541,
    19810, 20299, 20737, 21132, 21492, 21823, 22129, 22414, 22681, 23167, 23601, 23994, 24352, 24682, 24987,
    25271, 25536,
];

/// The entry of a table; 0 beyond its end, which no caller reaches.
#[inline(always)]
fn entry<T: Copy + Into<u32>, const N: usize>(table: &[T; N], index: u32) -> u32 {
    table.get(index as usize).map_or(0, |&entry| entry.into())
}

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
    let octave = (bits >> 23).cast_signed() - 127 + AMPLITUDE_OCTAVES;
    if octave < 0 {
        return Some(0);
    }
    let place = (bits >> 19) & 15;
    let low = entry(&LOGARITHM, place);
    let rise = entry(&LOGARITHM, place + 1) - low;
    let within = (rise * ((bits >> 11) & 0xff) + 128) >> 8;
    Some((octave << LEVEL_BITS) + (low + within).cast_signed())
}

/// The number of a level that is not shifted, within the normal numbers.
#[inline]
#[must_use]
pub fn number(level: i32) -> f32 {
    let octave = (level >> LEVEL_BITS).clamp(-126, 127);
    let rest = level.cast_unsigned() & ((1 << LEVEL_BITS) - 1);
    let place = rest >> 7;
    let low = entry(&EXPONENTIAL, place);
    let rise = entry(&EXPONENTIAL, place + 1) - low;
    let fraction = low + ((rise * (rest & 127)) >> 7);
    f32::from_bits(((octave + 127).cast_unsigned() << 23) + fraction)
}

/// A frequency in units of 2^−`shift` Hz, rounded down; `None` unless positive and below 2³⁰ units.
#[inline]
#[must_use]
pub fn fixed(frequency: f32, shift: i32) -> Option<u32> {
    let bits = frequency.to_bits();
    // Numbers that are subnormal, negative or not finite.
    if !(0x0080_0000..f32::INFINITY.to_bits()).contains(&bits) {
        return None;
    }
    let mantissa = (bits & 0x007f_ffff) | 0x0080_0000;
    let left = (bits >> 23).cast_signed() - 150 + shift;
    if left > 6 {
        return None;
    }
    Some(if left >= 0 { mantissa << left } else { mantissa.checked_shr(left.unsigned_abs()).unwrap_or(0) })
}

/// The detuning of a frequency `distance` units from the resonance, at most [`FARTHEST`] in magnitude; `slope` is 2²⁴ over
/// the half-bandwidth in units, at most 2¹³.
#[inline]
#[must_use]
pub fn detuning(distance: i32, slope: u32) -> i32 {
    let half_bandwidths = (distance.unsigned_abs() * slope) >> 12;
    let beside = half_bandwidths + (1 << DETUNING_BITS);
    let octave = octave_above(beside, DETUNING_BITS);
    let place = beside >> (octave + DETUNING_BITS - 3);
    let rest = (beside & ((1 << (octave + DETUNING_BITS - 3)) - 1)) >> octave;
    // `place` has its leading bit, which is 8.
    let index = 8 * octave + place - 8;
    let low = entry(&ARSINH, index);
    let rise = entry(&ARSINH, index + 1).wrapping_sub(low);
    let magnitude = (low + ((rise * rest + 256) >> 9)).cast_signed();
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

/// The row and the place above it, in 2⁻¹⁰ of the distance to the next row, of a level at a distance from the boundary.
///
/// The rows lie evenly in each octave of the distance increased by 2^`shift`: with two of them in an octave 0, ½, 1, 2, 3, 5,
/// 7, 11, 15, … times 2^`shift` levels from the boundary.
#[inline]
#[must_use]
pub fn row(distance: u32, Spacing { shift, bits }: Spacing) -> (u32, u32) {
    let beside = distance + (1 << shift);
    let octave = octave_above(beside, shift);
    // A row has 2^(octave + shift − bits) levels.
    let within = octave + shift - bits;
    let row = (beside >> within) & ((1 << bits) - 1);
    let rest = beside & ((1 << within) - 1);
    ((octave << bits) + row, if within > 10 { rest >> (within - 10) } else { rest << (10 - within) })
}

/// Distance of a row from the boundary, in levels: the inverse of [`row`].
#[must_use]
pub fn row_distance(row: u32, Spacing { shift, bits }: Spacing) -> u32 {
    let start = 1_u32 << ((row >> bits) + shift);
    start + (row & ((1 << bits) - 1)) * (start >> bits) - (1 << shift)
}

/// Position of the leading bit of `value` above bit `from`; `value` has a bit there or higher.
#[inline(always)]
fn octave_above(value: u32, from: u32) -> u32 {
    (31 - from).saturating_sub(value.leading_zeros())
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
}
