//! What comparisons of the map with the storage teach: the gain of the map, and the standing power.

use super::finding::OutputPower;
use super::{MapNode, MapState};
use crate::energy::response_map::WordSource;
use crate::node::tier::StoreReading;
use crate::node::voltage::{Element, VoltageEstimate};
use crate::scalar::Scalar;

/// Least gain.
const LOWEST_GAIN: f32 = 1e-3;
/// Variance of a comparison over that of the gain from which it says too little.
const LITTLE: f32 = 100.0;
/// Standard deviations of a comparison of map and storage from which it contradicts the gain, and such comparisons in turn after
/// which the map is doubtful.
const CONTRADICTS: f32 = 3.0;
const CONTRADICTIONS: u32 = 3;

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize, E: Element>
    MapNode<W, M, P, ACTIONS, E>
{
    /// Learns the gain from a predicted power in W, of relative variances by noise and by the map, and the estimate by the voltage of the same
    /// vibration.
    ///
    /// One jump of the vibration within a comparison would make it worthless. So a burst is compared with two intervals that the voltage resolved,
    /// or two bursts with the interval between them, and what changed from one to the other is in the variances.
    fn compare(
        &self,
        state: &mut MapState<P, ACTIONS>,
        predicted: f32,
        [noise, systematic]: [f32; 2],
        estimated: VoltageEstimate,
    ) {
        if predicted <= 0.0 {
            return;
        }
        // Noise takes it below 0 too: without that the mean of many comparisons would be too large.
        let ratio = estimated.power / predicted;
        let per_square = 1.0 / (predicted * predicted);
        let square = state.gain * state.gain;
        let of_ratio = estimated.variance * per_square + square * (noise + systematic);
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
        let least = Scalar::min(state.of_gain, estimated.lasting * per_square + square * systematic);
        state.of_gain = Scalar::max((1.0 - part) * state.of_gain, least);
    }

    /// Compares the last burst with the last two intervals that the voltage resolved.
    fn compare_pair(&self, state: &mut MapState<P, ACTIONS>) {
        let [Some(last), Some(before)] = state.estimated else { return };
        let change = last.power - before.power;
        let estimated = VoltageEstimate {
            power: 0.5 * (before.power + last.power),
            variance: 0.5 * (before.variance + last.variance) + change * change,
            lasting: last.lasting,
        };
        let OutputPower { value, noise, systematic } = state.latest.output;
        if state.is_rest {
            self.learn_draw(state, &estimated, change);
        } else {
            self.compare(state, value, [noise * noise / (value * value), systematic * systematic], estimated);
        }
    }

    /// Learns the standing power while the harvester rests: what then seems to be an income below 0 is drawn.
    fn learn_draw(&self, state: &mut MapState<P, ACTIONS>, estimated: &VoltageEstimate, change: f32) {
        let stored = self.voltage.stored_of(1.0);
        let noise = state.latest.output.noise;
        let variance = Scalar::max(estimated.variance - estimated.lasting, change * change) + noise * noise;
        let part = state.of_draw / (state.of_draw + stored * stored * variance);
        if part > 0.0 {
            self.voltage.draw_more(&mut state.voltage, -part * stored * estimated.power);
            state.of_draw *= 1.0 - part;
        }
    }

    /// Compares the interval that the voltage has resolved with the bursts at its begin and its end.
    pub(super) fn compare_between(&self, state: &mut MapState<P, ACTIONS>, before: OutputPower) {
        let Some(estimated) = state.estimated[0] else { return };
        let OutputPower { value, noise, systematic } = state.latest.output;
        let (predicted, change) = (0.5 * (before.value + value), value - before.value);
        let variance = (noise * noise + change * change) / (predicted * predicted);
        self.compare(state, predicted, [variance, systematic * systematic], estimated);
    }

    /// Keeps the estimate by the voltage since the reading before, and compares it with a burst between both.
    pub(super) fn keep_estimate(&self, state: &mut MapState<P, ACTIONS>) {
        let is_between = core::mem::replace(&mut state.is_between, false);
        if state.voltage.last_reading() != Some(StoreReading::Used) {
            state.unreported = state.unreported.saturating_add(state.interval.seconds);
            return;
        }
        let before = if state.unreported == 0 { state.estimated[0] } else { None };
        state.estimated = [Some(self.voltage.estimated(&state.voltage)), before];
        state.unreported = 0;
        if is_between {
            self.compare_pair(state);
        }
    }
}
