//! The account of the energies into and out of a storage, in J.

use super::storage::StorageStep;
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// Largest energy of one booking in J: sums of such energies, and their squares, are finite in `f32`.
const LARGEST_ENERGY: f64 = 1e9;

/// Whether a number is an energy in J that can be booked: 0 to 10⁹.
pub(super) fn is_energy<S: Scalar>(energy: S) -> bool {
    energy >= S::ZERO && energy <= S::from_f64(LARGEST_ENERGY)
}

/// The energies since the start in J at the storage.
///
/// `balance = income − shunted − leaked − (drawn − unserved) + corrected`. The account begins with an empty storage,
/// and the energy found by the first measurement counts as a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Account<S> {
    /// Harvested energy times the charging efficiency.
    pub income: S,
    /// Energy requested by the load over the discharging efficiency.
    pub drawn: S,
    /// Leaked energy.
    pub leaked: S,
    /// Income for which the storage had no room.
    pub shunted: S,
    /// Requested energy that the storage could not give above its lock-out. If the node spent that energy
    /// nevertheless, the storage held more than the budget assumed.
    pub unserved: S,
    /// Sum of the corrections by measurements, positive if the storage held more than the budget assumed.
    pub corrected: S,
    /// Stored energy by this account.
    pub balance: S,
    /// Number of values refused because they were negative, not finite, or above 10⁹.
    pub refused: u32,
}

/// Compensated sums of an [`Account`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct AccountSums<S> {
    income: CompensatedSum<S>,
    drawn: CompensatedSum<S>,
    leaked: CompensatedSum<S>,
    shunted: CompensatedSum<S>,
    unserved: CompensatedSum<S>,
    pub(super) corrected: CompensatedSum<S>,
    refused: u32,
}

impl<S: Scalar> AccountSums<S> {
    /// The rounded sums.
    pub(super) fn read(&self) -> Account<S> {
        let mut balance = self.corrected;
        let [income, shunted] = [self.income.value(), self.shunted.value()];
        let [leaked, drawn, unserved] = [self.leaked.value(), self.drawn.value(), self.unserved.value()];
        for term in [income, -shunted, -leaked, -drawn, unserved] {
            balance.add(term);
        }
        Account {
            income,
            drawn,
            leaked,
            shunted,
            unserved,
            corrected: self.corrected.value(),
            balance: balance.value(),
            refused: self.refused,
        }
    }

    /// `value` if it is from 0 to 10⁹; otherwise counts a refusal.
    pub(super) fn admit(&mut self, value: S) -> Option<S> {
        if is_energy(value) {
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
}

snapshot_fields!(impl [S: Scalar] AccountSums<S> {
    income, drawn, leaked, shunted, unserved, corrected, refused,
});
