//! Base acceleration `a(t)` in m/s² as a function of the integer clock, and the strongest sine in its samples.
//!
//! An excitation is a pure function of time, without state. In every scene `a` is the acceleration of the
//! base in the positive direction of the relative coordinate, so the force on the mass is `−m a`.

mod any;
mod sample_grid;
mod sampled;
mod silence;
mod sine;
mod stream;
mod tone_meter;
mod tones;

use crate::any::forward;
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::Scalar;

pub use any::AnyExcitation;
pub use sampled::{AfterLastSample, Sampled};
pub use silence::Silence;
pub use sine::Sine;
pub(crate) use stream::is_acceleration;
pub use stream::{LARGEST_SAMPLE, Stream, StreamError};
pub use tone_meter::{SpectralPeak, ToneMeter, ToneMeterState};
pub use tones::Tones;

/// The straight line over a step with the mean and the first moment of an acceleration, in m/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line<S> {
    /// Mean over the step.
    pub mean: S,
    /// Half the rise of the line over the step.
    pub tilt: S,
    /// The acceleration itself at the end of the step.
    pub end: S,
}

impl<S: Scalar> Line<S> {
    /// Of an acceleration that is linear over the step.
    #[inline(always)]
    fn between(start: S, end: S) -> Self {
        let half = S::from_f64(0.5);
        Self { mean: half * (start + end), tilt: half * (end - start), end }
    }
}

/// Base acceleration over time.
pub trait Excitation<S: Scalar> {
    /// Base acceleration in m/s² at `at`.
    fn acceleration(&self, at: Instant) -> S;

    /// Time derivative of the base acceleration in m/s³ just after `at`.
    ///
    /// Called only if an event depends on the acceleration: while a mass sticks to its stop, or a slider
    /// sticks by friction.
    fn jerk(&self, at: Instant) -> S;

    /// The longest step, in ticks, that resolves the acceleration: 0.9 radians of the fastest sine.
    ///
    /// The error estimate of a mass that sticks does not depend on the acceleration and cannot limit the step.
    #[inline]
    fn resolved_ticks(&self) -> u32 {
        u32::MAX
    }

    /// Angular frequency of the fastest sine in rad/s; 0 without a sine.
    #[inline]
    fn angular_frequency(&self) -> S {
        S::ZERO
    }

    /// Ticks until the next kink of the acceleration, at least 1.
    ///
    /// No step crosses a kink by more than a millionth of the interval between two kinks.
    #[inline]
    fn smooth_ticks(&self, _at: Instant) -> u32 {
        u32::MAX
    }

    /// The response of an oscillator over a step of `ticks` from `at`; `kernel` is of this step.
    ///
    /// By default that to the parabola through three accelerations. Sines, tones, samples and silence are exact.
    #[inline]
    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        kernel.to_parabola([0, ticks / 2, ticks].map(|offset| self.acceleration(at.after(offset))))
    }

    /// The line over a step of `ticks` from `at`, `step` in s; `start` is the acceleration at `at`.
    ///
    /// By default of the parabola through three accelerations. A sine, samples and silence are exact.
    #[inline]
    fn line(&self, at: Instant, ticks: u32, _step: S, start: S) -> Line<S> {
        let [middle, end] = [ticks / 2, ticks].map(|offset| self.acceleration(at.after(offset)));
        let line = Line::between(start, end);
        Line { mean: line.mean + S::from_f64(2.0 / 3.0) * (middle - line.mean), ..line }
    }
}

/// A reference to an excitation of a known type or a trait object.
impl<S: Scalar, E: Excitation<S> + ?Sized> Excitation<S> for &E {
    forward! {
        match { excitation => (**excitation) }
        #[inline] fn acceleration(&self, at: Instant) -> S;
        #[inline] fn jerk(&self, at: Instant) -> S;
        #[inline] fn resolved_ticks(&self) -> u32;
        #[inline] fn angular_frequency(&self) -> S;
        #[inline] fn smooth_ticks(&self, at: Instant) -> u32;
        #[inline] fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S>;
        #[inline] fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S>;
    }
}

/// The reason why the parameters of an excitation were refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ExcitationError {
    /// The amplitude is not finite.
    Amplitude,
    /// The frequency is negative, not finite, or above 1 MHz; for a sampled trace also if it is zero.
    Frequency,
    /// The phase is not finite.
    Phase,
    /// A sampled trace has fewer than two samples.
    TooFewSamples,
    /// A sample is not finite.
    Sample {
        /// Index of the sample.
        index: usize,
    },
}

impl core::fmt::Display for ExcitationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Amplitude => write!(f, "amplitude must be finite"),
            Self::Frequency => {
                write!(f, "frequency must be from 0 to 1e6 Hz, and above 0 for a sampled trace")
            }
            Self::Phase => write!(f, "phase must be finite"),
            Self::TooFewSamples => write!(f, "a sampled trace must have at least two samples"),
            Self::Sample { index } => write!(f, "sample {index} must be finite"),
        }
    }
}

impl core::error::Error for ExcitationError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::seconds_of_ticks;

    /// Mean and half the rise of the nearest line, by Gauss's rule in `pieces` parts of the step.
    fn by_quadrature(excitation: &impl Excitation<f64>, at: Instant, ticks: u32, pieces: u32) -> [f64; 2] {
        let (mut mean, mut tilt) = (0.0, 0.0);
        for piece in 0..pieces {
            for node in [-0.6_f64.sqrt(), 0.0, 0.6_f64.sqrt()] {
                let place = (f64::from(piece) + 0.5 * (1.0 + node)) / f64::from(pieces);
                let offset = (place * f64::from(ticks)).round();
                let place = offset / f64::from(ticks);
                let weight = if node == 0.0 { 8.0 } else { 5.0 } / 18.0 / f64::from(pieces);
                let value = excitation.acceleration(at.after(offset as u32));
                mean += weight * value;
                tilt += 3.0 * weight * (2.0 * place - 1.0) * value;
            }
        }
        [mean, tilt]
    }

    #[test]
    fn the_line_over_a_step_has_the_mean_and_the_moment_of_the_acceleration() {
        let sine = Sine::<f64>::new(3.0, 700.0, 0.4).expect("valid");
        let mut tones = Tones::<f64, 2>::new();
        for tone in [sine, Sine::new(2.0, 450.0, 1.0).expect("valid")] {
            tones.push(tone).expect("it fits");
        }
        let samples: Vec<f64> = (0..64).map(|n| f64::from(n * n % 17) - 8.0).collect();
        let trace = Sampled::new(&samples, 3e4, AfterLastSample::Repeat).expect("valid");
        for k in 0..40_u64 {
            // Up to 0.9 radians of the sine, and six samples.
            let (at, ticks) = (Instant::from_ticks(k * 1_234_567_891), 1_300_000 * (k as u32 + 1));
            let step = seconds_of_ticks(ticks);
            let close = |excitation: &dyn Excitation<f64>, pieces, bound: f64| {
                let line = excitation.line(at, ticks, step, excitation.acceleration(at));
                let [mean, tilt] = by_quadrature(&excitation, at, ticks, pieces);
                let error = (line.mean - mean).abs().max((line.tilt - tilt).abs());
                assert!(error < bound, "{k}: {line:?} {mean} {tilt}");
                assert_eq!(line.end, excitation.acceleration(at.after(ticks)));
            };
            close(&sine, 8, 1.2e-4);
            close(&trace, 4000, 2e-3);
            // The line of a sum is that of a parabola.
            close(&tones, 8, 2e-2);
        }
    }
}
