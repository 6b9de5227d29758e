//! What was harvested, and whether it adds up.

pub mod estimator;
mod event_log;
mod ledger;
mod meter;

pub use estimator::{Estimate, Estimator, Uncertainty};
pub use event_log::{EventLog, LoggedEvent};
pub use ledger::{Ledger, Residual};
pub use meter::{Integrals, Peak, PowerMeter, RunMeter};
