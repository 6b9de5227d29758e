//! Represents simulated time as an integer, and the phase of a frequency at a time.
//!
//! Time is a count of ticks of 2⁻³⁸ s (3.6 ps) in 64 bits, which wraps after two years (2²⁶ s). Rounding an event to
//! a tick is less than the `f32` rounding of any step above 31 µs, and a step of 32 bits reaches 15.6 ms: a quarter of
//! a period at 16 Hz. A frequency is a fixed-point number of turns per tick with 96 fractional bits. The phase at a
//! tick is one multiplication modulo a turn; its error after 24 hours at 10 kHz is below 10⁻⁹ turns in either precision.

use crate::scalar::{Decomposed, Scalar};
use crate::snapshot::snapshot_fields;

/// Number of ticks in a second, as a power of two.
const TICKS_PER_SECOND_LOG2: i32 = 38;

/// Number of ticks in a second.
pub const TICKS_PER_SECOND: u64 = 1 << TICKS_PER_SECOND_LOG2;

/// A point in simulated time, in ticks of 2⁻³⁸ s since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Instant(u64);

impl Instant {
    /// The start of simulated time.
    pub const START: Self = Self(0);

    /// The instant `ticks` ticks of 2⁻³⁸ s after the start.
    #[must_use]
    pub const fn from_ticks(ticks: u64) -> Self {
        Self(ticks)
    }

    /// Ticks of 2⁻³⁸ s since the start.
    #[must_use]
    pub const fn ticks(self) -> u64 {
        self.0
    }

    /// The instant `seconds` whole seconds after the start; 2²⁶ s and more wrap.
    #[must_use]
    pub const fn from_whole_seconds(seconds: u32) -> Self {
        Self((seconds as u64) << TICKS_PER_SECOND_LOG2)
    }

    /// The tick nearest to `seconds`; `None` if that is negative, not a number or 2²⁶ s or more.
    #[must_use]
    pub fn from_seconds<S: Scalar>(seconds: S) -> Option<Self> {
        let parts = seconds.decompose()?;
        if parts.negative || seconds >= S::from_f64(67_108_864.0) {
            return None;
        }
        scale_to_integer(parts, TICKS_PER_SECOND_LOG2).and_then(|ticks| u64::try_from(ticks).ok()).map(Self)
    }

    /// The instant `ticks` later.
    #[must_use]
    #[inline]
    pub const fn after(self, ticks: u32) -> Self {
        Self(self.0.wrapping_add(ticks as u64))
    }

    /// Ticks from this instant until `later`, which has not passed, at most `limit`.
    #[inline]
    pub(crate) fn ticks_until(self, later: Self, limit: u32) -> u32 {
        later.0.wrapping_sub(self.0).min(u64::from(limit)) as u32
    }

    /// Seconds since the start, rounded. For reports only: a step uses no absolute time.
    #[must_use]
    pub fn seconds<S: Scalar>(self) -> S {
        const LOW_BITS: i32 = TICKS_PER_SECOND_LOG2 - 32;
        let (whole, fraction) =
            (self.0 >> TICKS_PER_SECOND_LOG2, self.0 & ((1 << TICKS_PER_SECOND_LOG2) - 1));
        let fraction = S::from_u32((fraction >> LOW_BITS) as u32) * S::power_of_two(-32)
            + S::from_u32((fraction & ((1 << LOW_BITS) - 1)) as u32)
                * S::power_of_two(-TICKS_PER_SECOND_LOG2);
        S::from_u32(whole as u32) + fraction
    }
}

snapshot_fields!(impl [] Instant { 0 });

/// `mantissa · 2^(exponent + more)` rounded to nearest; `None` if it does not fit in 128 bits.
fn scale_to_integer(Decomposed { mantissa, exponent, .. }: Decomposed, more: i32) -> Option<u128> {
    let wide = u128::from(mantissa);
    match exponent.saturating_add(more) {
        left @ 0..=63 => Some(wide << left),
        right @ -127..=-1 => Some((wide + (1 << (-right - 1))) >> -right),
        ..-127 => Some(0),
        _ if mantissa == 0 => Some(0),
        _ => None,
    }
}

