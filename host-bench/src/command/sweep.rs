//! `host-bench sweep`: a scene over a grid of values, on all cores.

mod axis;
pub(super) mod picture;
mod shooting;

use std::io::Write;
use std::path::PathBuf;

use comfy_table::{Table, presets};
use rayon::prelude::*;
use serde_json::{Map, Value};

pub use self::axis::Axis;
use self::picture::Quantity;
use self::shooting::{Compared, compared};
use super::{SceneArguments, print, progress, write_whole};
use crate::method::{Failure, Options, run_scene};
use crate::outcome::{Format, Outcome, cell, number};
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

/// One point of the grid and what came of it.
struct Point {
    values: Vec<f64>,
    found: Result<Outcome, String>,
    /// What the steady state took against the run, where it was sought.
    compared: Option<Compared>,
}

/// Runs the grid, writes the files and prints the points.
///
/// Bad input at any point refuses the whole sweep before it begins. A point that fails on its way is
/// a row with its error; the rest is written and printed all the same.
///
/// # Errors
/// Bad input, or a step error at one of the points.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let options = Options { steady_state: arguments.steady_state, ..arguments.scene.options() };
    options.check()?;
    let axes = &arguments.axes;
    let count = axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.count()));
    let count = count
        .filter(|count| *count <= MOST)
        .ok_or_else(|| Failure::Input(format!("--over: the grid must have at most {MOST} points")))?;
    if let Some((index, axis)) =
        axes.iter().enumerate().find(|(index, axis)| axes[..*index].iter().any(|other| other.key == axis.key))
    {
        return Err(Failure::Input(format!(
            "--over {}: must be given once, is given again as number {}",
            axis.key,
            index + 1
        )));
    }
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
    let points = (0..count).into_par_iter().map(|index| {
        let values = values(axes, index);
        let scene = scene(arguments, &values)?;
        let found = match run_scene(&scene, &options) {
            Ok(outcome) => Ok(outcome),
            Err(Failure::Step(error) | Failure::StepLimitExceeded(error)) => Err(error),
            Err(error @ Failure::Input(_)) => return Err(error),
        };
        let compared = match &found {
            Ok(outcome) => compared(&scene, outcome, arguments)?,
            Err(_) => None,
        };
        bar.inc(1);
        Ok(Point { values, found, compared })
    });
    let points: Result<Vec<Point>, Failure> = points.collect();
    bar.finish_and_clear();
    let points = points?;
    if let Some(costs) = shooting::Costs::of(points.iter().filter_map(|point| point.compared.as_ref())) {
        // With no standard error left there is nobody to tell.
        let _ = writeln!(std::io::stderr(), "{costs}");
    }
    if let Some(folder) = &arguments.output {
        let title = format!("{}, {:?}", arguments.scene.scene.display(), options.method);
        let picture = picture::draw(&title, axes, &quantities(&points)).map_err(Failure::Input)?;
        std::fs::create_dir_all(folder).map_err(|error| {
            Failure::Input(format!("--output {}: cannot be made: {error}", folder.display()))
        })?;
        write_whole(&folder.join("sweep.csv"), &csv(axes, &points))?;
        if let Some(picture) = picture {
            write_whole(&folder.join("sweep.svg"), &picture)?;
        }
    }
    print(&match arguments.scene.format {
        Format::Table => table(axes, &points),
        Format::Json => json(axes, &points),
        Format::Csv => csv(axes, &points),
    })?;
    let failed = points.iter().filter(|point| point.found.is_err()).count();
    match points.iter().find_map(|point| point.found.as_ref().err().map(|error| (point, error))) {
        None => Ok(()),
        Some((point, error)) => Err(Failure::Step(format!(
            "{failed} of {count} points failed, the first at {}: {error}",
            named(axes, point).map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", "),
        ))),
    }
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
    let heading: Vec<String> = keys.chain(fields.iter().cloned()).chain(["error".to_owned()]).collect();
    let mut text = heading.join(",") + "\n";
    for point in points {
        let mut cells: Vec<String> = point.values.iter().map(|value| number(*value)).collect();
        match &point.found {
            Ok(outcome) => {
                cells.extend(outcome.fields().iter().map(|(_, value)| cell(value)));
                cells.push(String::new());
            }
            Err(error) => {
                cells.extend(fields.iter().map(|_| String::new()));
                cells.push(format!("\"{}\"", error.replace('"', "'")));
            }
        }
        text.push_str(&cells.join(","));
        text.push('\n');
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
