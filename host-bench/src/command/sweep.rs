//! `sweep`: a scene over a grid of values, on all cores.

mod axis;
pub(super) mod picture;
mod shooting;

use std::path::{Path, PathBuf};

use comfy_table::{Table, presets};
use rayon::prelude::*;
use serde_json::{Map, Value};

pub use self::axis::Axis;
use self::picture::Quantity;
use self::shooting::{Compared, Costs, compared};
use super::{SceneArguments, make_folder, print, progress, tell, write_whole};
use crate::method::{Failure, Options};
use crate::outcome::{Format, Outcome, cell, csv_line, number};
use crate::run::try_run_scene;
use crate::scene_file::{self, Override, Scene, SceneError};

/// Most points of a grid.
const MOST: usize = 1_000_000;

/// Arguments of `sweep`.
#[derive(Debug, Clone, clap::Args)]
pub struct SweepArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Values for a key of the scene; repeat it for a grid
    #[arg(long = "over", value_name = "KEY=FROM:TO:COUNT[:log]", required = true)]
    axes: Vec<Axis>,
    /// Write sweep.csv and sweep.svg into this folder
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seek the periodic steady state under one sine by shooting at each point, in place of the run; the
    /// run where there is none that is stable
    #[arg(long)]
    steady_state: bool,
    /// Make the runs as well, and tell on standard error how much longer they take
    #[arg(long, requires = "steady_state")]
    compare: bool,
}

/// One point of the grid and its outcome.
struct Point {
    values: Vec<f64>,
    found: Result<Outcome, String>,
    /// The cost of the steady state against that of the run, if a steady state was sought.
    compared: Option<Compared>,
}

/// Runs the grid, writes the files and prints the points.
///
/// Bad input at any point refuses the whole sweep before it begins. A point that fails on its way is a row with its
/// error; the other points are written and printed all the same.
///
/// # Errors
/// Bad input, or a step error at one of the points.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let options = Options { steady_state: arguments.steady_state, ..arguments.scene.options() };
    options.check()?;
    let axes = &arguments.axes;
    let count = check_axes(axes)?;
    if let Some(folder) = &arguments.output
        && folder.exists()
        && !folder.is_dir()
    {
        return Err(Failure::Input(format!("--output {}: must be a folder", folder.display())));
    }
    (0..count)
        .into_par_iter()
        .try_for_each(|index| options.check_scene(&scene(arguments, &values(axes, index))?))?;
    let bar = progress(count);
    let points: Result<Vec<Point>, Failure> = (0..count)
        .into_par_iter()
        .map(|index| {
            let point = Point::of(arguments, &options, values(axes, index));
            bar.inc(1);
            point
        })
        .collect();
    bar.finish_and_clear();
    let points = points?;
    if let Some(costs) = Costs::of(points.iter().filter_map(|point| point.compared.as_ref())) {
        tell(&costs.to_string());
    }
    if let Some(folder) = &arguments.output {
        write(arguments, folder, &points)?;
    }
    print(&match arguments.scene.format {
        Format::Table => table(axes, &points),
        Format::Json => json(axes, &points),
        Format::Csv => csv(axes, &points),
    })?;
    none_failed(axes, &points)
}

/// The number of points; each key must be given once.
fn check_axes(axes: &[Axis]) -> Result<usize, Failure> {
    let count = axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.count()));
    let count = count
        .filter(|count| *count <= MOST)
        .ok_or_else(|| Failure::Input(format!("--over: the grid must have at most {MOST} points")))?;
    let is_again = |index: usize, axis: &Axis| axes[..index].iter().any(|other| other.key == axis.key);
    match axes.iter().enumerate().find(|(index, axis)| is_again(*index, axis)) {
        None => Ok(count),
        Some((index, axis)) => Err(Failure::Input(format!(
            "--over {}: must be given once, is given again as number {}",
            axis.key,
            index + 1
        ))),
    }
}

impl Point {
    /// Runs the point at these values of the axes.
    fn of(arguments: &SweepArguments, options: &Options, values: Vec<f64>) -> Result<Self, Failure> {
        let scene = scene(arguments, &values)?;
        let found = try_run_scene(&scene, options)?;
        let compared = match &found {
            Ok(outcome) => compared(&scene, outcome, arguments)?,
            Err(_) => None,
        };
        Ok(Self { values, found, compared })
    }
}

/// Writes the table, and the picture if there is one.
fn write(arguments: &SweepArguments, folder: &Path, points: &[Point]) -> Result<(), Failure> {
    let axes = &arguments.axes;
    let title = format!("{}, {:?}", arguments.scene.scene.display(), arguments.scene.method);
    let picture = picture::draw(&title, axes, &quantities(points)).map_err(Failure::Input)?;
    make_folder(folder)?;
    write_whole(&folder.join("sweep.csv"), &csv(axes, points))?;
    picture.map_or(Ok(()), |picture| write_whole(&folder.join("sweep.svg"), &picture))
}

