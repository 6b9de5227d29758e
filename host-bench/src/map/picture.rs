//! The picture of a map: its values, its boundaries, and the places that check it.

use plotters::prelude::*;

use super::axes::amplitude_of;
use super::{Map, Place};
use crate::method::Failure;
use crate::report::svg::{
    Area, Drawn, FONT, Ticked, VERMILION, extremes, logarithmic_label, logarithmic_ticks, shade, svg,
};

/// Width and height.
const SIZE: (u32, u32) = (900, 640);
const LABEL: (&str, u32) = (FONT, 15);
/// Cells of the picture over frequency and over amplitude.
const CELLS: [usize; 2] = [128, 48];

/// The picture of one slice.
pub fn draw(map: &Map, slice: usize, title: &str) -> Result<String, Failure> {
    let told = map.image.map()?;
    let unit = if told.is_current() { "charge per second [A]" } else { "mean power [W]" };
    let [low, high] = map.axes.amplitudes.map(f64::log10);
    let [across, up] = CELLS;
    let edge = |index: usize, count: usize| index as f64 / count as f64;
    let value = |column: usize, row: usize| {
        let frequency = map.axes.frequency(edge(2 * column + 1, 2 * across)) as f32;
        let amplitude = 10f64.powf(low + (high - low) * edge(2 * row + 1, 2 * up)) as f32;
        told.in_slice_at(slice, amplitude, frequency).income().map(|income| f64::from(income.value))
    };
    let values: Vec<Option<f64>> = (0..across * up)
        .map(|index| value(index % across, index / across).filter(|value| *value > 0.0).map(f64::log10))
        .collect();
    let (least, most) = extremes(values.iter().flatten().copied());
    let title = match told.is_current() {
        true => format!("{title}, storage at {:.2} V", told.voltage(slice)),
        false => title.to_owned(),
    };
    let picture = svg(SIZE, |area| {
        let mut area = area.titled(&title, (FONT, 18))?;
        for line in legend(map, slice, values.iter().any(Option::is_none)) {
            area = area.titled(&line, LABEL)?;
        }
        let (body, scale) = area.split_horizontally(SIZE.0.cast_signed() - 130);
        field(&body, map, slice, &values, [least, most])?;
        bar(&scale, unit, [least, most])
    });
    picture.map_err(Failure::Input)
}

/// What lines, dots and white of a picture are.
fn legend(map: &Map, slice: usize, has_white: bool) -> Vec<String> {
    let mut lines = Vec::new();
    if map.slices[slice].iter().any(|column| column.found) {
        lines.push(
            "line: the lower motion ends as the amplitude rises; dashes: the upper one as it falls"
                .to_owned(),
        );
    }
    let mut checked = map.checked.iter().filter(|judged| judged.place.slice == slice);
    let dots = if checked.clone().any(|judged| !judged.holds) {
        "small white dots: checked, the bounds hold; red: they do not"
    } else {
        "small white dots: checked, the bounds hold"
    };
    let dots = checked.next().map(|_| dots);
    let white = has_white.then_some("white: the map has no income");
    let rest: Vec<&str> = white.into_iter().chain(dots).collect();
    if !rest.is_empty() {
        lines.push(rest.join("; "));
    }
    lines
}

/// The largest income of the map on the cells of its picture: slice, frequency in Hz, amplitude in m/s², and the income.
pub fn best(map: &Map) -> Result<Option<(usize, f64, f64, f64)>, Failure> {
    let told = map.image.map()?;
    let [low, high] = map.axes.amplitudes.map(f64::log10);
    let [across, up] = CELLS;
    let part = |index: usize, count: usize| index as f64 / (count - 1) as f64;
    let cells = (0..map.slices.len() * across * up).filter_map(|index| {
        let (slice, cell) = (index / (across * up), index % (across * up));
        let frequency = map.axes.frequency(part(cell % across, across));
        let amplitude = 10f64.powf(low + (high - low) * part(cell / across, up));
        let income = told.in_slice_at(slice, amplitude as f32, frequency as f32).income()?;
        Some((slice, frequency, amplitude, f64::from(income.value)))
    });
    Ok(cells.max_by(|one, other| one.3.total_cmp(&other.3)))
}

fn field(area: &Area<'_>, map: &Map, slice: usize, values: &[Option<f64>], ends: [f64; 2]) -> Drawn {
    let axes = &map.axes;
    let [low, high] = axes.amplitudes.map(f64::log10);
    let [across, up] = CELLS;
    let rows = logarithmic_ticks(low, high, 8);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(0.0..1.0, Ticked::new([low, high], &rows))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(8)
        .x_desc("frequency [Hz], at even distances of its detuning")
        .y_desc("amplitude [m/s²]")
        .label_style(LABEL)
        .x_label_formatter(&|part: &f64| format!("{:.2}", axes.frequency(part.clamp(0.0, 1.0))))
        .y_label_formatter(&|place: &f64| logarithmic_label(*place, &rows))
        .draw()?;
    chart.draw_series(values.iter().enumerate().filter_map(|(index, value)| {
        let [column, row] = [index % across, index / across].map(|index| index as f64);
        let step = (high - low) / up as f64;
        let corners = [
            (column / across as f64, low + row * step),
            ((column + 1.0) / across as f64, low + (row + 1.0) * step),
        ];
        Some(Rectangle::new(corners, shade((*value)?, ends[0], ends[1]).filled()))
    }))?;
    let columns = &map.slices[slice];
    let place = |index: usize, level: f64| {
        let amplitude = amplitude_of(level).log10().clamp(low, high);
        (index as f64 / (columns.len() - 1) as f64, amplitude)
    };
    if columns.iter().any(|column| column.found) {
        let rising = columns.iter().enumerate().map(|(index, column)| place(index, column.rising));
        chart.draw_series(LineSeries::new(rising, WHITE.stroke_width(2)))?;
        let falling = columns.iter().enumerate().map(|(index, column)| place(index, column.falling));
        chart.draw_series(DashedLineSeries::new(falling, 6, 4, WHITE.stroke_width(2)))?;
    }
    let of_slice = map.checked.iter().filter(|judged| judged.place.slice == slice);
    chart.draw_series(of_slice.map(|judged| {
        let Place { frequency_hz, amplitude, .. } = judged.place;
        let (below, part) = axes.column(frequency_hz);
        let x = (below as f64 + part) / (axes.frequencies.len() - 1) as f64;
        let colour = if judged.holds { WHITE } else { VERMILION };
        Circle::new((x, amplitude.log10()), if judged.holds { 1 } else { 3 }, colour.filled())
    }))?;
    Ok(())
}

/// The scale of the colours.
fn bar(area: &Area<'_>, unit: &str, [least, most]: [f64; 2]) -> Drawn {
    const SHADES: usize = 64;
    let most = most.max(least + 1e-6);
    let ticks = logarithmic_ticks(least, most, 10);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_bottom(50)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..1.0, Ticked::new([least, most], &ticks))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .label_style(LABEL)
        .y_desc(unit)
        .y_label_formatter(&|place: &f64| logarithmic_label(*place, &ticks))
        .draw()?;
    chart.draw_series((0..SHADES).map(|index| {
        let edge = |index: usize| least + (most - least) * index as f64 / SHADES as f64;
        let colour = shade(0.5 * (edge(index) + edge(index + 1)), least, most);
        Rectangle::new([(0.0, edge(index)), (1.0, edge(index + 1))], colour.filled())
    }))?;
    Ok(())
}
