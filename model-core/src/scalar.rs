//! Defines the floating-point number of all models, `f32` or `f64`, and its elementary functions.
//!
//! Every model and method in this crate is generic over [`Scalar`]. Addition, multiplication, division and conversion
//! are IEEE 754 operations. The elementary functions are those of a [`Mathematics`] backend in plain Rust, and no
//! code calls the platform's math library. So the same input gives the same bits on every core and on the host.

mod float;
#[cfg(feature = "libm")]
mod libm;
#[cfg(feature = "micromath")]
mod micromath;
mod polynomial;

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::snapshot::{Snapshot, snapshot_fields};

#[cfg(feature = "libm")]
pub use self::libm::Libm;
#[cfg(feature = "micromath")]
pub use self::micromath::Micromath;
pub use polynomial::Polynomial;
pub(crate) use polynomial::sine_of_phase;

/// A finite number as `±mantissa · 2^exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Decomposed {
    /// Magnitude of the significand, at most 53 bits.
    pub(crate) mantissa: u64,
    /// Exponent of the power of two that multiplies `mantissa`.
    pub(crate) exponent: i32,
    /// Whether the number is below zero.
    pub(crate) negative: bool,
}

/// The crate-private part of [`Scalar`].
pub(crate) trait Sealed {
    /// Mantissa and exponent of a finite number; `None` otherwise.
    fn decompose(self) -> Option<Decomposed>;
}

/// The floating-point number of states, parameters and coefficients: `f32` or `f64`.
pub trait Scalar:
    Copy
    + Debug
    + Default
    + Display
    + PartialEq
    + PartialOrd
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Snapshot
    + Sealed
    + 'static
{
    /// The elementary functions for computing coefficients, independent of the backend of the steps.
    type Build: Mathematics<Self>;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Whether it is of double precision, for which series take further terms.
    const IS_DOUBLE: bool;
    /// Smallest positive normal number.
    const TINY: Self;
    /// Positive infinity.
    const INFINITY: Self;

    /// `value` rounded to nearest.
    ///
    /// For literals in the source: the compiler folds the conversion, so an `f32` firmware links no double-precision arithmetic.
    fn from_f64(value: f64) -> Self;

    /// `value` rounded to nearest.
    fn from_u32(value: u32) -> Self;

    /// `value` rounded to nearest.
    fn from_i32(value: i32) -> Self;

    /// `value / 2^63` rounded to the precision of this type.
    fn from_fraction(value: i64) -> Self;

    /// The integer part, saturating at 0 and 2³² − 1; 0 for not-a-number.
    fn to_u32(self) -> u32;

    /// This number rounded to single precision, for the step control; no result depends on it.
    fn to_f32(self) -> f32;

    /// This number in double precision, exactly.
    fn to_f64(self) -> f64;

    /// Magnitude.
    fn abs(self) -> Self;

    /// Whether the number is neither infinite nor not-a-number.
    fn is_finite(self) -> bool;

    /// `2^power`; the nearest normal power of two if that is not a normal number.
    fn power_of_two(power: i32) -> Self;

    /// Square root to within one unit in the last place; 0 for negative numbers and not-a-number.
    ///
    /// Newton's iteration, four divisions in `f32` and five in `f64`, from an estimate by the bits of the number.
    /// Within a step only event location, the opening and closing of a contact, and the overlap of two discs call it.
    fn sqrt(self) -> Self;

    /// The larger of two numbers; `other` if this one is not a number.
    #[must_use]
    #[inline]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    /// The smaller of two numbers; `other` if this one is not a number.
    #[must_use]
    #[inline]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

/// Elementary functions, chosen at compile time by a type parameter.
///
/// A step calls [`Mathematics::sine_of_turns`] for a sinusoidal excitation, and an impact calls
/// [`Mathematics::exponential`] for some laws of restitution. The square root is [`Scalar::sqrt`] for every backend.
pub trait Mathematics<S: Scalar>: Copy + Debug + PartialEq + 'static {
    /// Name of the backend on a command line and in reports.
    const NAME: &'static str;

    /// `sin(2π · phase / 2^64)`: the sine of a phase in units of 2⁻⁶⁴ turns.
    fn sine_of_turns(phase: u64) -> S;

    /// `e^x`; 0 if the result is too small to represent.
    fn exponential(x: S) -> S;

    /// `cos(2π · phase / 2^64)`.
    #[inline]
    fn cosine_of_turns(phase: u64) -> S {
        Self::sine_of_turns(phase.wrapping_add(1 << 62))
    }
}

