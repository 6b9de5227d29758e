//! Curves and dots over linear or logarithmic axes, one plot above another.
//!
//! The drawing library draws the axes, on whole pixels. Curves and dots are SVG paths written here: they are finer than a
//! pixel, and ten thousand dots are one short element.

use std::fmt::Write;

use plotters::prelude::*;

use super::svg::{
    Area, Drawn, FONT, GRID, Ticked, extremes, linear_ticks, logarithmic_label, logarithmic_ticks, range,
    svg, tick, width_of,
};

/// An axis: its title and its span.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// The quantity with its unit.
    pub(crate) title: String,
    /// Its first and its last value.
    pub(crate) span: [f64; 2],
    /// Approximate number of labels.
    pub(crate) ticks: usize,
    logarithmic: bool,
}

impl Axis {
    /// Equal distances for equal differences.
    pub(crate) fn linear(title: impl Into<String>, span: [f64; 2], ticks: usize) -> Self {
        Self { title: title.into(), span, ticks, logarithmic: false }
    }

    /// Equal distances for equal ratios.
    pub(crate) fn logarithmic(title: impl Into<String>, span: [f64; 2]) -> Self {
        Self { title: title.into(), span, ticks: 12, logarithmic: true }
    }

    /// The same over another span.
    pub(crate) fn over(self, span: [f64; 2]) -> Self {
        Self { span, ..self }
    }

    /// Whether equal distances are equal ratios.
    pub(crate) fn is_logarithmic(&self) -> bool {
        self.logarithmic
    }

    /// The place of a value on a linear scale.
    fn place(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    /// Places of the ticks.
    fn places(&self) -> Vec<f64> {
        let [first, last] = self.span.map(|value| self.place(value));
        if self.logarithmic {
            logarithmic_ticks(first, last, self.ticks)
        } else {
            linear_ticks(first, last, self.ticks)
        }
    }

    /// The number at a place among all of them.
    fn label(&self, place: f64, all: &[f64]) -> String {
        if self.logarithmic { logarithmic_label(place, all) } else { tick(place) }
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
    /// A ring around each, of this diameter.
    Rings(f64),
}

/// Points with a colour and a mark.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    /// Name in the legend; empty for a curve that the legend does not have.
    pub(crate) name: String,
    pub(crate) colour: RGBColor,
    pub(crate) mark: Mark,
    /// A line has a gap at a point that is not a number.
    pub(crate) points: Vec<(f64, f64)>,
    /// For each point half the length of its vertical bar, such as a standard deviation; empty without bars.
    pub(crate) bars: Vec<f64>,
    /// For each point what a page says of it besides its values; empty without.
    pub(crate) notes: Vec<String>,
}

/// Least part of the height of a curve that a jump has, and how much larger than the differences beside it it is.
const JUMP: [f64; 2] = [0.08, 5.0];

impl Curve {
    pub(crate) fn new(
        name: impl Into<String>,
        colour: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.into(), colour, mark, points, bars: Vec::new(), notes: Vec::new() }
    }

    /// The same with a vertical bar at each point, of these half lengths.
    pub(crate) fn with_bars(self, bars: Vec<f64>) -> Self {
        Self { bars, ..self }
    }

    /// The same with a text for each point, which a page shows.
    pub(crate) fn with_notes(self, notes: Vec<String>) -> Self {
        Self { notes, ..self }
    }

