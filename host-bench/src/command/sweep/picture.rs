//! The picture of a sweep: curves over one axis, a map over two.

use plotters::prelude::*;

use super::axis::Axis;
use crate::report::svg::{Area, Drawn, FONT, extremes, range, shade, svg, tick};

/// Width and height of the picture.
const SIZE: (u32, u32) = (900, 640);

/// Font of the axes: whatever the viewer has for it.
const LABEL: (&str, u32) = (FONT, 15);

/// A quantity to draw: its name and one value for each point, if there is one.
#[derive(Debug, Clone)]
pub(in crate::command) struct Quantity {
    pub(in crate::command) name: &'static str,
    pub(in crate::command) values: Vec<Option<f64>>,
}

/// An SVG picture; `None` without values, without an axis of several values, or with more than two.
pub(in crate::command) fn draw(
    title: &str,
    axes: &[Axis],
    quantities: &[Quantity],
) -> Result<Option<String>, String> {
    let shown: Vec<&Quantity> = quantities
        .iter()
        .filter(|quantity| quantity.values.iter().flatten().any(|value| value.is_finite()))
        .collect();
    let long: Vec<&Axis> = axes.iter().filter(|axis| axis.count() > 1).collect();
    if shown.is_empty() || !(1..=2).contains(&long.len()) {
        return Ok(None);
    }
    let picture = svg(SIZE, |area| {
        let area = area.titled(title, (FONT, 18))?;
        match (&long[..], &shown[..]) {
            // The last axis runs fastest.
            ([across, up], [quantity, ..]) => map(&area, up, across, quantity),
            ([axis, ..], _) => area
                .split_evenly((shown.len(), 1))
                .iter()
                .zip(&shown)
                .try_for_each(|(part, quantity)| curve(part, axis, quantity)),
            _ => Ok(()),
        }
    });
    picture.map(Some)
}

/// The place of a value on its axis, in decades on a logarithmic one.
fn place(axis: &Axis, value: f64) -> f64 {
    if axis.logarithmic { value.log10() } else { value }
}

fn label(axis: &Axis, place: f64) -> String {
    tick(if axis.logarithmic { 10f64.powf(place) } else { place })
}

fn curve(area: &Area<'_>, axis: &Axis, quantity: &Quantity) -> Drawn {
    let points: Vec<(f64, f64)> = quantity
        .values
        .iter()
        .enumerate()
        .filter_map(|(index, value)| Some((place(axis, axis.value(index)), (*value)?)))
        .filter(|(_, value)| value.is_finite())
        .collect();
    let (left, right) = range((0..axis.count()).map(|index| place(axis, axis.value(index))));
    let (low, high) = range(points.iter().map(|(_, value)| *value));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(30)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(left..right, low..high)?;
    chart
        .configure_mesh()
        .x_desc(axis.key.as_str())
        .y_desc(quantity.name)
        .label_style(LABEL)
        .x_label_formatter(&|x| label(axis, *x))
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    chart.draw_series(LineSeries::new(points.iter().copied(), BLUE.stroke_width(2)))?;
    chart.draw_series(points.iter().map(|point| Circle::new(*point, 3, BLUE.filled())))?;
    Ok(())
}

/// Edges of the cell around the point with the given index.
fn cell(axis: &Axis, index: usize) -> (f64, f64) {
    let at = |index: usize| place(axis, axis.value(index));
    let middle = |left: usize, right: usize| 0.5 * (at(left) + at(right));
    let last = axis.count() - 1;
    let low = if index == 0 { 2.0 * at(0) - middle(0, 1) } else { middle(index - 1, index) };
    let high = if index == last { 2.0 * at(last) - middle(last - 1, last) } else { middle(index, index + 1) };
    (low, high)
}

fn map(area: &Area<'_>, across: &Axis, up: &Axis, quantity: &Quantity) -> Drawn {
    let values = quantity.values.iter().flatten().copied();
    let (low, high) = extremes(values.filter(|value| value.is_finite()));
    let (body, scale) = area.split_horizontally(i32::try_from(SIZE.0).unwrap_or(0) - 130);
    let span = |axis: &Axis| cell(axis, 0).0..cell(axis, axis.count() - 1).1;
    let mut chart = ChartBuilder::on(&body)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(span(across), span(up))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(across.key.as_str())
        .y_desc(up.key.as_str())
        .label_style(LABEL)
        .x_label_formatter(&|x| label(across, *x))
        .y_label_formatter(&|y| label(up, *y))
        .draw()?;
    chart.draw_series(quantity.values.iter().enumerate().filter_map(|(index, value)| {
        let value = value.filter(|value| value.is_finite())?;
        let (left, right) = cell(across, index % across.count());
        let (bottom, top) = cell(up, index / across.count());
        Some(Rectangle::new([(left, bottom), (right, top)], shade(value, low, high).filled()))
    }))?;
    let (bottom, top) = range(std::iter::once(low).chain(std::iter::once(high)));
    let mut bar = ChartBuilder::on(&scale)
        .margin(10)
        .margin_bottom(50)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..1.0, bottom..top)?;
    bar.configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .label_style(LABEL)
        .y_desc(quantity.name)
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    const SHADES: usize = 64;
    bar.draw_series((0..SHADES).map(|index| {
        let edge = |index: usize| bottom + (top - bottom) * index as f64 / SHADES as f64;
        let colour = shade(0.5 * (edge(index) + edge(index + 1)), low, high);
        Rectangle::new([(0.0, edge(index)), (1.0, edge(index + 1))], colour.filled())
    }))?;
    Ok(())
}
