//! Implements [`Scalar`] for `f32` and `f64`.

use super::{Decomposed, Polynomial, Scalar, Sealed};

impl Scalar for f32 {
    type Build = Polynomial;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const EPSILON: Self = f32::EPSILON;
    const TINY: Self = f32::MIN_POSITIVE;
    const INFINITY: Self = f32::INFINITY;

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
    fn from_f64(value: f64) -> Self {
        value as f32
    }

    #[inline]
    fn from_u32(value: u32) -> Self {
        value as f32
    }

    #[inline]
    fn from_i32(value: i32) -> Self {
        value as f32
    }

    #[inline]
    fn from_fraction(value: i64) -> Self {
        // The upper word holds more bits than the mantissa, and a 32-bit core converts it in one instruction.
        (value >> 32) as i32 as f32 * (1.0 / 2_147_483_648.0)
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, as documented")]
    fn to_u32(self) -> u32 {
        self as u32
    }

    #[inline]
    fn to_f32(self) -> f32 {
        self
    }

    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline]
    fn from_f32(value: f32) -> Self {
        value
    }

    #[inline]
    fn abs(self) -> Self {
        f32::from_bits(self.to_bits() & 0x7fff_ffff)
    }

    #[inline]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }

    #[inline]
    fn power_of_two(power: i32) -> Self {
        f32::from_bits((power.clamp(-126, 127) + 127).cast_unsigned() << 23)
    }

    fn sqrt(self) -> Self {
        // `!(self > 0.0)` also gives 0 for not-a-number.
        if !(self > 0.0 && f32::is_finite(self)) {
            return if self > 0.0 { self } else { 0.0 };
        }
        // Halving the biased exponent gives a first estimate within 6 %.
        let mut root = f32::from_bits((self.to_bits() >> 1) + 0x1fbb_67ae);
        for _ in 0..4 {
            root = 0.5 * (root + self / root);
        }
        root
    }
}

impl Sealed for f32 {
    fn decompose(self) -> Option<Decomposed> {
        if !f32::is_finite(self) {
            return None;
        }
        let bits = self.to_bits();
        let (biased, fraction) = ((bits >> 23) & 0xff, bits & 0x007f_ffff);
        let (mantissa, exponent) =
            if biased == 0 { (fraction, -149) } else { (fraction | 0x0080_0000, biased.cast_signed() - 150) };
        Some(Decomposed { mantissa: u64::from(mantissa), exponent, negative: self < 0.0 })
    }
}

impl Scalar for f64 {
    type Build = Polynomial;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const EPSILON: Self = f64::EPSILON;
    const TINY: Self = f64::MIN_POSITIVE;
    const INFINITY: Self = f64::INFINITY;

    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline]
    fn from_u32(value: u32) -> Self {
        f64::from(value)
    }

    #[inline]
    fn from_i32(value: i32) -> Self {
        f64::from(value)
    }

    #[inline]
    fn from_fraction(value: i64) -> Self {
        value as f64 * (1.0 / 9_223_372_036_854_775_808.0)
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, as documented")]
    fn to_u32(self) -> u32 {
        self as u32
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
    fn to_f32(self) -> f32 {
        self as f32
    }

    fn to_f64(self) -> f64 {
        self
    }

    #[inline]
    fn from_f32(value: f32) -> Self {
        f64::from(value)
    }

    #[inline]
    fn abs(self) -> Self {
        f64::from_bits(self.to_bits() & 0x7fff_ffff_ffff_ffff)
    }

    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }

    #[inline]
    fn power_of_two(power: i32) -> Self {
        f64::from_bits(u64::from((power.clamp(-1022, 1023) + 1023).cast_unsigned()) << 52)
    }

    fn sqrt(self) -> Self {
        if !(self > 0.0 && f64::is_finite(self)) {
            return if self > 0.0 { self } else { 0.0 };
        }
        let mut root = f64::from_bits((self.to_bits() >> 1) + 0x1ff7_6cf5_d0b0_9955);
        for _ in 0..5 {
            root = 0.5 * (root + self / root);
        }
        root
    }
}

impl Sealed for f64 {
    fn decompose(self) -> Option<Decomposed> {
        if !f64::is_finite(self) {
            return None;
        }
        let bits = self.to_bits();
        let (biased, fraction) = ((bits >> 52) & 0x7ff, bits & 0x000f_ffff_ffff_ffff);
        let (mantissa, exponent) = if biased == 0 {
            (fraction, -1074)
        } else {
            // The biased exponent has eleven bits: the cast is exact.
            (fraction | 0x0010_0000_0000_0000, (biased as u32).cast_signed() - 1075)
        };
        Some(Decomposed { mantissa, exponent, negative: self < 0.0 })
    }
}

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
