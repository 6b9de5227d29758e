//! No excitation, and one chosen at run time, for hosts that read scene files.

use super::{Burst, Excitation, Line, Random, Sampled, Sine, Sweep, Tones};
use crate::clock::Instant;
use crate::forward;
use crate::oscillator::{Kernel, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar};

/// An excitation chosen at run time, with at most `TONES` sines in a sum, and at most as many lines of a random one.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyExcitation<'a, S: Scalar, const TONES: usize, M = Polynomial> {
    /// A base at rest.
    Silence,
    /// One sine.
    Sine(Sine<S, M>),
    /// A sum of sines.
    Tones(Tones<S, TONES, M>),
    /// A recorded trace.
    Sampled(Sampled<'a, S>),
    /// Shocks of half a sine, or bursts of sines.
    Burst(Burst<S, M>),
    /// A sine of changing frequency.
    Sweep(Sweep<S, M>),
    /// A random acceleration with a spectral density.
    Random(Random<S, TONES, M>),
}

impl<S: Scalar, const TONES: usize, M: Mathematics<S>> Excitation<S> for AnyExcitation<'_, S, TONES, M> {
    forward! {
        match {
            Self::Silence => Silence,
            Self::Sine(sine) => sine,
            Self::Tones(tones) => tones,
            Self::Sampled(trace) => trace,
            Self::Burst(burst) => burst,
            Self::Sweep(sweep) => sweep,
            Self::Random(random) => random,
        }
        fn acceleration(&self, at: Instant) -> S;
        fn jerk(&self, at: Instant) -> S;
        fn angular_frequency(&self) -> S;
        fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S>;
        fn line(&self, at: Instant, ticks: u32, step: S, start: S) -> Line<S>;
    }

    fn resolved_ticks(&self) -> u32 {
        match self {
            Self::Sine(sine) => sine.resolved_ticks(),
            Self::Tones(tones) => tones.resolved_ticks(),
            Self::Sweep(sweep) => sweep.resolved_ticks(),
            Self::Random(random) => random.resolved_ticks(),
            Self::Silence | Self::Sampled(_) | Self::Burst(_) => u32::MAX,
        }
    }

    fn is_exact(&self) -> bool {
        matches!(self, Self::Sine(_) | Self::Tones(_))
    }

    fn resolved_ticks_at(&self, at: Instant) -> u32 {
        if let Self::Burst(burst) = self { burst.resolved_ticks_at(at) } else { self.resolved_ticks() }
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        match self {
            Self::Sampled(trace) => trace.smooth_ticks(at),
            Self::Burst(burst) => burst.smooth_ticks(at),
            Self::Sweep(sweep) => sweep.smooth_ticks(at),
            Self::Random(random) => random.smooth_ticks(at),
            Self::Silence | Self::Sine(_) | Self::Tones(_) => u32::MAX,
        }
    }
}

/// A base at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Silence;

impl<S: Scalar> Excitation<S> for Silence {
    #[inline]
    fn acceleration(&self, _at: Instant) -> S {
        S::ZERO
    }

    #[inline]
    fn jerk(&self, _at: Instant) -> S {
        S::ZERO
    }

    #[inline]
    fn response(&self, _at: Instant, _ticks: u32, _kernel: &Kernel<S>) -> Response<S> {
        Response::NONE
    }

    #[inline]
    fn line(&self, _at: Instant, _ticks: u32, _step: S, _start: S) -> Line<S> {
        Line::between(S::ZERO, S::ZERO)
    }
}
