//! `fit`: parameters of a scene from measurements.

use std::path::{Path, PathBuf};

use super::files::Outputs;
use super::{NODE, SceneArguments, check_keys, print, progress, tell};
use crate::fit::{self, Found, Request, free::Asked};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file;

/// Starts that are looked at where the first one does not end well.
const STARTS: usize = 24;

/// What is added up of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LossName {
    /// Their squares.
    Linear,
    /// Huber's function: outliers count linearly.
    Huber,
}

#[derive(Debug, Clone, clap::Args)]
pub struct FitArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Measurements: a sweep (column frequency_hz) or a trace (column time_s); may be repeated
    #[arg(long = "data", value_name = "FILE.csv")]
    data: Vec<PathBuf>,
    /// A key of the scene to fit, with the bounds of its value; may be repeated
    #[arg(long = "free", value_name = "KEY[=LOW:HIGH]", allow_hyphen_values = true)]
    free: Vec<Asked>,
    /// What is added up of the residuals: their squares, or Huber's function [default: linear]
    #[arg(long, value_enum)]
    loss: Option<LossName>,
    /// Most further starts, if the first one does not end well [default: 24]
    #[arg(long, value_name = "COUNT")]
    starts: Option<usize>,
    /// Write the scene with the fitted values, and data and model as a picture beside it (.svg)
    #[arg(long, value_name = "FITTED.toml")]
    output: Option<PathBuf>,
    /// Write data and model, residuals below, into this picture
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

/// Fits, writes the files, and prints the result.
pub fn run(arguments: &FitArguments) -> Result<(), Failure> {
    let found = fitted(arguments)?;
    print(&fit::text(&found, arguments.scene.format)?)?;
    ended(&found, arguments.output.as_deref())
}

/// Fits and writes the files. Returns the result as JSON, whether it has converged or not.
///
/// # Errors
/// [`Failure::Input`] for bad input.
pub fn json(arguments: &FitArguments) -> Result<String, Failure> {
    fit::text(&fitted(arguments)?, Format::Json)
}

fn fitted(arguments: &FitArguments) -> Result<Found, Failure> {
    let SceneArguments { scene: file, options, overrides, .. } = &arguments.scene;
    let (scene, table) = scene_file::read_with_fit(file, overrides)?;
    let of_table = |error: String| Failure::Input(format!("{}: fit.{error}", file.display()));
    let free = if arguments.free.is_empty() {
        let asked =
            table.free.iter().map(|text| text.parse().map_err(|error| format!("free: {text:?}: {error}")));
        asked.collect::<Result<Vec<Asked>, String>>().map_err(of_table)?
    } else {
        arguments.free.clone()
    };
    let huber = match (arguments.loss, table.loss.as_deref()) {
        (Some(loss), _) => loss == LossName::Huber,
        (None, None | Some("linear")) => false,
        (None, Some("huber")) => true,
        (None, Some(other)) => {
            return Err(of_table(format!("loss = {other:?}: must be \"linear\" or \"huber\"")));
        }
    };
    let starts = arguments.starts.or(table.starts).unwrap_or(STARTS);
    if starts > 1000 {
        return Err(Failure::Input(format!("--starts {starts}: must be at most 1000")));
    }
    let keys = overrides.iter().map(|change| ("--set", change.key()));
    let keys: Vec<(&str, &str)> =
        keys.chain(free.iter().map(|asked| ("--free", asked.key.as_str()))).collect();
    check_keys(&keys[..overrides.len()], &[NODE])?;
    let of_free: Vec<(&str, &str)> = keys[overrides.len()..].to_vec();
    check_keys(&of_free, &[NODE, ("fit", "[fit] is no part of the model")])?;
    let data = if arguments.data.is_empty() { table.data } else { arguments.data.clone() };
    let outputs = Outputs::of(file, overrides)?.and(&data);
    let pictures =
        [arguments.output.as_ref().map(|path| path.with_extension("svg")), arguments.picture.clone()];
    for path in arguments.output.iter().chain(pictures.iter().flatten()) {
        outputs.check("--output", path)?;
    }
    if let Some(path) = &arguments.picture {
        outputs.check_picture("--picture", path, &["svg"])?;
    }
    let bar = progress(0);
    let done = || {
        bar.inc_length(1);
        bar.inc(1);
    };
    let request = Request { file, overrides, options: *options, data, free, huber, starts };
    let found = fit::fit(&request, &scene, &done);
    bar.finish_and_clear();
    let found = found?;
    for warning in &found.warnings {
        tell(&format!("warning: {warning}"));
    }
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let is_written = found.is_identifiable() && found.converged;
    let [beside, asked] = &pictures;
    for path in beside.iter().filter(|_| is_written).chain(asked) {
        outputs.write(path, &fit::draw(&found, &name).map_err(Failure::Input)?)?;
    }
    if let Some(path) = arguments.output.as_ref().filter(|_| is_written) {
        let written = found.parameters.iter().filter(|parameter| parameter.is_written);
        let entries: Vec<fit::Entry> = written.map(fit::Parameter::entry).collect();
        let moved = folder(path) != folder(file);
        outputs.write(path, &fit::fitted_scene(file, overrides, &entries, moved)?)?;
    }
    Ok(found)
}

/// The end of a fit that is no result.
fn ended(found: &Found, output: Option<&Path>) -> Result<(), Failure> {
    if !found.converged {
        return Err(Failure::Step("the fit has not converged; the best point so far is printed".to_owned()));
    }
    match output {
        Some(path) if !found.is_identifiable() => Err(Failure::Step(format!(
            "{}: is not written, because the data do not determine all free keys",
            path.display()
        ))),
        _ => Ok(()),
    }
}

/// The folder of a file, as the system names it.
pub(super) fn folder(file: &Path) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    std::fs::canonicalize(folder).ok()
}
