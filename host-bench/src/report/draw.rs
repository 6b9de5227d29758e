//! Charts as SVG, one above another.
//!
//! The drawing library draws the axes, on whole pixels. Curves, dots and cells are SVG paths written here: they are finer than
//! a pixel, and ten thousand dots are one short element.

use std::fmt::Write;
use std::ops::Range;

use plotters::prelude::*;

use super::chart::{Axis, Chart, Curve, DASHES, Field, Mark, SHADES, SIGNS, colour};
use super::page::escaped;
use super::svg::{Area, Drawn, FONT, GRID, Ticked, hex, svg, width_of};

/// Height of a row above a chart: names of its curves, or a further line of its title or note.
const LEGEND: i32 = 26;
/// Least room at the left for the numbers and the title of the axis.
const LEFT: i32 = 72;
/// Room around it.
const MARGIN: i32 = 10;
const RIGHT: i32 = 26;
/// Width of the scale of colours without the room for its numbers.
const SCALE: i32 = 58;
/// Text; the library's size is 1.24 times what an SVG calls it.
const TITLE: u32 = 20;
const TEXT: (&str, u32) = (FONT, 18);
/// Width in pixels from which two charts of half of it stand beside each other.
const LEAST_OF_HALVES: u32 = 700;
/// Height of the title above all charts.
const HEAD: u32 = 30;

