//! Logs events, with a fixed capacity.

use crate::clock::Instant;
use crate::observer::{AcceptedStep, Event, Motion, Observer};
use crate::scalar::Scalar;
use heapless::Vec;

/// One event.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LoggedEvent<S> {
    /// Time of the event.
    pub at: Instant,
    /// Numbers of the modes before and after the event.
    pub modes: [u8; 2],
    /// Impact speed in m/s; `None` for an event other than an impact.
    pub impact_speed: Option<S>,
    /// The first coordinate after the event in m, and its rate in m/s.
    pub coordinate: Motion<S>,
    /// Energy lost in J.
    pub loss: S,
}

/// The first `CAPACITY` events of a run, and the number of further events.
#[derive(Debug, Clone, PartialEq)]
pub struct EventLog<S, const CAPACITY: usize> {
    events: Vec<LoggedEvent<S>, CAPACITY>,
    overflowed: u32,
}

impl<S, const CAPACITY: usize> EventLog<S, CAPACITY> {
    /// An empty log.
    #[must_use]
    pub const fn new() -> Self {
        Self { events: Vec::new(), overflowed: 0 }
    }

    /// The logged events, in order of time.
    #[must_use]
    pub fn events(&self) -> &[LoggedEvent<S>] {
        &self.events
    }

    /// Number of events after the log was full.
    #[must_use]
    pub fn overflowed(&self) -> u32 {
        self.overflowed
    }
}

impl<S, const CAPACITY: usize> Default for EventLog<S, CAPACITY> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const CAPACITY: usize> Observer<S> for EventLog<S, CAPACITY> {
    const READS_OUTPUTS: bool = false;

    #[inline]
    fn step(&mut self, _step: &AcceptedStep<'_, S>) {}

    fn event(&mut self, event: &Event<'_, S>) {
        let logged = LoggedEvent {
            at: event.at,
            modes: [event.before.mode, event.after.mode],
            impact_speed: event.impact_speed,
            coordinate: event.after.coordinate(),
            loss: event.loss,
        };
        if self.events.push(logged).is_err() {
            self.overflowed = self.overflowed.saturating_add(1);
        }
    }
}