/// `Σ coefficients[k] x^k` by Horner's rule.
#[inline]
pub(crate) fn horner<S: Scalar>(coefficients: &[S], x: S) -> S {
    let Some((&highest, lower)) = coefficients.split_last() else { return S::ZERO };
    lower.iter().rev().fold(highest, |sum, &coefficient| sum * x + coefficient)
}

/// An angle in radians as a fraction of a turn in units of 2⁻⁶⁴; `None` unless finite and below 2²⁰ turns.
pub(crate) fn turns_of_radians<S: Scalar>(radians: S) -> Option<u64> {
    let turns = radians * S::from_f64(core::f64::consts::FRAC_1_PI * 0.5);
    let magnitude = turns.abs();
    // `!(magnitude < …)` also refuses not-a-number.
    if !(magnitude < S::from_f64(1_048_576.0)) {
        return None;
    }
    let fraction = magnitude - S::from_u32(magnitude.to_u32());
    // 2³² · fraction is exact; its own fraction gives the lower word.
    let scaled = fraction * S::power_of_two(32);
    let upper = scaled.to_u32();
    let lower = ((scaled - S::from_u32(upper)) * S::power_of_two(32)).to_u32();
    let units = (u64::from(upper) << 32) | u64::from(lower);
    Some(if turns < S::ZERO { units.wrapping_neg() } else { units })
}

/// Number of terms of the series of the logarithm; `z^(2n)` is then below a rounding of `f64`.
const LOGARITHM_TERMS: u32 = 12;

/// `ln x` of a positive normal number, to a few roundings; not-a-number otherwise.
///
/// With `x = m 2ⁿ`, `1/√2 ≤ m < √2`, and `z = (m − 1)/(m + 1)`: `ln x = n ln 2 + 2 (z + z³/3 + z⁵/5 + …)`.
pub(crate) fn logarithm<S: Scalar>(x: S) -> S {
    let parts = x.decompose().filter(|parts| !parts.negative && parts.mantissa != 0);
    let Some(parts) = parts else { return S::from_f64(f64::NAN) };
    let mut exponent =
        parts.exponent.wrapping_add(64).wrapping_sub(parts.mantissa.leading_zeros().cast_signed());
    let mut mantissa = x * S::power_of_two(exponent.wrapping_neg());
    if mantissa < S::from_f64(core::f64::consts::FRAC_1_SQRT_2) {
        mantissa += mantissa;
        exponent = exponent.wrapping_sub(1);
    }
    let z = (mantissa - S::ONE) / (mantissa + S::ONE);
    let square = z * z;
    let term = |sum, n: u32| square * (S::ONE / S::from_u32(n << 1 | 1) + sum);
    let series = (1..LOGARITHM_TERMS).rev().fold(S::ZERO, term);
    S::from_i32(exponent) * S::from_f64(core::f64::consts::LN_2) + S::from_f64(2.0) * (z + z * series)
}

/// Number of terms of the arcsine series; 4⁻ⁿ is then below a rounding of `f64`.
const ARCSINE_TERMS: u32 = 28;