/// The font of a title, from this size down to that of the labels, and its lines of about one length, none wider than `width` if no
/// word is. A number and its unit stand in one line.
fn lines_of(title: &str, largest: u32, width: i32) -> ((&'static str, u32), Vec<String>) {
    let mut sizes = (TEXT.1..=largest).rev();
    let font = (FONT, sizes.find(|size| width_of(title, *size) <= width).unwrap_or(TEXT.1));
    // Behind a number its unit has room.
    let room = |word: &str| if word.parse::<f64>().is_ok() { width_of(" half-b", font.1) } else { 0 };
    let within = |width: i32| {
        let mut lines: Vec<String> = Vec::new();
        for word in title.split_whitespace() {
            match lines.last_mut() {
                Some(line) if width_of(&format!("{line} {word}"), font.1) + room(word) <= width => {
                    *line += &format!(" {word}")
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    };
    let widest = within(width);
    let narrower = (1..=width).map(within).find(|lines| lines.len() == widest.len());
    (font, narrower.unwrap_or(widest))
}

/// The title and the note of a chart.
fn above(chart: &Chart, width: i32) -> [((&'static str, u32), Vec<String>); 2] {
    [lines_of(&chart.title, TITLE, width), lines_of(&chart.note, TEXT.1, width)]
}

/// Room for the title of an ordinate, its numbers, and what is between them.
fn room(axis: &Axis) -> i32 {
    let places = axis.places();
    let numbers = places.iter().map(|place| width_of(&axis.label(*place, &places), TEXT.1));
    LEFT.max(27 + numbers.max().unwrap_or(0))
}

/// The charts as SVG text below a title: from left to right where two have half of the width, else one below the other.
/// At the bottom stands a figure, if there is one, with its height.
pub(crate) fn draw(
    width: u32,
    title: &str,
    charts: &[Chart],
    figure: Option<&(u32, String)>,
) -> Result<String, String> {
    let (font, lines) = lines_of(title, TITLE, width.cast_signed());
    let head = HEAD * lines.len() as u32;
    let (mut left, mut top, mut bottom) = (0, head, head);
    let mut places = Vec::new();
    let mut shown = charts.iter().filter(|chart| !chart.is_of_page).peekable();
    while let Some(chart) = shown.next() {
        // A half alone would leave the other one empty.
        let is_one_of_two =
            chart.is_half && (left == width / 2 || shown.peek().is_some_and(|next| next.is_half));
        let wide = if is_one_of_two && width >= LEAST_OF_HALVES { width / 2 } else { width };
        if left + wide > width {
            (left, top) = (0, bottom);
        }
        let lines = above(chart, wide.cast_signed()).map(|(_, lines)| lines.len().saturating_sub(1) as u32);
        let height = chart.height + LEGEND.cast_unsigned() * lines.iter().sum::<u32>();
        places.push((chart, (left, top), (wide, height)));
        (left, bottom) = (left + wide, bottom.max(top + height));
    }
    // The charts have their ordinates at one place.
    let room = places.iter().map(|(chart, ..)| room(&chart.up)).max().unwrap_or(LEFT);
    let mut paths = String::new();
    let below = figure.map_or(0, |(height, _)| *height);
    let frame = svg((width, (bottom + below).max(1)), |area| {
        for (line, top) in lines.iter().zip((0..).step_by(HEAD as usize)) {
            area.clone().shrink((0, top), (width, HEAD)).titled(line, font)?;
        }
        for (chart, place, size) in &places {
            axes(&area.clone().shrink(*place, *size), chart, room, &mut paths)?;
        }
        Ok(())
    })?;
    if let Some((_, figure)) = figure {
        paths += &figure.replacen("<svg ", &format!("<svg y=\"{bottom}\" "), 1);
    }
    let end = frame.rfind("</svg>").ok_or("an SVG without an end")?;
    let (frame, end) = frame.split_at(end);
    // Who does not see the picture has what it shows.
    let words = places.iter().map(|(chart, ..)| chart.words()).collect::<Vec<_>>().join("; ");
    let named = format!(
        " role=\"img\" aria-label=\"{}\" viewBox=",
        escaped(if words.is_empty() { title } else { &words })
    );
    Ok(format!("{}{paths}{end}", frame.replacen(" viewBox=", &named, 1)))
}

/// Draws the axes with so much room for the ordinate, and appends the paths of cells and curves to `paths`.
fn axes(area: &Area<'_>, chart: &Chart, left_room: i32, paths: &mut String) -> Drawn {
    let (columns, _) = area.get_pixel_range();
    let wide = columns.end - columns.start;
    let mut area = area.clone();
    for (font, lines) in above(chart, wide) {
        for line in lines {
            area = area.titled(&line, font)?;
        }
    }
    let names = entries(&chart.curves, wide);
    if let Some(last) = names.last() {
        let (above, below) = area.split_vertically(LEGEND * (last.row + last.lines.len() as i32));
        legend(&above, &names, paths)?;
        area = below;
    }
    if let Some(field) = &chart.field {
        let (body, scale) = area.split_horizontally(wide - SCALE - room(&field.scale));
        scale_of(&scale, field)?;
        area = body;
    }
    let ([left, right], [low, high]) = (chart.across.ends(), chart.up.ends());
    let [columns, rows] = [chart.across.places(), chart.up.places()];
    let mut drawn = ChartBuilder::on(&area)
        .margin_top(8)
        .margin_left(MARGIN)
        .margin_bottom(MARGIN)
        .margin_right(RIGHT)
        .x_label_area_size(50)
        .y_label_area_size(left_room)
        .build_cartesian_2d(Ticked::new([left, right], &columns), Ticked::new([low, high], &rows))?;
    drawn
        .configure_mesh()
        .x_desc(chart.across.title.as_str())
        .y_desc(chart.up.title.as_str())
        .label_style(TEXT)
        .axis_desc_style(TEXT)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x| chart.across.label(*x, &columns))
        .y_label_formatter(&|y| chart.up.label(*y, &rows))
        .draw()?;
    marks(paths, chart, drawn.plotting_area().get_pixel_range());
    Ok(())
}

/// Appends the paths of cells and curves within the axes at these pixels.
fn marks(paths: &mut String, chart: &Chart, (columns, rows): (Range<i32>, Range<i32>)) {
    // The last pixel of the library's range is part of the axis.
    let (width, height) = (columns.end - columns.start - 1, rows.end - rows.start - 1);
    let ([left, right], [low, high]) = (chart.across.ends(), chart.up.ends());
    // An inner SVG element clips the curves at the axes: names of clip paths clash in a page of several pictures.
    let frame =
        format!("<svg x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\"", columns.start, rows.start);
    let _ = writeln!(paths, "{frame}>");
    let place = |&(x, y): &(f64, f64)| {
        let (x, y) = (chart.across.place(x), chart.up.place(y));
        [(x - left) / (right - left) * f64::from(width), (high - y) / (high - low) * f64::from(height)]
    };
    if let Some(field) = &chart.field {
        cells(paths, field, place);
    }
    let mut dots = String::new();
    for curve in chart.curves.iter().filter(|curve| !curve.is_hidden) {
        if !curve.bars.is_empty() {
            let ends = curve
                .points
                .iter()
                .zip(&curve.bars)
                .flat_map(|(&(x, y), bar)| [place(&(x, y - bar)), place(&(x, y + bar)), [f64::NAN; 2]]);
            path(paths, curve.colour, Mark::line(0, 1.0), ends);
        }
        for mark in curve.mark.parts() {
            let is_line = mark.line.is_some();
            // A dot at the end of an axis is whole.
            let is_on = |at: f64, length: i32| is_line || (-0.5..=f64::from(length) + 0.5).contains(&at);
            let is_shown = |&[x, y]: &[f64; 2]| is_on(x, width) && is_on(y, height);
            let points = || curve.points.iter().map(place).filter(is_shown);
            let to = if is_line { &mut *paths } else { &mut dots };
            if chart.field.is_some() {
                // With a light edge it is seen on each colour of the cells.
                let size = mark.size() + 2.0;
                path(to, WHITE, if is_line { Mark::line(0, size) } else { Mark::point(0, size) }, points());
            }
            path(to, curve.colour, mark, points());
        }
    }
    let _ = writeln!(paths, "</svg>\n{frame} overflow=\"visible\">\n{dots}</svg>");
}

/// The cells of each colour as one path, on whole pixels.
fn cells(paths: &mut String, field: &Field, place: impl Fn(&(f64, f64)) -> [f64; 2]) {
    let [across, up] = &field.edges;
    let left: Vec<i64> = across.iter().map(|x| place(&(*x, up[0]))[0].round() as i64).collect();
    let top: Vec<i64> = up.iter().map(|y| place(&(across[0], *y))[1].round() as i64).collect();
    let shades = field.shades();
    for shade in 0..SHADES {
        let mut ways = String::new();
        for (index, _) in shades.iter().enumerate().filter(|(_, found)| **found == Some(shade)) {
            let (column, row) = (index % (left.len() - 1), index / (left.len() - 1));
            let (wide, high) = (left[column + 1] - left[column], top[row] - top[row + 1]);
            let _ = write!(ways, "M{} {}h{wide}v{high}h-{wide}z", left[column], top[row + 1]);
        }
        if !ways.is_empty() {
            let fill = hex(colour(shade));
            let _ = writeln!(paths, "<path fill=\"{fill}\" shape-rendering=\"crispEdges\" d=\"{ways}\"/>");
        }
    }
}

/// The scale of the colours, from the least value to the largest.
fn scale_of(area: &Area<'_>, field: &Field) -> Drawn {
    let [low, high] = field.scale.ends();
    // One value has no range.
    let [bottom, top] = if high > low { [low, high] } else { [low, low + low.abs().max(1e-300)] };
    let ticks = if high > low { field.scale.places() } else { vec![low] };
    let mut bar = ChartBuilder::on(area)
        .margin_top(8)
        .margin_right(MARGIN)
        .margin_bottom(50 + MARGIN)
        .y_label_area_size(room(&field.scale))
        .build_cartesian_2d(0.0..1.0, Ticked::new([bottom, top], &ticks))?;
    bar.configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .label_style(TEXT)
        .axis_desc_style(TEXT)
        .y_desc(field.scale.title.as_str())
        .y_label_formatter(&|place| field.scale.label(*place, &ticks))
        .draw()?;
    // Each goes up to the top, below those that follow: between two that only touch a scaled picture has a white line.
    bar.draw_series((0..SHADES).map(|index| {
        let edge = bottom + (top - bottom) * index as f64 / SHADES as f64;
        let shade = if high > low { index } else { SHADES / 2 };
        Rectangle::new([(0.0, edge), (1.0, top)], colour(shade).filled())
    }))?;
    Ok(())
}

/// The name of a curve in the legend: its lines, the row of the first, and its left edge.
struct Entry<'a> {
    curve: &'a Curve,
    lines: Vec<String>,
    row: i32,
    left: i32,
}

/// Length of the line before a name, its distance to the name, and that to the next.
const SAMPLE: [i32; 3] = [32, 7, 16];

/// The names of the curves in rows that are not wider than `width`.
fn entries(curves: &[Curve], width: i32) -> Vec<Entry<'_>> {
    let (mut row, mut left) = (0, MARGIN + LEFT);
    let mut entries = Vec::new();
    let room = width - left - MARGIN - SAMPLE[0] - SAMPLE[1];
    for curve in curves.iter().filter(|curve| !curve.name.is_empty() && !curve.is_hidden) {
        let (_, lines) = lines_of(&curve.name, TEXT.1, room);
        let widest = lines.iter().map(|line| width_of(line, TEXT.1)).max().unwrap_or(0);
        let wide = SAMPLE[0] + SAMPLE[1] + widest;
        if left > MARGIN + LEFT && left + wide > width - MARGIN {
            (row, left) = (row + 1, MARGIN + LEFT);
        }
        let further = lines.len().saturating_sub(1) as i32;
        entries.push(Entry { curve, lines, row, left });
        (row, left) = (row + further, left + wide + SAMPLE[2]);
    }
    entries
}

fn legend(area: &Area<'_>, entries: &[Entry<'_>], paths: &mut String) -> Drawn {
    let (columns, rows) = area.get_pixel_range();
    for &Entry { curve, ref lines, row, left } in entries {
        let middle = LEGEND * row + LEGEND / 2;
        let ends =
            [left, left + SAMPLE[0]].map(|x| [f64::from(columns.start + x), f64::from(rows.start + middle)]);
        let between = [0.5 * (ends[0][0] + ends[1][0]), ends[0][1]];
        for mark in curve.mark.parts() {
            let places = if mark.line.is_some() { &ends[..] } else { &[between] };
            path(paths, curve.colour, mark, places.iter().copied());
        }
        for (line, top) in lines.iter().zip((middle - 8..).step_by(LEGEND as usize)) {
            area.draw(&Text::new(line.as_str(), (left + SAMPLE[0] + SAMPLE[1], top), TEXT.into_font()))?;
        }
    }
    Ok(())
}

/// Removes the inner points of level stretches that go to the right.
fn level(points: &mut Vec<[i64; 2]>) {
    let mut thinned: Vec<[i64; 2]> = Vec::with_capacity(points.len());
    for &point in points.iter() {
        if let [.., before, last] = thinned[..]
            && before[1] == last[1]
            && last[1] == point[1]
            && before[0] <= last[0]
            && last[0] <= point[0]
        {
            thinned.pop();
        }
        thinned.push(point);
    }
    *points = thinned;
}

/// A path through the points, with gaps at those that are no number, or of dots, to a tenth of a pixel; equal dots are drawn once.
fn path(paths: &mut String, colour: RGBColor, mut mark: Mark, points: impl Iterator<Item = [f64; 2]>) {
    let mut points: Vec<[f64; 2]> = points.collect();
    let mut fill = "none".to_owned();
    match mark.point {
        Some((size, 0, false)) => {
            path(paths, colour, Mark::point(0, size), points.clone().into_iter());
            return path(paths, WHITE, Mark::point(0, 0.55 * size), points.into_iter());
        }
        Some((size, shape @ 1.., is_filled)) => {
            fill = hex(if is_filled { colour } else { WHITE });
            let corner =
                |[x, y]: [f64; 2], [right, down]: [f64; 2]| [x + 0.45 * size * right, y + 0.45 * size * down];
            let sign =
                |&point| SIGNS[shape - 1].iter().map(move |at| corner(point, *at)).chain([[f64::NAN; 2]]);
            points = points.iter().flat_map(sign).collect();
            mark = Mark::line(0, 1.6);
        }
        _ => {}
    }
    let is_dots = mark.point.is_some();
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
    let _ = write!(paths, "<path fill=\"{fill}\" stroke=\"{}\" ", hex(colour));
    let _ = write!(paths, "stroke-width=\"{}\" stroke-line", mark.size());
    paths.push_str(if is_dots { "cap=\"round\"" } else { "join=\"round\"" });
    if let Some((_, number @ 1..)) = mark.line {
        let _ = write!(paths, " stroke-dasharray=\"{}\"", DASHES[number - 1]);
    }
    paths.push_str(" d=\"");
    let tenth = |value: i64| {
        let text = format!("{:.1}", value as f64 / 10.0);
        text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
    };
    // A PDF leaves a path without an extent out.
    let dot = if points.len() == 1 { "h0.01" } else { "h0" };
    for part in parts {
        for (index, [x, y]) in part.into_iter().enumerate() {
            let letter = if index == 0 || is_dots { 'M' } else { 'L' };
            let _ = write!(paths, "{letter}{} {}", tenth(x), tenth(y));
            if is_dots {
                paths.push_str(dot);
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
        let chart = Chart { height: 430, ..Chart::new("Title", across, up, curves) };
        draw(560, "", &[chart], None).expect("a picture")
    }

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
        let curves = names.map(|name| Curve::new(name, BLUE, Mark::line(0, 1.0), [(0.0, 0.0), (1.0, 1.0)]));
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
    fn a_narrow_chart_has_readable_lines_of_its_note_and_whole_dots_at_its_ends() {
        let dots = Curve::new("", BLUE, Mark::point(0, 6.0), [(0.0, 0.0), (1.0, 1.0), (2.0, 1.0)]);
        let [across, up] = ["x", "y"].map(|title| Axis::linear(title, [0.0, 1.0], 5));
        let note = "not drawn: 72 runs ".repeat(6);
        let svg = draw(300, "", &[Chart { note, ..Chart::new("", across, up, vec![dots]) }], None);
        let svg = svg.expect("a picture");
        let sizes = svg.split("font-size=\"").skip(1).map(|rest| rest.split('"').next()?.parse().ok());
        let least = sizes.map(|size: Option<f64>| size.expect("a size")).fold(f64::INFINITY, f64::min);
        assert!((14.5..15.0).contains(&least), "7 pt are 14.5: {least}");
        assert!(!texts(&svg).iter().any(|text| text.2.ends_with("72")), "a number without its unit");
        let whole = svg.split("overflow=\"visible\"").nth(1).expect("dots");
        assert_eq!(whole.matches("h0").count(), 2, "the third is beyond the axis");
    }

    #[test]
    fn a_jump_is_a_gap_and_a_slope_is_not() {
        let gaps = |values: &[f64]| {
            let points = values.iter().enumerate().map(|(index, value)| (index as f64, *value));
            let curve = Curve::new("", BLUE, Mark::line(0, 1.0), points).broken_at_jumps();
            curve.points.iter().filter(|point| point.1.is_nan()).count()
        };
        assert_eq!(gaps(&[1.0, 1.1, 1.2, 5.0, 5.1, 5.2]), 1);
        assert_eq!(gaps(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 0);
        assert_eq!(gaps(&[0.0, 0.1, 1.0, 3.0, 4.0, 4.1]), 0);
        // A resonance that is resolved.
        let resonance: Vec<f64> = (-20..=20).map(|x| 1.0 / (1.0 + f64::from(x * x) / 4.0)).collect();
        assert_eq!(gaps(&resonance), 0);
        let curve = Curve::new("", GREEN, Mark::line(0, 1.0), [(0.0, 0.0), (f64::NAN, f64::NAN), (1.0, 1.0)]);
        let svg = plot(Axis::linear("x", [0.0, 1.0], 5), vec![curve]);
        let path =
            svg.split("stroke=\"#009E73\"").nth(1).expect("the curve").split("d=\"").nth(1).expect("a path");
        let path = path.split('"').next().expect("an end");
        assert_eq!((path.matches('M').count(), path.matches('L').count()), (2, 0), "{path}");
    }
}
