//! `sweep`: a scene over a grid of values, on all cores.

mod axis;
mod messages;
pub(super) mod picture;
mod rows;

use std::path::{Path, PathBuf};

use comfy_table::presets;
use rayon::prelude::*;
use serde_json::json;

pub use self::axis::Axis;
use self::messages::{best, best_text, doubt, is_of_accuracy, warnings};
use self::picture::{Labels, Quantity, picture};
use self::rows::{ROWS, Rows};
use super::files::{Outputs, make_folder};
use super::{NODE, SceneArguments, StorageVoltage, check_keys, is_quiet, note, print, print_line, progress};
use crate::accuracy::run_with_accuracy;
use crate::attractors::add_branches;
use crate::input::{self, MOST_OF_DATA};
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::outcome::{Fields, Format, STABLE, fields, flattened, number, rows_csv};
use crate::report::setting::{margin, setting};
use crate::rows::{Column, Digits};
use crate::run::{run_scene, stopped_as_text};
use crate::scene_file::{self, Override, Scene};
use crate::stability::{build, fnv_1a};
use messages::{Compared, compared};

/// Most points of a grid.
const MOST: usize = 1_000_000;
/// The table, the picture and the page.
const FILES: [&str; 3] = ["sweep.csv", "sweep.svg", "sweep.html"];

#[derive(Debug, Clone, clap::Args)]
pub struct SweepArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Values for a key of the scene; repeat it for a grid
    #[arg(long = "over", value_name = "KEY=FROM:TO:COUNT[:log]", required = true)]
    axes: Vec<Axis>,
    /// Write sweep.csv, sweep.svg and sweep.html into this folder; points are kept there as they are done, and a sweep that was
    /// interrupted goes on from them when it is given again
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seek the periodic steady state under one sine by shooting at each point, in place of the run; the
    /// run where there is none that is stable
    #[arg(long)]
    steady_state: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Make the runs as well, and print on standard error how much longer they take
    #[arg(long, requires = "steady_state")]
    compare: bool,
    /// Run each point once only: without the accuracy statement, and a bump-stop scene with its default steps
    #[arg(long)]
    no_accuracy: bool,
    /// Leave out the runs of each point from displaced starts; --no-accuracy leaves them out too
    #[arg(long)]
    single_start: bool,
}

/// One point of the grid and its outcome.
struct Point {
    values: Vec<f64>,
    found: Result<Fields, String>,
    /// The cost of the steady state against that of the run, if a steady state was sought.
    compared: Option<Compared>,
}

/// Runs the grid, writes the files and prints the points.
///
/// Bad input at any point refuses the whole sweep before it begins. A point that fails on its way is a row with its
/// error; the other points are written and printed all the same.
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let options = Options { steady_state: arguments.steady_state, ..arguments.scene.options };
    options.check()?;
    arguments.storage_voltage.check(arguments.steady_state)?;
    let axes = &arguments.axes;
    let count = check_axes(axes)?;
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?;
    (0..count)
        .into_par_iter()
        .try_for_each(|index| options.check_scene(&scene(arguments, &values(axes, index))?))?;
    let overrides = arguments.scene.overrides.iter().map(|change| ("--set", change.key()));
    let keys = overrides.chain(axes.iter().map(|axis| ("--over", axis.key.as_str())));
    check_keys(&keys.collect::<Vec<_>>(), &arguments.storage_voltage.unused(&[NODE]))?;
    if let Some(folder) = &arguments.output {
        check_folder(folder)?;
        outputs.check_in("--output", folder, &FILES)?;
    }
    let rows = match &arguments.output {
        Some(folder) => {
            make_folder(folder)?;
            outputs.check("--output", &folder.join(ROWS))?;
            Some(Rows::open(folder, &identity(arguments)?)?)
        }
        None => None,
    };
    if let Some(done) = rows.as_ref().map(Rows::count).filter(|done| *done > 0) {
        note(&format!("{done} of {count} points were done before"));
    }
    let bar = progress(count);
    let points: Result<Vec<Point>, Failure> = (0..count)
        .into_par_iter()
        .map(|index| {
            let point = Point::of(arguments, &options, values(axes, index), (index, rows.as_ref()));
            bar.inc(1);
            point
        })
        .collect();
    bar.finish_and_clear();
    let points = points?;
    print_notes(arguments, &options, &points);
    if let Some(folder) = &arguments.output {
        write(arguments, folder, &outputs, &points)?;
    }
    print(&match arguments.scene.format {
        Format::Table => table(axes, &points),
        Format::Json => format!("{:#}\n", json!(rows_of(axes, &points).0)),
        Format::Csv => csv(axes, &points),
    })?;
    outputs.ended()?;
    if let Some(rows) = rows {
        rows.remove();
    }
    none_failed(axes, &points)
}

