//! What comparisons of the map with the storage teach: the gain of the map, and the standing power.

use super::finding::Yield;
use super::{MapNode, MapState};
use crate::energy::response_map::Words;
use crate::node::tier::StoreReading;
use crate::node::voltage::{Element, Told};
use crate::scalar::Scalar;

/// Least gain.
const LOWEST_GAIN: f32 = 1e-3;
/// Variance of a comparison over that of the gain from which it says too little.
const LITTLE: f32 = 100.0;
/// Standard deviations of a comparison of map and storage from which it contradicts the gain, and such comparisons in turn after
/// which the map is doubtful.
const CONTRADICTS: f32 = 3.0;
const CONTRADICTIONS: u32 = 3;

impl<W: Words, const M: usize, const P: usize, const ACTIONS: usize, E: Element>
    MapNode<W, M, P, ACTIONS, E>
{
    /// Learns the gain from a modelled power in W, of relative variances by noise and by the map, and what the storage told of the same
    /// vibration.
    ///
    /// One jump of the vibration within a comparison would make it worthless. So a burst is compared with two intervals that the storage told,
    /// or two bursts with the interval between them, and what changed from one to the other is in the variances.
    fn compare(
        &self,
        state: &mut MapState<P, ACTIONS>,
        modelled: f32,
        [noise, systematic]: [f32; 2],
        told: Told,
    ) {
        if modelled <= 0.0 {
            return;
        }
        // Noise takes it below 0 too: without that the mean of many comparisons would be too large.
        let ratio = told.power / modelled;
        let per_square = 1.0 / (modelled * modelled);
        let square = state.gain * state.gain;
        let of_ratio = told.variance * per_square + square * (noise + systematic);
        if !(of_ratio < LITTLE * state.of_gain) {
            return;
        }
        let (departure, both) = (ratio - state.gain, state.of_gain + of_ratio);
        if departure * departure > CONTRADICTS * CONTRADICTS * both {
            state.contradictions += 1;
            if state.contradictions < CONTRADICTIONS {
                return;
            }
            // The harvester is another one: this comparison and the next ones learn its gain.
            state.is_doubtful = true;
            state.of_gain = departure * departure;
        }
        state.contradictions = 0;
        let part = state.of_gain / (state.of_gain + of_ratio);
        state.gain = Scalar::max(state.gain + part * departure, LOWEST_GAIN);
        // What is off of the storage, the draw and the map is the same in each comparison.
        let least = Scalar::min(state.of_gain, told.lasting * per_square + square * systematic);
        state.of_gain = Scalar::max((1.0 - part) * state.of_gain, least);
    }

    /// Compares the last burst with the last two intervals that the storage told.
    fn compare_pair(&self, state: &mut MapState<P, ACTIONS>) {
        let [Some(last), Some(before)] = state.told else { return };
        let change = last.power - before.power;
        let told = Told {
            power: 0.5 * (before.power + last.power),
            variance: 0.5 * (before.variance + last.variance) + change * change,
            lasting: last.lasting,
        };
        let Yield { value, noise, systematic } = state.held.yielded;
        if state.is_rest {
            self.learn_draw(state, &told, change);
        } else {
            self.compare(state, value, [noise * noise / (value * value), systematic * systematic], told);
        }
    }

    /// Learns the standing power while the harvester rests: what then seems to be an income below 0 is drawn.
    fn learn_draw(&self, state: &mut MapState<P, ACTIONS>, told: &Told, change: f32) {
        let stored = self.voltage.stored_of(1.0);
        let noise = state.held.yielded.noise;
        let variance = Scalar::max(told.variance - told.lasting, change * change) + noise * noise;
        let part = state.of_draw / (state.of_draw + stored * stored * variance);
        if part > 0.0 {
            self.voltage.draw_more(&mut state.voltage, -part * stored * told.power);
            state.of_draw *= 1.0 - part;
        }
    }

    /// Compares the interval that the storage has told with the bursts at its begin and its end.
    pub(super) fn compare_between(&self, state: &mut MapState<P, ACTIONS>, before: Yield) {
        let Some(told) = state.told[0] else { return };
        let Yield { value, noise, systematic } = state.held.yielded;
        let (modelled, change) = (0.5 * (before.value + value), value - before.value);
        let variance = (noise * noise + change * change) / (modelled * modelled);
        self.compare(state, modelled, [variance, systematic * systematic], told);
    }

    /// Keeps what the storage told since the reading before, and compares it with a burst between both.
    pub(super) fn keep_told(&self, state: &mut MapState<P, ACTIONS>) {
        let is_between = core::mem::replace(&mut state.is_between, false);
        if state.voltage.last_reading() != Some(StoreReading::Used) {
            state.untold = state.untold.saturating_add(state.interval.seconds);
            return;
        }
        let before = if state.untold == 0 { state.told[0] } else { None };
        state.told = [Some(self.voltage.told(&state.voltage)), before];
        state.untold = 0;
        if is_between {
            self.compare_pair(state);
        }
    }
}
