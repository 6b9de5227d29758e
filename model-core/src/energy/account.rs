//! Where a storage's energy came from and where it went.

use super::storage::StorageStep;
use crate::scalar::{CompensatedSum, Scalar};

/// Where energy came from and went since the start, in joules at the storage.
///
/// `income − shunted − leaked − (drawn − unserved) + corrected` is the stored energy: the account is opened
/// on an empty storage, and what a first measurement finds in it is a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Account<S> {
    income: CompensatedSum<S>,
    drawn: CompensatedSum<S>,
    leaked: CompensatedSum<S>,
    shunted: CompensatedSum<S>,
    unserved: CompensatedSum<S>,
    corrected: CompensatedSum<S>,
    refused: u32,
}

impl<S: Scalar> Account<S> {
    pub(super) const EMPTY: Self = Self {
        income: CompensatedSum::ZERO,
        drawn: CompensatedSum::ZERO,
        leaked: CompensatedSum::ZERO,
        shunted: CompensatedSum::ZERO,
        unserved: CompensatedSum::ZERO,
        corrected: CompensatedSum::ZERO,
        refused: 0,
    };

    /// Harvested, through the charging efficiency.
    #[must_use]
    pub fn income(&self) -> S {
        self.income.value()
    }

    /// Asked for by the load, through the discharging efficiency.
    #[must_use]
    pub fn drawn(&self) -> S {
        self.drawn.value()
    }

    /// Leaked.
    #[must_use]
    pub fn leaked(&self) -> S {
        self.leaked.value()
    }

    /// Income for which the storage had no room.
    #[must_use]
    pub fn shunted(&self) -> S {
        self.shunted.value()
    }

    /// Of what the load asked for, the part that the storage could not give above its lock-out. On a node that
    /// did spend it, a sign that the storage was thought lower than it was.
    #[must_use]
    pub fn unserved(&self) -> S {
        self.unserved.value()
    }

    /// Put right by measurements, the first one included: positive where the storage held more than thought.
    #[must_use]
    pub fn corrected(&self) -> S {
        self.corrected.value()
    }

    /// Number of energies that were negative or not finite, and were not counted.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// What the storage holds by this account.
    #[must_use]
    pub fn balance(&self) -> S {
        let mut sum = self.corrected;
        for term in [self.income(), -self.shunted(), -self.leaked(), -self.drawn(), self.unserved()] {
            sum.add(term);
        }
        sum.value()
    }

    /// `value` if it can be an amount of energy.
    pub(super) fn admit(&mut self, value: S) -> Option<S> {
        if value >= S::ZERO && value < S::INFINITY {
            return Some(value);
        }
        self.refuse();
        None
    }

    /// Counts a value that is not taken.
    pub(super) fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
    }

    /// Enters what a step of the storage did.
    pub(super) fn enter(&mut self, income: S, drawn: S, step: &StorageStep<S>) {
        self.income.add(income);
        self.drawn.add(drawn);
        self.leaked.add(step.leaked);
        self.shunted.add(step.shunted);
        self.unserved.add(step.unserved);
    }

    pub(super) fn correct(&mut self, change: S) {
        self.corrected.add(change);
    }
}
