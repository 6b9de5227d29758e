//! The number: `f32` or `f64`, and the elementary functions behind it.
//!
//! Every model and method in this crate is generic over [`Scalar`], so the bits that run on a
//! microcontroller are the bits that the host tests. Nothing here calls the platform's math
//! library: addition, multiplication, division and conversion are IEEE 754 operations, and the
//! elementary functions are one of the [`Mathematics`] backends, which are plain Rust.

mod compensated;
mod complex;
mod float;
#[cfg(feature = "libm")]
mod libm;
#[cfg(feature = "micromath")]
mod micromath;
mod polynomial;

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::snapshot::Snapshot;

#[cfg(feature = "libm")]
pub use self::libm::Libm;
#[cfg(feature = "micromath")]
pub use self::micromath::Micromath;
pub use compensated::CompensatedSum;
pub(crate) use compensated::add_increment;
pub(crate) use complex::Complex;
pub use polynomial::Polynomial;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A number written `mantissa · 2^exponent`, so that integers can be made from it exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decomposed {
    /// Magnitude of the significand, at most 53 bits.
    pub mantissa: u64,
    /// Power of two that scales `mantissa`.
    pub exponent: i32,
    /// Whether the number is below zero.
    pub negative: bool,
}

/// The floating-point number that states, parameters and coefficients are made of.
///
/// Implemented for `f32` and `f64` only.
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
    + sealed::Sealed
    + 'static
{
    /// The elementary functions of which coefficients are built, whatever backend a step uses.
    type Build: Mathematics<Self>;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Smallest positive normal number.
    const TINY: Self;
    /// Positive infinity.
    const INFINITY: Self;

    /// A literal in the source, rounded once to this precision.
    ///
    /// For constants only: the conversion is folded at compile time, so that an `f32` firmware
    /// links no double-precision arithmetic.
    fn from_f64(value: f64) -> Self;

    /// `value`, rounded to nearest.
    fn from_u32(value: u32) -> Self;

    /// `value`, rounded to nearest.
    fn from_i32(value: i32) -> Self;

    /// `value / 2^63`: a 64-bit signed fraction of one, rounded to the precision of this type.
    fn from_fraction(value: i64) -> Self;

    /// The integer part, saturating at both ends; not-a-number gives 0.
    fn to_u32(self) -> u32;

    /// This number in single precision, for quantities that steer and do not enter a result.
    fn to_f32(self) -> f32;

    /// This number in double precision, exactly: for reports on a host.
    fn to_f64(self) -> f64;

    /// The single-precision number `value`, exactly.
    fn from_f32(value: f32) -> Self;

    /// Magnitude.
    fn abs(self) -> Self;

    /// Neither infinite nor not-a-number.
    fn is_finite(self) -> bool;

    /// Mantissa and exponent of a finite number; `None` otherwise.
    fn decompose(self) -> Option<Decomposed>;

    /// `2^power`, for powers whose result is a normal number; others are clamped to the nearest.
    fn power_of_two(power: i32) -> Self;

    /// Square root to within one unit in the last place; 0 for arguments at or below 0.
    ///
    /// Newton's iteration from an estimate made of the bits. For building coefficients: a step
    /// calls it nowhere.
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
/// A step of an integrator calls at most [`Mathematics::sine_of_turns`] (for the excitation) and
/// an impact [`Mathematics::exponential`]; square roots and the like belong to the build of the
/// coefficients and are [`Scalar`]'s own, the same for every backend.
pub trait Mathematics<S: Scalar>: Copy + Debug + PartialEq + 'static {
    /// The backend's name, as a command line or a report writes it.
    const NAME: &'static str;

    /// `sin(2π · phase / 2^64)`: the sine of a phase given in turns, wrapping.
    fn sine_of_turns(phase: u64) -> S;

    /// `e^x`. Arguments too small to represent the result give 0.
    fn exponential(x: S) -> S;

    /// `cos(2π · phase / 2^64)`: the sine a quarter of a turn further on.
    #[inline]
    fn cosine_of_turns(phase: u64) -> S {
        Self::sine_of_turns(phase.wrapping_add(1 << 62))
    }
}

/// A polynomial by Horner's rule, coefficients from the constant one up.
#[inline]
pub(crate) fn horner<S: Scalar, const N: usize>(coefficients: &[S; N], x: S) -> S {
    coefficients.iter().rev().fold(S::ZERO, |sum, &coefficient| sum * x + coefficient)
}

/// An angle as a fraction of a turn in units of 2⁻⁶⁴; `None` unless finite and below 2²⁰ turns.
pub(crate) fn turns_of_radians<S: Scalar>(radians: S) -> Option<u64> {
    let turns = radians * S::from_f64(core::f64::consts::FRAC_1_PI * 0.5);
    let magnitude = turns.abs();
    // Written so that not-a-number is refused too.
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

/// Terms of the arcsine's series: 4⁻ⁿ falls below a rounding of `f64`.
const ARCSINE_TERMS: u32 = 28;

/// `arcsin x` in radians for −1 ≤ x ≤ 1, by its series up to 1/2 and by that of the half angle beyond; a
/// few roundings.
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
