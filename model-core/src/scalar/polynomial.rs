//! Sine and exponential by range reduction in integers and minimax polynomials: the default backend.
//!
//! The polynomials are fitted by Remez exchange and evaluated by Horner's rule. A function costs a Cortex-M4F a
//! few tens of instructions.

use super::{Mathematics, Scalar, horner};

/// Elementary functions by short polynomials, with the same bits on every machine.
///
/// Sine within 1.8e-7 (`f32`) and 3e-16 (`f64`) absolute; exponential within 2e-7 and 4e-16 relative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Polynomial;

/// `sin(2πx) / x` as a polynomial in x², |x| ≤ 1/4: error 2.7e-8.
#[expect(clippy::approx_constant, reason = "the leading coefficient is fitted and only near 2π")]
const SINE_F32: [f32; 5] = [6.283_185_3, -41.341_682, 81.602_486, -76.581_4, 39.761_616];

/// `sin(2πx) / x` as a polynomial in x², |x| ≤ 1/4: error 1.3e-18.
#[expect(clippy::approx_constant, reason = "the leading coefficient is fitted and only near 2π")]
const SINE_F64: [f64; 9] = [
    6.283_185_307_179_586_475_6,
    -41.341_702_240_399_756_87,
    81.605_249_276_073_617_81,
    -76.705_859_752_825_255_623,
    42.058_693_925_449_834_856,
    -15.094_641_676_840_100_147,
    3.819_928_107_886_425_210_9,
    -0.717_733_926_659_433_048_8,
    0.100_897_493_184_479_093_24,
];

/// `e^x`, |x| ≤ ln 2 / 2: error 1.9e-9.
const EXPONENTIAL_F32: [f32; 7] =
    [1.0, 1.0, 0.500_000_02, 0.166_664_15, 0.041_666_084, 0.008_375_128_6, 0.001_395_605_6];

/// `e^x`, |x| ≤ ln 2 / 2: error 4.1e-20.
const EXPONENTIAL_F64: [f64; 13] = [
    1.0,
    0.999_999_999_999_999_998_47,
    0.499_999_999_999_999_999_28,
    0.166_666_666_666_667_024_14,
    0.041_666_666_666_666_751_124,
    0.008_333_333_333_309_525_765,
    0.001_388_888_888_885_095_359_5,
    0.000_198_412_699_092_196_050_65,
    0.000_024_801_587_383_725_400_305,
    2.755_722_495_630_502_681e-6,
    2.755_722_702_708_013_393e-7,
    2.511_487_016_158_721_308_5e-8,
    2.092_848_395_652_304_162_4e-9,
];

/// The phase in [−1/4, 1/4] turn with the same sine as `phase`, in units of 2⁻⁶⁴ turns.
#[inline]
fn fold_quarter_wave(phase: u64) -> i64 {
    let signed = phase.cast_signed();
    // sin(½ turn − x) = sin x above a quarter of a turn. The subtraction wraps like a phase.
    if (phase.wrapping_add(1 << 62)) >> 63 == 0 { signed } else { i64::MIN.wrapping_sub(signed) }
}

#[inline]
fn sine_of_turns<S: Scalar, const N: usize>(phase: u64, coefficients: &[S; N]) -> S {
    // `from_fraction` divides by 2⁶³, which is half a turn.
    let turns = S::from_fraction(fold_quarter_wave(phase)) * S::from_f64(0.5);
    turns * horner(coefficients, turns * turns)
}

/// The sine of a phase in 2⁻³² turns, with the bits of [`Polynomial`], also at compile time.
pub(crate) const fn sine_of_phase(phase: u32) -> f32 {
    let signed = phase.cast_signed();
    let folded = if phase.wrapping_add(1 << 30) >> 31 == 0 { signed } else { i32::MIN.wrapping_sub(signed) };
    let turns = folded as f32 * (0.5 / 2_147_483_648.0);
    let (square, [a, b, c, d, e]) = (turns * turns, SINE_F32);
    turns * ((((e * square + d) * square + c) * square + b) * square + a)
}

