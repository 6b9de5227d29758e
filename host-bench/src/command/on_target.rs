//! `on-target`: what the models cost on a microcontroller.

use crate::on_target::core::Core;
use crate::on_target::{self, Error, Measurement, qemu};
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use std::time::Duration;

/// Build the firmware for each core, run it under QEMU, and report instructions, flash, RAM and
/// stack.
#[derive(Debug, Clone, Args)]
pub struct OnTargetArguments {
    /// The cores, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_name = "CORE")]
    core: Vec<Core>,

    /// How long a run may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120)]
    time_limit: u64,
}

/// Measures each core and prints one table.
///
/// # Errors
///
/// At the first core whose firmware cannot be built, run, or trusted.
pub fn run(arguments: &OnTargetArguments) -> Result<(), Error> {
    let cores = if arguments.core.is_empty() { Core::value_variants() } else { &arguments.core };
    qemu::find()?;
    let mut measurements = Vec::new();
    for &core in cores {
        eprintln!("{core}, on the board {}", core.hardware().board);
        let limit = Duration::from_secs(arguments.time_limit);
        measurements.push(on_target::measure(core, limit)?);
    }
    println!("{}", table(&measurements));
    println!("Instructions as QEMU executes them, which are not cycles. Flash: what is added to an empty");
    println!("firmware with the same runtime and logging. Stack: from the top of RAM. Sizes in bytes.");
    Ok(())
}

fn table(measurements: &[Measurement]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_header([
        "core",
        "workload",
        "instructions per step",
        "per simulated second",
        "flash",
        "static RAM",
        "stack",
        "per instruction",
    ]);
    for measurement in measurements {
        for workload in &measurement.workloads {
            table.add_row([
                measurement.core.to_string(),
                workload.name.clone(),
                format!("{:.1}", workload.instructions_per_step()),
                format!("{:.0}", workload.instructions_per_second()),
                measurement.flash.to_string(),
                measurement.size.static_ram.to_string(),
                workload.stack.to_string(),
                format!("{:.4}", measurement.calibration),
            ]);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
