//! Balances the energies of a run: the work of the base against the energy stored, lost and delivered.
//!
//! ```text
//! Δ(mechanical) = ∫ base − ∫ dissipation − ∫ electrostatic work − losses in contact
//! Δ(electrical) = ∫ field work − ∫ load − ∫ diodes
//! Δ(storage)    = ∫ load − ∫ leakage − ∫ draw
//! ```
//!
//! The third balance applies to a storage capacitor behind a rectifier. The identities hold along any exact
//! trajectory (multiply the equation of motion by the velocity, and that of the circuit by the voltage), so
//! the residual is the error of the integration. The method of bump-stop conserves energy at any step: there
//! a small residual says nothing about the error.

use super::meter::Integrals;
use crate::observer::{AcceptedStep, Event, Observer, Outputs, PowerIndex, StorageOutput, StoredEnergy};
use crate::scalar::{CompensatedSum, Scalar};

/// Residuals of the balances in J, and the energy for comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Residual<S> {
    /// Residual of the mechanical balance.
    pub mechanical: S,
    /// Residual of the electrical balance.
    pub electrical: S,
    /// Residual of the balance of the storage behind a rectifier; 0 without one.
    pub storage: S,
    /// The larger of `∫ |base power| dt` and the peak of the stored energy, in J; 0 for a run that does not integrate all
    /// powers, whose residuals mean nothing.
    pub scale: S,
}

impl<S: Scalar> Residual<S> {
    /// The larger of two residuals relative to the scale: that of the sum of the mechanical and the
    /// electrical balance, and that of the storage. `None` if the scale is 0, as for a run that does not integrate all powers.
    ///
    /// The sum closes only if the force law is derived from the field.
    #[must_use]
    pub fn total(&self) -> Option<S> {
        self.relative((self.mechanical + self.electrical).abs().max(self.storage.abs()))
    }

    /// The largest residual of the balances, relative to the scale; `None` if the scale is 0, as for a run that does not integrate all powers.
    #[must_use]
    pub fn largest(&self) -> Option<S> {
        let harvester = self.mechanical.abs().max(self.electrical.abs());
        self.relative(harvester.max(self.storage.abs()))
    }

    fn relative(&self, residual: S) -> Option<S> {
        (self.scale > S::ZERO).then(|| residual / self.scale)
    }
}

/// Balances the energies of a run that integrates all powers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ledger<S> {
    integrals: Integrals<S>,
    losses: CompensatedSum<S>,
    start: StoredEnergy<S>,
    now: StoredEnergy<S>,
    peak: S,
    storage_at_start: Option<StorageOutput<S>>,
    storage_now: Option<StorageOutput<S>>,
}

impl<S: Scalar> Ledger<S> {
    /// A ledger that opens with the outputs at the start of a run.
    #[must_use]
    pub fn open(outputs: &Outputs<'_, S>) -> Self {
        let start = outputs.stored;
        Self {
            integrals: Integrals::ZERO,
            losses: CompensatedSum::ZERO,
            start,
            now: start,
            peak: start.total(),
            storage_at_start: outputs.storage,
            storage_now: outputs.storage,
        }
    }

    /// The integrals of the powers.
    #[must_use]
    pub fn integrals(&self) -> &Integrals<S> {
        &self.integrals
    }

    /// The residuals so far.
    #[must_use]
    pub fn residual(&self) -> Residual<S> {
        let integral = |power| self.integrals.integral(power);
        let (start, now) = (self.start, self.now);
        let income = integral(PowerIndex::Base) - integral(PowerIndex::Dissipation);
        let outgoings = integral(PowerIndex::ElectrostaticWork) + self.losses.value();
        let delivered = integral(PowerIndex::Load);
        let left = delivered - integral(PowerIndex::Leakage) - integral(PowerIndex::Draw);
        Residual {
            mechanical: (now.mechanical - start.mechanical) - (income - outgoings),
            electrical: (now.electrical - start.electrical)
                - (integral(PowerIndex::FieldWork) - delivered - integral(PowerIndex::Diodes)),
            storage: self.stored().map_or(S::ZERO, |stored| stored - left),
            scale: if self.integrals.is_complete() {
                integral(PowerIndex::BaseMagnitude).max(self.peak)
            } else {
                S::ZERO
            },
        }
    }

    /// Energy lost in contact so far, in J; negative if a contact law created energy.
    #[must_use]
    pub fn lost_in_contact(&self) -> S {
        self.losses.value()
    }

    /// Energy gained by the storage in J; `None` without a storage, and for a DC bus.
    fn stored(&self) -> Option<S> {
        self.storage_now?.gained_since(&self.storage_at_start?)
    }

    fn update(&mut self, outputs: &Outputs<'_, S>) {
        self.now = outputs.stored;
        self.storage_now = outputs.storage;
        self.peak = self.peak.max(self.now.total());
    }
}

impl<S: Scalar> Observer<S> for Ledger<S> {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.integrals.add(step.energies, step.ticks);
        self.losses.add(step.contact.loss);
        self.update(&step.end);
    }

    fn event(&mut self, event: &Event<'_, S>) {
        self.losses.add(event.loss);
        self.integrals.add_at_once(event.energies);
        self.update(&event.after);
    }
}
