//! Half-sine shocks and bursts of sines, once or repeated.

use core::marker::PhantomData;

use super::integers::divide;
use super::sample_grid::line_of_pieces;
use super::sine::line_of_sine;
use super::{Excitation, ExcitationError, Line};
use crate::clock::{Frequency, Instant, ticks_of_seconds};
use crate::oscillator::{Kernel, LONGEST_RADIANS, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar};

/// A whole number of half cycles of a sine, once or periodically; zero before, between and after.
///
/// `a(t) = A sin(2π f (t − t₀))` for `0 ≤ t − t₀ < n/2f`: with one half cycle a half-sine shock. Start, length and period
/// are whole ticks. The event-driven methods end a step at the start and at the end of each burst and respond exactly to it;
/// the fixed steps of bump-stop see the mean and the first moment of the acceleration over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Burst<S, M = Polynomial> {
    amplitude: S,
    /// `2π f` in rad/s.
    angular_frequency: S,
    frequency: Frequency,
    /// Ticks in [`LONGEST_RADIANS`].
    resolved: u32,
    /// Ticks of a burst.
    length: u64,
    /// Ticks from time zero to the first burst.
    start: u64,
    /// Ticks from one burst to the next; `u64::MAX` for one burst only.
    period: u64,
    mathematics: PhantomData<M>,
}

/// Where an instant is.
struct Place {
    /// Ticks since the start of a burst that lasts.
    within: Option<u64>,
    /// Ticks until that burst ends, or the next one begins.
    left: u64,
}

impl<S: Scalar, M: Mathematics<S>> Burst<S, M> {
    /// A shock of half a sine at time zero: `amplitude` in m/s², which may be negative, and `duration` in s. Its impulse
    /// `2 amplitude duration/π` does not depend on the rounding of the duration to ticks.
    ///
    /// # Errors
    /// An amplitude that is not finite; a duration that is not 10⁻⁶ to 10⁶ s.
    pub fn half_sine(amplitude: S, duration: S) -> Result<Self, ExcitationError> {
        let length = ticks(duration, 1e-6).ok_or(ExcitationError::Duration)?;
        let frequency = Frequency::from_units(divide(1, 95, u128::from(length)));
        let angular_frequency = S::from_f64(core::f64::consts::PI) / duration;
        // Half a tick is 4·10⁻⁸ of 50 µs, of which f64 would see the impulse change.
        let rounded = (duration - Instant::from_ticks(length).seconds::<S>()) / duration;
        Self::of(amplitude + amplitude * rounded, angular_frequency, frequency, length)
    }

    /// A burst at time zero: `amplitude` in m/s², `frequency` in Hz and a number of whole `cycles`.
    ///
    /// # Errors
    /// An amplitude that is not finite; a frequency that is not 10⁻⁶ to 10⁶ Hz; no cycle, or a burst longer than 10⁶ s.
    pub fn cycles(amplitude: S, frequency: S, cycles: u32) -> Result<Self, ExcitationError> {
        let fixed = Frequency::from_hertz(frequency).ok_or(ExcitationError::Frequency)?;
        if !(frequency >= S::from_f64(1e-6)) {
            return Err(ExcitationError::Frequency);
        }
        let seconds = S::from_u32(cycles) / frequency;
        if cycles == 0 || !(seconds <= S::from_f64(LONGEST)) {
            return Err(ExcitationError::Duration);
        }
        let length = (divide(u128::from(cycles), 96, fixed.units())) as u64;
        Self::of(amplitude, frequency * S::from_f64(core::f64::consts::TAU), fixed, length)
    }

    fn of(
        amplitude: S,
        angular_frequency: S,
        frequency: Frequency,
        length: u64,
    ) -> Result<Self, ExcitationError> {
        if !amplitude.is_finite() {
            return Err(ExcitationError::Amplitude);
        }
        let resolved = ticks_of_seconds(S::from_f64(LONGEST_RADIANS) / angular_frequency);
        let (start, period) = (0, u64::MAX);
        let mathematics = PhantomData;
        Ok(Self { amplitude, angular_frequency, frequency, resolved, length, start, period, mathematics })
    }

