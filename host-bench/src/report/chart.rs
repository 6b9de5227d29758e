//! Error against run time as a picture.

use plotters::prelude::*;

use super::plot::{Axis, Curve, Mark, Plot};
use super::svg::{self, Area, Drawn, FONT, power_of_ten, svg};
use crate::method::{Math, Precision};
use crate::work_precision::table::resistance;
use crate::work_precision::triboelectric::method_name;
use crate::work_precision::{Comparison, Variant};

/// Width and height of the picture.
const SIZE: (u32, u32) = (980, 520);
/// Width of the legend at the right.
const LEGEND: i32 = 250;
/// Titles of the axes.
const TITLES: [&str; 2] = ["host time per simulated second [µs]", "relative error of mean power"];

struct Series {
    name: String,
    colour: RGBColor,
    dashed: bool,
    /// Host µs per simulated second, error of mean power.
    points: Vec<(f64, f64)>,
    /// The step or tolerance of each.
    notes: Vec<String>,
}

/// The picture as SVG text.
pub(super) fn draw(comparison: &Comparison) -> Result<String, String> {
    let series = series(comparison);
    svg(SIZE, |area| {
        let (left, right) = area.split_horizontally(i32::try_from(SIZE.0).unwrap_or(0) - LEGEND);
        curves(&left, &series, comparison)?;
        legend(&right, &series)
    })
}

/// The same as a plot for a page.
pub(super) fn plot(comparison: &Comparison) -> Plot {
    let series = series(comparison);
    let all = || series.iter().flat_map(|series| &series.points);
    let (left, right) = decades(all().map(|point| point.0));
    let (low, high) = decades(all().map(|point| point.1));
    let curves = series.iter().flat_map(|series| {
        let [line, dots] = match series.dashed {
            true => [Mark::Dashes(2.0), Mark::Rings(8.0)],
            false => [Mark::Line(2.0), Mark::Dots(8.0)],
        };
        let curve = |name: &str, mark| Curve::new(name, series.colour, mark, series.points.iter().copied());
        [curve(&series.name, line).with_notes(series.notes.clone()), curve("", dots)]
    });
    Plot {
        title: title(comparison),
        across: Axis::logarithmic(TITLES[0], [left, right]),
        up: Axis::logarithmic(TITLES[1], [low, high]),
        curves: curves.collect(),
    }
}

fn title(comparison: &Comparison) -> String {
    format!("{}, R = {}", comparison.file(), resistance(comparison.scene.load.resistance_ohm()))
}

/// The curves: one for each method and precision. Rows with other elementary functions than the polynomials, and rows with
/// an error above 1, are in the table only.
fn series(comparison: &Comparison) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for row in &comparison.rows {
        let Some(found) = &row.found else { continue };
        let Some(error) = comparison.error(row) else { continue };
        if error > 1.0 || row.variant.math.is_some_and(|math| math != Math::Polynomial) {
            continue;
        }
        let name = name(&row.variant);
        let place = series.iter().position(|series| series.name == name).unwrap_or_else(|| {
            series.push(Series {
                name,
                colour: colour(method_name(&row.variant)),
                dashed: row.variant.precision == Precision::F32,
                points: Vec::new(),
                notes: Vec::new(),
            });
            series.len() - 1
        });
        // In the order of their times.
        let Series { points, notes, .. } = &mut series[place];
        let time = found.ns_per_s / 1e3;
        let at = points.partition_point(|point| point.0 <= time);
        points.insert(at, (time, error.max(1e-16)));
        notes.insert(at, format!("step or tolerance: {}", row.variant.control));
    }
    series
}

fn name(variant: &Variant) -> String {
    format!("{}, {}", method_name(variant), variant.precision.name())
}

fn colour(method: &str) -> RGBColor {
    match method {
        "exponential Radau" => svg::BLACK,
        "exponential Radau, fixed step" => svg::PURPLE,
        "TR-BDF2" => svg::BLUE,
        "TR-BDF2, fixed step" => svg::ORANGE,
        "RK4, fixed step" => svg::VERMILION,
        _ => svg::GREEN,
    }
}

/// The whole decades that hold the values.
fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = svg::extremes(values);
    if !(high > 0.0) {
        return (0.97e-1, 1.03);
    }
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    // A little wider than the decades, so that both ends have ticks.
    (0.97 * 10f64.powf(low), 1.03 * 10f64.powf(if high > low { high } else { low + 1.0 }))
}

fn curves(area: &Area<'_>, series: &[Series], comparison: &Comparison) -> Drawn {
    let all = || series.iter().flat_map(|series| series.points.iter().copied());
    let (left, right) = decades(all().map(|point| point.0));
    let (low, high) = decades(all().map(|point| point.1));
    let mut chart = ChartBuilder::on(area)
        .caption(title(comparison), (FONT, 18))
        .margin(12)
        .x_label_area_size(52)
        .y_label_area_size(78)
        .build_cartesian_2d((left..right).log_scale(), (low..high).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(TITLES[0])
        .y_desc(TITLES[1])
        .x_labels(8)
        .y_labels(10)
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 16))
        .bold_line_style(RGBColor(205, 210, 216))
        .light_line_style(RGBColor(240, 242, 244))
        .x_label_formatter(&|x| power_of_ten(x.log10()))
        .y_label_formatter(&|y| power_of_ten(y.log10()))
        .draw()?;
    for series in series {
        let points = series.points.iter().copied();
        if series.dashed {
            chart.draw_series(DashedLineSeries::new(points, 6, 4, series.colour.stroke_width(2)))?;
        } else {
            chart.draw_series(LineSeries::new(points, series.colour.stroke_width(2)))?;
        }
        let fill = if series.dashed { WHITE.filled() } else { series.colour.filled() };
        chart.draw_series(series.points.iter().map(|point| Circle::new(*point, 4, fill)))?;
        chart.draw_series(
            series.points.iter().map(|point| Circle::new(*point, 4, series.colour.stroke_width(2))),
        )?;
    }
    Ok(())
}

fn legend(area: &Area<'_>, series: &[Series]) -> Drawn {
    let mut height = 60;
    for series in series {
        let line = |from: i32, to: i32| {
            PathElement::new(vec![(from, height), (to, height)], series.colour.stroke_width(2))
        };
        if series.dashed {
            area.draw(&line(4, 12))?;
            area.draw(&line(24, 32))?;
        } else {
            area.draw(&line(4, 32))?;
        }
        let fill = if series.dashed { WHITE.filled() } else { series.colour.filled() };
        area.draw(&Circle::new((18, height), 4, fill))?;
        area.draw(&Circle::new((18, height), 4, series.colour.stroke_width(2)))?;
        area.draw(&Text::new(series.name.clone(), (40, height - 8), (FONT, 15).into_font()))?;
        height += 26;
    }
    Ok(())
}
