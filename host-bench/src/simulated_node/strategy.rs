//! What drives a simulated node.

use model_core::node::{IncomeOfTime, Outage, Progress, Tier, Wake};

/// A node as its plant sees it: when it reads, and when it acts.
pub trait Strategy {
    /// Wakes it at a second, with the code of the storage's voltage where it was read; after a lock-out with `was_off`.
    fn wake(&mut self, now: u32, code: Option<u32>, was_off: bool) -> Wake;

    /// Takes samples of a burst.
    fn samples(&mut self, _samples: &[i16]) -> Progress {
        Progress::Idle
    }

    /// The income of the last hour.
    fn last_hour(&self) -> Option<IncomeOfTime>;

    /// Energy in J that estimating the income has taken.
    fn spent(&self) -> f64;
}

/// A node of the library with its state.
#[derive(Debug, Clone, Copy)]
pub struct Tiered<N: Tier> {
    pub node: N,
    pub state: N::State,
    pub(super) hour: fn(&N::State) -> Option<IncomeOfTime>,
    /// The income since the start.
    pub(super) overall: fn(&N, &N::State) -> IncomeOfTime,
    spent: fn(&N, &N::State) -> f64,
}

impl<N: Tier> Tiered<N> {
    pub(super) fn new(
        node: N,
        hour: fn(&N::State) -> Option<IncomeOfTime>,
        overall: fn(&N, &N::State) -> IncomeOfTime,
        spent: fn(&N, &N::State) -> f64,
    ) -> Self {
        let state = node.start(0);
        Self { node, state, hour, overall, spent }
    }
}

impl<N: Tier> Strategy for Tiered<N> {
    fn wake(&mut self, now: u32, code: Option<u32>, was_off: bool) -> Wake {
        let Self { node, state, .. } = self;
        if was_off {
            node.wake_after(state, Outage::LockedOutUntil(now), code)
        } else {
            node.wake(state, now, code)
        }
    }

    fn samples(&mut self, samples: &[i16]) -> Progress {
        self.node.samples(&mut self.state, samples)
    }

    fn last_hour(&self) -> Option<IncomeOfTime> {
        (self.hour)(&self.state)
    }

    fn spent(&self) -> f64 {
        (self.spent)(&self.node, &self.state)
    }
}
