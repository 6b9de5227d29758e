//! What a node does now: a listen, the confirmation of a reading, an action, or sleep.

use super::{HOUR, Node, NodeState, Regular, Task, Wake};
use crate::energy::response_map::Words;
use crate::energy::{Action, BudgetState};

/// Seconds after which a doubtful reading is confirmed.
const CONFIRMATION: u32 = 1;
/// Seconds after its end at which a listen that is not complete is given up.
const GRACE: u32 = 2;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// Decides what to do now.
    #[inline(never)]
    pub(super) fn decide(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) -> Wake {
        let wake = self.next(state);
        state.ask(wake)
    }

    fn next(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) -> Wake {
        if state.listen.missing > 0 {
            let since = state.second.saturating_sub(state.listen.started);
            let left = (self.duration + GRACE).saturating_sub(since);
            if left > 0 {
                let samples = state.listen.start_up.saturating_add(state.listen.missing);
                return Wake { task: Task::Listen { samples }, again_in: left, read: false };
            }
            self.miss(state);
            state.listen.missing = 0;
        }
        if self.listen_is_due(state)
            && self.budget.can_afford(&state.budget, &self.listen, state.budget.second())
        {
            let samples = self.begin(state);
            return Wake { task: Task::Listen { samples }, again_in: self.duration + GRACE, read: false };
        }
        if state.filter.is_doubted() {
            return Wake { task: Task::Sleep, again_in: CONFIRMATION, read: true };
        }
        let now = state.second;
        // What leaves a full storage would be shunted otherwise, and its return tells the income.
        let is_full = state.filter.was_full() && state.last_reading == now;
        let mut next = HOUR.saturating_sub(now.saturating_sub(state.hour_start)).max(1);
        for (index, regular) in self.parameters.actions.iter().enumerate() {
            let last = state.last_run.get(index).copied().unwrap_or(now);
            let since = now.saturating_sub(last);
            if since < regular.every {
                next = next.min(regular.every - since);
                continue;
            }
            if self.can_run(state, index, regular) || is_full && self.leaves_reserve(&state.budget, regular) {
                self.run(state, index, regular);
                return Wake { task: Task::Run(index), again_in: 0, read: false };
            }
        }
        let until = |last: u32, interval: u32| interval.saturating_sub(now.saturating_sub(last)).max(1);
        let reading = until(state.last_attempt(), self.reading_interval(state));
        // A listen that is due waits for the next reading, for an hour at most.
        let listen = until(state.last_listen, self.listen_interval(state)).max(reading.min(HOUR));
        let again_in = next.min(reading).min(listen);
        let hour_ends = now.saturating_add(again_in).saturating_sub(state.hour_start) >= HOUR;
        self.plan(state, reading, listen);
        if self.glance.is_some() {
            return Wake { task: Task::Sleep, again_in: again_in.min(state.glances.interval), read: true };
        }
        Wake { task: Task::Sleep, again_in, read: again_in >= reading || hour_ends }
    }

    /// Whether an action leaves the reserve in the storage, and the coming day as it is.
    #[inline(never)]
    pub(super) fn grants(&self, state: &BudgetState<f32, SLOTS>, regular: &Regular) -> bool {
        // What leaves the reserve can be afforded.
        self.leaves_reserve(state, regular) && self.budget.leaves_the_day(state, &regular.action())
    }

    /// Whether an action leaves the reserve in the storage.
    fn leaves_reserve(&self, state: &BudgetState<f32, SLOTS>, regular: &Regular) -> bool {
        let with_reserve = Action::at_once(regular.energy + self.parameters.reserve);
        self.budget.can_afford(state, &with_reserve, state.second())
    }

    /// Begins a listen; the number of samples.
    fn begin(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) -> u32 {
        let start_up = self.parameters.sensor.start_up;
        state.begin(self.bank.start(), self.samples, start_up);
        self.spend_on_knowing(state, self.parameters.cost.listen);
        self.samples + start_up
    }
}
