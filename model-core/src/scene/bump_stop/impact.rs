//! Locates an impact of a rigid contact, and applies its restitution.

use super::state::StateOf;
use super::step_set::StepSetOf;
use super::stepper::{MOST_LOCATING, PairOf, Stepper};
use super::trial::Trial;
use super::{BumpStop, Parts};
use crate::clock::seconds_of_ticks;
use crate::excitation::Excitation;
use crate::hybrid::{StepError, Work};
use crate::observer::{ALL_POWERS, Event, Observer, PowerIndex};
use crate::scalar::Scalar;

/// Ratio of the gap to the drift above which the drift is removed.
const OPENED: f64 = 16.0;

/// Impact speed in m/s below which an impact closes the contact.
const CLOSING_SPEED: f64 = 1e-5;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize> Stepper<S, P, B, R, ALL> {
    /// Steps to the tick at which the gap closes, and through the impact.
    ///
    /// The gap is at or below zero at the start and above zero at the end of the attempt `beyond`.
    #[cold]
    #[inline(never)]
    pub(super) fn locate_impact<E: Excitation<S>, O: Observer<S>>(
        &self,
        beyond: (StepSetOf<S, P, B, R>, Trial<S>),
        restitution: S,
        pair: &mut PairOf<'_, S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let (mut set, mut trial) = beyond;
        let mut reached = *pair.next;
        let (mut open, mut closed) = (0, set.ticks);
        let (mut latest, mut gap, mut rate) = (closed, reached.gap, self.scene.gap_rate(&reached));
        let mut attempts = 0;
        while closed.wrapping_sub(open) > 1 && attempts < MOST_LOCATING {
            // Newton's iteration from the last attempt, overshooting; bisection if it leaves the bracket.
            let distance = ((gap / rate).abs() / seconds_of_ticks(1)).to_u32();
            let next = match (rate > S::ZERO, gap > S::ZERO) {
                (true, true) if distance == 0 => break,
                (true, true) => latest.saturating_sub(distance),
                (true, false) => latest.saturating_add(distance).saturating_add(1),
                (false, _) => open,
            };
            latest = if next > open && next < closed { next } else { open.midpoint(closed) };
            attempts = attempts.wrapping_add(1);
            let shorter = self.scene.step_set(latest);
            let mut attempt = trial;
            self.attempt(&shorter, pair, &mut attempt, excitation);
            (gap, rate) = (pair.next.gap, self.scene.gap_rate(pair.next));
            if gap > S::ZERO {
                (closed, set, reached, trial) = (latest, shorter, *pair.next, attempt);
            } else {
                open = latest;
            }
        }
        work.locating = work.locating.wrapping_add(attempts);
        *pair.next = reached;
        self.take(pair, &trial, (set.ticks, set.step), observer, work)?;
        self.collide(pair.now, &reached, restitution, observer, work);
        Ok(())
    }

    /// The impact at `state`; the gap closes at the rate in `reached`.
    fn collide<O: Observer<S>>(
        &self,
        state: &mut StateOf<S, P, B, R>,
        reached: &StateOf<S, P, B, R>,
        restitution: S,
        observer: &mut O,
        work: &mut Work,
    ) {
        let before = *state;
        BumpStop::<S, P, B, R>::close_gap(state);
        let speed = self.scene.gap_rate(reached);
        if !(speed > S::ZERO) {
            return;
        }
        work.events = work.events.wrapping_add(1);
        let holds = speed < S::from_f64(CLOSING_SPEED);
        let rebound = if holds { S::ZERO } else { restitution };
        let impulse = (S::ONE + rebound) * speed / self.scene.inverse_mass;
        for (coordinate, mode) in state.beam.iter_mut().zip(&self.scene.beam) {
            coordinate[1] -= mode.contact * impulse;
        }
        for (coordinate, mode) in state.rod.iter_mut().zip(&self.scene.rod) {
            coordinate[1] += mode.contact * impulse;
        }
        state.closed = holds;
        let half = S::from_f64(0.5);
        let loss = half * (S::ONE - rebound * rebound) * speed * speed / self.scene.inverse_mass;
        let mut energies = [S::ZERO; ALL_POWERS];
        energies[PowerIndex::ContactForce as usize] = impulse;
        observer.event(&Event {
            at: state.clock,
            guard: 0,
            impact_speed: Some(speed),
            before: self.scene.outputs(&before),
            after: self.scene.outputs(state),
            loss,
            energies: &energies,
        });
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Sets a positive gap coordinate to zero. It is due to the rounding of an impact's time or to the drift of a
    /// closed contact; `drift` shifts the rod's face by this amount until the gap has opened.
    pub(super) fn close_gap(state: &mut StateOf<S, P, B, R>) {
        if state.gap > S::ZERO {
            state.drift += state.gap;
            state.gap = S::ZERO;
        }
    }

    /// Moves the rod's face back by the drift once the gap is open.
    #[inline]
    pub(super) fn remove_drift(state: &mut StateOf<S, P, B, R>) {
        if state.drift > S::ZERO && state.gap < -S::from_f64(OPENED) * state.drift {
            state.gap += state.drift;
            state.drift = S::ZERO;
        }
    }
}
