//! Base acceleration `a(t)` in m/s² as a function of the integer clock, and the lines of a band in its samples.
//!
//! An excitation is a pure function of time, without state. In every scene `a` is the acceleration of the
//! base in the positive direction of the relative coordinate, so the force on the mass is `−m a`.

mod any;
mod burst;
mod density;
mod integers;
mod line_bank;
mod random;
mod sample_grid;
mod sampled;
mod sine;
mod stream;
mod sweep;

use crate::bounds::ParameterError;
use crate::clock::Instant;
use crate::forward;
use crate::oscillator::{Kernel, Response};
use crate::scalar::Scalar;

pub use any::{AnyExcitation, Silence};
pub use burst::Burst;
pub use density::{DENSITY_FREQUENCY, SpectralDensity};
pub use line_bank::{LineBank, LineBankState, Lines};
pub use random::{Random, SpectralLine};
pub use sampled::{AfterLastSample, Sampled};
pub use sine::{Sine, Tones};
pub(crate) use stream::{LARGEST_SAMPLE, is_acceleration};
pub use stream::{Stream, StreamError};
pub use sweep::{Sweep, SweepLaw};

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
    #[inline]
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
    /// Called only if an event depends on the acceleration: while a mass sticks to its stop, or a slider sticks by friction.
    fn jerk(&self, at: Instant) -> S;

    /// The longest step, in ticks, that resolves the acceleration: 0.9 radians of the fastest sine.
    ///
    /// The error estimate of a mass that sticks does not depend on the acceleration and cannot limit the step.
    #[inline]
    fn resolved_ticks(&self) -> u32 {
        u32::MAX
    }

    /// Whether [`Excitation::response`] is exact over any step that the series of the kernel reach. [`Excitation::resolved_ticks`] then
    /// limits the steps of a mass that sticks alone.
    #[inline]
    fn is_exact(&self) -> bool {
        false
    }

    /// As [`Excitation::resolved_ticks`], of a step from `at`, for a method that does not end its steps at the kinks of the
    /// acceleration ([`Excitation::smooth_ticks`]).
    #[inline]
    fn resolved_ticks_at(&self, _at: Instant) -> u32 {
        self.resolved_ticks()
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
    /// By default that to the parabola through three accelerations. The types of this module are exact, but for
    /// [`Random`] and [`Sweep`], which state their errors.
    #[inline]
    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        kernel.to_parabola([0, ticks / 2, ticks].map(|offset| self.acceleration(at.after(offset))))
    }

    /// The line over a step of `ticks` from `at`, `step` in s; `start` is the acceleration at `at`.
    ///
    /// By default of the parabola through three accelerations, as of [`Tones`]. Samples are exact; of a sine of at most 0.9
    /// radians in the step the mean is within 6·10⁻⁵ of the amplitude.
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
        #[inline] fn resolved_ticks_at(&self, at: Instant) -> u32;
        #[inline] fn is_exact(&self) -> bool;
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
    /// The frequency is negative, not finite, or above 1 MHz; for a sampled trace also if it is zero, for a burst or a
    /// sweep also if it is too low, for a sweep also if the two are too close.
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
    /// A spectral density has fewer than two points.
    TooFewPoints,
    /// A point of a spectral density is out of bounds, or its frequency is not at least 1.001 times that of the point before.
    Point {
        /// Index of the point.
        index: usize,
    },
    /// A random acceleration has no line, or more than its capacity.
    Lines,
    /// A number of a bank of lines is outside its bounds: `M`, the most samples of a section; `unit`; `rate`; `frequency`, two
    /// section rates to 0.45 of the rate; or `half_bandwidth`.
    Bank(ParameterError<f32>),
    /// The bins of a bank of lines do not cover the resonance with its half-bandwidth: its sections are too long.
    Band {
        /// Rate of the sections in Hz.
        section_rate: f32,
        /// Half-bandwidth of the resonance in Hz.
        half_bandwidth: f32,
        /// Half-bandwidth in Hz below which these sections cover this resonance.
        limit: f32,
    },
    /// A block of a bank of lines is shorter than the memory of the harvester.
    Block {
        /// Length of a block in s.
        seconds: f32,
        /// Least length in s: 1/(2π · half-bandwidth).
        least: f32,
    },
    /// The length of a shock, a burst or a sweep is out of bounds.
    Duration,
    /// The start of a shock or a burst is out of bounds.
    Start,
    /// The period of a shock or a burst is out of bounds, or shorter than it.
    Period,
}

impl core::fmt::Display for ExcitationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Amplitude => write!(f, "amplitude must be finite"),
            Self::Frequency => write!(
                f,
                "frequency must be from 0 to 1e6 Hz, above 0 for a sampled trace, from 1e-6 Hz for a burst, and from \
                 1e-3 Hz with a quotient of at least 1.001 for a sweep"
            ),
            Self::Phase => write!(f, "phase must be finite"),
            Self::TooFewSamples => write!(f, "a sampled trace must have at least two samples"),
            Self::Sample { index } => write!(f, "sample {index} must be finite"),
            Self::TooFewPoints => write!(f, "a spectral density must have at least two points"),
            Self::Point { index } => write!(
                f,
                "point {index} of the spectral density must be from 1e-3 to 1e5 Hz, at least 1.001 times the point before, and from \
                 1e-12 to 1e8 (m/s²)²/Hz"
            ),
            Self::Lines => write!(f, "lines must be at least 1 and at most the capacity"),
            Self::Bank(error) => write!(f, "bank of lines: {error}"),
            Self::Band { section_rate, half_bandwidth, limit } => write!(
                f,
                "bank of lines: half-bandwidth {half_bandwidth:?} Hz must be below {limit:?} Hz with sections at {section_rate:?} \
                 Hz: fewer samples in a section, or a higher rate"
            ),
            Self::Block { seconds, least } => write!(
                f,
                "bank of lines: a block of {seconds:?} s must be at least {least:?} s, 1/(2 pi half-bandwidth): more samples in a \
                 section, or more sections"
            ),
            Self::Duration => {
                write!(
                    f,
                    "duration must be from 1e-6 to 1e6 s of a shock or a burst, from 1e-3 to 1e5 s of a sweep"
                )
            }
            Self::Start => write!(f, "start must be from 0 to 1e6 s"),
            Self::Period => write!(f, "period must be from 1e-6 to 1e6 s, and not shorter than the burst"),
        }
    }
}

impl core::error::Error for ExcitationError {}

#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;