    /// The same with a gap at each jump: where two neighbours differ by much more than those beside them, a line between
    /// them would be no measured slope.
    pub(crate) fn broken_at_jumps(self) -> Self {
        let points = &self.points;
        let (low, high) = extremes(points.iter().map(|point| point.1));
        let difference = |index: Option<usize>| {
            let pair = index.and_then(|index| Some([points.get(index)?.1, points.get(index + 1)?.1]));
            pair.map_or(0.0, |[one, next]| (next - one).abs())
        };
        let jumps = |index: usize| {
            let beside = difference(index.checked_sub(1)).max(difference(Some(index + 1)));
            let here = difference(Some(index));
            here > JUMP[0] * (high - low) && here > JUMP[1] * beside
        };
        // Fewer points have no neighbours to compare with.
        if points.len() < 5 {
            return self;
        }
        let mut broken = Vec::with_capacity(points.len());
        for (index, point) in points.iter().enumerate() {
            broken.push(*point);
            if jumps(index) {
                broken.push((f64::NAN, f64::NAN));
            }
        }
        Self { points: broken, ..self }
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

/// The font of a title that is not wider than its plot.
fn title_of(title: &str, width: i32) -> (&'static str, u32) {
    let sizes = (13..=TITLE.1).rev();
    let mut fitting = sizes.filter(|size| width_of(title, *size) <= width);
    (TITLE.0, fitting.next().unwrap_or(13))
}

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
    let (columns, _) = area.get_pixel_range();
    let mut area = area.titled(&plot.title, title_of(&plot.title, columns.end - columns.start))?;
    let names = entries(&plot.curves, columns.end - columns.start);
    if let Some(last) = names.last() {
        let (above, below) = area.split_vertically(LEGEND * (last.row + 1));
        legend(&above, &names, paths)?;
        area = below;
    }
    let [left, right] = plot.across.span.map(|value| plot.across.place(value));
    let [low, high] = plot.up.span.map(|value| plot.up.place(value));
    let [columns, rows] = [plot.across.places(), plot.up.places()];
    let mut chart = ChartBuilder::on(&area)
        .margin_top(8)
        .margin_left(MARGIN)
        .margin_bottom(MARGIN)
        .margin_right(RIGHT)
        .x_label_area_size(50)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(Ticked::new([left, right], &columns), Ticked::new([low, high], &rows))?;
    chart
        .configure_mesh()
        .x_desc(plot.across.title.as_str())
        .y_desc(plot.up.title.as_str())
        .label_style(TEXT)
        .axis_desc_style(TEXT)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x| plot.across.label(*x, &columns))
        .y_label_formatter(&|y| plot.up.label(*y, &rows))
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
        if !curve.bars.is_empty() {
            let ends = curve
                .points
                .iter()
                .zip(&curve.bars)
                .flat_map(|(&(x, y), bar)| [place(&(x, y - bar)), place(&(x, y + bar)), [f64::NAN; 2]]);
            path(paths, curve.colour, Mark::Line(1.0), ends);
        }
        path(paths, curve.colour, curve.mark, curve.points.iter().map(place));
    }
    paths.push_str("</svg>\n");
    Ok(())
}

/// The name of a curve in the legend: its row, and its left edge.
struct Entry<'a> {
    curve: &'a Curve,
    row: i32,
    left: i32,
}

/// Length of the line before a name, its distance to the name, and that to the next.
const SAMPLE: [i32; 3] = [26, 7, 16];

/// The names of the curves in rows that are not wider than `width`.
fn entries(curves: &[Curve], width: i32) -> Vec<Entry<'_>> {
    let (mut row, mut left) = (0, MARGIN + LEFT);
    let mut entries = Vec::new();
    for curve in curves.iter().filter(|curve| !curve.name.is_empty()) {
        let wide = SAMPLE[0] + SAMPLE[1] + width_of(&curve.name, TEXT.1);
        if left > MARGIN + LEFT && left + wide > width - MARGIN {
            (row, left) = (row + 1, MARGIN + LEFT);
        }
        entries.push(Entry { curve, row, left });
        left += wide + SAMPLE[2];
    }
    entries
}

