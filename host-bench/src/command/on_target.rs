//! `on-target`: what the models cost on a microcontroller.

mod cores;
mod estimators;
mod leave_outs;
mod node;
mod peer;
mod work_precision;

use crate::on_target::core::Core;
use crate::on_target::{Error, qemu};
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use std::time::Duration;

/// Build the firmware for each core, run it under QEMU, check its bits against the host, and report
/// instructions, flash, RAM and stack.
#[derive(Debug, Clone, Args)]
pub struct OnTargetArguments {
    /// The cores, separated by commas [default: all; M4F where one of the options below is given]
    #[arg(long, value_delimiter = ',', value_name = "CORE")]
    core: Vec<Core>,

    /// How long a run may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120)]
    time_limit: u64,

    /// Error against instructions, over tolerances, fixed steps and methods
    #[arg(long, group = "report")]
    work_precision: bool,

    /// What each part of a scene costs: flash and instructions without it
    #[arg(long, group = "report")]
    leave_outs: bool,

    /// The sensor node: its log compared with the host's [default: M4F and M0]
    #[arg(long, group = "report")]
    node: bool,

    /// What an estimate costs for each sample, and a closed form for each call [default: M4F and M0]
    #[arg(long, group = "report")]
    estimators: bool,

    /// The smooth scene by the crate numeris beside ours
    #[arg(long, group = "report")]
    peer: bool,
}

/// Measures each core and prints one table.
///
/// # Errors
///
/// At the first core whose firmware cannot be built, run, or trusted.
pub fn run(arguments: &OnTargetArguments) -> Result<(), Error> {
    qemu::find()?;
    let limit = Duration::from_secs(arguments.time_limit);
    let of_one = |report: fn(Core, Duration) -> Result<(), Error>| {
        let small = arguments.node || arguments.estimators;
        let usual = if small { &[Core::M4f, Core::M0][..] } else { &[Core::M4f] };
        let cores = if arguments.core.is_empty() { usual } else { &arguments.core };
        cores.iter().try_for_each(|&core| {
            announce(core);
            report(core, limit)
        })
    };
    if arguments.work_precision {
        of_one(work_precision::report)
    } else if arguments.leave_outs {
        of_one(leave_outs::report)
    } else if arguments.node {
        of_one(node::report)
    } else if arguments.estimators {
        of_one(estimators::report)
    } else if arguments.peer {
        of_one(peer::report)
    } else {
        let cores = if arguments.core.is_empty() { Core::value_variants() } else { &arguments.core };
        cores::report(cores, limit)
    }
}

fn announce(core: Core) {
    eprintln!("{core}, on the board {}", core.hardware().board);
}

/// A table with its first `text` columns to the left and the others, which are numbers, to the right.
fn table<const N: usize>(header: [&str; N], rows: Vec<[String; N]>, text: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_header(header);
    table.add_rows(rows);
    for column in table.column_iter_mut().skip(text) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
