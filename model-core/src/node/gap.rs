//! Returns of a node from a time in which it was off.

use super::filter::Growth;
use super::{Node, NodeState, Wake, real};
use crate::energy::response_map::Words;
use crate::scalar::Scalar;

/// Standard deviation of an even distribution from −1 to 1.
const ONE_OF_EVEN: f32 = 0.577_350_26;
/// Mean power of a gap over the usual power, one standard deviation.
const OF_USUAL: f32 = 3.0;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// As after a reset that lost what is newer than `state`: the node was on until `now`. It ran any part of what it
    /// could have run, and heard something that is lost; the income since is uncertain by that part.
    #[cold]
    #[inline(never)]
    pub(super) fn wake_after_reset(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        now: u32,
        code: Option<u32>,
    ) -> Wake {
        let largest = self.largest_spent(state, now, 0.0);
        self.return_from_gap(state, now, code, largest, true)
    }

    /// As with [`Gap::OffUntil`](super::Gap::OffUntil) where the node went off at an unknown time between the last call and the wake that was due
    /// then: it slept first, and drew any part of its standing power over that time. The income of the gap is uncertain by as
    /// much.
    #[cold]
    #[inline(never)]
    pub fn wake_after_lock_out(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        now: u32,
        code: Option<u32>,
    ) -> Wake {
        let asleep = state.second_of(now).min(state.asked_for).saturating_sub(state.second);
        let largest = self.largest_standing_power(state) * real(asleep);
        self.return_from_gap(state, now, code, largest, false)
    }

    /// As [`Node::wake_after_lock_out`], of a node that was awake after the last call too: it also ran any part of what it runs
    /// at most, as far as the storage and the income of the time allowed it.
    pub(super) fn wake_after_lost_calls(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        now: u32,
        code: Option<u32>,
    ) -> Wake {
        let largest = self.largest_spent(state, now, self.largest_standing_power(state));
        self.return_from_gap(state, now, code, largest, false)
    }

    /// The largest energy in J that the node spent since the last call, with a standing power in W: actions, listens and
    /// readings at their shortest intervals, as far as the storage and the income of the time allowed it.
    fn largest_spent(&self, state: &NodeState<P, SLOTS, ACTIONS>, now: u32, standing: f32) -> f32 {
        let now = state.second_of(now);
        let gap = now.saturating_sub(state.second);
        let (seconds, cost) = (real(gap), &self.parameters.cost);
        // Each of them may have been due at the start.
        let times =
            |since: u32, every: u32| (real(since.min(gap.saturating_add(every))) / real(every)).to_u32();
        let knowing = [
            (cost.listen, state.last_listen, self.parameters.listening.shortest),
            (cost.reading, state.last_reading, cost.shortest_reading),
        ];
        let actions = self.parameters.actions.iter().zip(state.last_run);
        let actions = actions.map(|(regular, last)| (regular.energy, last, regular.every));
        let spent =
            knowing.into_iter().chain(actions).fold(standing * seconds, |sum, (energy, last, every)| {
                sum + energy * real(times(now.saturating_sub(last), every))
            });
        let [stored, bound] = state.stored();
        let above = Scalar::max(stored + bound - self.budget.storage().lock_out(), 0.0);
        Scalar::min(spent, above + OF_USUAL * state.usual_power() * seconds)
    }

    /// Growth of variances in a gap: an income of some times that of the usual power may have come at any time in it. A storage that
    /// was emptied and is charged again has one of the order of what was drawn.
    fn growth_in_gap(
        &self,
        state: &NodeState<P, SLOTS, ACTIONS>,
        seconds: u32,
        largest_drawn: f32,
    ) -> Growth<f32> {
        let (growth, time) = (self.growth(state), real(seconds));
        let power = OF_USUAL * Scalar::max(state.usual_power(), largest_drawn / time);
        Growth { power: growth.power + 3.0 * power * power / time, ..growth }
    }

    /// Standing power in W with what it may exceed the stated one by.
    fn largest_standing_power(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> f32 {
        let excess = state.filter.draw();
        Scalar::max(self.filter.standing + excess.mean + 2.0 * excess.deviation(), 0.0)
    }

    /// Wakes from a time of which nothing is known that was heard, and any energy up to `largest_drawn` in J was drawn, in
    /// addition to the standing power if the node was on.
    #[cold]
    #[inline(never)]
    pub(super) fn return_from_gap(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        now: u32,
        code: Option<u32>,
        largest_drawn: f32,
        is_on: bool,
    ) -> Wake {
        let Some(now) = self.present(state, now) else { return self.wake_after_unknown_gap(state, code) };
        state.abandon();
        self.settle(state, now, None);
        self.advance(state, state.second, true);
        let seconds = now.saturating_sub(state.settled);
        let mut growth = self.growth(state);
        if !is_on {
            self.lose(state, 0.0);
            self.be_off(state, now);
            growth = self.growth_in_gap(state, seconds, largest_drawn);
        }
        let half = 0.5 * largest_drawn;
        self.budget.spend(&mut state.budget, half);
        state.spent += half;
        // Glances assume the largest drop of the code since the last one.
        self.pay(state, 2.0 * half);
        if seconds > 0 {
            self.advance_by(state, seconds, is_on, growth);
            state.second = state.second.max(now);
        }
        // Each energy up to the largest one is as likely.
        let deviation = self.budget.storage().drawn(half) * ONE_OF_EVEN;
        state.filter.widen_store(deviation * deviation);
        self.read(state, code, true);
        self.decide(state)
    }

    /// The second of the state at a second of the clock; `None` if the clock has gone back, by which it is set.
    #[inline(never)]
    pub(super) fn present(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, clock: u32) -> Option<u32> {
        let now = state.second_of(clock);
        if now >= state.second {
            return Some(now);
        }
        state.ahead = state.second.wrapping_sub(clock);
        self.budget.set_clock(&mut state.budget, clock);
        None
    }

    #[cold]
    #[inline(never)]
    pub(super) fn wake_after_unknown_gap(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        code: Option<u32>,
    ) -> Wake {
        state.abandon();
        let now = state.second;
        self.settle(state, now, None);
        self.advance(state, now, true);
        state.filter.lose_store();
        // What was spent before the gap left another storage.
        state.spent = 0.0;
        self.budget.correct(&mut state.budget, 0.0, 0.0);
        self.lose(state, 0.0);
        self.read(state, code, true);
        self.decide(state)
    }
}