/// Refuses points that failed.
fn none_failed(axes: &[Axis], points: &[Point]) -> Result<(), Failure> {
    let mut failed = points.iter().filter_map(|point| Some((point, point.found.as_ref().err()?)));
    let Some((point, error)) = failed.next() else { return Ok(()) };
    Err(Failure::Step(format!(
        "{} of {} points failed, the first at {}: {error}",
        1 + failed.count(),
        points.len(),
        named(axes, point).map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", "),
    )))
}

/// The values of the point with the given index; the last axis runs fastest.
fn values(axes: &[Axis], index: usize) -> Vec<f64> {
    let mut rest = index;
    let mut values: Vec<f64> = axes
        .iter()
        .rev()
        .map(|axis| {
            let value = axis.value(rest % axis.count());
            rest /= axis.count();
            value
        })
        .collect();
    values.reverse();
    values
}

fn scene(arguments: &SweepArguments, values: &[f64]) -> Result<Scene, SceneError> {
    let mut overrides = arguments.scene.overrides.clone();
    let axes = arguments.axes.iter().zip(values);
    overrides.extend(axes.map(|(axis, value)| Override::new(&axis.key, &number(*value))));
    scene_file::read(&arguments.scene.scene, &overrides)
}

fn named<'a>(axes: &'a [Axis], point: &'a Point) -> impl Iterator<Item = (&'a str, f64)> {
    axes.iter().map(|axis| axis.key.as_str()).zip(point.values.iter().copied())
}

/// Names of an outcome's fields, from the first point that has one.
fn fields(points: &[Point]) -> Vec<String> {
    let first = points.iter().find_map(|point| point.found.as_ref().ok());
    first.map(|outcome| outcome.fields().into_iter().map(|(name, _)| name).collect()).unwrap_or_default()
}

fn csv(axes: &[Axis], points: &[Point]) -> String {
    let fields = fields(points);
    let keys = axes.iter().map(|axis| axis.key.clone());
    let mut text = csv_line(keys.chain(fields.iter().cloned()).chain(["error".to_owned()]));
    for point in points {
        let (found, error) = match &point.found {
            Ok(outcome) => (outcome.fields().iter().map(|(_, value)| cell(value)).collect(), String::new()),
            Err(error) => (vec![String::new(); fields.len()], error.clone()),
        };
        text += &csv_line(point.values.iter().copied().map(number).chain(found).chain([error]));
    }
    text
}

fn json(axes: &[Axis], points: &[Point]) -> String {
    let objects = points.iter().map(|point| {
        let mut object: Map<String, Value> =
            named(axes, point).map(|(key, value)| (key.to_owned(), Value::from(value))).collect();
        match &point.found {
            Ok(outcome) => object.extend(outcome.fields()),
            Err(error) => object.extend([("error".to_owned(), Value::from(error.as_str()))]),
        }
        Value::Object(object)
    });
    format!("{:#}\n", Value::Array(objects.collect()))
}

/// The values of each point with its power and voltage, aligned.
fn table(axes: &[Axis], points: &[Point]) -> String {
    let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.5e}"));
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let keys = axes.iter().map(|axis| axis.key.as_str());
    let steady = points.iter().any(|point| point.compared.is_some());
    let names = ["mean_power_w", "rms_voltage_v", "steps"].into_iter();
    let verdict = steady.then_some("steady_state");
    table.set_header(keys.chain(names).chain(verdict).chain(["error"]));
    for point in points {
        let values = point.values.iter().map(|value| shown(Some(*value)));
        let (found, error) = match &point.found {
            Ok(outcome) => (
                [shown(outcome.mean_power_w), shown(outcome.rms_voltage_v), outcome.steps.to_string()],
                String::new(),
            ),
            Err(error) => ([shown(None), shown(None), shown(None)], error.clone()),
        };
        let verdict = steady.then(|| match point.found.as_ref().map(|outcome| &outcome.steady_state) {
            Ok(Some(found)) => found.steady_state.to_owned(),
            _ => shown(None),
        });
        table.add_row(values.chain(found).chain(verdict).chain([error]));
    }
    table.trim_fmt() + "\n"
}

fn quantities(points: &[Point]) -> Vec<Quantity> {
    let quantity = |name, of: fn(&Outcome) -> Option<f64>| Quantity {
        name,
        values: points.iter().map(|point| point.found.as_ref().ok().and_then(of)).collect(),
    };
    vec![
        quantity("mean power [W]", |outcome| outcome.mean_power_w),
        quantity("RMS voltage [V]", |outcome| outcome.rms_voltage_v),
    ]
}
