//! A sine whose frequency sweeps up and down between two frequencies.

use core::marker::PhantomData;

use super::integers::{divide, octaves, power_of_two, times_ln_2};
use super::sine::line_of_sine;
use super::{Excitation, ExcitationError, Line};
use crate::clock::{Frequency, Instant, ticks_of_seconds};
use crate::oscillator::{Kernel, LONGEST_RADIANS, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar, turns_of_radians};

/// How the frequency of a [`Sweep`] goes from one end to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SweepLaw {
    /// At a constant number of hertz in a second.
    Linear,
    /// At a constant number of octaves in a minute.
    Logarithmic,
}

/// A sine of constant amplitude whose frequency goes from one frequency to another within a time, back the same way
/// within the same time, and so on.
///
/// `a(t) = A sin(2π ∫ f dt + φ)`. The phase is computed from the clock in integers, so it does not drift; phase and
/// frequency are continuous at the turns, where steps end. Over a step the acceleration is a sine at the frequency in its
/// middle and the cubic of the difference through four instants. A step is at most so long that the phase of the sweep
/// leaves that of the sine by 10⁻⁴ rad: the error is below 3·10⁻⁶ of the amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep<S, M = Polynomial> {
    amplitude: S,
    law: Law<S>,
    /// Ticks from one end to the other.
    length: u64,
    /// Ticks that the clock is ahead of a sweep that begins upwards.
    ahead: u64,
    /// Phase at the lower end, in units of 2⁻⁶⁴ turns.
    start: u64,
    /// Turns of one way, in units of 2⁻⁶⁴, modulo a turn.
    way: u64,
    /// `2π` times the upper frequency, in rad/s.
    highest: S,
    /// Ticks of the longest step.
    resolved: u32,
    mathematics: PhantomData<M>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Law<S> {
    Linear {
        /// Lower frequency, and the rise over the way, in units of 2⁻⁹⁶ cycles per tick.
        low: u128,
        rise: u128,
        /// The same in rad/s.
        low_angular: S,
        rise_angular: S,
        /// `2¹²⁷` over the ticks of the way.
        inverse: u128,
    },
    Logarithmic {
        /// Octaves of the way, in units of 2⁻⁵⁷.
        octaves: u64,
        /// Cycles in the time in which the lower frequency would rise by a factor `e`, in units of 2⁻⁶⁴.
        cycles: u128,
        low_angular: S,
        inverse: u128,
    },
}

/// Sweep times in s.
const SWEEP_SECONDS: [f64; 2] = [1e-3, 1e5];
/// Least quotient of the two frequencies.
const LEAST_RATIO: f64 = 1.001;
/// Most rad by which the phase over a step leaves that of a sine.
const BEND: f64 = 1e-4;

/// The product of a number below 2¹²⁷ with a fraction in units of 2⁻⁶⁴, at most 1, halved.
fn half_product(number: u128, fraction: u128) -> u128 {
    let (upper, lower) = (number >> 32, number & 0xffff_ffff);
    (upper.wrapping_mul(fraction) >> 33).wrapping_add(lower.wrapping_mul(fraction) >> 65)
}

impl<S: Scalar> Law<S> {
    /// The part of the way after `ticks`, in units of 2⁻⁶⁴.
    #[inline]
    fn part(&self, ticks: u64) -> u128 {
        let (Self::Linear { inverse, .. } | Self::Logarithmic { inverse, .. }) = self;
        inverse.wrapping_mul(ticks.into()) >> 63
    }

    /// The phase after so many ticks of the way up, in units of 2⁻⁶⁴ turns; and the angular frequency in rad/s.
    fn at(&self, ticks: u64) -> (u64, S) {
        let part = self.part(ticks);
        match *self {
            Self::Linear { low, rise, low_angular, rise_angular, .. } => {
                let mean = half_product(rise, part).wrapping_add(low);
                let way = S::from_fraction(i64::try_from(part >> 1).unwrap_or(i64::MAX));
                let phase = mean.wrapping_mul(u128::from(ticks)) >> 32;
                (phase as u64, low_angular + rise_angular * way)
            }
            Self::Logarithmic { octaves, cycles, low_angular, .. } => {
                let elapsed = part.wrapping_mul(octaves.into()) >> 57;
                let (whole, power) = ((elapsed >> 64) as u32, power_of_two(elapsed as u64));
                // `cycles · 2^passed` modulo a turn, less the phase at the lower end.
                let scaled = cycles << whole.min(63);
                let upper = u128::from((scaled >> 64) as u64) * u128::from(power);
                let lower = u128::from(scaled as u64) * u128::from(power);
                let phase = ((upper << 2) as u64).wrapping_add((lower >> 62) as u64);
                let ratio = S::from_fraction(power.min(i64::MAX as u64).cast_signed())
                    * S::power_of_two(whole.min(63).cast_signed() + 1);
                (phase.wrapping_sub(cycles as u64), low_angular * ratio)
            }
        }
    }
}