/// The length of `ticks` ticks in seconds.
#[inline]
pub(crate) fn seconds_of_ticks<S: Scalar>(ticks: u32) -> S {
    S::from_u32(ticks) * S::power_of_two(-TICKS_PER_SECOND_LOG2)
}

/// The number of ticks nearest to `seconds`, between 1 and the largest step of 2³² − 1 ticks.
#[must_use]
pub fn ticks_of_seconds<S: Scalar>(seconds: S) -> u32 {
    // The scaling is exact, and the conversion saturates.
    (seconds * S::power_of_two(TICKS_PER_SECOND_LOG2) + S::from_f64(0.5)).to_u32().max(1)
}

/// The longest step in seconds: 2³² − 1 ticks, 15.6 ms.
pub const LONGEST_STEP_S: f64 = 4_294_967_295.0 / 274_877_906_944.0;

/// Cycles since the start of simulated time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cycles {
    /// Completed cycles.
    pub(crate) whole: u64,
    /// Fraction of the present cycle, in units of 2⁻⁶⁴.
    pub(crate) fraction: u64,
}

/// A frequency in units of 2⁻⁹⁶ cycles per tick, which are 2⁻⁵⁶ Hz.
///
/// An `f32` or `f64` from 2⁻⁴ Hz to 1 MHz is represented to that unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Frequency {
    upper: u64,
    lower: u32,
}

impl Frequency {
    /// The highest frequency that is accepted, in Hz.
    pub(crate) const HIGHEST_HZ: f64 = 1e6;

    /// A frequency given in Hz; `None` if negative, not finite, or above [`Frequency::HIGHEST_HZ`].
    pub(crate) fn from_hertz<S: Scalar>(hertz: S) -> Option<Self> {
        let parts = hertz.decompose()?;
        if parts.negative || hertz > S::from_f64(Self::HIGHEST_HZ) {
            return None;
        }
        let units = scale_to_integer(parts, 96 - TICKS_PER_SECOND_LOG2)?;
        Some(Self { upper: (units >> 32) as u64, lower: units as u32 })
    }

    /// A frequency in units of 2⁻⁹⁶ cycles per tick; at most one cycle in two ticks.
    pub(crate) fn from_units(units: u128) -> Self {
        let units = units.min(1 << 95);
        Self { upper: (units >> 32) as u64, lower: units as u32 }
    }

    /// The frequency in units of 2⁻⁹⁶ cycles per tick.
    pub(crate) fn units(self) -> u128 {
        (u128::from(self.upper) << 32) | u128::from(self.lower)
    }

    /// Fraction of the present cycle at `at`, in units of 2⁻⁶⁴.
    #[inline]
    pub(crate) fn phase(self, at: Instant) -> u64 {
        let ticks = at.0;
        let lower = u64::from(self.lower);
        self.upper
            .wrapping_mul(ticks)
            .wrapping_add(lower.wrapping_mul(ticks >> 32))
            .wrapping_add((lower * (ticks & 0xffff_ffff)) >> 32)
    }

    /// Ticks in a cycle, rounded down; `None` where the number does not fit in 64 bits.
    pub(crate) fn whole_ticks_per_cycle(self) -> Option<u64> {
        let units = self.units();
        // Long division of 2⁹⁶ bit by bit, because no other code of a firmware links a 128-bit division.
        let (mut quotient, mut remainder) = (0_u128, 0_u128);
        for bit in (0..=96).rev() {
            remainder = (remainder << 1) | u128::from(bit == 96_u32);
            quotient <<= 1;
            if remainder >= units {
                remainder -= units;
                quotient |= 1;
            }
        }
        u64::try_from(quotient).ok()
    }

