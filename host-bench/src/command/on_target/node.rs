//! The sensor node's log.

use std::time::Duration;

use super::table;
use crate::on_target::core::Core;
use crate::on_target::node::Kind;
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
            let [harvested, stored] = report.microjoules();
            [
                report.second.to_string(),
                report.decision.name().to_owned(),
                format!("{harvested:.4}"),
                format!("{stored:.3}"),
                report.steps.to_string(),
            ]
        })
        .collect();
    println!("{}", table(["second", "decision", "harvested in uJ", "stored in uJ", "steps"], rows, 2));
    let how = match Kind::of(core) {
        Kind::Following => "The harvester's model is stepped along 400 samples a second from flash",
        Kind::Listening => {
            "A closed form is asked about the strongest line of 400 samples a second from flash"
        }
    };
    println!("{core}. {how};");
    println!("each logged value has the host's bits. The whole firmware, trace and logging included:");
    println!("{} bytes of flash.", size.flash);
    Ok(())
}