impl<S: Scalar, M: Mathematics<S>> Sweep<S, M> {
    /// A sweep of `amplitude` in m/s² that goes from one frequency in Hz to the other within `seconds`; `phase` in rad is
    /// that at time zero.
    ///
    /// # Errors
    /// A number that is not finite; frequencies that are not 10⁻³ to 10⁶ Hz and a factor of 1.001 apart; a time that is
    /// not 10⁻³ to 10⁵ s; a phase of 2²⁰ turns or more.
    pub fn new(
        amplitude: S,
        [from, to]: [S; 2],
        seconds: S,
        law: SweepLaw,
        phase: S,
    ) -> Result<Self, ExcitationError> {
        if !amplitude.is_finite() {
            return Err(ExcitationError::Amplitude);
        }
        let (lower, upper) = (from.min(to), from.max(to));
        let units = |frequency: S| Frequency::from_hertz(frequency).ok_or(ExcitationError::Frequency);
        let (low, high) = (units(lower)?.units(), units(upper)?.units());
        let apart = upper >= lower * S::from_f64(LEAST_RATIO) && to.is_finite() && from.is_finite();
        if !(apart && lower >= S::from_f64(1e-3)) {
            return Err(ExcitationError::Frequency);
        }
        let [shortest, longest] = SWEEP_SECONDS.map(S::from_f64);
        let valid = seconds >= shortest && seconds <= longest;
        let length =
            Instant::from_seconds(seconds).filter(|_| valid).ok_or(ExcitationError::Duration)?.ticks();
        let tau = S::from_f64(core::f64::consts::TAU);
        let (low_angular, highest) = (lower * tau, upper * tau);
        let inverse = divide(1, 127, u128::from(length));
        // The fastest rise of the angular frequency in rad/s².
        let mut rate = (highest - low_angular) / seconds;
        let law = match law {
            SweepLaw::Linear => {
                let rise_angular = highest - low_angular;
                Law::Linear { low, rise: high.wrapping_sub(low), low_angular, rise_angular, inverse }
            }
            SweepLaw::Logarithmic => {
                let octaves = octaves(low, high);
                let logarithm = times_ln_2(octaves);
                // `low` is below 2⁷⁷, the length below 2⁵⁵: their product in two parts, in units of 2⁻⁶⁴ cycles.
                let ticks = u128::from(length);
                let lower = (low & 0xffff_ffff).wrapping_mul(ticks) >> 32;
                let all = (low >> 32).wrapping_mul(ticks).wrapping_add(lower);
                rate =
                    highest / seconds * S::from_fraction((logarithm >> 1).cast_signed()) * S::power_of_two(7);
                Law::Logarithmic {
                    octaves,
                    cycles: divide(all, 57, u128::from(logarithm)),
                    low_angular,
                    inverse,
                }
            }
        };
        // The phase over half a step bends by `rate/2 · (h/2)²`.
        let bend = (S::from_f64(8.0 * BEND) / rate).sqrt();
        let resolved = ticks_of_seconds(bend.min(S::from_f64(LONGEST_RADIANS) / highest));
        let (way, _) = law.at(length);
        let ahead = if to < from { length } else { 0 };
        let phase = turns_of_radians(phase).ok_or(ExcitationError::Phase)?;
        let start = if to < from { phase.wrapping_sub(way) } else { phase };
        let mathematics = PhantomData;
        Ok(Self { amplitude, law, length, ahead, start, way, highest, resolved, mathematics })
    }

