//! The scale of the colours of a map.

use plotters::prelude::*;

use super::svg::{Area, Drawn, FONT, Ticked, linear_ticks, shade, tick};

const LABEL: (&str, u32) = (FONT, 15);

/// The scale of the colours, from the least value to the largest.
pub(crate) fn colour_bar(area: &Area<'_>, name: &str, [low, high]: [f64; 2]) -> Drawn {
    const SHADES: usize = 64;
    // One value has no range.
    let [bottom, top] = if high > low { [low, high] } else { [low, low + low.abs().max(1e-300)] };
    let ticks = if high > low { linear_ticks(low, high, 8) } else { vec![low] };
    let mut bar = ChartBuilder::on(area)
        .margin(10)
        .margin_bottom(50)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..1.0, Ticked::new([bottom, top], &ticks))?;
    bar.configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .label_style(LABEL)
        .y_desc(name)
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    bar.draw_series((0..SHADES).map(|index| {
        let edge = |index: usize| bottom + (top - bottom) * index as f64 / SHADES as f64;
        let colour = shade(0.5 * (edge(index) + edge(index + 1)), low, high);
        Rectangle::new([(0.0, edge(index)), (1.0, edge(index + 1))], colour.filled())
    }))?;
    Ok(())
}
