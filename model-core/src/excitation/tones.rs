//! A sum of sines, `a(t) = Σ A_k sin(2π f_k t + φ_k)`.

use super::{Excitation, Sine};
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar};
use heapless::Vec;

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