    /// The phase in units of 2⁻⁶⁴ turns and the angular frequency in rad/s; and the ticks until the next turn.
    fn place(&self, at: Instant) -> (u64, S, u64) {
        let ticks = at.ticks().wrapping_add(self.ahead);
        let both = self.length.wrapping_mul(2);
        let before = ticks.checked_div(both).unwrap_or(0);
        let within = ticks.wrapping_sub(before.wrapping_mul(both));
        let ways = self.way.wrapping_mul(before.wrapping_mul(2)).wrapping_add(self.start);
        if within < self.length {
            let (phase, frequency) = self.law.at(within);
            return (ways.wrapping_add(phase), frequency, self.length.wrapping_sub(within));
        }
        let left = both.wrapping_sub(within);
        let (phase, frequency) = self.law.at(left);
        (ways.wrapping_add(self.way.wrapping_mul(2)).wrapping_sub(phase), frequency, left)
    }

    /// The sine at the frequency in the middle of a step of `step` s, with the phase there.
    fn sine_in_the_middle(&self, at: Instant, ticks: u32, step: S) -> SineInStep<S> {
        let (middle, frequency, _) = self.place(at.after(ticks / 2));
        let half = S::from_f64(0.5) * frequency * step;
        SineInStep { middle, half: turns_of_radians(half).unwrap_or(0), frequency }
    }
}

/// A sine over a step.
struct SineInStep<S> {
    /// Phase in the middle of the step, in units of 2⁻⁶⁴ turns.
    middle: u64,
    /// Phase over half a step.
    half: u64,
    /// Angular frequency in rad/s.
    frequency: S,
}

impl<S: Scalar, M: Mathematics<S>> Excitation<S> for Sweep<S, M> {
    fn acceleration(&self, at: Instant) -> S {
        let (phase, ..) = self.place(at);
        self.amplitude * M::sine_of_turns(phase)
    }

    fn jerk(&self, at: Instant) -> S {
        let (phase, frequency, _) = self.place(at);
        self.amplitude * frequency * M::cosine_of_turns(phase)
    }

    /// 0.9 radians of the upper frequency, or less where the frequency changes fast.
    fn resolved_ticks(&self) -> u32 {
        self.resolved
    }

    fn angular_frequency(&self) -> S {
        self.highest
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        let (_, _, left) = self.place(at);
        u32::try_from(left).unwrap_or(u32::MAX)
    }

    /// To a sine at the frequency in the middle, and to the cubic of the difference at four instants.
    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        let SineInStep { middle, half, frequency } = self.sine_in_the_middle(at, ticks, kernel.step);
        let third = half / 3;
        let begin = middle.wrapping_sub(half);
        let difference = |offset: u32, phase: u64| {
            self.acceleration(at.after(offset)) - self.amplitude * M::sine_of_turns(phase)
        };
        let a = difference(0, begin);
        let b = difference(ticks / 3, middle.wrapping_sub(third));
        let c = difference(ticks - ticks / 3, middle.wrapping_add(third));
        let d = difference(ticks, middle.wrapping_add(half));
        // The cubic through four values at thirds.
        let [half, thrice] = [0.5, 3.0].map(S::from_f64);
        let (first, second, third) = (b - a, a - b - b + c, d - a + thrice * (b - c));
        let cubic = [
            a,
            thrice * (first - half * second + S::from_f64(1.0 / 3.0) * third),
            S::from_f64(4.5) * (second - third),
            S::from_f64(4.5) * third,
        ];
        let rate = self.amplitude * frequency * M::cosine_of_turns(begin);
        kernel.to_sine(self.amplitude * M::sine_of_turns(begin), rate, frequency).and(kernel.to_cubic(cubic))
    }

    /// That of the sine in the middle of the step, and of the parabola of the difference, which is 0 in the middle.
    fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S> {
        let SineInStep { middle, half, frequency } = self.sine_in_the_middle(at, ticks, step);
        let ends = [middle.wrapping_sub(half), middle.wrapping_add(half)]
            .map(|phase| self.amplitude * M::sine_of_turns(phase));
        let [begin, finish] = ends;
        let end = self.acceleration(at.after(ticks));
        let sine = line_of_sine(Line::between(begin, finish), frequency * step);
        let (before, after) = (start - begin, end - finish);
        Line {
            mean: sine.mean + S::from_f64(1.0 / 6.0) * (before + after),
            tilt: sine.tilt + S::from_f64(0.5) * (after - before),
            end,
        }
    }
}

#[cfg(test)]
mod tests;
