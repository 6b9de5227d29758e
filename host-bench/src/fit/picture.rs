//! The picture of a fit: data and model over frequency or time, their difference below.

use plotters::style::RGBColor;

use super::result::{Curve as Column, FitResult};
use crate::method::Failure;
use crate::outcome::Format;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::setting::{number_and_unit, scaled};
use crate::report::svg::{BLACK, BLUE, COLOURS, VERMILION, range};

/// Most columns drawn.
const MOST: usize = 8;
/// Most points of a curve; of more only every so many are drawn.
const POINTS: usize = 20_000;

/// The picture with the numbers below.
pub(crate) fn picture(found: &FitResult, title: &str) -> Result<Picture, Failure> {
    let columns = &found.curves[..found.curves.len().min(MOST)];
    // A file is named once, above its first column.
    let is_first = |at: usize| at == 0 || columns[at - 1].file != columns[at].file;
    let charts = columns.iter().enumerate();
    let charts = charts.flat_map(|(at, column)| [data(column, is_first(at)), residuals(column)]).collect();
    Ok(Picture {
        title: format!("Fit of {title}"),
        width: 900,
        charts,
        text: super::text(found, Format::Table)?,
        ..Picture::default()
    })
}

/// The name of a quantity with its unit, and the factor to it.
fn named_unit(column: &str, values: impl Iterator<Item = f64>) -> (String, f64) {
    let (word, unit) = number_and_unit(column);
    scaled(&word.replace("rms ", "RMS "), unit, values)
}

fn across(column: &Column) -> Axis {
    let (low, high) = range(column.x.iter().copied());
    Axis::linear(if column.is_trace { "time [s]" } else { "frequency [Hz]" }, [low, high], 9)
}

/// The rows of a group that are drawn, with its colours and its name.
struct Shown<'a> {
    rows: Vec<usize>,
    /// Of the data, and of the model.
    colours: [RGBColor; 2],
    name: &'a str,
}

/// One group alone has data in the first colour and the model in the second.
fn shown(column: &Column) -> impl Iterator<Item = Shown<'_>> {
    let every = column.x.len().div_ceil(POINTS).max(1);
    let is_alone = column.groups.len() == 1;
    column.groups.iter().zip(COLOURS.into_iter().cycle()).map(move |(group, own)| Shown {
        rows: group.rows.iter().copied().step_by(every).collect(),
        colours: if is_alone { [BLUE, VERMILION] } else { [own; 2] },
        name: group.name.as_str(),
    })
}

/// `measured`, or `measured, up`.
fn named(word: &str, group: &str) -> String {
    if group.is_empty() { word.to_owned() } else { format!("{word}, {group}") }
}

/// Measured points with their standard deviations, and the model as lines.
fn data(column: &Column, is_first: bool) -> Chart {
    let (title, factor) = named_unit(&column.column, column.measured.iter().copied());
    let mut curves = Vec::new();
    for (index, Shown { rows, colours, name }) in shown(column).enumerate() {
        let line: Vec<(f64, f64)> = match column.lines.get(index) {
            Some(line) => line.iter().map(|&(x, y)| (x, factor * y)).collect(),
            None => rows.iter().map(|&row| (column.x[row], factor * column.model[row])).collect(),
        };
        let line = Curve::new(named("model", name), colours[1], Mark::line(index, 1.2), line);
        curves.push(if column.is_trace { line } else { line.broken_at_jumps() });
        let points = rows.iter().map(|&row| (column.x[row], factor * column.measured[row]));
        let dots = Curve::new(named("measured", name), colours[0], Mark::point(index, 5.0), points);
        curves.push(Curve { bars: bars(column, &rows, factor), ..dots });
    }
    let word = title.split(" [").next().unwrap_or_default();
    let title_of_chart = if is_first { format!("{}: {word}", column.file) } else { word.to_owned() };
    let up = Axis::linear(title.as_str(), FITTING, 6);
    Chart::new(title_of_chart, across(column), up, curves).grouped(&column.file, 340)
}

/// The standard deviations of some rows; none where the column has none.
fn bars(column: &Column, rows: &[usize], factor: f64) -> Vec<f64> {
    column.std.iter().flat_map(|std| rows.iter().map(|&row| factor * std[row])).collect()
}

fn residuals(column: &Column) -> Chart {
    let difference = |row: usize| column.measured[row] - column.model[row];
    let deviation = |row: usize| column.std.as_ref().map_or(0.0, |std| std[row]);
    let beyond = (0..column.x.len()).map(|row| difference(row).abs() + deviation(row));
    let most = beyond.filter(|beyond| beyond.is_finite()).fold(0.0, f64::max);
    let (title, factor) = named_unit(&column.column, [most].into_iter());
    let unit = title.find('[').map_or("", |at| &title[at..]);
    let across = across(column);
    let level = Curve::new("", BLACK, Mark::line(0, 1.0), across.span.map(|x| (x, 0.0)));
    let dots = shown(column).enumerate().map(|(index, Shown { rows, colours, name })| {
        let points = rows.iter().map(|&row| (column.x[row], factor * difference(row)));
        let dots = Curve::new(name, colours[0], Mark::point(index, 5.0), points);
        Curve { bars: bars(column, &rows, factor), ..dots }
    });
    let end = if most > 0.0 { 1.1 * factor * most } else { 1.0 };
    let up = Axis::linear(format!("data − model {unit}").trim(), [-end, end], 4);
    Chart::new("", across, up, std::iter::once(level).chain(dots).collect()).grouped(&column.file, 210)
}
