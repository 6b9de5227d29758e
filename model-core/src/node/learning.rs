//! What a node learns from a listen: the power, how it changes, and the gain of the map.

use super::filter::{Growth, USUAL};
use super::heard::{Motion, PowerMeasurement};
use super::hearing::{Modelled, Yield};
use super::{Hearing, Node, NodeState, real};
use crate::energy::response_map::Words;
use crate::scalar::Scalar;

/// Weights of squares of relative changes, above the inverse of which shaking tells nothing of the gain: of the change since
/// the listen before, and of the changes of all listens.
const UNSTEADY: [f32; 2] = [4.0, 0.5];
/// Square of the relative change up to which two motions are those of the listen before.
const SAME: f32 = 0.04;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// Takes in what a whole listen says.
    #[inline(never)]
    pub(super) fn conclude(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, voltage: f32) -> Hearing {
        let elapsed = state.second.saturating_sub(state.last_listen);
        let modelled = state.listen.blocks.modelled(&self.map, voltage);
        let mut hearing = modelled.hearing;
        let mut found = modelled.lower;
        match hearing {
            Hearing::Line | Hearing::Broadband | Hearing::Rest => state.last_motions = [0.0; 2],
            Hearing::TwoMotions => {
                let Some(seen) = self.seen(state, elapsed, &modelled) else {
                    self.miss(state);
                    return hearing;
                };
                (hearing, found) = (Hearing::TwoMotionsOneSeen, seen);
            }
            Hearing::Damaged => {
                self.miss(state);
                return hearing;
            }
            _ => {
                state.last_motions = [0.0; 2];
                self.lose(state, found.value);
                self.miss(state);
                return hearing;
            }
        }
        let measurement = self.measurement(state, &found);
        self.widen(state, measurement.change, found.systematic);
        self.filter.hear(&mut state.filter, elapsed, measurement);
        let gain = state.filter.gain().mean;
        let [power, deviation] = [found.value, found.noise].map(|part| gain * part);
        state.fluctuation = Scalar::max(state.listening.fluctuation() - deviation * deviation, 0.0);
        self.listening.hear(&mut state.listening, elapsed, power, deviation, self.parameters.cost.listen);
        state.heard(measurement.lasting, found.value);
        hearing
    }

    /// The yield of the one of two motions that goes on, if the storage has seen which; else what the doubt means.
    fn seen(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        elapsed: u32,
        modelled: &Modelled,
    ) -> Option<Yield> {
        let before = core::mem::replace(&mut state.last_motions, values(modelled));
        let Some(motion) = self.decided(state, modelled, before) else {
            self.doubt(state, elapsed, modelled, before);
            return None;
        };
        let (found, before) = match motion {
            Motion::Lower => (modelled.lower, before[0]),
            Motion::Upper => (modelled.upper, before[1]),
        };
        if state.last_heard <= 0.0 {
            // The listen before heard this motion too.
            (state.last_modelled, state.last_heard) = (before, before);
        }
        Some(found)
    }

    /// Which of two motions the storage has seen since the listen before, which found both with the yields `before`, whether
    /// it could say which or not. What it saw before the first such listen may have been another shaking.
    fn decided(
        &self,
        state: &NodeState<P, SLOTS, ACTIONS>,
        modelled: &Modelled,
        before: [f32; 2],
    ) -> Option<Motion> {
        if !(state.has_told() && before[1] > 0.0) {
            return None;
        }
        let [lower, upper] =
            [(modelled.lower, before[0]), (modelled.upper, before[1])].map(|(now, before)| {
                // The storage has seen what was between both listens.
                let noise = now.noise / now.value;
                change_of(now.value, before) + noise * noise + now.systematic * now.systematic
            });
        self.filter.decide(&state.filter, values(modelled), [lower, upper])
    }

    /// Two motions were heard, and the storage does not know which one goes on.
    ///
    /// Of the same motions as before this is the same doubt, which makes nothing more certain: the power is then what the
    /// storage tells. Others may yield either power.
    fn doubt(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        elapsed: u32,
        modelled: &Modelled,
        before: [f32; 2],
    ) {
        let either = modelled.either();
        let changes = values(modelled).into_iter().zip(before);
        if changes.map(|(now, before)| change_of(now, before)).all(|change| change <= SAME) {
            let power = state.filter.power().mean;
            let change = change_of(either.value, 0.5 * (before[0] + before[1]));
            state.filter.widen_power(power * power * change);
            self.compare_either(state, elapsed, modelled, before);
        } else {
            self.widen(state, either.value - state.last_modelled, either.systematic);
            self.filter.hear_either(&mut state.filter, elapsed, [either.value, either.noise]);
            state.last_modelled = either.value;
        }
    }

    /// Takes in that the gain is the power that the storage has told over one of two yields, where that says more than what is
    /// known: the middle of both quotients, uncertain by half of their difference.
    fn compare_either(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        elapsed: u32,
        modelled: &Modelled,
        before: [f32; 2],
    ) {
        let middle = |[lower, upper]: [f32; 2]| 2.0 * lower * upper / (lower + upper);
        let [lower, upper] = values(modelled);
        let (found, half) = (middle([lower, upper]), (upper - lower) / (upper + lower));
        let (power, gain) = (state.filter.power(), state.filter.gain());
        let deviation = half * gain.mean;
        let [of_power, of_gain] = [half * power.mean, deviation].map(|deviation| deviation * deviation);
        // The doubt is the same each time, and leaves the gain no less uncertain than once.
        let is_told = state.has_told() && 4.0 * power.variance < of_power;
        if !(is_told && gain.variance > of_gain) {
            return;
        }
        state.last_heard = middle(before);
        let of_gain = self.part_of_gain(state, found, state.listening.fluctuation());
        let variance = deviation * found * (deviation * found);
        let measurement =
            PowerMeasurement { modelled: found, lasting: found, change: 0.0, variance, of_gain };
        self.filter.hear(&mut state.filter, elapsed, measurement);
    }

    /// What a listen measured, with the part of it that lasts by the differences of the listens before.
    fn measurement(&self, state: &NodeState<P, SLOTS, ACTIONS>, found: &Yield) -> PowerMeasurement<f32> {
        let gain = state.filter.gain().mean;
        let noise = gain * found.noise;
        let before = state.last_modelled;
        let change = found.value - before;
        let moved = gain * change;
        let part = match state.listening.differences() {
            Some([one, _]) if moved * moved <= 9.0 * one => {
                Scalar::max(2.0 * state.listening.correlation() - 1.0, 0.0)
            }
            _ => 1.0,
        };
        let variance = Scalar::max(noise * noise, state.listening.fluctuation());
        let of_gain = self.part_of_gain(state, found.value, variance);
        let change = if state.listens == 0 { 0.0 } else { part * change };
        PowerMeasurement {
            modelled: found.value,
            lasting: if state.listens == 0 { found.value } else { before + change },
            change,
            variance,
            of_gain,
        }
    }

    /// Part of what a listen says of the gain that is believed.
    ///
    /// The power that the storage has shown is that of the time before the listen, and behind it where the shaking changes:
    /// above what was heard where it has ended, below it where it has begun. The storage of a strong shaking is full. So
    /// only steady shaking tells the gain: each other one would pull it to one side.
    fn part_of_gain(&self, state: &NodeState<P, SLOTS, ACTIONS>, found: f32, variance: f32) -> f32 {
        // The power and not what was heard: a part that grew with it would make the gain too small.
        let power = state.filter.power().mean;
        let (product, square) = (state.last_heard * found, power * power);
        if !(product > 0.0 && square > 0.0 && state.has_told()) {
            return 0.0;
        }
        let change = found - state.last_heard;
        let [of_change, of_variance] = UNSTEADY;
        Scalar::max(1.0 - of_change * change * change / product - of_variance * variance / square, 0.0)
    }

    /// Widens the gain by how far the place in the map has moved: by `moved` W from the last one.
    fn widen(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, moved: f32, systematic: f32) {
        let last = state.last_modelled;
        let product = last * (last + moved);
        // Of small changes the square of the logarithm of the ratio.
        let change = if product > 0.0 { Scalar::min(moved * moved / product, 4.0) } else { 4.0 };
        let by_place = self.parameters.spread.gain_by_place;
        let part = if state.listens == 0 { 0.0 } else { by_place * by_place * change };
        let bounds = if state.listens == 0 { 1.0 } else { Scalar::min(100.0 * change, 1.0) };
        self.filter.widen_gain_by(&mut state.filter, part + systematic * systematic * bounds);
    }

    /// Books a listen without a value.
    pub(super) fn miss(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        let elapsed = state.second.saturating_sub(state.last_listen);
        self.listening.miss(&mut state.listening, elapsed, self.parameters.cost.listen);
        state.missed();
    }

    /// The shaking is another one than before: the power may be any like the usual one, or like a modelled one in W, of which
    /// only the order of magnitude is known.
    ///
    /// The modelled one is no measurement: impacts yield up to a hundred times what the linear motion does.
    pub(super) fn lose(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, modelled: f32) {
        let modelled = state.filter.gain().mean * modelled;
        let power = Scalar::max(state.usual_power(), modelled);
        state.filter.widen_power(power * power);
    }

    /// Variances that power and income gain in a second.
    pub(super) fn growth(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> Growth<f32> {
        // A full storage does not show a shaking that begins between two listens.
        let least = if state.store_tells() { 0.0 } else { USUAL as f32 * self.parameters.spread.power };
        let power = Scalar::max(state.usual_power(), least);
        let deviation = self.parameters.spread.income * power;
        let assumed = deviation * deviation * (1.0 / 3600.0);
        let interval = real(self.listening.interval(&state.listening));
        let power = match state.listening.differences() {
            Some([one, two]) => {
                // A storage that tells shows a change that the listens have missed.
                let least = if state.store_tells() { 0.25 } else { 1.0 };
                Scalar::max((two - one) / interval, least * assumed)
            }
            None => assumed,
        };
        // What does not last from listen to listen lasts half of the time between them at most.
        Growth { power, income: 0.5 * interval * state.fluctuation }
    }
}

/// Yields of both motions in W.
fn values(modelled: &Modelled) -> [f32; 2] {
    [modelled.lower.value, modelled.upper.value]
}

/// Square of a relative change; not finite or not a number without either of both.
fn change_of(now: f32, before: f32) -> f32 {
    (now - before) * (now - before) / (now * before)
}
