//! Implements [`Scalar`] for `f32` and `f64`.

use super::{Decomposed, Polynomial, Scalar, Sealed};

/// Implements [`Scalar`] for `$float` with the bits of a `$bits`.
///
/// The square root takes `$iterations` of Newton's iteration from an estimate within 6 %: the bits of the number, shifted
/// to halve the biased exponent, plus `$offset`. With `$below` numbers below the normal ones, whose estimate is farther off, take one more.
macro_rules! impl_scalar {
    ($float:ident, $bits:ident, $from_fraction:expr, $offset:literal, $iterations:literal, $below:literal) => {
        #[allow(clippy::cast_lossless, clippy::cast_possible_truncation, reason = "rounding is the purpose")]
        impl Scalar for $float {
            type Build = Polynomial;

            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $float::EPSILON;
            const IS_DOUBLE: bool = $float::MANTISSA_DIGITS > 24;
            const TINY: Self = $float::MIN_POSITIVE;
            const INFINITY: Self = $float::INFINITY;

            #[inline]
            fn from_f64(value: f64) -> Self {
                value as $float
            }

            #[inline]
            fn from_u32(value: u32) -> Self {
                value as $float
            }

            #[inline]
            fn from_i32(value: i32) -> Self {
                value as $float
            }

            #[inline]
            fn from_fraction(value: i64) -> Self {
                ($from_fraction)(value)
            }

            #[inline]
            #[expect(clippy::cast_sign_loss, reason = "saturates, as documented")]
            fn to_u32(self) -> u32 {
                self as u32
            }

            #[inline]
            fn to_f32(self) -> f32 {
                self as f32
            }

            fn to_f64(self) -> f64 {
                self as f64
            }

            #[inline]
            fn abs(self) -> Self {
                $float::from_bits(self.to_bits() & ($bits::MAX >> 1))
            }

            #[inline]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }

            #[inline]
            fn power_of_two(power: i32) -> Self {
                const BIAS: i32 = $float::MAX_EXP - 1;
                let biased = (power.clamp($float::MIN_EXP - 1, BIAS) + BIAS).cast_unsigned();
                $float::from_bits($bits::from(biased) << ($float::MANTISSA_DIGITS - 1))
            }

            fn sqrt(self) -> Self {
                // `!(self > 0.0)` also gives 0 for not-a-number.
                if !(self > 0.0 && $float::is_finite(self)) {
                    return if self > 0.0 { self } else { 0.0 };
                }
                let mut root = $float::from_bits((self.to_bits() >> 1) + $offset);
                for _ in 0..$iterations {
                    root = 0.5 * (root + self / root);
                }
                if $below && self.to_bits() < $float::MIN_POSITIVE.to_bits() {
                    root = 0.5 * (root + self / root);
                }
                root
            }
        }

        impl Sealed for $float {
            fn decompose(self) -> Option<Decomposed> {
                const FRACTION_BITS: u32 = $float::MANTISSA_DIGITS - 1;
                /// Exponent of the last bit of the smallest normal number.
                const LEAST: i32 = $float::MIN_EXP - $float::MANTISSA_DIGITS.cast_signed();
                if !$float::is_finite(self) {
                    return None;
                }
                let magnitude = Scalar::abs(self).to_bits();
                let (biased, fraction) = (magnitude >> FRACTION_BITS, magnitude & ((1 << FRACTION_BITS) - 1));
                let (mantissa, exponent) = if biased == 0 {
                    (fraction, LEAST)
                } else {
                    // The biased exponent has at most eleven bits: the cast is exact.
                    (fraction | (1 << FRACTION_BITS), LEAST - 1 + biased as i32)
                };
                Some(Decomposed { mantissa: u64::from(mantissa), exponent, negative: self < 0.0 })
            }
        }
    };
}

// The upper word holds more bits than the mantissa, and a 32-bit core converts it in one instruction.
impl_scalar!(
    f32,
    u32,
    |value: i64| (value >> 32) as i32 as f32 * (1.0 / 2_147_483_648.0),
    0x1fbb_67ae,
    3,
    true
);
impl_scalar!(
    f64,
    u64,
    |value: i64| value as f64 * (1.0 / 9_223_372_036_854_775_808.0),
    0x1ff7_6cf5_d0b0_9955,
    5,
    false
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_root_is_within_one_unit_in_the_last_place() {
        let mut x = 1.1e-30_f64;
        while x < 1e30 {
            let exact = x.sqrt();
            assert!((Scalar::sqrt(x) - exact).abs() <= exact * f64::EPSILON, "{x}");
            let single = x as f32;
            let exact = single.sqrt();
            assert!((Scalar::sqrt(single) - exact).abs() <= exact * f32::EPSILON, "{x}");
            x *= 1.37;
        }
        assert_eq!(Scalar::sqrt(-1.0_f64), 0.0);
        assert_eq!(Scalar::sqrt(f32::NAN), 0.0);
        assert_eq!(Scalar::sqrt(f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn decomposition_reassembles_to_the_same_number() {
        for value in [1.0_f64, 0.1, 1e4, 3.3e-310, 6.02e23, -2.5] {
            let parts = value.decompose().expect("finite");
            let magnitude = parts.mantissa as f64
                * 2f64.powi(parts.exponent / 2)
                * 2f64.powi(parts.exponent - parts.exponent / 2);
            assert_eq!(if parts.negative { -magnitude } else { magnitude }, value);
        }
        for value in [1.0_f32, 0.1, 1e4, 1e-40, -2.5] {
            let parts = value.decompose().expect("finite");
            let magnitude = (parts.mantissa as f64 * 2f64.powi(parts.exponent)) as f32;
            assert_eq!(if parts.negative { -magnitude } else { magnitude }, value);
        }
        assert_eq!(f64::NAN.decompose(), None);
        assert_eq!(f32::INFINITY.decompose(), None);
    }
}
