//! What a call of the driver did: why it returned, its work, and why a step failed.

use crate::clock::Instant;
use crate::scalar::Scalar;

/// The reason why [`Driver::advance`](super::Driver::advance) returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ended {
    /// The clock has reached the requested instant.
    Finished,
    /// The budget is spent; a further call continues the run.
    BudgetSpent,
    /// An event happened and [`Driver::pause_at_events`](super::Driver::pause_at_events) is set.
    Event,
}

/// Counts of the work of one call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Work {
    /// Accepted steps.
    pub steps: u32,
    /// Attempts rejected by the step control or not converged.
    pub rejected: u32,
    /// Attempts to locate events, without the accepted steps.
    pub locating: u32,
    /// Newton iterations.
    pub iterations: u32,
    /// Events.
    pub events: u32,
}

impl Work {
    /// Number of attempted steps, which a budget limits.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.steps.saturating_add(self.rejected).saturating_add(self.locating)
    }

    /// The sum of two counts, saturating.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            steps: self.steps.saturating_add(other.steps),
            rejected: self.rejected.saturating_add(other.rejected),
            locating: self.locating.saturating_add(other.locating),
            iterations: self.iterations.saturating_add(other.iterations),
            events: self.events.saturating_add(other.events),
        }
    }
}

/// The result of [`Driver::advance`](super::Driver::advance).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Advance {
    /// The reason of the return.
    pub ended: Ended,
    /// The work done.
    pub work: Work,
}

/// The cause of a failed step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StepFailure<S> {
    /// The step became shorter than 15 ps: the equations were not solved or the tolerance was not met.
    StepVanished,
    /// More than 64 successive events followed within a nanosecond of each other.
    EventStorm,
    /// A quantity is outside the domain of the model.
    OutsideDomain {
        /// The name of the quantity.
        quantity: &'static str,
        /// Its value, in SI units.
        value: S,
    },
}

/// A step failed; the state is that before the step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct StepError<S> {
    /// The cause.
    pub failure: StepFailure<S>,
    /// The instant at the start of the step.
    pub at: Instant,
}

impl<S: Scalar> core::fmt::Display for StepError<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.failure {
            StepFailure::StepVanished => write!(f, "the step shrank to nothing"),
            StepFailure::EventStorm => write!(f, "events follow one another without end"),
            StepFailure::OutsideDomain { quantity, value } => {
                write!(f, "{quantity} = {value} is outside the model's domain")
            }
        }?;
        write!(f, " at {} s", self.at.seconds::<S>())
    }
}

impl<S: Scalar> core::error::Error for StepError<S> {}
