//! An excitation chosen at run time, for hosts that read scene files.

use super::{Excitation, Line, Sampled, Silence, Sine, Tones};
use crate::any::forward;
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar};

/// An excitation chosen at run time, with at most `TONES` sines in a sum.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyExcitation<'a, S, const TONES: usize, M = Polynomial> {
    /// A base at rest.
    Silence,
    /// One sine.
    Sine(Sine<S, M>),
    /// A sum of sines.
    Tones(Tones<S, TONES, M>),
    /// A recorded trace.
    Sampled(Sampled<'a, S>),
}

impl<S: Scalar, const TONES: usize, M: Mathematics<S>> Excitation<S> for AnyExcitation<'_, S, TONES, M> {
    forward! {
        match {
            Self::Silence => Silence,
            Self::Sine(sine) => sine,
            Self::Tones(tones) => tones,
            Self::Sampled(trace) => trace,
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
            Self::Silence | Self::Sampled(_) => u32::MAX,
        }
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        match self {
            Self::Sampled(trace) => trace.smooth_ticks(at),
            Self::Silence | Self::Sine(_) | Self::Tones(_) => u32::MAX,
        }
    }
}
