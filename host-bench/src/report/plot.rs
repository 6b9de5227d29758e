//! Curves and dots over linear axes, one plot above another.
//!
//! The drawing library does the axes, on whole pixels. Curves and dots are paths of our own: finer
//! than a pixel, and ten thousand dots in one short element.

use std::fmt::Write;

use plotters::prelude::*;

use super::svg::{Area, Drawn, FONT, GRID, svg, tick};

/// An axis: what it shows, from where to where.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// What it shows, with its unit.
    pub(crate) title: &'static str,
    /// Where it begins and ends.
    pub(crate) span: [f64; 2],
    /// About how many numbers stand at it.
    pub(crate) ticks: usize,
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mark {
    /// A line through them, of this width.
    Line(f64),
    /// A dashed line through them, of this width.
    Dashes(f64),
    /// A dot for each, of this diameter.
    Dots(f64),
}

/// Points, drawn alike.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    /// Name in the legend; without one it is not there.
    pub(crate) name: String,
    pub(crate) colour: RGBColor,
    pub(crate) mark: Mark,
    pub(crate) points: Vec<(f64, f64)>,
}

/// One plot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plot {
    pub(crate) title: String,
    pub(crate) across: Axis,
    pub(crate) up: Axis,
    pub(crate) curves: Vec<Curve>,
}

/// Height of the row above a plot that names its curves.
const LEGEND: i32 = 26;
/// Room at the left for the numbers and the title of the axis.
const LEFT: i32 = 60;
/// Room around it.
const MARGIN: i32 = 10;
const RIGHT: i32 = 22;
/// Text; the library's size is 1.24 times what an SVG calls it.
const TITLE: (&str, u32) = (FONT, 20);
const TEXT: (&str, u32) = (FONT, 18);

/// The plots, one above the other and equally high, as SVG text.
///
/// # Errors
/// What the drawing library says.
pub(crate) fn draw(size: (u32, u32), plots: &[Plot]) -> Result<String, String> {
    let mut paths = String::new();
    let frame = svg(size, |area| {
        for (part, plot) in area.split_evenly((plots.len(), 1)).iter().zip(plots) {
            axes(part, plot, &mut paths)?;
        }
        Ok(())
    })?;
    let end = frame.rfind("</svg>").ok_or("an SVG without an end")?;
    let (frame, end) = frame.split_at(end);
    Ok(format!("{frame}{paths}{end}"))
}

/// Draws all but the curves, whose paths are put behind `paths`.
fn axes(area: &Area<'_>, plot: &Plot, paths: &mut String) -> Drawn {
    let mut area = area.titled(&plot.title, TITLE)?;
    if plot.curves.iter().any(|curve| !curve.name.is_empty()) {
        let (above, below) = area.split_vertically(LEGEND);
        legend(&above, &plot.curves, paths)?;
        area = below;
    }
    let [left, right] = plot.across.span;
    let [low, high] = plot.up.span;
    let mut chart = ChartBuilder::on(&area)
        .margin_top(8)
        .margin_left(MARGIN)
        .margin_bottom(MARGIN)
        .margin_right(RIGHT)
        .x_label_area_size(50)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(left..right, low..high)?;
    chart
        .configure_mesh()
        .x_desc(plot.across.title)
        .y_desc(plot.up.title)
        .x_labels(plot.across.ticks)
        .y_labels(plot.up.ticks)
        .label_style(TEXT)
        .axis_desc_style(TEXT)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .draw()?;
    // The library's last pixel is within the axis.
    let (columns, rows) = chart.plotting_area().get_pixel_range();
    let (width, height) = (columns.end - columns.start - 1, rows.end - rows.start - 1);
    // What lies outside of the axes is cut off by an inner picture: it needs no name, and names would
    // clash where one page holds several pictures.
    let _ = writeln!(
        paths,
        "<svg x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\">",
        columns.start, rows.start
    );
    let place = |&(x, y): &(f64, f64)| {
        [(x - left) / (right - left) * f64::from(width), (high - y) / (high - low) * f64::from(height)]
    };
    for curve in &plot.curves {
        path(paths, curve.colour, curve.mark, curve.points.iter().map(place));
    }
    paths.push_str("</svg>\n");
    Ok(())
}

/// Names the curves in one row.
fn legend(area: &Area<'_>, curves: &[Curve], paths: &mut String) -> Drawn {
    let (columns, rows) = area.get_pixel_range();
    let named: Vec<&Curve> = curves.iter().filter(|curve| !curve.name.is_empty()).collect();
    let width =
        (columns.end - columns.start - MARGIN - LEFT - RIGHT) / i32::try_from(named.len()).unwrap_or(1);
    let middle = LEGEND / 2;
    for (curve, left) in named.iter().zip((MARGIN + LEFT..).step_by(usize::try_from(width).unwrap_or(1))) {
        let ends = [left, left + 26].map(|x| [f64::from(columns.start + x), f64::from(rows.start + middle)]);
        path(paths, curve.colour, curve.mark, ends.into_iter());
        area.draw(&Text::new(curve.name.as_str(), (left + 33, middle - 8), TEXT.into_font()))?;
    }
    Ok(())
}

/// A path through the points, or of dots at them, to a tenth of a pixel; dots in one place are drawn once.
fn path(paths: &mut String, colour: RGBColor, mark: Mark, points: impl Iterator<Item = [f64; 2]>) {
    let mut tenths: Vec<[i64; 2]> =
        points.map(|point| point.map(|place| (10.0 * place).round() as i64)).collect();
    if let Mark::Dots(_) = mark {
        tenths.sort_unstable();
    }
    tenths.dedup();
    let RGBColor(red, green, blue) = colour;
    let _ = write!(paths, "<path fill=\"none\" stroke=\"#{red:02X}{green:02X}{blue:02X}\" ");
    let _ = match mark {
        Mark::Line(width) => write!(paths, "stroke-width=\"{width}\" stroke-linejoin=\"round\""),
        Mark::Dashes(width) => {
            write!(paths, "stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-dasharray=\"7 5\"")
        }
        Mark::Dots(width) => write!(paths, "stroke-width=\"{width}\" stroke-linecap=\"round\""),
    };
    paths.push_str(" d=\"");
    let tenth = |value: i64| {
        let text = format!("{:.1}", value as f64 / 10.0);
        text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
    };
    for (index, &[x, y]) in tenths.iter().enumerate() {
        let letter = if index == 0 || matches!(mark, Mark::Dots(_)) { 'M' } else { 'L' };
        let _ = write!(paths, "{letter}{} {}", tenth(x), tenth(y));
        if let Mark::Dots(_) = mark {
            paths.push_str("h0");
        }
    }
    paths.push_str("\"/>\n");
}