    /// The same from `start` on, in s.
    ///
    /// # Errors
    /// A start that is not 0 to 10⁶ s.
    pub fn starting_at(self, start: S) -> Result<Self, ExcitationError> {
        let start = ticks(start, 0.0).ok_or(ExcitationError::Start)?;
        Ok(Self { start, ..self })
    }

    /// The same again each `period`, in s.
    ///
    /// # Errors
    /// A period that is not 10⁻⁶ to 10⁶ s, or shorter than the burst.
    pub fn every(self, period: S) -> Result<Self, ExcitationError> {
        let period = ticks(period, 1e-6).filter(|period| *period >= self.length);
        Ok(Self { period: period.ok_or(ExcitationError::Period)?, ..self })
    }

    fn place(&self, at: Instant) -> Place {
        let Some(since) = at.ticks().checked_sub(self.start) else {
            return Place { within: None, left: self.start.wrapping_sub(at.ticks()) };
        };
        let elapsed = since.checked_rem(self.period).unwrap_or(since);
        match self.length.checked_sub(elapsed) {
            Some(left) if left > 0 => Place { within: Some(elapsed), left },
            _ => Place { within: None, left: self.period.wrapping_sub(elapsed) },
        }
    }

    /// Phase in units of 2⁻⁶⁴ turns so many ticks after the start of a burst.
    #[inline]
    fn phase(&self, elapsed: u64) -> u64 {
        self.frequency.phase(Instant::from_ticks(elapsed))
    }
}

/// Longest time in s.
const LONGEST: f64 = 1e6;

/// The ticks of a time in s from `shortest` to [`LONGEST`].
fn ticks<S: Scalar>(seconds: S, shortest: f64) -> Option<u64> {
    let valid = seconds >= S::from_f64(shortest) && seconds <= S::from_f64(LONGEST);
    Instant::from_seconds(seconds).filter(|_| valid).map(Instant::ticks)
}

impl<S: Scalar, M: Mathematics<S>> Excitation<S> for Burst<S, M> {
    fn acceleration(&self, at: Instant) -> S {
        let within = self.place(at).within;
        within.map_or(S::ZERO, |elapsed| self.amplitude * M::sine_of_turns(self.phase(elapsed)))
    }

    fn jerk(&self, at: Instant) -> S {
        let within = self.place(at).within;
        within.map_or(S::ZERO, |elapsed| {
            self.amplitude * self.angular_frequency * M::cosine_of_turns(self.phase(elapsed))
        })
    }

    /// Before a burst a step reaches into it by at most 0.9 radians.
    fn resolved_ticks_at(&self, at: Instant) -> u32 {
        let Place { within, left } = self.place(at);
        if within.is_some() {
            self.resolved
        } else {
            u32::try_from(left).unwrap_or(u32::MAX).max(self.resolved)
        }
    }

    /// To the next start or end, and within a burst at most 0.9 radians.
    fn smooth_ticks(&self, at: Instant) -> u32 {
        let Place { within, left } = self.place(at);
        let left = u32::try_from(left).unwrap_or(u32::MAX);
        if within.is_some() { left.min(self.resolved) } else { left }
    }

    fn response(&self, at: Instant, _ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        let Some(elapsed) = self.place(at).within else { return Response::NONE };
        let phase = self.phase(elapsed);
        let start = self.amplitude * M::sine_of_turns(phase);
        let rate = self.amplitude * self.angular_frequency * M::cosine_of_turns(phase);
        kernel.to_sine(start, rate, self.angular_frequency)
    }

    /// Of the pieces, at a step of any length.
    fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S> {
        let Place { within, left } = self.place(at);
        if within.is_none() && left >= u64::from(ticks) {
            return Line { mean: S::ZERO, tilt: S::ZERO, end: S::ZERO };
        }
        let radians_per_tick = self.angular_frequency * step / S::from_u32(ticks);
        let line_of_piece = |at: Instant, ticks: u32, start: S| {
            let chord = Line::between(start, self.acceleration(at.after(ticks)));
            // A piece of silence has a line of zeros at any length.
            line_of_sine(chord, radians_per_tick * S::from_u32(ticks))
        };
        if self.smooth_ticks(at) >= ticks {
            return line_of_piece(at, ticks, start);
        }
        line_of_pieces(self, (at, ticks), start, line_of_piece)
    }
}

#[cfg(test)]
mod tests;
