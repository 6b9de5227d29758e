//! `run`: one scene.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::files::Outputs;
use super::{
    FileArguments, NODE, SceneArguments, StorageVoltage, Unused, Watch, check_overrides, count, one_more,
    print, warn, with_progress,
};
use crate::accuracy::{imbalance, print_warnings, run_with_accuracy};
use crate::attractors::add_branches;
use crate::closed_form::estimate;
use crate::method::{Failure, Options, Precision};
use crate::motion::{self, Series};
use crate::outcome::{Format, Outcome, fields, text};
use crate::report::Picture;
use crate::report::setting::{margin, named, setting};
use crate::resolution::remarks;
use crate::run::run_scene;
use crate::scene_file::{self, Scene, finite_number_in};
use crate::seeds::{self, Statistics};

#[derive(Debug, Clone, clap::Args)]
pub struct RunArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write the motion over time to this CSV file
    #[arg(long, value_name = "FILE.csv", requires = "trace_every")]
    trace: Option<PathBuf>,
    /// Seconds between the rows of the trace
    #[arg(long, value_name = "S", requires = "trace", allow_hyphen_values = true,
        value_parser = finite_number_in("s", "S"))]
    trace_every: Option<f64>,
    /// Write a picture of the run to this file, .svg or .html (.pdf or .png in a build with images): time histories, phase portrait, spectrum, energy flow; plot has choices
    #[arg(long, value_name = "FILE", conflicts_with_all = ["seeds", "steady_state"])]
    picture: Option<PathBuf>,
    /// Seek the periodic steady state under one sine by shooting, in place of the run; the run where there is none that is stable
    #[arg(long)]
    steady_state: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Run once only: without the accuracy statement, and a bump-stop scene with its default steps
    #[arg(long)]
    no_accuracy: bool,
    /// Leave out the runs from displaced starts, which seek other motions under a periodic excitation; --no-accuracy leaves
    /// them out too
    #[arg(long)]
    single_start: bool,
    /// Run a scene with a random excitation with this many seeds, from its own on, on all cores: means over the seeds, with
    /// their confidence intervals
    #[arg(long, value_name = "COUNT", conflicts_with_all = ["trace", "steady_state"], allow_hyphen_values = true,
        value_parser = count::<u64>(2..=100_000))]
    seeds: Option<u64>,
}

/// Runs the scene, writes picture and trace, and prints the outcome; nothing of them if the run fails.
pub(super) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let mut options = Options {
        trace_every_s: arguments.trace_every,
        steady_state: arguments.steady_state,
        ..arguments.scene.options
    };
    options.check()?;
    let storage_voltage = arguments.storage_voltage;
    storage_voltage.check(arguments.steady_state)?;
    let mut scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &storage_voltage.unused(&[NODE]))?;
    storage_voltage.hold(&mut scene)?;
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?;
    if let Some(file) = &arguments.trace {
        outputs.check("--trace", file)?;
    }
    if let Some(file) = &arguments.picture {
        outputs.check_picture("--picture", [file])?;
        let every_s = motion::every_s(&scene, motion::span_s(&scene));
        options.trace_every_s = options.trace_every_s.or(Some(every_s));
    }
    if let Some(count) = arguments.seeds {
        return run_seeds(arguments, &scene, &options, count);
    }
    let watch = Watch::new();
    let outcome = if arguments.no_accuracy {
        let mut outcome = run_scene(&scene, &options)?;
        outcome.warnings.splice(..0, imbalance(&outcome));
        let remarks: Vec<String> = remarks(&scene, &outcome).collect();
        outcome.warnings.extend(remarks);
        outcome
    } else {
        let mut outcome = run_with_accuracy(&scene, &options)?;
        if !arguments.single_start {
            add_branches(&scene, &options, &mut outcome);
        }
        outcome
    };
    drop(watch);
    if let (Some(file), Some(every_s)) = (&arguments.picture, options.trace_every_s) {
        let picture = picture(&arguments.scene.scene, &scene, (&options, every_s), &outcome)?;
        outputs.keep(file, picture.of_file(file)?);
    }
    if let (Some(file), Some(recording)) = (&arguments.trace, &outcome.trace) {
        outputs.keep(file, recording.csv());
    }
    outcome.warnings.iter().for_each(|warning| warn(warning));
    print(&outcome.text(arguments.scene.format))?;
    outputs.ended()
}

/// The picture of a run, recorded every `every_s` s. The lines of a spectrum need a more accurate run than its numbers.
pub(super) fn picture(
    file: &Path,
    scene: &Scene,
    (options, every_s): (&Options, f64),
    outcome: &Outcome,
) -> Result<Picture, Failure> {
    let recorded =
        |options: &Options| run_scene(scene, &Options { trace_every_s: Some(every_s), ..*options });
    let accurate = motion::of_spectrum(scene, options);
    let [fine, coarse] = accurate.map_or([None, None], |all| all.map(|options| recorded(&options).ok()));
    let series = Series::of("run", scene, fine.as_ref().unwrap_or(outcome));
    let coarse = coarse.filter(|_| fine.is_some()).map(|outcome| Series::of("run", scene, &outcome));
    let words = setting(scene, &[]) + &margin(named(&outcome.margins));
    let title = motion::title(file, &outcome.method, &words);
    let usual = motion::usual(scene, &title, &series, every_s);
    motion::picture(&motion::Wanted { coarse: coarse.as_ref(), ..usual }, &[series])
}

/// Runs the scene with several seeds and prints the statistics over them.
fn run_seeds(arguments: &RunArguments, scene: &Scene, options: &Options, count: u64) -> Result<(), Failure> {
    let seeds = seeds::Seeds::new(scene, count)?;
    let found = with_progress("seeds", seeds.count(), |bar| {
        Statistics::of(scene, options, &seeds, !arguments.no_accuracy, || one_more(bar))
    })?;
    print_warnings(&found.stated);
    print(&found.text(arguments.scene.format)?)
}

/// Keys that a closed form does not use.
const UNUSED_BY_CLOSED_FORM: [Unused; 4] = [
    NODE,
    ("excitation.phase_rad", "a closed form is that of the steady motion"),
    ("run", "a closed form is that of the steady motion"),
    ("initial", "a closed form is that of the steady motion"),
];

#[derive(Debug, Clone, clap::Args)]
pub struct ClosedFormArguments {
    #[command(flatten)]
    scene: FileArguments,
    /// Precision of the closed form
    #[arg(long, value_enum, default_value = "f64")]
    precision: Precision,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
}

pub(super) fn run_closed_form(arguments: &ClosedFormArguments) -> Result<(), Failure> {
    let mut scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &arguments.storage_voltage.unused(&UNUSED_BY_CLOSED_FORM))?;
    arguments.storage_voltage.hold(&mut scene)?;
    let found = estimate(&scene, arguments.precision)?;
    let mut named = fields(&json!({ "scene": scene.name() }));
    named.extend(fields(&found));
    print(&text(&named, arguments.format))
}
