//! The bench on each core.

use std::time::Duration;

use firmware_example::workload::scenes;

use super::{announce, table};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, accuracy, native};

/// Measures the bench on `cores` and prints one table.
///
/// # Errors
///
/// At the first core whose firmware cannot be built, run, or trusted.
pub(super) fn report(cores: &[Core], limit: Duration) -> Result<(), Error> {
    let scene = accuracy::scene(&scenes::IMPACTING, 0.0, |_| {})?;
    let reference = accuracy::reference_power(&scene)?;
    let mut rows = Vec::new();
    let mut samples = 0;
    for &core in cores {
        announce(core);
        let measurement = on_target::measure(core, Binary::new("bench"), limit)?;
        native::compare_all(core, &measurement.workloads, &mut [&mut native::accepted(scenes::bench())?])?;
        for workload in &measurement.workloads {
            let whole = workload.whole();
            samples += workload.samples.len();
            rows.push([
                core.to_string(),
                core.hardware().board.to_owned(),
                format!("{:.0}", whole.instructions_per_step()),
                format!("{:.0}", whole.instructions_per_second()),
                accuracy::error(accuracy::mean_power(workload, None), reference),
                measurement.flash.to_string(),
                measurement.size.static_ram.to_string(),
                workload.stack.to_string(),
            ]);
        }
    }
    let header = [
        "core",
        "board in QEMU",
        "instructions per step",
        "per simulated second",
        "error",
        "flash",
        "static RAM",
        "stack",
    ];
    println!("{}", table(header, rows, 2));
    println!(
        "{samples} sampled states, each bit-identical to the host's f32 run. Contact-separation, 20 Hz,"
    );
    println!("0.2 g, {} s from rest, with impacts; tolerance {}.", scene.run.duration_s, scenes::TOLERANCE);
    println!("Error: of this run's mean power against the independent reference over the same time.");
    println!("Instructions as QEMU executes them, which are not cycles. Flash: what is added to an empty");
    println!("firmware with the same runtime and logging. Stack: from the top of RAM. Sizes in bytes.");
    Ok(())
}