/// Draws the names of the curves.
fn legend(area: &Area<'_>, entries: &[Entry<'_>], paths: &mut String) -> Drawn {
    let (columns, rows) = area.get_pixel_range();
    for &Entry { curve, row, left } in entries {
        let middle = LEGEND * row + LEGEND / 2;
        let ends =
            [left, left + SAMPLE[0]].map(|x| [f64::from(columns.start + x), f64::from(rows.start + middle)]);
        let between = [0.5 * (ends[0][0] + ends[1][0]), ends[0][1]];
        match curve.mark {
            Mark::Dots(_) | Mark::Rings(_) => path(paths, curve.colour, curve.mark, std::iter::once(between)),
            Mark::Line(_) | Mark::Dashes(_) => path(paths, curve.colour, curve.mark, ends.into_iter()),
        }
        let place = (left + SAMPLE[0] + SAMPLE[1], middle - 8);
        area.draw(&Text::new(curve.name.as_str(), place, TEXT.into_font()))?;
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

/// A path through the points, with gaps at those that are no number, or of dots at them, to a tenth of a pixel; dots in one
/// place are drawn once.
fn path(paths: &mut String, colour: RGBColor, mark: Mark, points: impl Iterator<Item = [f64; 2]>) {
    if let Mark::Rings(width) = mark {
        let points: Vec<[f64; 2]> = points.collect();
        path(paths, colour, Mark::Dots(width), points.iter().copied());
        path(paths, WHITE, Mark::Dots(0.55 * width), points.into_iter());
        return;
    }
    let is_dots = matches!(mark, Mark::Dots(_));
    let points: Vec<[f64; 2]> = points.collect();
    let mut parts: Vec<Vec<[i64; 2]>> = points
        .split(|point| point.iter().any(|place| place.is_nan()))
        .map(|part| part.iter().map(|point| point.map(|place| (10.0 * place).round() as i64)).collect())
        .collect();
    for part in &mut parts {
        if is_dots {
            part.sort_unstable();
        }
        part.dedup();
        if !is_dots {
            level(part);
        }
    }
    let RGBColor(red, green, blue) = colour;
    let _ = write!(paths, "<path fill=\"none\" stroke=\"#{red:02X}{green:02X}{blue:02X}\" ");
    let _ = match mark {
        Mark::Line(width) => write!(paths, "stroke-width=\"{width}\" stroke-linejoin=\"round\""),
        Mark::Dashes(width) => {
            write!(paths, "stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-dasharray=\"7 5\"")
        }
        Mark::Dots(width) | Mark::Rings(width) => {
            write!(paths, "stroke-width=\"{width}\" stroke-linecap=\"round\"")
        }
    };
    paths.push_str(" d=\"");
    let tenth = |value: i64| {
        let text = format!("{:.1}", value as f64 / 10.0);
        text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
    };
    for part in parts {
        for (index, [x, y]) in part.into_iter().enumerate() {
            let letter = if index == 0 || is_dots { 'M' } else { 'L' };
            let _ = write!(paths, "{letter}{} {}", tenth(x), tenth(y));
            if is_dots {
                paths.push_str("h0");
            }
        }
    }
    paths.push_str("\"/>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::svg::{BLUE, GREEN};

    fn plot(across: Axis, curves: Vec<Curve>) -> String {
        let up = Axis::linear("value", [0.0, 1.0], 5);
        draw((560, 430), &[Plot { title: "Title".to_owned(), across, up, curves }]).expect("a picture")
    }

    /// Texts of a picture with their places.
    fn texts(svg: &str) -> Vec<(f64, f64, String)> {
        let attribute = |element: &str, name: &str| {
            let from = element.find(&format!("{name}=\""))? + name.len() + 2;
            element[from..].split('"').next()?.parse::<f64>().ok()
        };
        let elements = svg.split("<text").skip(1).filter_map(|element| {
            let content = element.split_once('>')?.1.split("</text").next()?.trim().to_owned();
            Some((attribute(element, " x")?, attribute(element, " y")?, content))
        });
        elements.collect()
    }

    #[test]
    fn each_decade_has_its_own_number() {
        let svg = plot(Axis::logarithmic("load resistance [Ω]", [1e5, 1e10]), Vec::new());
        let labels: Vec<String> = texts(&svg).into_iter().map(|text| text.2).collect();
        for decade in ["10⁵", "10⁶", "10⁷", "10⁸", "10⁹", "10¹⁰"] {
            assert_eq!(labels.iter().filter(|label| *label == decade).count(), 1, "{decade} in {labels:?}");
        }
        assert!(!labels.iter().any(|label| label == "10⁰"), "{labels:?}");
    }

    #[test]
    fn names_in_the_legend_do_not_touch() {
        let names = ["0 Ω", "10 MΩ", "50 MΩ", "100 MΩ", "10 GΩ", "a rather long name of a curve"];
        let curves = names.map(|name| Curve::new(name, BLUE, Mark::Line(1.0), [(0.0, 0.0), (1.0, 1.0)]));
        let found = entries(&curves, 560);
        assert_eq!(found.len(), names.len());
        for pair in found.windows(2) {
            let end = pair[0].left + SAMPLE[0] + SAMPLE[1] + width_of(&pair[0].curve.name, TEXT.1);
            assert!(pair[1].row > pair[0].row || pair[1].left >= end + 10, "{}", pair[0].curve.name);
            assert!(end <= 560, "{}", pair[0].curve.name);
        }
        assert!(found.last().is_some_and(|entry| entry.row >= 1), "one row is too short");
        // Each name stands in the picture.
        let svg = plot(Axis::linear("x", [0.0, 1.0], 5), curves.to_vec());
        for name in names {
            assert_eq!(texts(&svg).iter().filter(|text| text.2 == name).count(), 1, "{name}");
        }
    }

    #[test]
    fn a_jump_is_a_gap_and_a_slope_is_not() {
        let gaps = |values: &[f64]| {
            let points = values.iter().enumerate().map(|(index, value)| (index as f64, *value));
            let curve = Curve::new("", BLUE, Mark::Line(1.0), points).broken_at_jumps();
            curve.points.iter().filter(|point| point.1.is_nan()).count()
        };
        assert_eq!(gaps(&[1.0, 1.1, 1.2, 5.0, 5.1, 5.2]), 1);
        assert_eq!(gaps(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 0);
        assert_eq!(gaps(&[0.0, 0.1, 1.0, 3.0, 4.0, 4.1]), 0);
        // A resonance that is resolved.
        let resonance: Vec<f64> = (-20..=20).map(|x| 1.0 / (1.0 + f64::from(x * x) / 4.0)).collect();
        assert_eq!(gaps(&resonance), 0);
        let curve = Curve::new("", GREEN, Mark::Line(1.0), [(0.0, 0.0), (f64::NAN, f64::NAN), (1.0, 1.0)]);
        let svg = plot(Axis::linear("x", [0.0, 1.0], 5), vec![curve]);
        let path =
            svg.split("stroke=\"#009E73\"").nth(1).expect("the curve").split("d=\"").nth(1).expect("a path");
        let path = path.split('"').next().expect("an end");
        assert_eq!((path.matches('M').count(), path.matches('L').count()), (2, 0), "{path}");
    }
}
