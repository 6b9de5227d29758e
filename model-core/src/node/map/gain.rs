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
pub(super) const CONTRADICTIONS: u32 = 3;

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize, E: Element>
    MapNode<W, M, P, ACTIONS, E>
{
    /// Learns the gain from the last burst and the estimate by the voltage of the same vibration.
    ///
    /// One jump of the vibration within a comparison would make it worthless. So a burst is compared with two intervals that the voltage resolved,
    /// and what changed from one to the other is in the variances.
    fn learn_gain(&self, state: &mut MapState<P, ACTIONS>, estimated: &VoltageEstimate) {
        let OutputPower { value, noise, systematic } = state.latest.output;
        if value <= 0.0 {
            return;
        }
        // Noise takes it below 0 too: without that the mean of many comparisons would be too large.
        let ratio = estimated.power / value;
        let per_square = 1.0 / (value * value);
        let (square, of_map) = (state.gain * state.gain, systematic * systematic);
        let of_ratio = estimated.variance * per_square + square * (noise * noise * per_square + of_map);
        let (departure, both) = (ratio - state.gain, state.of_gain + of_ratio);
        if departure * departure > CONTRADICTS * CONTRADICTS * both {
            if state.motion.take().is_some() {
                // It may be in the other motion: the map says nothing before the next burst, which comes where the voltage is silent.
                state.latest.miss();
                return;
            }
            let side = u32::from(departure < 0.0);
            let is_same = state.contradictions % 2 == side;
            let is_other = state.contradictions > 1 && !is_same;
            let before = if is_same { state.contradictions } else { side };
            state.contradictions = before.saturating_add(2);
            if state.contradictions < 2 * CONTRADICTIONS {
                // The next comparison comes now, not with the next check. Vibration that beats contradicts to either side: it waits.
                state.is_asked |= !is_other;
                return;
            }
            // The harvester is another one: this comparison and the next ones learn its gain.
            state.is_doubtful = true;
            state.of_gain = departure * departure;
        }
        if !(of_ratio < LITTLE * state.of_gain) {
            return;
        }
        state.contradictions = 0;
        let part = state.of_gain / (state.of_gain + of_ratio);
        state.gain = Scalar::max(state.gain + part * departure, LOWEST_GAIN);
        // What is off of the storage, the draw and the map is the same in each comparison.
        let least = Scalar::min(state.of_gain, estimated.lasting * per_square + square * of_map);
        state.of_gain = Scalar::max((1.0 - part) * state.of_gain, least);
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
        let ([Some(last), Some(before)], true) = (state.estimated, is_between) else { return };
        let change = last.power - before.power;
        let estimated = VoltageEstimate {
            power: 0.5 * (before.power + last.power),
            variance: 0.5 * (before.variance + last.variance) + change * change,
            lasting: last.lasting,
        };
        if state.is_rest {
            self.learn_draw(state, &estimated, change);
        } else {
            self.learn_gain(state, &estimated);
        }
    }
}
