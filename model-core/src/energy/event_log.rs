//! A log of events of fixed capacity.

use crate::clock::Instant;
use crate::hybrid::{Event, Observer, Span};
use crate::scalar::Scalar;
use heapless::Vec;

/// One event.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LoggedEvent<S, Mode, const N: usize> {
    /// When.
    pub at: Instant,
    /// The mode that ended.
    pub before: Mode,
    /// The mode that began.
    pub after: Mode,
    /// The state at which it began.
    pub state: [S; N],
    /// Energy lost, in joules.
    pub loss: S,
}

/// The first `CAPACITY` events of a run, and the number of those for which there was no room.
#[derive(Debug, Clone, PartialEq)]
pub struct EventLog<S, Mode, const N: usize, const CAPACITY: usize> {
    events: Vec<LoggedEvent<S, Mode, N>, CAPACITY>,
    overflowed: u32,
}

impl<S, Mode, const N: usize, const CAPACITY: usize> EventLog<S, Mode, N, CAPACITY> {
    /// An empty log.
    #[must_use]
    pub const fn new() -> Self {
        Self { events: Vec::new(), overflowed: 0 }
    }

    /// The logged events, in order of time.
    #[must_use]
    pub fn events(&self) -> &[LoggedEvent<S, Mode, N>] {
        &self.events
    }

    /// Number of events that came when the log was full.
    #[must_use]
    pub fn overflowed(&self) -> u32 {
        self.overflowed
    }
}

impl<S, Mode, const N: usize, const CAPACITY: usize> Default for EventLog<S, Mode, N, CAPACITY> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S, Mode, const N: usize, const P: usize, const CAPACITY: usize> Observer<S, Mode, N, P>
    for EventLog<S, Mode, N, CAPACITY>
where
    S: Scalar,
    Mode: Copy,
{
    #[inline(always)]
    fn step(&mut self, _span: &Span<'_, S, Mode, N, P>) {}

    fn event(&mut self, event: &Event<'_, S, Mode, N, P>) {
        let Event { at, before, after, loss, .. } = *event;
        if self.events.push(LoggedEvent { at, before, after, state: event.left.state, loss }).is_err() {
            self.overflowed = self.overflowed.saturating_add(1);
        }
    }
}
