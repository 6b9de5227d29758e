//! The picture of a fit: data and model over frequency or time, their difference below.

use plotters::prelude::*;

use super::result::{Curve, Found};
use crate::report::svg::{Area, BLUE, Drawn, FONT, VERMILION, range, svg, tick};

/// Width of the picture, and height of the part of one measured column.
const WIDTH: u32 = 900;
const HEIGHT: u32 = 420;
/// Height of the residuals in it.
const RESIDUALS: u32 = 140;
/// Most columns drawn.
const MOST: usize = 8;
/// Most points of a curve.
const POINTS: usize = 2000;
const LABEL: (&str, u32) = (FONT, 14);

/// The picture as SVG.
pub(crate) fn draw(found: &Found, title: &str) -> Result<String, String> {
    let curves = &found.curves[..found.curves.len().min(MOST)];
    let height = HEIGHT * u32::try_from(curves.len()).unwrap_or(1).max(1) + 40;
    svg((WIDTH, height), |area| {
        let area = area.titled(title, (FONT, 18))?;
        let parts = area.split_evenly((curves.len(), 1));
        parts.iter().zip(curves).try_for_each(|(part, curve)| one(part, curve))
    })
}

fn one(area: &Area<'_>, curve: &Curve) -> Drawn {
    let height = area.dim_in_pixel().1;
    let (upper, lower) = area.split_vertically(height.saturating_sub(RESIDUALS).cast_signed());
    let every = curve.x.len().div_ceil(POINTS);
    let mut rows: Vec<usize> = (0..curve.x.len()).step_by(every.max(1)).collect();
    rows.sort_by(|&one, &other| curve.x[one].total_cmp(&curve.x[other]));
    let (left, right) = range(curve.x.iter().copied());
    let (low, high) = range(curve.measured.iter().chain(&curve.model).copied());
    let mut chart = ChartBuilder::on(&upper)
        .caption(format!("{}: points as measured, line of the model", curve.file), (FONT, 14))
        .margin(8)
        .margin_right(30)
        .x_label_area_size(4)
        .y_label_area_size(90)
        .build_cartesian_2d(left..right, low..high)?;
    chart
        .configure_mesh()
        .y_desc(curve.column.as_str())
        .label_style(LABEL)
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    let points = rows.iter().map(|&row| (curve.x[row], curve.measured[row]));
    if let Some(std) = &curve.std {
        chart.draw_series(rows.iter().map(|&row| {
            let (x, y) = (curve.x[row], curve.measured[row]);
            PathElement::new(vec![(x, y - std[row]), (x, y + std[row])], BLUE)
        }))?;
    }
    chart.draw_series(points.map(|point| Circle::new(point, 2, BLUE.filled())))?;
    let model: Vec<(f64, f64)> = rows.iter().map(|&row| (curve.x[row], curve.model[row])).collect();
    let is_single = model.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if is_single || curve.is_trace {
        chart.draw_series(LineSeries::new(model, VERMILION.stroke_width(1)))?;
    } else {
        // Several amplitudes, loads or directions at one frequency are no one line.
        chart.draw_series(model.into_iter().map(|point| Cross::new(point, 4, VERMILION)))?;
    }
    residuals(&lower, curve, &rows, [left, right])
}

fn residuals(area: &Area<'_>, curve: &Curve, rows: &[usize], [left, right]: [f64; 2]) -> Drawn {
    let points: Vec<(f64, f64)> =
        rows.iter().map(|&row| (curve.x[row], curve.measured[row] - curve.model[row])).collect();
    let largest = points.iter().fold(f64::MIN_POSITIVE, |largest, point| largest.max(point.1.abs())) * 1.1;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(30)
        .x_label_area_size(36)
        .y_label_area_size(90)
        .build_cartesian_2d(left..right, -largest..largest)?;
    let x = if curve.is_trace { "time [s]" } else { "frequency [Hz]" };
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc("data − model")
        .y_labels(5)
        .label_style(LABEL)
        .x_label_formatter(&|x| tick(*x))
        // A tick at 0 may have a rounding.
        .y_label_formatter(&|y| tick(if y.abs() < 1e-9 * largest { 0.0 } else { *y }))
        .draw()?;
    chart.draw_series(points.into_iter().map(|point| Circle::new(point, 2, BLUE.filled())))?;
    chart.draw_series(LineSeries::new([(left, 0.0), (right, 0.0)], BLACK.stroke_width(1)))?;
    Ok(())
}