    /// Cycles from the start of simulated time to `at`.
    pub(crate) fn cycles(self, at: Instant) -> Cycles {
        let upper = u128::from(self.upper) * u128::from(at.0);
        let total = upper + ((u128::from(self.lower) * u128::from(at.0)) >> 32);
        Cycles { whole: (total >> 64) as u64, fraction: total as u64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Sealed;

    const DAY: u64 = 86_400 << TICKS_PER_SECOND_LOG2;

    /// The phase in turns after `ticks`, by exact integer arithmetic on the number that was given.
    fn exact_phase(hertz_mantissa: u64, hertz_exponent: i32, ticks: u64) -> f64 {
        // hertz · ticks · 2⁻³⁸ modulo 1, with hertz = mantissa · 2^exponent and exponent < 0.
        let bits = u32::try_from(TICKS_PER_SECOND_LOG2 - hertz_exponent).expect("small");
        let product = u128::from(hertz_mantissa) * u128::from(ticks);
        let remainder = product & ((1u128 << bits) - 1);
        remainder as f64 / 2f64.powi(bits as i32)
    }

    #[test]
    fn a_sine_loses_no_phase_in_a_simulated_day() {
        let mut hertz = 0.01_f64;
        while hertz <= 10_000.0 {
            for offset in [0, 1, 12_345_678_901, (1 << 38) - 1] {
                let at = Instant::from_ticks(DAY + offset);
                let single = hertz as f32;
                for (frequency, parts) in [
                    (Frequency::from_hertz(hertz), hertz.decompose()),
                    (Frequency::from_hertz(single), single.decompose()),
                ] {
                    let (frequency, parts) = (frequency.expect("in range"), parts.expect("finite"));
                    let phase = frequency.phase(at) as f64 / 2f64.powi(64);
                    let mut error = (phase - exact_phase(parts.mantissa, parts.exponent, at.ticks())).abs();
                    error = error.min(1.0 - error);
                    assert!(error < 1e-10, "{hertz} Hz: {error} turns after a day");
                }
            }
            hertz *= 3.7;
        }
    }

    #[test]
    fn cycles_and_phase_agree() {
        let frequency = Frequency::from_hertz(400.3_f32).expect("in range");
        for ticks in [0, 1, 3_000_000_000, DAY, DAY + 987_654_321] {
            let at = Instant::from_ticks(ticks);
            let cycles = frequency.cycles(at);
            // The two round the lowest of 96 bits differently.
            assert!(cycles.fraction.wrapping_sub(frequency.phase(at)).cast_signed().abs() <= 1);
            let exact = f64::from(400.3_f32) * ticks as f64 / TICKS_PER_SECOND as f64;
            assert!((cycles.whole as f64 - exact).abs() <= 1.0);
        }
    }

    #[test]
    fn ticks_per_cycle_are_rounded_down() {
        // 2³⁸ ticks in a second, in integers.
        for (hertz, ticks) in
            [(1.0, 1 << 38), (3.0, 91_625_968_981), (400.0, 687_194_767), (1e6, 274_877), (0.5, 1 << 39)]
        {
            let frequency = Frequency::from_hertz::<f64>(hertz).expect("in range");
            assert_eq!(frequency.whole_ticks_per_cycle(), Some(ticks), "{hertz} Hz");
        }
        assert_eq!(Frequency::from_hertz(0.0_f32).expect("in range").whole_ticks_per_cycle(), None);
    }

    #[test]
    fn conversions_round_to_the_nearest_tick_and_refuse_the_rest() {
        assert_eq!(Instant::from_seconds(1.5_f32), Some(Instant(3 << 37)));
        assert_eq!(Instant::from_seconds(2f64.powi(-39) * 1.01), Some(Instant(1)));
        assert_eq!(Instant::from_seconds(0.0_f64), Some(Instant(0)));
        for refused in [-1.0, f64::NAN, f64::INFINITY, 6.8e7, 1e300] {
            assert_eq!(Instant::from_seconds(refused), None, "{refused}");
        }
        for refused in [-1.0, f64::NAN, f64::INFINITY, 1.1e6, 1e300] {
            assert_eq!(Frequency::from_hertz(refused), None, "{refused}");
        }
        let at = Instant::from_seconds(12_345.678_9_f64).expect("in range");
        assert!((at.seconds::<f64>() - 12_345.678_9).abs() < 4e-12);
        assert_eq!(ticks_of_seconds(1e9_f32), u32::MAX);
        assert_eq!(ticks_of_seconds(0.0_f32), 1);
        assert_eq!(ticks_of_seconds(1e-6_f64), 274_878);
    }
}
