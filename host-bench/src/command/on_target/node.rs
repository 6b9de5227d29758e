//! The sensor node's log.

use std::time::Duration;

use super::table;
use crate::on_target::core::Core;
use crate::on_target::{Error, node};

/// Runs the node and prints what it logged.
///
/// # Errors
///
/// If it cannot be built or run, or the host's run logs anything else.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    let (reports, size) = node::follow(core, limit)?;
    let rows = reports
        .iter()
        .map(|report| {
            [report.second.to_string(), format!("{:.4}", report.mean_power * 1e6), report.steps.to_string()]
        })
        .collect();
    println!("{}", table(["second", "mean power in uW", "steps"], rows, 0));
    println!("{core}. A trace of 400 samples a second from flash; each logged value has the host's bits.");
    println!("The whole firmware, trace and logging included: {} bytes of flash.", size.flash);
    Ok(())
}
