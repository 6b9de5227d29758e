//! The energy ledger: what the base put in, against what was stored, lost and delivered.
//!
//! ```text
//! Δ(mechanical)  = ∫ base − ∫ dissipation − ∫ given up − losses in contact
//! Δ(electrical)  = ∫ taken up − ∫ load − ∫ diodes
//! Δ(storage)       = ∫ load − ∫ leaked − ∫ drawn
//! ```
//!
//! The third only where there is a storage behind a rectifier.
//!
//! The identities of sections 6.3 and 6.4 of the model's derivation: they hold along any exact
//! trajectory, so what is left over is the error of the integration. No reference is needed.

use crate::hybrid::{Event, HybridState, Observer, Span};
use crate::integrate::Point;
use crate::scalar::{CompensatedSum, Scalar};
use crate::scene::{Harvester, StoredEnergy, account};

use super::meter::Integrals;

/// What is left over, in joules, and what it is to be compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Residual<S> {
    /// Of the mechanical ledger.
    pub mechanical: S,
    /// Of the electrical ledger.
    pub electrical: S,
    /// Of the ledger of the storage behind a rectifier; 0 without one.
    pub storage: S,
    /// The larger of `∫ |base power| dt` and the peak of the stored energy.
    pub scale: S,
}

impl<S: Scalar> Residual<S> {
    /// The larger residual of the sum of the mechanical and the electrical ledger and of the storage's,
    /// relative to the scale; `None` if the scale is 0.
    ///
    /// The sum closes only where the force law is the field's own.
    #[must_use]
    pub fn total(&self) -> Option<S> {
        self.relative((self.mechanical + self.electrical).abs().max(self.storage.abs()))
    }

    /// The largest residual of the ledgers, relative to the scale; `None` if the scale is 0.
    #[must_use]
    pub fn largest(&self) -> Option<S> {
        let harvester = self.mechanical.abs().max(self.electrical.abs());
        self.relative(harvester.max(self.storage.abs()))
    }

    fn relative(&self, residual: S) -> Option<S> {
        (self.scale > S::ZERO).then(|| residual.abs() / self.scale)
    }
}

/// Draws up the ledger of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ledger<'a, S, H> {
    harvester: &'a H,
    integrals: Integrals<S, { account::WHOLE }>,
    losses: CompensatedSum<S>,
    start: StoredEnergy<S>,
    now: StoredEnergy<S>,
    peak: S,
    /// Compensated voltage of the storage at the start.
    opening_voltage: [S; 2],
    /// What the storage has gained; `None` without a storage.
    stored: Option<S>,
}

impl<'a, S: Scalar, H> Ledger<'a, S, H> {
    /// A ledger that opens at `state`.
    #[must_use]
    pub fn open<const N: usize>(
        harvester: &'a H,
        state: &HybridState<S, H::Mode, N, { account::WHOLE }>,
    ) -> Self
    where
        H: Harvester<S, N, { account::WHOLE }>,
    {
        let start = harvester.stored_energy(state.mode, &state.point);
        Self {
            harvester,
            integrals: Integrals::new(),
            losses: CompensatedSum::ZERO,
            start,
            now: start,
            peak: start.mechanical + start.electrical,
            opening_voltage: harvester.compensated_storage_voltage(state.mode, &state.point),
            stored: None,
        }
    }

    /// The integrals of the powers.
    #[must_use]
    pub fn integrals(&self) -> &Integrals<S, { account::WHOLE }> {
        &self.integrals
    }

    /// What is left over so far.
    #[must_use]
    pub fn residual(&self) -> Residual<S> {
        let integral = |index| self.integrals.integral(index);
        let (start, now) = (self.start, self.now);
        let income = integral(account::BASE) - integral(account::DISSIPATION);
        let outgoings = integral(account::ELECTROSTATIC_WORK) + self.losses.value();
        let left = integral(account::LOAD) - integral(account::LEAKED) - integral(account::DRAWN);
        Residual {
            mechanical: (now.mechanical - start.mechanical) - (income - outgoings),
            electrical: (now.electrical - start.electrical)
                - (integral(account::FIELD_WORK) - integral(account::LOAD) - integral(account::DIODES)),
            storage: self.stored.map_or(S::ZERO, |stored| stored - left),
            scale: integral(account::BASE_MAGNITUDE).max(self.peak),
        }
    }

    /// Work of the electrostatic force on the motion so far, in joules: negative where the force
    /// has given the motion energy.
    #[must_use]
    pub fn electrostatic_work(&self) -> S {
        self.integrals.integral(account::ELECTROSTATIC_WORK)
    }

    /// Energy lost in contact so far, in joules.
    #[must_use]
    pub fn lost_in_contact(&self) -> S {
        self.losses.value()
    }
}

impl<S: Scalar, H> Ledger<'_, S, H> {
    fn look<const N: usize>(&mut self, mode: H::Mode, point: &Point<S, N, { account::WHOLE }>)
    where
        H: Harvester<S, N, { account::WHOLE }>,
    {
        self.now = self.harvester.stored_energy(mode, point);
        let voltage = self.harvester.compensated_storage_voltage(mode, point);
        self.stored = self.harvester.storage_gain(self.opening_voltage, voltage);
        self.peak = self.peak.max(self.now.mechanical + self.now.electrical);
    }
}

impl<S, H, const N: usize> Observer<S, H::Mode, N, { account::WHOLE }> for Ledger<'_, S, H>
where
    S: Scalar,
    H: Harvester<S, N, { account::WHOLE }>,
{
    fn step(&mut self, span: &Span<'_, S, H::Mode, N, { account::WHOLE }>) {
        self.integrals.add(span.energies, span.ticks);
        self.look(span.mode, span.end);
    }

    fn event(&mut self, event: &Event<'_, S, H::Mode, N, { account::WHOLE }>) {
        self.losses.add(event.loss);
        self.integrals.add_at_once(event.energies);
        self.look(event.after, event.left);
    }
}
