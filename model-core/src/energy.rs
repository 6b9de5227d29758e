//! Harvested energy: meters, the estimator of a node, the energy ledger, and the energy budget of a node.

mod account;
pub(crate) mod battery;
mod budget;
pub mod estimator;
mod forecast;
mod income;
mod ledger;
mod meter;
mod queries;
pub mod response_map;
mod storage;

pub use crate::integrate::cubic::Peak;
pub use account::Account;
pub use battery::{Battery, BatteryCurve};
pub use budget::{Action, Budget, BudgetParameters, BudgetState};
pub use estimator::{Estimate, Estimator, Uncertainty};
pub use income::IncomeParameters;
pub use ledger::{Ledger, Residual};
pub use meter::{Integrals, PowerMeter, RunMeter, RunReport};
pub use response_map::{Response, ResponseMap};
pub use storage::{Storage, StorageParameters};

pub use crate::part::storage::Capacitor;

/// Its fingerprint and checksum, not its words.
#[cfg(feature = "defmt")]
impl<W: response_map::WordSource> defmt::Format for ResponseMap<W> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "ResponseMap {=u32:#x} {=u32:#x}", self.fingerprint(), self.checksum());
    }
}