/// Prints on standard error the costs of all points, the warnings, and the best point.
fn print_notes(arguments: &SweepArguments, options: &Options, points: &[Point]) {
    let axes = &arguments.axes;
    if let Some(costs) = messages::costs(points.iter().filter_map(|point| point.compared.as_ref())) {
        note(&costs);
    }
    for warning in warnings(axes, points) {
        print_line(&format!("warning: {warning}"));
    }
    if let (Format::Table, false, Some(best)) = (arguments.scene.format, is_quiet(), best(points)) {
        note(&best_text(axes, best));
        if let Some(doubt) = doubt(arguments, options, best) {
            print_line(&format!("warning: {doubt}"));
        }
    }
}

/// Refuses a new folder with the name of a file.
fn check_folder(folder: &Path) -> Result<(), Failure> {
    let ending = folder.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !["csv", "svg", "html", "json"].contains(&ending.as_str()) || folder.exists() {
        return Ok(());
    }
    let [table, drawing, page] = FILES;
    Err(Failure::Input(format!(
        "--output {}: must be a folder, into which {table}, {drawing} and {page} are written, is named as a file",
        folder.display()
    )))
}

/// The number of points, if it can be counted.
pub(super) fn points_of(axes: &[Axis]) -> Option<usize> {
    axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.count()))
}

/// The number of points; each key must be given once.
pub(super) fn check_axes(axes: &[Axis]) -> Result<usize, Failure> {
    let count = points_of(axes)
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
    /// Runs the point at these values of the axes, unless it was done before.
    fn of(
        arguments: &SweepArguments,
        options: &Options,
        values: Vec<f64>,
        (index, rows): (usize, Option<&Rows>),
    ) -> Result<Self, Failure> {
        if let Some(found) = rows.and_then(|rows| rows.known(index)) {
            return Ok(Self { values, found, compared: None });
        }
        let scene = scene(arguments, &values)?;
        let run = if arguments.no_accuracy { run_scene } else { run_with_accuracy };
        let mut found = stopped_as_text(run(&scene, options))?;
        if let (Ok(outcome), false) = (&mut found, arguments.no_accuracy || arguments.single_start) {
            add_branches(&scene, options, outcome);
        }
        let compared = match &found {
            Ok(outcome) => compared(&scene, outcome, arguments)?,
            Err(_) => None,
        };
        let found = found.map(|outcome| fields(&outcome));
        rows.map_or(Ok(()), |rows| rows.add(index, &found))?;
        Ok(Self { values, found, compared })
    }

    /// A number of its outcome.
    fn number(&self, name: &str) -> Option<f64> {
        self.found.as_ref().ok()?.get(name)?.as_f64()
    }

    /// Whether it was run with an accuracy statement, known or not.
    fn is_stated(&self) -> bool {
        self.warnings().any(is_of_accuracy)
    }

    /// A text of its outcome.
    fn text(&self, name: &str) -> Option<&str> {
        self.found.as_ref().ok()?.get(name)?.as_str()
    }

    /// The warnings of its outcome.
    fn warnings(&self) -> impl Iterator<Item = &str> {
        let list = self.found.as_ref().ok().and_then(|fields| fields.get("warnings")?.as_array());
        list.into_iter().flatten().filter_map(|warning| warning.as_str())
    }
}

/// Which sweep it is: the build, the files that are read, and what was asked for.
fn identity(arguments: &SweepArguments) -> Result<String, Failure> {
    // The same points in another folder or format are the same sweep.
    let SweepArguments { scene, axes, storage_voltage, output: _, .. } = arguments;
    let SweepArguments { steady_state, compare, no_accuracy, single_start, .. } = arguments;
    let flags = [steady_state, compare, no_accuracy, single_start];
    let asked = (&scene.options, &scene.overrides, axes, storage_voltage, flags);
    let mut asked = format!("{asked:?}").into_bytes();
    for file in scene_file::files(&arguments.scene.scene, &arguments.scene.overrides)? {
        let content = input::read(&file, MOST_OF_DATA)
            .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", file.display())))?;
        asked.extend(content);
    }
    Ok(format!("{} {:016x}", build(), fnv_1a(&asked)))
}

/// Writes the table, and picture and page if there are any.
fn write(
    arguments: &SweepArguments,
    folder: &Path,
    outputs: &Outputs,
    points: &[Point],
) -> Result<(), Failure> {
    let [table, drawing, interactive] = FILES.map(|name| folder.join(name));
    let axes = &arguments.axes;
    let file = Name::of_file(&arguments.scene.scene).line();
    let keys: Vec<&str> = axes.iter().filter(|axis| axis.count() > 1).map(|axis| axis.key.as_str()).collect();
    let first = points.first().map_or(&[][..], |point| &point.values);
    let method = points.iter().find_map(|point| point.text("method"));
    let parameters = setting(&scene(arguments, first)?, &keys);
    let smallest = points.iter().filter_map(|point| point.number("smallest_margin"));
    let title = format!("{file}, {}: {parameters}{}", method.unwrap_or("no run"), margin(smallest));
    let is_of_a_run = |point: &Point| point.text("steady_state").is_some_and(|verdict| verdict != STABLE);
    let unstable: Vec<bool> = points.iter().map(is_of_a_run).collect();
    let words = Labels {
        title: &title,
        without: "the run failed",
        marked: (&unstable, "no stable orbit: of the run"),
    };
    let quantities = quantities(points);
    let picture = picture(words, axes, &quantities);
    make_folder(folder)?;
    outputs.keep(&table, csv(axes, points));
    for (file, picture) in [drawing, interactive].iter().zip(picture.iter().cycle()) {
        outputs.keep(file, picture.of_file(file)?);
    }
    Ok(())
}

