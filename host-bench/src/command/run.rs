//! `run`: one scene.

use std::path::PathBuf;

use super::files::Outputs;
use super::storage_voltage::StorageVoltage;
use super::{NODE, SceneArguments, check_overrides, print, tell};
use crate::accuracy::{imbalance, run_with_accuracy};
use crate::method::{Failure, Options};
use crate::run::run_scene;
use crate::scene_file;

#[derive(Debug, Clone, clap::Args)]
pub struct RunArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write the motion over time to this CSV file
    #[arg(long, value_name = "FILE.csv", requires = "trace_every")]
    trace: Option<PathBuf>,
    /// Seconds between the rows of the trace
    #[arg(long, value_name = "S", requires = "trace", allow_hyphen_values = true)]
    trace_every: Option<f64>,
    /// Seek the periodic steady state under one sine by shooting, in place of the run; the run where
    /// there is none that is stable
    #[arg(long)]
    steady_state: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Run once only: without the accuracy statement, and a bump-stop scene with its default steps
    #[arg(long)]
    no_accuracy: bool,
}

/// Runs the scene, writes the trace and prints the outcome; nothing of either if it fails.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let options = Options {
        trace_every_s: arguments.trace_every,
        steady_state: arguments.steady_state,
        ..arguments.scene.options
    };
    options.check()?;
    let held = arguments.storage_voltage;
    held.check(arguments.steady_state)?;
    let mut scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &held.unused(&[NODE]))?;
    held.hold(&mut scene)?;
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?;
    if let Some(file) = &arguments.trace {
        outputs.check("--trace", file)?;
    }
    let outcome = if arguments.no_accuracy {
        let mut outcome = run_scene(&scene, &options)?;
        outcome.warnings.splice(..0, imbalance(&outcome));
        outcome
    } else {
        run_with_accuracy(&scene, &options)?
    };
    if let (Some(file), Some(recording)) = (&arguments.trace, &outcome.trace) {
        outputs.write(file, &recording.csv())?;
    }
    for warning in &outcome.warnings {
        tell(&format!("warning: {warning}"));
    }
    print(&outcome.text(arguments.scene.format))
}
