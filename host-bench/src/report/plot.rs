//! Curves and dots over linear or logarithmic axes, one plot above another.
//!
//! The drawing library draws the axes, on whole pixels. Curves and dots are SVG paths written here: they are finer than a
//! pixel, and ten thousand dots are one short element.

use std::fmt::Write;

use plotters::prelude::*;

use super::svg::{Area, Drawn, FONT, GRID, power_of_ten, range, svg, tick};

/// An axis: its title and its span.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// The quantity with its unit.
    pub(crate) title: &'static str,
    /// Its first and its last value.
    pub(crate) span: [f64; 2],
    /// Approximate number of labels; a logarithmic axis labels the powers of ten.
    pub(crate) ticks: usize,
    logarithmic: bool,
}

impl Axis {
    /// Equal distances for equal differences.
    pub(crate) fn linear(title: &'static str, span: [f64; 2], ticks: usize) -> Self {
        Self { title, span, ticks, logarithmic: false }
    }

    /// Equal distances for equal ratios, and a number at each power of ten.
    pub(crate) fn logarithmic(title: &'static str, span: [f64; 2]) -> Self {
        let decades = (span[1] / span[0]).log10().abs().ceil();
        // More than the powers of ten, so that none is left out.
        Self { title, span, ticks: decades as usize + 2, logarithmic: true }
    }

    /// The place of a value on a linear scale.
    fn place(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    /// The number at a place.
    fn label(&self, place: f64) -> String {
        // A sum of steps that should be 0 may differ by rounding.
        let place = if place.abs() < 1e-9 * (self.span[1] - self.span[0]).abs() { 0.0 } else { place };
        match (self.logarithmic, (place - place.round()).abs() < 1e-9) {
            (false, _) => tick(place),
            (true, true) => power_of_ten(place),
            (true, false) => String::new(),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mark {
    /// A line through them, of this width.
    Line(f64),
    /// A dashed line through them, of this width.
    Dashes(f64),
    /// A dot for each, of this diameter.
    Dots(f64),
}

/// Points with a colour and a mark.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    /// Name in the legend; empty for a curve that the legend does not have.
    pub(crate) name: String,
    pub(crate) colour: RGBColor,
    pub(crate) mark: Mark,
    pub(crate) points: Vec<(f64, f64)>,
}

impl Curve {
    pub(crate) fn new(
        name: impl Into<String>,
        colour: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { name: name.into(), colour, mark, points: points.into_iter().collect() }
    }

    /// A line of this width with a dot of this diameter at each point.
    pub(crate) fn dotted(
        name: impl Into<String>,
        colour: RGBColor,
        [line, dot]: [f64; 2],
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> [Self; 2] {
        let line = Self::new(name, colour, Mark::Line(line), points);
        let dots = Self::new("", colour, Mark::Dots(dot), line.points.clone());
        [line, dots]
    }
}

/// The range of the ordinates of some curves, with a margin.
pub(crate) fn height<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> [f64; 2] {
    let (low, high) = range(curves.into_iter().flat_map(|curve| &curve.points).map(|point| point.1));
    [low, high]
}

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
const LEFT: i32 = 72;
/// Room around it.
const MARGIN: i32 = 10;
const RIGHT: i32 = 26;
/// Text; the library's size is 1.24 times what an SVG calls it.
const TITLE: (&str, u32) = (FONT, 20);
const TEXT: (&str, u32) = (FONT, 18);

/// The plots, one above the other and equally high, as SVG text.
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

/// Draws the axes, and appends the paths of the curves to `paths`.
fn axes(area: &Area<'_>, plot: &Plot, paths: &mut String) -> Drawn {
    let mut area = area.titled(&plot.title, TITLE)?;
    if plot.curves.iter().any(|curve| !curve.name.is_empty()) {
        let (above, below) = area.split_vertically(LEGEND);
        legend(&above, &plot.curves, paths)?;
        area = below;
    }
    let [left, right] = plot.across.span.map(|value| plot.across.place(value));
    let [low, high] = plot.up.span.map(|value| plot.up.place(value));
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
        .x_label_formatter(&|x| plot.across.label(*x))
        .y_label_formatter(&|y| plot.up.label(*y))
        .draw()?;
    // The last pixel of the library's range is part of the axis.
    let (columns, rows) = chart.plotting_area().get_pixel_range();
    let (width, height) = (columns.end - columns.start - 1, rows.end - rows.start - 1);
    // An inner SVG element clips the curves at the axes. A clip path would need a name, and names clash where one page
    // holds several pictures.
    let _ = writeln!(
        paths,
        "<svg x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\">",
        columns.start, rows.start
    );
    let place = |&(x, y): &(f64, f64)| {
        let (x, y) = (plot.across.place(x), plot.up.place(y));
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
        let between = [0.5 * (ends[0][0] + ends[1][0]), ends[0][1]];
        match curve.mark {
            Mark::Dots(_) => path(paths, curve.colour, curve.mark, std::iter::once(between)),
            Mark::Line(_) | Mark::Dashes(_) => path(paths, curve.colour, curve.mark, ends.into_iter()),
        }
        area.draw(&Text::new(curve.name.as_str(), (left + 33, middle - 8), TEXT.into_font()))?;
    }
    Ok(())
}

/// Removes the inner points of level stretches that go to the right.
fn level(points: &mut Vec<[i64; 2]>) {
    let mut kept: Vec<[i64; 2]> = Vec::with_capacity(points.len());
    for &point in points.iter() {
        if let [.., before, last] = kept[..]
            && before[1] == last[1]
            && last[1] == point[1]
            && before[0] <= last[0]
            && last[0] <= point[0]
        {
            kept.pop();
        }
        kept.push(point);
    }
    *points = kept;
}

/// A path through the points, or of dots at them, to a tenth of a pixel; dots in one place are drawn once.
fn path(paths: &mut String, colour: RGBColor, mark: Mark, points: impl Iterator<Item = [f64; 2]>) {
    let mut tenths: Vec<[i64; 2]> =
        points.map(|point| point.map(|place| (10.0 * place).round() as i64)).collect();
    if let Mark::Dots(_) = mark {
        tenths.sort_unstable();
    }
    tenths.dedup();
    if !matches!(mark, Mark::Dots(_)) {
        level(&mut tenths);
    }
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
