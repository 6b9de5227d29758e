//! `sweep`: a scene over a grid of values, on all cores.

mod axis;
mod messages;
pub(super) mod picture;
pub(super) mod points;
mod rows;

use comfy_table::presets;
use serde_json::json;

pub(super) use self::axis::Axis;
pub(super) use self::messages::warnings;
use self::messages::{best, best_text, doubt, refined_text};
use self::picture::{Labels, Quantity, picture};
use self::points::{Point, PointArguments, Points, csv};
use super::{Watch, is_quiet, note, warn};
use crate::method::Failure;
use crate::outcome::{Format, folded};
use crate::report::Picture;
use crate::rows::{Column, Digits};

/// Most points of a grid.
const MOST: usize = 1_000_000;

#[derive(Debug, Clone, clap::Args)]
pub struct SweepArguments {
    #[command(flatten)]
    points: PointArguments,
    /// Values for a key of the scene; repeat it for a grid
    #[arg(long = "over", value_name = "KEY=FROM:TO:COUNT[:log]", required = true)]
    axes: Vec<Axis>,
    /// Make the runs as well, and print on standard error how much longer they take
    #[arg(long, requires = "steady_state", conflicts_with_all = ["part", "merge"])]
    compare: bool,
}

/// Runs the grid, writes the files and prints the points.
///
/// Bad input at any point refuses the whole sweep before it begins. A point that fails on its way is a row with its
/// error; the other points are written and printed all the same.
pub(super) fn run(
    SweepArguments { points: arguments, axes, compare }: &SweepArguments,
) -> Result<(), Failure> {
    let points = points(arguments, axes, *compare)?;
    let Some(done) = points.run(&[])? else { return Ok(()) };
    let found = &done.points;
    if let Some(costs) = messages::costs(found.iter().filter_map(|point| point.compared.as_ref())) {
        note(&costs);
    }
    warnings(found).for_each(|warning| warn(&warning));
    if let (Format::Table, false, Some(best)) = (arguments.scene.format, is_quiet(), best(found)) {
        note(&best_text(found, best));
        doubt(axes, &points, found, best).iter().for_each(|doubt| warn(doubt));
    }
    let picture = match arguments.output {
        Some(_) => picture_of(axes, &points, found)?,
        None => None,
    };
    let text = match arguments.scene.format {
        Format::Table => table(found),
        Format::Json => format!("{:#}\n", json!(rows_of(found).0)),
        Format::Csv => csv(found),
    };
    points.end(done, picture.as_ref(), &text)
}

/// The number of points; each key must be given once.
pub(super) fn check_axes(axes: &[Axis]) -> Result<usize, Failure> {
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

/// The picture of a sweep over one key, with its best point and its warnings as the text.
pub(super) fn drawn(arguments: &PointArguments, axis: Axis) -> Result<Picture, Failure> {
    let axes = &[axis];
    let points = points(arguments, axes, false)?;
    let none = || Failure::Input("no point could be run to its end".to_owned());
    let found = points.run(&[])?.ok_or_else(none)?.points;
    // The runs that judge the best point.
    let watch = Watch::new();
    let best = best(&found);
    let doubt = best.and_then(|best| doubt(axes, &points, &found, best)).into_iter();
    let warnings = warnings(&found).chain(doubt).map(|warning| format!("warning: {warning}"));
    let best = best.map(|best| refined_text(&axes[0], &points, &found, best)).into_iter();
    let lines: Vec<String> = best.chain(warnings).map(|line| folded(&line, 2)).collect();
    drop(watch);
    Ok(Picture { text: lines.join("\n"), ..picture_of(axes, &points, &found)?.ok_or_else(none)? })
}

fn points<'a>(arguments: &'a PointArguments, axes: &'a [Axis], compare: bool) -> Result<Points<'a>, Failure> {
    Ok(Points {
        arguments,
        command: "sweep",
        keys: axes.iter().map(|axis| ("--over", axis.key.as_str())).collect(),
        count: check_axes(axes)?,
        values: Box::new(|index| values(axes, index)),
        asked: format!("{axes:?}"),
        compare,
    })
}

fn picture_of(axes: &[Axis], points: &Points<'_>, found: &[Point]) -> Result<Option<Picture>, Failure> {
    let keys: Vec<&str> = axes.iter().filter(|axis| axis.count() > 1).map(|axis| axis.key.as_str()).collect();
    let title = points.title(found, &keys)?;
    let unstable: Vec<bool> = found.iter().map(Point::is_of_a_run).collect();
    let words = Labels {
        title: &title,
        without: "the run failed",
        marked: (&unstable, "no stable orbit: of the run"),
    };
    Ok(picture(words, axes, &quantities(found)))
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

fn rows_of(points: &[Point]) -> crate::rows::Rows {
    crate::rows::Rows(points.iter().map(Point::row).collect())
}

/// The values of each point with its power and its voltage, or with what its node did, aligned.
fn table(points: &[Point]) -> String {
    let keys = points.iter().take(1).flat_map(|point| &point.values);
    let keys = keys.map(|(key, _)| (key.as_str(), key.as_str(), Digits::Exponent(5)));
    let steady = points.iter().any(|point| point.text("steady_state").is_some());
    let of_run = [
        ("rms_voltage_v", "rms_voltage_v", Digits::Exponent(5)),
        ("smallest_margin", "smallest_margin", Digits::Exponent(5)),
        ("steps", "steps", Digits::Six),
    ];
    let of_node = [
        ("runs", "node_runs", Digits::Six),
        ("lockouts", "node_lockouts", Digits::Six),
        ("lowest_voltage_v", "node_lowest_voltage_v", Digits::Exponent(5)),
    ];
    let has_node = points.iter().any(|point| point.number("node_runs").is_some());
    let columns: Vec<Column<'_>> = keys
        .chain([
            ("mean_power_w", "mean_power_w", Digits::Exponent(5)),
            ("stated_error", "accuracy_total", Digits::Exponent(1)),
        ])
        .chain(if has_node { of_node } else { of_run })
        .chain(steady.then_some(("steady_state", "steady_state", Digits::Six)))
        .chain(points.iter().any(|point| point.found.is_err()).then_some(("error", "error", Digits::Word)))
        .collect();
    rows_of(points).table(presets::NOTHING, &columns, columns.len())
}

/// What is drawn: of the harvester and of the node, without what is the same at all points, unless all of it is.
fn quantities(points: &[Point]) -> Vec<Quantity> {
    let quantity = |(name, unit, field)| Quantity {
        name,
        unit,
        values: points.iter().map(|point| point.number(field)).collect(),
    };
    let of_run = [("mean power", "W", "mean_power_w"), ("RMS voltage", "V", "rms_voltage_v")].map(quantity);
    let of_node = [
        ("runs of the node", "", "node_runs"),
        ("lock-outs of the node", "", "node_lockouts"),
        ("lowest voltage of the storage", "V", "node_lowest_voltage_v"),
    ];
    let of_node = of_node.map(quantity).into_iter().filter(|node| node.values.iter().any(Option::is_some));
    let all: Vec<Quantity> = of_run.into_iter().chain(of_node).collect();
    let changes = |one: &&Quantity| one.values.iter().any(|value| *value != one.values[0]);
    let changed: Vec<Quantity> = all.iter().filter(changes).cloned().collect();
    if changed.is_empty() { all } else { changed }
}
