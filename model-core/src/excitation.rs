//! What shakes the base: its acceleration as a function of the integer clock.
//!
//! An excitation is a pure value: asked for an instant it answers, and keeps nothing. The sign
//! convention of every scene is that of the papers: `a` is the acceleration of the base in the
//! positive direction of the relative coordinate, so the mass feels `−m a`.

mod any;
mod sample_grid;
mod sampled;
mod silence;
mod sine;
mod stream;
mod tone_meter;
mod tones;

use crate::clock::Instant;
use crate::scalar::Scalar;

pub use any::AnyExcitation;
pub use sampled::{AfterLastSample, Sampled};
pub use silence::Silence;
pub use sine::Sine;
pub use stream::{Stream, StreamError};
pub use tone_meter::{Line, ToneMeter, ToneMeterState};
pub use tones::Tones;

/// Base acceleration over time.
pub trait Excitation<S: Scalar> {
    /// Base acceleration in m/s² at `at`.
    fn acceleration(&self, at: Instant) -> S;

    /// Time derivative of the base acceleration in m/s³ just after `at`.
    ///
    /// Asked for only where an event depends on the acceleration itself: a mass held on its stop,
    /// a slider held by friction.
    fn jerk(&self, at: Instant) -> S;

    /// The longest step, in ticks, in which the acceleration is resolved: an eighth of the period of the
    /// fastest sine. A mass that is held does not show its step control what shakes it.
    #[inline(always)]
    fn resolved_ticks(&self) -> u32 {
        u32::MAX
    }

    /// Angular frequency in rad/s of the fastest sine; 0 where there is none.
    #[inline(always)]
    fn angular_frequency(&self) -> S {
        S::ZERO
    }

    /// Ticks until the acceleration next has a kink, at least 1: no step crosses one
    /// by more than a millionth of the interval between two.
    #[inline(always)]
    fn smooth_ticks(&self, _at: Instant) -> u32 {
        u32::MAX
    }
}

/// A reference to an excitation, of a type that is known or not.
impl<S: Scalar, E: Excitation<S> + ?Sized> Excitation<S> for &E {
    #[inline]
    fn acceleration(&self, at: Instant) -> S {
        (**self).acceleration(at)
    }

    #[inline]
    fn jerk(&self, at: Instant) -> S {
        (**self).jerk(at)
    }

    #[inline]
    fn resolved_ticks(&self) -> u32 {
        (**self).resolved_ticks()
    }

    #[inline]
    fn angular_frequency(&self) -> S {
        (**self).angular_frequency()
    }

    #[inline]
    fn smooth_ticks(&self, at: Instant) -> u32 {
        (**self).smooth_ticks(at)
    }
}

/// Why an excitation was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ExcitationError {
    /// The amplitude is not finite.
    Amplitude,
    /// The frequency is negative, not finite, or above [`crate::clock::Frequency::HIGHEST_HZ`];
    /// for a sampled trace: not above zero.
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
