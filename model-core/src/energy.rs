//! What was harvested, whether it adds up, and what a node can do with it.

mod account;
mod budget;
mod correction;
mod cut_normal;
mod event_log;
mod forecast;
mod income;
mod ledger;
mod meter;
mod queries;
mod storage;

pub use account::Account;
pub use budget::{Action, Budget, BudgetParameters, BudgetState};
pub use correction::{Correction, CorrectionParameters, CorrectionState, Reading};
pub use event_log::{EventLog, LoggedEvent};
pub use income::{DAY_SECONDS, Income, IncomeParameters, IncomeState};
pub use ledger::{Ledger, Residual};
pub use meter::{Integrals, Peak, PowerMeter, RunMeter};
pub use storage::{Relaxation, Storage, StorageParameters, StorageStep};
