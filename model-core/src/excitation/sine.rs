//! A sine of fixed amplitude, frequency and phase, and sums of them.

use core::marker::PhantomData;

use super::{Excitation, ExcitationError, Line};
use crate::clock::{Frequency, Instant, ticks_of_seconds};
use crate::oscillator::{Kernel, LONGEST_RADIANS, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar, turns_of_radians};
use heapless::Vec;

/// `a(t) = A sin(2π f t + φ)`.
///
/// The phase is an integer number of 2⁻⁶⁴ turns, computed from the clock, so it does not drift and needs no
/// range reduction. `M` evaluates the sine.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sine<S, M = Polynomial> {
    amplitude: S,
    /// `2π f` in rad/s.
    angular_frequency: S,
    frequency: Frequency,
    /// Ticks in [`LONGEST_RADIANS`].
    resolved: u32,
    /// `φ` in units of 2⁻⁶⁴ turns.
    start: u64,
    mathematics: PhantomData<M>,
}

impl<S: Scalar, M: Mathematics<S>> Sine<S, M> {
    /// A sine of `amplitude` in m/s², `frequency` in Hz, and `phase` at time zero in radians.
    ///
    /// # Errors
    /// An argument that is not finite, a negative frequency or one above 1 MHz, a phase of 2²⁰ turns or more.
    pub fn new(amplitude: S, frequency: S, phase: S) -> Result<Self, ExcitationError> {
        if !amplitude.is_finite() {
            return Err(ExcitationError::Amplitude);
        }
        let fixed = Frequency::from_hertz(frequency).ok_or(ExcitationError::Frequency)?;
        let start = turns_of_radians(phase).ok_or(ExcitationError::Phase)?;
        let angular_frequency = frequency * S::from_f64(core::f64::consts::TAU);
        let resolved = ticks_of_seconds(S::from_f64(LONGEST_RADIANS) / angular_frequency);
        Ok(Self { amplitude, angular_frequency, frequency: fixed, resolved, start, mathematics: PhantomData })
    }

    /// Phase at `at` in units of 2⁻⁶⁴ turns.
    #[inline]
    pub(crate) fn phase(&self, at: Instant) -> u64 {
        self.frequency.phase(at).wrapping_add(self.start)
    }
}

impl<S: Scalar, M: Mathematics<S>> Excitation<S> for Sine<S, M> {
    #[inline]
    fn acceleration(&self, at: Instant) -> S {
        self.amplitude * M::sine_of_turns(self.phase(at))
    }

    #[inline]
    fn jerk(&self, at: Instant) -> S {
        self.amplitude * self.angular_frequency * M::cosine_of_turns(self.phase(at))
    }

    #[inline]
    fn is_exact(&self) -> bool {
        true
    }

    #[inline]
    fn resolved_ticks(&self) -> u32 {
        self.resolved
    }

    #[inline]
    fn angular_frequency(&self) -> S {
        self.angular_frequency
    }

    #[inline(always)]
    fn response(&self, at: Instant, _ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        let phase = self.phase(at);
        let start = self.amplitude * M::sine_of_turns(phase);
        let rate = self.amplitude * self.angular_frequency * M::cosine_of_turns(phase);
        kernel.to_sine(start, rate, self.angular_frequency)
    }

    #[inline(always)]
    fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S> {
        let line = Line::between(start, self.acceleration(at.after(ticks)));
        line_of_sine(line, self.angular_frequency * step)
    }
}

/// The line over a step of a sine through both ends of `chord`, at most 0.9 `radians` apart.
///
/// With `x` half the radians of the step the mean is `tan(x)/x`, the rise `3 (1 − x cot x)/x²` times that between the
/// ends. Their series to `x⁶` and `x⁴` are exact to 4·10⁻⁵ at 0.9 radians.
#[inline]
pub(super) fn line_of_sine<S: Scalar>(chord: Line<S>, radians: S) -> Line<S> {
    let square = S::from_f64(0.25) * radians * radians;
    let [first, second, third] = [1.0 / 3.0, 2.0 / 15.0, 17.0 / 315.0].map(S::from_f64);
    let of_mean = square * (first + square * (second + square * third));
    let [first, second] = [1.0 / 15.0, 2.0 / 315.0].map(S::from_f64);
    let of_tilt = square * (first + square * second);
    let Line { mean, tilt, end } = chord;
    Line { mean: mean + mean * of_mean, tilt: tilt + tilt * of_tilt, end }
}