/// The values of a point, for a sentence.
fn place(axes: &[Axis], point: &Point) -> String {
    named(axes, point).map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn none_failed(axes: &[Axis], points: &[Point]) -> Result<(), Failure> {
    let mut failed = points.iter().filter_map(|point| Some((point, point.found.as_ref().err()?)));
    let Some((point, error)) = failed.next() else { return Ok(()) };
    Err(Failure::Step(format!(
        "{} of {} points failed, the first at {}: {error}",
        1 + failed.count(),
        points.len(),
        place(axes, point),
    )))
}

/// The values of the point with the given index; the last axis runs fastest.
pub(super) fn values(axes: &[Axis], index: usize) -> Vec<f64> {
    axes.iter().zip(indices(axes, index)).map(|(axis, index)| axis.value(index)).collect()
}

/// The index on each axis of the point with the given index.
fn indices(axes: &[Axis], index: usize) -> Vec<usize> {
    let mut rest = index;
    let mut indices: Vec<usize> = axes
        .iter()
        .rev()
        .map(|axis| {
            let index = rest % axis.count();
            rest /= axis.count();
            index
        })
        .collect();
    indices.reverse();
    indices
}

fn scene(arguments: &SweepArguments, values: &[f64]) -> Result<Scene, Failure> {
    let mut overrides = arguments.scene.overrides.clone();
    let axes = arguments.axes.iter().zip(values);
    overrides.extend(axes.map(|(axis, value)| Override::new(&axis.key, &number(*value)).by("--over")));
    let mut scene = scene_file::read(&arguments.scene.scene, &overrides)?;
    arguments.storage_voltage.hold(&mut scene)?;
    Ok(scene)
}

fn named<'a>(axes: &'a [Axis], point: &'a Point) -> impl Iterator<Item = (&'a str, f64)> {
    axes.iter().map(|axis| axis.key.as_str()).zip(point.values.iter().copied())
}

/// Names and values of a point: those of its outcome, or its error.
fn row(axes: &[Axis], point: &Point) -> Fields {
    let mut row: Fields = named(axes, point).map(|(key, value)| (key.to_owned(), value.into())).collect();
    match &point.found {
        Ok(fields) => row.extend(fields.clone()),
        Err(error) => row.extend([("error".to_owned(), error.as_str().into())]),
    }
    row
}

fn rows_of(axes: &[Axis], points: &[Point]) -> crate::rows::Rows {
    crate::rows::Rows(points.iter().map(|point| row(axes, point)).collect())
}

fn csv(axes: &[Axis], points: &[Point]) -> String {
    let rows: Vec<Fields> = points.iter().map(|point| flattened(row(axes, point))).collect();
    let run = points.iter().position(|point| point.found.is_ok());
    let mut columns: Vec<String> = match run {
        Some(run) => rows[run].keys().cloned().collect(),
        None => axes.iter().map(|axis| axis.key.clone()).collect(),
    };
    columns.push("error".to_owned());
    rows_csv(&columns, &rows)
}

/// The values of each point with its power and voltage, aligned.
fn table(axes: &[Axis], points: &[Point]) -> String {
    let keys = axes.iter().map(|axis| (axis.key.as_str(), axis.key.as_str(), Digits::Exponent(5)));
    let steady = points.iter().any(|point| point.text("steady_state").is_some());
    let columns: Vec<Column<'_>> = keys
        .chain([
            ("mean_power_w", "mean_power_w", Digits::Exponent(5)),
            ("stated_error", "accuracy_total", Digits::Exponent(1)),
            ("rms_voltage_v", "rms_voltage_v", Digits::Exponent(5)),
            ("smallest_margin", "smallest_margin", Digits::Exponent(5)),
            ("steps", "steps", Digits::Six),
        ])
        .chain(steady.then_some(("steady_state", "steady_state", Digits::Six)))
        .chain(points.iter().any(|point| point.found.is_err()).then_some(("error", "error", Digits::Word)))
        .collect();
    rows_of(axes, points).table(presets::NOTHING, &columns, columns.len())
}

fn quantities(points: &[Point]) -> Vec<Quantity> {
    let quantity = |name, unit, field| Quantity {
        name,
        unit,
        values: points.iter().map(|point| point.number(field)).collect(),
    };
    vec![quantity("mean power", "W", "mean_power_w"), quantity("RMS voltage", "V", "rms_voltage_v")]
}
