//! `run`: one scene.

use std::path::PathBuf;

use super::{SceneArguments, print, tell, writable, write_whole};
use crate::method::{Failure, Options};
use crate::run::run_scene;
use crate::scene_file;

/// Relative residual of the energy ledger above which a run is not to be trusted.
const UNBALANCED: f64 = 1e-2;

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
}

/// Runs the scene, writes the trace and prints the outcome; nothing of either if it fails.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let options = Options {
        trace_every_s: arguments.trace_every,
        steady_state: arguments.steady_state,
        ..arguments.scene.options
    };
    options.check()?;
    if let Some(file) = &arguments.trace {
        writable("--trace", file)?;
    }
    let scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    let outcome = run_scene(&scene, &options)?;
    if let (Some(file), Some(recording)) = (&arguments.trace, &outcome.trace) {
        write_whole(file, &recording.csv())?;
    }
    if let Some(residual) = outcome.energy_residual.filter(|residual| !(residual.abs() <= UNBALANCED)) {
        tell(&format!(
            "warning: energy_residual = {residual:.1e} is more than {UNBALANCED}: the step or the tolerance was \
             probably too coarse, or the method unstable; these numbers are not to be trusted"
        ));
    }
    print(&outcome.text(arguments.scene.format))
}