/// A sum of at most `CAPACITY` sines; zero if empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Tones<S, const CAPACITY: usize, M = Polynomial> {
    tones: Vec<Sine<S, M>, CAPACITY>,
}

impl<S: Scalar, const CAPACITY: usize, M: Mathematics<S>> Tones<S, CAPACITY, M> {
    /// A sum without sines.
    #[must_use]
    pub const fn new() -> Self {
        Self { tones: Vec::new() }
    }

    /// Adds a sine.
    ///
    /// # Errors
    /// The sine itself if there are `CAPACITY` sines already.
    pub fn push(&mut self, tone: Sine<S, M>) -> Result<(), Sine<S, M>> {
        self.tones.push(tone)
    }
}

impl<S: Scalar, const CAPACITY: usize, M: Mathematics<S>> Default for Tones<S, CAPACITY, M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const CAPACITY: usize, M: Mathematics<S>> Excitation<S> for Tones<S, CAPACITY, M> {
    #[inline]
    fn acceleration(&self, at: Instant) -> S {
        self.tones.iter().fold(S::ZERO, |sum, tone| sum + tone.acceleration(at))
    }

    #[inline]
    fn jerk(&self, at: Instant) -> S {
        self.tones.iter().fold(S::ZERO, |sum, tone| sum + tone.jerk(at))
    }

    #[inline]
    fn is_exact(&self) -> bool {
        true
    }

    #[inline]
    fn resolved_ticks(&self) -> u32 {
        self.tones.iter().map(Excitation::<S>::resolved_ticks).min().unwrap_or(u32::MAX)
    }

    #[inline]
    fn angular_frequency(&self) -> S {
        self.tones.iter().fold(S::ZERO, |fastest, tone| fastest.max(tone.angular_frequency()))
    }

    #[inline]
    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        self.tones.iter().fold(Response::NONE, |sum, tone| sum.and(tone.response(at, ticks, kernel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_sine_and_its_derivative() {
        let sine = Sine::<f64>::new(1.962, 20.0, 0.3).expect("valid");
        for k in 0..500 {
            let at = Instant::from_seconds(f64::from(k) * 1.37e-3).expect("valid");
            let angle = core::f64::consts::TAU * 20.0 * at.seconds::<f64>() + 0.3;
            assert!((sine.acceleration(at) - 1.962 * angle.sin()).abs() < 1e-12);
            assert!((sine.jerk(at) - 1.962 * core::f64::consts::TAU * 20.0 * angle.cos()).abs() < 1e-9);
        }
    }

    #[test]
    fn start_phase_may_be_negative_or_beyond_a_turn() {
        for phase in [-0.3_f64, 6.5, -1000.0, 0.0] {
            let sine = Sine::<f64>::new(1.0, 0.0, phase).expect("valid");
            assert!((sine.acceleration(Instant::START) - phase.sin()).abs() < 1e-11, "{phase}");
            let single = Sine::<f32>::new(1.0, 0.0, phase as f32).expect("valid");
            let tolerance = 1e-6 * phase.abs().max(1.0) as f32;
            assert!((single.acceleration(Instant::START) - phase.sin() as f32).abs() < tolerance, "{phase}");
        }
    }

    #[test]
    fn arguments_out_of_range_are_named() {
        assert_eq!(Sine::<f32>::new(f32::NAN, 1.0, 0.0), Err(ExcitationError::Amplitude));
        assert_eq!(Sine::<f32>::new(1.0, -1.0, 0.0), Err(ExcitationError::Frequency));
        assert_eq!(Sine::<f32>::new(1.0, 1.0, f32::INFINITY), Err(ExcitationError::Phase));
    }
}

#[cfg(test)]
mod tests_of_tones {
    use super::*;

    #[test]
    fn adds_its_tones_and_refuses_one_too_many() {
        let (a, b) =
            (Sine::new(1.0_f64, 20.0, 0.0).expect("valid"), Sine::new(0.5_f64, 33.0, 1.0).expect("valid"));
        let mut tones = Tones::<f64, 2>::new();
        assert_eq!((tones.push(a), tones.push(b), tones.push(a)), (Ok(()), Ok(()), Err(a)));
        let at = Instant::from_ticks(987_654_321_012);
        assert_eq!(tones.acceleration(at), a.acceleration(at) + b.acceleration(at));
        assert_eq!(tones.jerk(at), a.jerk(at) + b.jerk(at));
    }
}
