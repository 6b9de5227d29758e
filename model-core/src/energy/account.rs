//! The account of the energies that a storage took and gave, in joules.

use super::storage::StorageStep;
use crate::scalar::{CompensatedSum, Scalar};

/// The energies since the start in joules at the storage.
///
/// The stored energy is `income − shunted − leaked − (drawn − unserved) + corrected`. The account begins with
/// an empty storage, and the energy found by the first measurement counts as a correction.
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

    /// Harvested energy times the charging efficiency, in joules.
    #[must_use]
    pub fn income(&self) -> S {
        self.income.value()
    }

    /// Energy requested by the load over the discharging efficiency, in joules.
    #[must_use]
    pub fn drawn(&self) -> S {
        self.drawn.value()
    }

    /// Leaked energy in joules.
    #[must_use]
    pub fn leaked(&self) -> S {
        self.leaked.value()
    }

    /// Income in joules for which the storage had no room.
    #[must_use]
    pub fn shunted(&self) -> S {
        self.shunted.value()
    }

    /// Requested energy in joules that the storage could not give above its lock-out. If the node spent that
    /// energy nevertheless, the storage held more than the budget knew.
    #[must_use]
    pub fn unserved(&self) -> S {
        self.unserved.value()
    }

    /// Sum of the corrections by measurements in joules, positive where the storage held more than the budget
    /// knew.
    #[must_use]
    pub fn corrected(&self) -> S {
        self.corrected.value()
    }

    /// Number of values that were refused because they were negative or not finite.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Stored energy in joules by this account.
    #[must_use]
    pub fn balance(&self) -> S {
        let mut sum = self.corrected;
        for term in [self.income(), -self.shunted(), -self.leaked(), -self.drawn(), self.unserved()] {
            sum.add(term);
        }
        sum.value()
    }

    /// `value` if it is finite and not negative; otherwise counts a refusal.
    pub(super) fn admit(&mut self, value: S) -> Option<S> {
        if value >= S::ZERO && value < S::INFINITY {
            return Some(value);
        }
        self.refuse();
        None
    }

    /// Counts a refused value.
    pub(super) fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
    }

    /// Enters the energies of a step of the storage.
    pub(super) fn enter(&mut self, income: S, drawn: S, step: &StorageStep<S>) {
        self.income.add(income);
        self.drawn.add(drawn);
        self.leaked.add(step.leaked);
        self.shunted.add(step.shunted);
        self.unserved.add(step.unserved);
    }

    /// Enters a correction in joules.
    pub(super) fn correct(&mut self, change: S) {
        self.corrected.add(change);
    }
}
