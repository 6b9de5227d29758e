//! `on-target`: what the models cost on a microcontroller.

mod cores;
mod estimators;
mod node;
mod output;
mod peer;
mod rows;
mod work_precision;

use self::output::{Format, Output};
use super::count;
use super::files::Outputs;
use crate::method::Failure;
use crate::on_target::core::Core;
use crate::on_target::{Bench, Error, day, qemu};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Build the firmware for each core, run it under QEMU, check its bits against the host, and report
/// instructions, flash, RAM and stack.
#[derive(Debug, Clone, Args)]
pub struct OnTargetArguments {
    /// The cores, separated by commas [default: all; M4F where one of the options below is given]
    #[arg(long, value_delimiter = ',', value_name = "CORE")]
    core: Vec<Core>,

    /// How long a run may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = count::<u64>(1..=86_400))]
    time_limit: u64,

    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Error against instructions, over tolerances, fixed steps and methods
    #[arg(long, group = "report")]
    work_precision: bool,

    /// The sensor node: a day with losses of power, its log compared with the host's [default: M4F and M0]
    #[arg(long, group = "report")]
    node: bool,

    /// Make the day of the sensor node with the full model, and write it into this file for the firmware's build
    #[arg(long, group = "report", value_name = "FILE")]
    day: Option<PathBuf>,

    /// What an estimate costs for each sample, and a look-up in a response map for each call [default: M4F and M0]
    #[arg(long, group = "report")]
    estimators: bool,

    /// The smooth scene by the crate numeris beside ours
    #[arg(long, group = "report")]
    peer: bool,
}

/// Prints the chosen report.
///
/// # Errors
///
/// At the first core whose firmware does not build or run, or computes other bits than the host.
pub fn run(arguments: &OnTargetArguments) -> Result<(), Error> {
    if let Some(file) = &arguments.day {
        let outputs = Outputs::of_shipped([]);
        let failed = |failure: Failure| Error::File { path: "--day".into(), what: failure.to_string() };
        outputs.check("", file).map_err(failed)?;
        return outputs.write(file, day::table(&day::day()?)).map_err(failed);
    }
    qemu::find()?;
    let limit = Duration::from_secs(arguments.time_limit);
    let mut output = Output::new(arguments.format);
    let cores = |default: &[Core]| match &arguments.core[..] {
        [] => default.to_vec(),
        chosen => chosen.to_vec(),
    };
    let of_bench: fn(&Bench, &mut Output) -> Result<(), Error> = if arguments.work_precision {
        work_precision::report
    } else if arguments.estimators {
        estimators::report
    } else if arguments.peer {
        peer::report
    } else {
        let all = if arguments.node { &[Core::M4f, Core::M0] } else { Core::value_variants() };
        let cores = cores(all);
        if arguments.node {
            node::report(&cores, limit, &mut output)?;
        } else {
            cores::report(&cores, limit, &mut output)?;
        }
        output.finish();
        return Ok(());
    };
    for core in cores(if arguments.estimators { &[Core::M4f, Core::M0] } else { &[Core::M4f] }) {
        of_bench(&bench(core, limit)?, &mut output)?;
    }
    output.finish();
    Ok(())
}

/// The bench on `core`, announced on standard error.
fn bench(core: Core, limit: Duration) -> Result<Bench, Error> {
    announce(core);
    Bench::new(core, limit)
}

fn announce(core: Core) {
    eprintln!("{core}, on the board {}", core.hardware().board);
}
