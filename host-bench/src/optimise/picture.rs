//! The picture of an optimum: a curve over one key, a map over the first two.

use plotters::prelude::*;

use super::{Found, Point, Range, Request};
use crate::report::colour_bar::colour_bar;
use crate::report::label::label as label_of_key;
use crate::report::svg::{Area, BLUE, Drawn, FONT, VERMILION, extremes, range, shade, svg, tick};

const SIZE: (u32, u32) = (900, 640);
const LABEL: (&str, u32) = (FONT, 15);

/// The picture as SVG.
pub(crate) fn draw(found: &Found, request: &Request<'_>, title: &str) -> Result<String, String> {
    svg(SIZE, |area| {
        let area = area.titled(title, (FONT, 18))?;
        match &request.ranges[..] {
            [only] => curve(&area, found, request, only),
            [up, across, ..] => map(&area, found, request, [up, across]),
            [] => Ok(()),
        }
    })
}

/// The place of a value on its axis, in decades on a logarithmic one.
fn axis(range: &Range, value: f64) -> f64 {
    if range.is_logarithmic { value.log10() } else { value }
}

fn label(range: &Range, place: f64) -> String {
    tick(if range.is_logarithmic { 10f64.powf(place) } else { place })
}

fn curve(area: &Area<'_>, found: &Found, request: &Request<'_>, key: &Range) -> Drawn {
    let of = |point: &Point| Some((axis(key, key.value(point.place[0])), request.signed(point.value()?)));
    let mut points: Vec<(f64, f64)> = found.points.iter().filter_map(of).collect();
    points.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (low, high) = range(points.iter().map(|point| point.1));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(30)
        .x_label_area_size(40)
        .y_label_area_size(90)
        .build_cartesian_2d(axis(key, key.low)..axis(key, key.high), low..high)?;
    chart
        .configure_mesh()
        .x_desc(label_of_key(&key.key))
        .y_desc(request.quantity.as_str())
        .label_style(LABEL)
        .x_label_formatter(&|x| label(key, *x))
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    chart.draw_series(LineSeries::new(points.iter().copied(), BLUE.stroke_width(1)))?;
    chart.draw_series(points.iter().map(|point| Circle::new(*point, 2, BLUE.filled())))?;
    chart.draw_series(of(&found.best).map(|point| Circle::new(point, 6, VERMILION.filled())))?;
    Ok(())
}

/// The best value of each cell of the grid over the first two keys, the second running fastest; none where no point keeps the
/// constraints.
pub(super) fn grid_cells(found: &Found, request: &Request<'_>) -> Vec<Option<f64>> {
    let count = request.grid;
    let others = count.pow(u32::try_from(request.ranges.len()).unwrap_or(2) - 2);
    found.points[..count * count * others]
        .chunks_exact(others)
        .map(|points| {
            points.iter().filter_map(Point::feasible).reduce(f64::max).map(|value| request.signed(value))
        })
        .collect()
}

/// The value at a part of the way over a range, or beyond its ends.
pub(super) fn value_beyond(range: &Range, part: f64) -> f64 {
    let [low, high] = [axis(range, range.low), axis(range, range.high)];
    let place = low + part * (high - low);
    if range.is_logarithmic { 10f64.powf(place) } else { place }
}

/// The grid over two keys; with more, each cell has the best value over the others.
fn map(area: &Area<'_>, found: &Found, request: &Request<'_>, [up, across]: [&Range; 2]) -> Drawn {
    let count = request.grid;
    let cells = grid_cells(found, request);
    let (low, high) = extremes(cells.iter().flatten().copied());
    let (body, scale) = area.split_horizontally(SIZE.0.cast_signed() - 150);
    let half = 0.5 / (count - 1) as f64;
    let edge = |key: &Range, part: f64| {
        let (low, high) = (axis(key, key.low), axis(key, key.high));
        low + part * (high - low)
    };
    let span = |key: &Range| edge(key, -half)..edge(key, 1.0 + half);
    let mut chart = ChartBuilder::on(&body)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(90)
        .build_cartesian_2d(span(across), span(up))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(label_of_key(&across.key))
        .y_desc(label_of_key(&up.key))
        .label_style(LABEL)
        .x_label_formatter(&|x| label(across, *x))
        .y_label_formatter(&|y| label(up, *y))
        .draw()?;
    chart.draw_series(cells.iter().enumerate().filter_map(|(index, value)| {
        let part = |index: usize| index as f64 / (count - 1) as f64;
        let (x, y) = (part(index % count), part(index / count));
        let corners =
            [(edge(across, x - half), edge(up, y - half)), (edge(across, x + half), edge(up, y + half))];
        Some(Rectangle::new(corners, shade((*value)?, low, high).filled()))
    }))?;
    let point = (edge(across, found.best.place[1]), edge(up, found.best.place[0]));
    chart.draw_series([Circle::new(point, 7, WHITE.filled()), Circle::new(point, 5, VERMILION.filled())])?;
    colour_bar(&scale, &request.quantity, [low, high])
}
