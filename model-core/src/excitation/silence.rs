//! Zero base acceleration, for free decay, static equilibrium and leakage.

use super::{Excitation, Line};
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::Scalar;

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
