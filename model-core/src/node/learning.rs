//! What a node learns from a listen: the power, how it changes, and the gain of the map.

use super::{Hearing, Node, NodeState, real};
use crate::energy::response_map::Words;
use crate::scalar::Scalar;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// Takes in what a whole listen says.
    pub(super) fn conclude(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, voltage: f32) -> Hearing {
        let elapsed = state.second.saturating_sub(state.last_listen);
        let mut modelled = state.listen.blocks.modelled(&self.map, voltage);
        match modelled.hearing {
            Hearing::Line | Hearing::Broadband | Hearing::Rest => {}
            Hearing::TwoMotions => {
                let seen = self.filter.decide(&state.filter, [modelled.value, modelled.upper]);
                if let Some(seen) = seen {
                    modelled.hearing = Hearing::TwoMotionsOneSeen;
                    modelled.value = seen;
                } else if state.was_undecided {
                    // Nothing new: the same doubt again makes nothing more certain.
                    self.miss(state);
                    return modelled.hearing;
                } else {
                    // Either: the middle, uncertain by half of the difference.
                    modelled.noise = 0.5 * (modelled.upper - modelled.value);
                    modelled.value += modelled.noise;
                }
            }
            Hearing::Damaged => {
                self.miss(state);
                return modelled.hearing;
            }
            _ => {
                // Where the order of magnitude is known, it is a measurement, uncertain by its own size.
                self.lose(state);
                if modelled.value > 0.0 {
                    self.filter.hear_about(&mut state.filter, modelled.value);
                }
                self.miss(state);
                return modelled.hearing;
            }
        }
        state.was_undecided = modelled.hearing == Hearing::TwoMotions;
        self.widen(state, modelled.value, modelled.systematic);
        self.filter.hear(&mut state.filter, elapsed, modelled.value, modelled.noise);
        let gain = state.filter.gain().mean;
        let [power, deviation] = [modelled.value, modelled.noise].map(|part| gain * part);
        self.listening.hear(&mut state.listening, elapsed, power, deviation, self.parameters.cost.listen);
        state.heard(modelled.value);
        modelled.hearing
    }

    /// Widens the gain by how far the place in the map has moved.
    fn widen(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, value: f32, systematic: f32) {
        let last = state.last_modelled;
        let product = last * value;
        let difference = value - last;
        // Of small changes the square of the logarithm of the ratio.
        let change = if product > 0.0 { Scalar::min(difference * difference / product, 4.0) } else { 4.0 };
        let by_place = self.parameters.spread.gain_by_place;
        let part = if state.listens == 0 { 0.0 } else { by_place * by_place * change };
        let bounds = if state.listens == 0 { 1.0 } else { Scalar::min(100.0 * change, 1.0) };
        state.filter.widen_gain(part + systematic * systematic * bounds);
    }

    /// Books a listen without a value.
    pub(super) fn miss(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        let elapsed = state.second.saturating_sub(state.last_listen);
        self.listening.miss(&mut state.listening, elapsed, self.parameters.cost.listen);
        state.missed();
    }

    /// The power may be any like it: the shaking is another one than before.
    pub(super) fn lose(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        let power = Scalar::max(state.filter.power().mean, state.budget.mean_power());
        state.filter.widen_power(power * power);
    }

    /// Variance that the power gains in a second, in W²/s.
    pub(super) fn walk(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> f32 {
        let power = Scalar::max(state.filter.power().mean, state.budget.mean_power());
        let deviation = self.parameters.spread.income * power;
        let assumed = deviation * deviation * (1.0 / 3600.0);
        match state.listening.differences() {
            Some([one, two]) => {
                let interval = real(self.listening.interval(&state.listening));
                // A storage that tells shows a change that the listens have missed.
                let least = if state.store_tells() { 0.25 } else { 1.0 };
                Scalar::max((two - one) / interval, least * assumed)
            }
            None => assumed,
        }
    }
}
