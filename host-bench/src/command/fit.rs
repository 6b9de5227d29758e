//! `fit`: parameters of a scene from measurements.

use std::path::{Path, PathBuf};

use super::files::Outputs;
use super::{
    NODE, SceneArguments, check_keys, check_overrides, count, fail_after_result, print, with_progress,
};
use crate::accuracy::print_warnings;
use crate::fit::{self, FitResult, Request, free::Asked};
use crate::input::STANDARD;
use crate::method::Failure;
use crate::name::Name;
use crate::scene_file::{self, Fit, finite_number_in};

/// Starts that are looked at where the first one does not end well.
const STARTS: usize = 24;

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
    /// Rate in Hz of even times to which the traces of --data are resampled, as by excitation.resample_hz
    #[arg(long = "resample", value_name = "HZ", value_parser = finite_number_in("Hz", "HZ"))]
    resample_hz: Option<f64>,
    /// A key of the scene to fit, with the bounds of its value; may be repeated
    #[arg(long = "free", value_name = "KEY[=LOW:HIGH]", allow_hyphen_values = true)]
    free: Vec<Asked>,
    /// What is added up of the residuals: their squares, or Huber's function [default: linear]
    #[arg(long, value_enum)]
    loss: Option<LossName>,
    /// Most further starts, if the first one does not end well [default: 24]
    #[arg(long, value_name = "COUNT", value_parser = count::<usize>(0..=1000))]
    starts: Option<usize>,
    /// Iterations after which a search is given up; the fit has then not converged
    #[arg(long, value_name = "COUNT", default_value_t = 60, value_parser = count::<usize>(1..=1000))]
    iterations: usize,
    /// Write the scene with the fitted values, and data and model as a picture beside it (.svg)
    #[arg(long, value_name = "FITTED.toml")]
    output: Option<PathBuf>,
    /// Write data and model, residuals below, into this picture (.svg) or page with zoom and hover (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
}

/// Fits, writes the files, and prints the result. [`Failure::Step`] where the fit has not converged, or its scene is not written.
pub(super) fn run(arguments: &FitArguments) -> Result<(), Failure> {
    let SceneArguments { scene: file, options, overrides, .. } = &arguments.scene;
    let (scene, table) = scene_file::read_with_fit(file, overrides)?;
    let asked = arguments.loss.map(|loss| loss == LossName::Huber);
    let (free, huber) = (arguments.free(&table)?, asked.or(table.huber).unwrap_or(false));
    let starts = arguments.starts.or(table.starts).unwrap_or(STARTS);
    let iterations = arguments.iterations;
    check_overrides(overrides, &[NODE])?;
    let keys: Vec<(&str, &str)> = free.iter().map(|asked| ("--free", asked.key.as_str())).collect();
    check_keys(&keys, &[NODE, ("fit", "[fit] is no part of the model")])?;
    let data = if arguments.data.is_empty() { table.data } else { arguments.data.clone() };
    let outputs = Outputs::of(file, overrides)?.and(&data);
    for path in arguments.output.iter().chain(&arguments.beside()) {
        outputs.check("--output", path)?;
    }
    outputs.check_picture("--picture", &arguments.picture)?;
    let is_drawn = arguments.output.is_some() || arguments.picture.is_some();
    let (options, resample_hz) = (*options, arguments.resample_hz);
    if let Some(rate) = resample_hz.filter(|rate| !(1e-3..=1e6).contains(rate)) {
        return Err(Failure::Input(format!("--resample {rate}: must be from 1e-3 to 1e6 Hz")));
    }
    let request =
        Request { file, overrides, options, data, resample_hz, free, huber, starts, iterations, is_drawn };
    let found = with_progress("runs", 0, |bar| {
        fit::fit(&request, &scene, &|| {
            bar.inc_length(1);
            bar.inc(1);
        })
    })?;
    print_warnings(&found.statements.fields(&found.warnings));
    arguments.write(&outputs, &found)?;
    print(&fit::text(&found, arguments.scene.format)?)?;
    outputs.ended()?;
    if !found.converged {
        fail_after_result("the fit has not converged; the best point so far is printed".to_owned())?;
    }
    match (&arguments.output, unwritten(&found)) {
        // Who goes on with the file would take that of an earlier fit.
        (Some(path), Some(reason)) => {
            Err(Failure::Step(format!("{}: is not written, because {reason}", path.display())))
        }
        _ => Ok(()),
    }
}

impl FitArguments {
    /// The free keys: those of the options, else those of the table.
    fn free(&self, table: &Fit) -> Result<Vec<Asked>, Failure> {
        if !self.free.is_empty() {
            return Ok(self.free.clone());
        }
        let scene = self.scene.scene.display();
        let asked = table.free.iter().map(|text| {
            text.parse().map_err(|error| Failure::Input(format!("{scene}: fit.free: {text:?}: {error}")))
        });
        asked.collect()
    }

    fn beside(&self) -> Option<PathBuf> {
        self.output.as_deref().and_then(beside)
    }

    /// Writes the pictures, and the fitted scene where there is one.
    fn write(&self, outputs: &Outputs, found: &FitResult) -> Result<(), Failure> {
        let SceneArguments { scene: file, overrides, .. } = &self.scene;
        let name = Name::of_file(file).line();
        let is_written = unwritten(found).is_none();
        for path in self.beside().iter().filter(|_| is_written).chain(&self.picture) {
            outputs.keep(path, fit::picture(found, &name)?.of_file(path)?);
        }
        if let Some(path) = self.output.as_ref().filter(|_| is_written) {
            let entries = found.entries();
            let moved = folder(path) != folder(file);
            outputs.keep(path, fit::fitted_scene(file, overrides, &entries, moved)?);
        }
        Ok(())
    }
}

/// Why there is no fitted scene.
fn unwritten(found: &FitResult) -> Option<&'static str> {
    match found {
        found if !found.converged => Some("the fit has not converged"),
        found if !found.is_identifiable() => Some("the data do not determine all free keys"),
        _ => None,
    }
}

/// The picture beside a scene that is written; standard output has none.
pub(super) fn beside(path: &Path) -> Option<PathBuf> {
    (path != Path::new(STANDARD)).then(|| path.with_extension("svg"))
}

/// The folder of a file, as the system names it.
pub(super) fn folder(file: &Path) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    std::fs::canonicalize(folder).ok()
}