/// `e^x = 2^n e^r` with |r| ≤ ln 2 / 2. `n ln 2` is subtracted in two parts, so that `r` keeps its digits.
#[inline]
fn exponential<S: Scalar, const N: usize>(
    x: S,
    lowest: f64,
    highest: f64,
    ln_2: [f64; 2],
    coefficients: &[S; N],
) -> S {
    if x < S::from_f64(lowest) {
        return S::ZERO;
    }
    if x > S::from_f64(highest) {
        return S::INFINITY;
    }
    let scaled = x * S::from_f64(core::f64::consts::LOG2_E);
    let half = S::from_f64(0.5);
    let magnitude = (scaled.abs() + half).to_u32().cast_signed();
    let n = if scaled < S::ZERO { magnitude.wrapping_neg() } else { magnitude };
    let count = S::from_i32(n);
    let r = (x - count * S::from_f64(ln_2[0])) - count * S::from_f64(ln_2[1]);
    // Two factors, both in the normal range.
    let lower = n / 2;
    horner(coefficients, r) * S::power_of_two(lower) * S::power_of_two(n.wrapping_sub(lower))
}

impl Mathematics<f32> for Polynomial {
    const NAME: &'static str = "polynomial";

    #[inline]
    fn sine_of_turns(phase: u64) -> f32 {
        sine_of_turns(phase, &SINE_F32)
    }

    fn exponential(x: f32) -> f32 {
        exponential(x, -87.0, 88.7, [0.693_145_751_953_125, 1.428_606_820_309_417_2e-6], &EXPONENTIAL_F32)
    }
}

impl Mathematics<f64> for Polynomial {
    const NAME: &'static str = "polynomial";

    #[inline]
    fn sine_of_turns(phase: u64) -> f64 {
        sine_of_turns(phase, &SINE_F64)
    }

    fn exponential(x: f64) -> f64 {
        exponential(
            x,
            -708.0,
            709.7,
            [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10],
            &EXPONENTIAL_F64,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_is_accurate_over_the_whole_turn() {
        for k in 0..200_000_u64 {
            let phase = k.wrapping_mul(92_233_720_368_547_759).wrapping_add(k << 7);
            // The comparison itself rounds its argument, up to π, to 4e-16.
            let exact =
                (core::f64::consts::TAU * (phase.cast_signed() as f64 / 18_446_744_073_709_551_616.0)).sin();
            let double: f64 = Polynomial::sine_of_turns(phase);
            assert!((double - exact).abs() < 8e-16, "{phase} {double} {exact}");
            let single: f32 = Polynomial::sine_of_turns(phase);
            assert!((f64::from(single) - exact).abs() < 1.8e-7, "{phase} {single} {exact}");
        }
    }

    #[test]
    fn sine_at_the_quarters_is_exact() {
        for (phase, exact) in [(0_u64, 0.0), (1 << 62, 1.0), (1 << 63, 0.0), (3 << 62, -1.0)] {
            let double: f64 = Polynomial::sine_of_turns(phase);
            let single: f32 = Polynomial::sine_of_turns(phase);
            assert!((double - exact).abs() < 3e-16 && (f64::from(single) - exact).abs() < 1e-7);
        }
    }

    #[test]
    fn exponential_is_accurate_and_saturates() {
        let mut x = -86.0_f64;
        while x < 88.0 {
            let exact = x.exp();
            let double: f64 = Polynomial::exponential(x);
            assert!((double / exact - 1.0).abs() < 6e-16, "{x}");
            let single: f32 = Polynomial::exponential(x as f32);
            assert!((f64::from(single) / f64::from(x as f32).exp() - 1.0).abs() < 3e-7, "{x} {single}");
            x += 0.0137;
        }
        let (low, high): (f32, f64) = (Polynomial::exponential(-1e9_f32), Polynomial::exponential(1e9_f64));
        assert_eq!((low, high), (0.0, f64::INFINITY));
    }
}
