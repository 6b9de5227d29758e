//! When a node listens and reads its storage.

use super::{Node, NodeState, real};
use crate::energy::response_map::Words;

/// Readings at the start that are taken at the shortest interval.
const FIRST_READINGS: u32 = 4;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// Whether to listen now.
    pub(super) fn listen_is_due(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> bool {
        let elapsed = state.second.saturating_sub(state.last_listen);
        if state.listens == 0 && state.misses == 0 {
            return true;
        }
        if elapsed >= self.listen_interval(state) {
            return true;
        }
        if state.listens > 0 && elapsed >= self.after_misses(state) {
            // Where the storage knows the power, a wake for another reason is one to learn the gain.
            return self.listening.is_due(&state.listening, elapsed, state.departure);
        }
        self.is_called_for(state, elapsed)
    }

    /// Least time in s from a listen to the next after listens without a value.
    fn after_misses(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> u32 {
        let parameters = &self.parameters.listening;
        parameters.shortest << state.misses.min(parameters.doublings)
    }

    /// Whether the storage has departed so far that a listen is due before its time.
    fn is_called_for(&self, state: &NodeState<P, SLOTS, ACTIONS>, elapsed: u32) -> bool {
        if state.listens > 0 {
            return self.listening.is_surprise(&state.listening, elapsed, state.departure);
        }
        // No listen has had a value: the income is that of the storage.
        let parameters = &self.parameters.listening;
        state.departure > 0.0
            && elapsed >= parameters.shortest
            && self.parameters.cost.listen <= parameters.share * state.usual_power() * real(elapsed)
    }

    /// Time in s from a listen to the next, without surprises, for which the node wakes.
    pub(super) fn listen_interval(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> u32 {
        let parameters = &self.parameters.listening;
        let longest = parameters.shortest << parameters.doublings;
        let after_misses = self.after_misses(state);
        let power = state.filter.power();
        if state.listens > 0
            && power.variance <= (parameters.error * power.mean) * (parameters.error * power.mean)
        {
            // The storage knows it as well.
            return longest;
        }
        if state.listens > 0 {
            self.listening.interval(&state.listening).max(after_misses)
        } else {
            after_misses
        }
    }

    /// Time from a reading to the next in s: the shortest whose cost the income pays for.
    pub(super) fn reading_interval(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> u32 {
        let cost = &self.parameters.cost;
        let mut interval = cost.shortest_reading;
        // What an action has taken from a full storage comes back with the income, and is then seen.
        let is_refilled = state.filter.was_full() && state.last_run.contains(&state.last_reading);
        if state.readings < FIRST_READINGS || is_refilled {
            return interval;
        }
        let power = self.share_of_readings() * cost.reading_share * state.usual_power();
        for _ in 0..cost.reading_doublings {
            if cost.reading <= power * real(interval) {
                break;
            }
            interval *= 2;
        }
        interval
    }
}
