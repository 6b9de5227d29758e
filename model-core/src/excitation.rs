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
pub use stream::{Stream, StreamError};
pub use tone_meter::{SpectralPeak, ToneMeter, ToneMeterState};
pub use tones::Tones;

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
