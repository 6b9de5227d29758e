//! Bounds how far the gap can depart from a straight line within a step in free flight.

use super::choices::{ContactOf, Coupling};
use super::contact_law::ContactLaw;
use super::state::State;
use super::{BumpStop, Parts};
use crate::scalar::Scalar;

/// The coefficients of the bound for one step length `h`.
///
/// Within a step the displacement of a mode departs from the straight line between its ends by at most `h²/8` times
/// the largest `|r̈|`, and by at most twice the largest `|r|`.
///
/// * The energy of a free mode does not grow, so with `N = |ω r| + |ṙ|` at the start `|r| ≤ N/ω` and `|r̈| ≤ √(1 + 4ζ²)
///   ω N`.
/// * Under a force of at most `f` per unit mass that is linear over the step, from rest, `|r̈| ≤ 3 f`. The response is a
///   linear function of time and a free motion of at most `(1 + 2 (1 + 2ζ)/ωh) f/ω²`.
///
/// Each mode contributes the smaller of both bounds (derived here).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GapBound<S, const B: usize, const R: usize> {
    /// Gap in m by `N` of each mode.
    beam: [S; B],
    rod: [S; R],
    /// Gap in m by the largest `|a|`, and by the largest `|v|`.
    by_base: S,
    by_voltage: S,
}

/// The free motion at the start of a step, for the bounds of all step lengths.
#[derive(Clone, Copy)]
pub(super) struct Flight<S, const B: usize, const R: usize> {
    /// Rate of the gap coordinate in m/s; 0 without a stop.
    pub(super) rate: S,
    /// `N` of each mode.
    beam: [S; B],
    rod: [S; R],
}

impl<S: Scalar, const B: usize, const R: usize> Flight<S, B, R> {
    #[inline]
    pub(super) fn of<P: Parts<S>, C>(scene: &BumpStop<S, P, B, R>, state: &State<S, B, R, C>) -> Self {
        let mut flight = Self { rate: S::ZERO, beam: [S::ZERO; B], rod: [S::ZERO; R] };
        if !ContactOf::<S, P>::POSSIBLE {
            return flight;
        }
        for ((norm, mode), [displacement, velocity]) in
            flight.beam.iter_mut().zip(&scene.beam).zip(&state.beam)
        {
            flight.rate += mode.contact * *velocity;
            *norm = (mode.angular_frequency * *displacement).abs() + velocity.abs();
        }
        for ((norm, mode), [displacement, velocity]) in flight.rod.iter_mut().zip(&scene.rod).zip(&state.rod)
        {
            flight.rate -= mode.contact * *velocity;
            *norm = (mode.angular_frequency * *displacement).abs() + velocity.abs();
        }
        flight
    }
}

impl<S: Scalar, const B: usize, const R: usize> GapBound<S, B, R> {
    /// For a step in s.
    pub(super) fn new<P: Parts<S>>(scene: &BumpStop<S, P, B, R>, step: S) -> Self {
        let (two, three) = (S::from_f64(2.0), S::from_f64(3.0));
        let sagitta = S::from_f64(0.125) * step * step;
        let damping = two * scene.damping_ratio;
        let factor = (S::ONE + damping * damping).sqrt();
        let free = |contact: S, omega: S| contact.abs() * (factor * omega * sagitta).min(two / omega);
        let forced = |omega: S| {
            let swing = S::ONE + two * (S::ONE + damping) / (omega * step);
            (three * sagitta).min(two * swing / (omega * omega))
        };
        let (mut by_base, mut by_voltage) = (S::ZERO, S::ZERO);
        for mode in &scene.beam {
            let forced = forced(mode.angular_frequency);
            by_base += forced * (mode.contact * mode.base).abs();
            by_voltage += forced * (mode.contact * mode.voltage).abs();
        }
        for mode in &scene.rod {
            by_base += forced(mode.angular_frequency) * (mode.contact * mode.base).abs();
        }
        Self {
            beam: scene.beam.map(|mode| free(mode.contact, mode.angular_frequency)),
            rod: scene.rod.map(|mode| free(mode.contact, mode.angular_frequency)),
            by_base,
            by_voltage: if scene.coupling.is_two_way() { by_voltage } else { S::ZERO },
        }
    }

    /// The part in m of the free motion.
    #[inline]
    pub(super) fn of_modes(&self, flight: &Flight<S, B, R>) -> S {
        let mut reach = S::ZERO;
        for (by_norm, norm) in self.beam.iter().zip(&flight.beam) {
            reach += *by_norm * *norm;
        }
        for (by_norm, norm) in self.rod.iter().zip(&flight.rod) {
            reach += *by_norm * *norm;
        }
        reach
    }

    /// The part in m of the largest magnitudes over the step of the lines of the base acceleration in m/s² and of the voltage in V.
    #[inline]
    pub(super) fn of_forces(&self, acceleration: S, voltage: S) -> S {
        self.by_base * acceleration + self.by_voltage * voltage
    }
}
