//! A step of a given length, and the distance of two states: for checks of the steps by halves of them.

use super::choices::ContactOf;
use super::contact_law::{ContactKind, ContactLaw};
use super::gap_bound::Flight;
use super::state::StateOf;
use super::stepper::{LEVELS, PairOf, Stepper};
use super::trial::Trial;
use super::{BumpStop, Parts};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::{StepError, Work};
use crate::observer::Observer;
use crate::scalar::Scalar;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> Stepper<S, P, B, R> {
    /// Takes the step of a level, if it ends at or before `until` and is allowed.
    pub(super) fn step_of<E: Excitation<S>, O: Observer<S>>(
        &self,
        level: usize,
        pair: &mut PairOf<'_, S, P, B, R>,
        until: Instant,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<bool, StepError<S>> {
        let left = pair.now.clock.ticks_until(until, u32::MAX);
        if level == LEVELS - 1 {
            let short = self.short();
            if short.ticks > left {
                return Ok(false);
            }
            self.short_step(short, pair, &mut Trial::none(), excitation, observer, work)?;
            return Ok(true);
        }
        let flight = Flight::of(&self.scene, pair.now);
        match self.passes(level, left, pair.now, &flight) {
            Some(room) if !pair.now.closed => self.try_flight(level, room, pair, excitation, observer, work),
            _ => Ok(false),
        }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Energy in J of the difference of two states: of the modes, of the capacitance, and of the contact.
    pub(super) fn energy_between(&self, one: &StateOf<S, P, B, R>, other: &StateOf<S, P, B, R>) -> S {
        let between = |omega: S, a: &[S; 2], b: &[S; 2]| {
            let (displacement, velocity) = (omega * (a[0] - b[0]), a[1] - b[1]);
            displacement * displacement + velocity * velocity
        };
        let mut squares = S::ZERO;
        for (mode, (a, b)) in self.beam.iter().zip(one.beam.iter().zip(&other.beam)) {
            squares += between(mode.angular_frequency, a, b);
        }
        for (mode, (a, b)) in self.rod.iter().zip(one.rod.iter().zip(&other.rod)) {
            squares += between(mode.angular_frequency, a, b);
        }
        let voltage = self.voltage(one) - self.voltage(other);
        squares += self.capacitance * voltage * voltage;
        if ContactOf::<S, P>::POSSIBLE && self.contact.kind() == ContactKind::Compliant {
            let pressed = one.gap.max(S::ZERO) - other.gap.max(S::ZERO);
            squares += self.stiffness * pressed * pressed;
        }
        S::from_f64(0.5) * squares
    }
}
