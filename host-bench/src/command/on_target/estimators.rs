//! What an estimate costs, a sample at a time.

use std::time::Duration;

use firmware_example::workload::estimators::with_all;

use super::table;
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, native};

/// Measures the estimators and the closed forms of all scenes on `core` and prints their cost.
///
/// # Errors
///
/// If they cannot be built or run, or come to other bits than the host.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    let measurement = on_target::measure(core, Binary::new("estimators"), limit)?;
    with_all(|native| {
        let native = native::accepted(native)?;
        native::compare_all(core, &measurement.workloads, native)
    })?;
    let rows = measurement.workloads.iter().map(|workload| {
        let whole = workload.whole();
        [
            core.to_string(),
            workload.name.clone(),
            format!("{:.0}", whole.instructions_per_step()),
            format!("{:.0}", whole.instructions_per_second()),
            workload.stack.to_string(),
        ]
    });
    let header = ["core", "estimate", "instructions per sample or call", "per second", "stack"];
    println!("{}", table(header, rows.collect(), 2));
    println!(
        "Samples at 400 (contact-separation, strongest line), 367 (sliding) and 3520 a second (bump-stop);"
    );
    println!("closed forms by call, one a second. Each estimate has the host's bits.");
    Ok(())
}