/// `arcsin x` in radians for −1 ≤ x ≤ 1, to a few roundings: the series up to |x| = 1/2, above it `π/2 − 2
/// arcsin √((1 − |x|)/2)` with the sign of `x`.
pub(crate) fn arcsine<S: Scalar>(x: S) -> S {
    let half = S::from_f64(0.5);
    let magnitude = x.abs();
    let value = if magnitude > half {
        let rest = (half * (S::ONE - magnitude)).sqrt();
        S::from_f64(core::f64::consts::FRAC_PI_2) - S::from_f64(2.0) * arcsine_series(rest)
    } else {
        arcsine_series(magnitude)
    };
    if x < S::ZERO { -value } else { value }
}

fn arcsine_series<S: Scalar>(x: S) -> S {
    let square = x * x;
    let (mut term, mut sum) = (x, x);
    for n in 1..ARCSINE_TERMS {
        let odd = 2 * n - 1;
        term = term * square * S::from_u32(odd) / S::from_u32(2 * n);
        sum += term / S::from_u32(2 * n + 1);
    }
    sum
}

/// A running sum whose error stays at one rounding of the result for any number of terms: it keeps the part that a plain
/// addition rounds away (Kahan 1965, with the comparison of Neumaier 1974).
///
/// A term may be larger than the sum so far. Each addition includes the correction of the previous one, so
/// the correction never exceeds a rounding of the sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct CompensatedSum<S> {
    sum: S,
    correction: S,
}

impl<S: Scalar> CompensatedSum<S> {
    /// The empty sum.
    pub(crate) const ZERO: Self = Self { sum: S::ZERO, correction: S::ZERO };

    /// Adds `term`.
    #[inline]
    pub(crate) fn add(&mut self, term: S) {
        let moved = term + self.correction;
        let total = self.sum + moved;
        self.correction = if self.sum.abs() >= moved.abs() {
            (self.sum - total) + moved
        } else {
            (moved - total) + self.sum
        };
        self.sum = total;
    }

    /// The sum, rounded once.
    #[inline]
    pub(crate) fn value(&self) -> S {
        self.sum + self.correction
    }
}

snapshot_fields!(impl [S: Scalar] CompensatedSum<S> { sum, correction });

/// `high + low + increment` as a new pair, in which `low` is the part that rounding removed from `high`.
///
/// For a state with small increments. Without the branch of [`CompensatedSum::add`], an increment larger than
/// the state is added with the rounding of a plain addition.
#[inline]
pub(crate) fn add_increment<S: Scalar>(high: S, low: S, increment: S) -> (S, S) {
    let moved = increment + low;
    let sum = high + moved;
    (sum, moved - (sum - high))
}

/// `f` of each entry of `a` and the one of `b` at the same place. Unlike an index in a closure it links no check of bounds.
#[inline]
pub(crate) fn zip_with<A: Copy, B, const N: usize>(
    mut a: [A; N],
    b: &[B; N],
    f: impl Fn(A, &B) -> A,
) -> [A; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, b);
    }
    a
}

/// The sum of two vectors.
#[inline]
pub(crate) fn sum<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> [S; N] {
    zip_with(*a, b, |a, b| a + *b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_of_microjoules_does_not_drift_in_single_precision() {
        let (mut compensated, mut plain) = (CompensatedSum::<f32>::ZERO, 0.0_f32);
        let terms = 86_400_u32 * 100;
        for k in 0..terms {
            let term = 1e-8 * (1.0 + 0.5 * ((k % 7) as f32));
            compensated.add(term);
            plain += term;
        }
        let mut exact = 0.0_f64;
        for k in 0..terms {
            exact += f64::from(1e-8_f32 * (1.0 + 0.5 * ((k % 7) as f32)));
        }
        assert!((f64::from(compensated.value()) / exact - 1.0).abs() < 1e-7);
        assert!((f64::from(plain) / exact - 1.0).abs() > 1e-4, "the plain sum is expected to drift");
    }

    #[test]
    fn increments_below_a_unit_in_the_last_place_are_summed() {
        let (mut high, mut low) = (3e-3_f32, 0.0_f32);
        for _ in 0..1_000_000 {
            (high, low) = add_increment(high, low, 1e-12);
        }
        assert!((high - 3.001e-3).abs() < 1e-9, "{high}");
    }
}
