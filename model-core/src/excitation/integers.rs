//! Divisions, logarithms and powers of two in integers, with the same bits in both precisions.

/// `ln 2` in units of 2⁻⁶⁴.
const LN_2: u64 = 0xb172_17f7_d1cf_79ac;
/// Terms of the power series of `2^x` in `x ln 2`; the next is below 2⁻⁶⁵.
const TERMS: usize = 20;
/// `2⁶²/n!`, rounded to nearest.
const SERIES: [u64; TERMS + 1] = {
    let mut terms = [1_u64 << 62; TERMS + 1];
    let mut factorial = 1_u128;
    let mut n = 1;
    while n <= TERMS {
        factorial *= n as u128;
        terms[n] = (((1_u128 << 62) + factorial / 2) / factorial) as u64;
        n += 1;
    }
    terms
};

/// The upper half of a product.
pub(super) fn upper_product(a: u64, b: u64) -> u64 {
    ((u128::from(a) * u128::from(b)) >> 64) as u64
}

/// `numerator · 2^bits / denominator`, rounded down, modulo 2¹²⁸; 0 for a denominator of 0, which is below 2¹²⁷.
///
/// Bit by bit, because no other code of a firmware links a 128-bit division.
pub(super) fn divide(numerator: u128, bits: u32, denominator: u128) -> u128 {
    if denominator == 0 {
        return 0;
    }
    let (mut quotient, mut remainder) = (0_u128, 0_u128);
    for place in (0..bits.saturating_add(128)).rev() {
        let bit = place.checked_sub(bits).map_or(0, |place| numerator.wrapping_shr(place) & 1);
        remainder = (remainder << 1) | bit;
        quotient <<= 1;
        if remainder >= denominator {
            remainder = remainder.wrapping_sub(denominator);
            quotient |= 1;
        }
    }
    quotient
}

/// `log₂ (number/2⁶³)` in units of 2⁻⁶³, rounded down, for a number of at least 2⁶³. Each squaring gives a bit.
fn logarithm_of_mantissa(number: u64) -> u64 {
    let (mut mantissa, mut logarithm) = (number, 0);
    for _ in 0..63 {
        let square = u128::from(mantissa) * u128::from(mantissa);
        let two = square >> 127;
        mantissa = (square >> (63 + two)) as u64;
        logarithm = (logarithm << 1) | two as u64;
    }
    logarithm
}

/// `log₂ (high/low)` in units of 2⁻⁵⁷ for `low ≤ high`, a quotient below 2⁶⁵; both are above 0.
pub(super) fn octaves(low: u128, high: u128) -> u64 {
    // Within a factor of 2⁶³; the quotient then has its highest bit at 63 or above.
    let quotient = divide(high, 63, low).max(1 << 63);
    let whole = 64 - quotient.leading_zeros();
    let mantissa = (quotient >> whole) as u64;
    (u64::from(whole) << 57) + (logarithm_of_mantissa(mantissa) >> 6)
}

/// `2^x` in units of 2⁻⁶² for `x` in units of 2⁻⁶⁴: from 2⁶² to 2⁶³.
pub(super) fn power_of_two(x: u64) -> u64 {
    let argument = upper_product(x, LN_2);
    SERIES.iter().rev().fold(0, |sum, term| upper_product(sum, argument).wrapping_add(*term))
}

pub(super) fn times_ln_2(number: u64) -> u64 {
    upper_product(number, LN_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_logarithms_and_powers_are_those_of_the_platform() {
        for (numerator, bits, denominator) in
            [(1, 96, 3_u128), (7 << 70, 40, 1 << 76), (5, 0, 7), (1, 127, 977)]
        {
            let exact = numerator as f64 * 2f64.powi(bits as i32) / denominator as f64;
            let found = divide(numerator, bits, denominator);
            assert!((found as f64 - exact).abs() <= 1.0 + 1e-15 * exact, "{numerator} {bits} {denominator}");
            let exactly = (numerator << bits.min(50)) / denominator;
            assert_eq!(divide(numerator, bits.min(50), denominator), exactly);
        }
        assert_eq!(divide(1, 10, 0), 0);
        for ratio in [1.0, 1.001, 1.5, 1.999_999, 2.0, 3.7, 100.0, 999_999.0_f64] {
            let (low, high) = (1_u128 << 60, (ratio * 2f64.powi(60)) as u128);
            let found = octaves(low, high) as f64 / 2f64.powi(57);
            assert!((found - ratio.log2()).abs() < 5e-15, "{ratio}: {found}");
        }
        for k in 0..=1000_u64 {
            let x = k * (u64::MAX / 1000);
            let found = power_of_two(x) as f64 / 2f64.powi(62);
            let exact = (x as f64 / 2f64.powi(64)).exp2();
            assert!((found - exact).abs() < 5e-16, "{k}: {found} {exact}");
        }
    }
}
