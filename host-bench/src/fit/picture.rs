//! The picture of a fit: data and model over frequency or time, their difference below.

use plotters::style::RGBColor;

use super::result::{Curve as Column, Found};
use crate::motion::quantity;
use crate::outcome::Format;
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped};
use crate::report::plot::{self, Axis, Curve, Mark, Plot, height};
use crate::report::setting::prefix;
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION, range, together};

/// Width of the picture, height of data and model, and height of the residuals.
const WIDTH: u32 = 900;
const UPPER: u32 = 340;
const LOWER: u32 = 210;
/// Most columns drawn.
const MOST: usize = 8;
/// Most points of a curve; of more only every so many are drawn.
const POINTS: usize = 20_000;
/// Colours of groups of rows. One group alone has data in the first and the model in the second.
const COLOURS: [RGBColor; 6] = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, BLACK];

/// The picture as SVG.
pub(crate) fn draw(found: &Found, title: &str) -> Result<String, String> {
    let mut parts = Vec::new();
    let mut below = 0;
    for column in &found.curves[..found.curves.len().min(MOST)] {
        let mut upper = data(column);
        upper.title = format!("{title}: {}", upper.title);
        let mut lower = residuals(column);
        let level = lower.across.span.map(|x| (x, 0.0));
        lower.curves.insert(0, Curve::new("", BLACK, Mark::Line(1.0), level));
        for (plot, height) in [(upper, UPPER), (lower, LOWER)] {
            parts.push((0, below, plot::draw((WIDTH, height), &[plot])?));
            below += height;
        }
    }
    Ok(together((WIDTH, below.max(1)), &parts))
}

/// The picture as a page, with the numbers below.
pub(crate) fn page(found: &Found, title: &str) -> Result<String, String> {
    let mut charts = Charts::default();
    let mut body = format!("<h1>Fit of {}</h1>\n{HINT}", escaped(title));
    for column in &found.curves[..found.curves.len().min(MOST)] {
        let group = Some(column.file.as_str());
        body += &charts.place(&data(column), Look { height: 340, group });
        body += &charts.place(&residuals(column), Look { height: 190, group });
    }
    let text = super::text(found, Format::Table).map_err(|failure| failure.to_string())?;
    body += &format!("<pre>{}</pre>\n", escaped(&text));
    body += &charts.scripts();
    Ok(document(title, &body))
}

/// The name of a quantity with its unit, and the factor to it.
fn scaled(column: &str, largest: f64) -> (String, f64) {
    let (word, unit) = quantity(column);
    let (sign, factor) = prefix(largest);
    let word = word.replace("rms ", "RMS ");
    if unit.is_empty() { (word, 1.0) } else { (format!("{word} [{sign}{unit}]"), factor) }
}

fn across(column: &Column) -> Axis {
    let (low, high) = range(column.x.iter().copied());
    Axis::linear(if column.is_trace { "time [s]" } else { "frequency [Hz]" }, [low, high], 9)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|value| value.is_finite()).fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The rows of a group that are drawn, with its colours and its name.
struct Shown<'a> {
    rows: Vec<usize>,
    /// Of the data, and of the model.
    colours: [RGBColor; 2],
    name: &'a str,
}

fn shown(column: &Column) -> Vec<Shown<'_>> {
    let every = column.x.len().div_ceil(POINTS).max(1);
    let is_alone = column.groups.len() == 1;
    let of_group = |(index, group): (usize, &'_ super::lines::Group)| {
        let own = COLOURS[index % COLOURS.len()];
        (
            group.rows.iter().copied().step_by(every).collect(),
            if is_alone { [BLUE, VERMILION] } else { [own; 2] },
        )
    };
    let groups = column.groups.iter().enumerate();
    groups
        .map(|(index, group)| {
            let (rows, colours) = of_group((index, group));
            Shown { rows, colours, name: group.name.as_str() }
        })
        .collect()
}

/// `measured`, or `measured, up`.
fn named(word: &str, group: &str) -> String {
    if group.is_empty() { word.to_owned() } else { format!("{word}, {group}") }
}

/// Measured points with their standard deviations, and the model as lines.
fn data(column: &Column) -> Plot {
    let (title, factor) = scaled(&column.column, largest(column.measured.iter().copied()));
    let mut curves = Vec::new();
    for (index, Shown { rows, colours, name }) in shown(column).into_iter().enumerate() {
        let line: Vec<(f64, f64)> = match column.lines.get(index) {
            Some(line) => line.iter().map(|&(x, y)| (x, factor * y)).collect(),
            None => rows.iter().map(|&row| (column.x[row], factor * column.model[row])).collect(),
        };
        let line = Curve::new(named("model", name), colours[1], Mark::Line(1.2), line);
        curves.push(if column.is_trace { line } else { line.broken_at_jumps() });
        let points = rows.iter().map(|&row| (column.x[row], factor * column.measured[row]));
        let dots = Curve::new(named("measured", name), colours[0], Mark::Dots(5.0), points);
        curves.push(dots.with_bars(bars(column, &rows, factor)));
    }
    let up = Axis::linear(title, height(&curves), 6);
    Plot { title: column.file.clone(), across: across(column), up, curves }
}

/// The standard deviations of some rows; none where the column has none.
fn bars(column: &Column, rows: &[usize], factor: f64) -> Vec<f64> {
    column.std.iter().flat_map(|std| rows.iter().map(|&row| factor * std[row])).collect()
}

fn residuals(column: &Column) -> Plot {
    let difference = |row: usize| column.measured[row] - column.model[row];
    let deviation = |row: usize| column.std.as_ref().map_or(0.0, |std| std[row]);
    let most = largest((0..column.x.len()).map(|row| difference(row).abs() + deviation(row)));
    let (title, factor) = scaled(&column.column, most);
    let unit = title.find('[').map_or("", |at| &title[at..]);
    let curves = shown(column).into_iter().map(|Shown { rows, colours, name }| {
        let points = rows.iter().map(|&row| (column.x[row], factor * difference(row)));
        let dots = Curve::new(name, colours[0], Mark::Dots(5.0), points);
        dots.with_bars(bars(column, &rows, factor))
    });
    let end = if most > 0.0 { 1.1 * factor * most } else { 1.0 };
    Plot {
        title: String::new(),
        across: across(column),
        up: Axis::linear(format!("data − model {unit}").trim().to_owned(), [-end, end], 4),
        curves: curves.collect(),
    }
}
