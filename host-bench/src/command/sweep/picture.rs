//! The picture of a sweep: curves over one axis, a map over two.

use plotters::prelude::*;

use super::axis::Axis;
use crate::report::colour_bar::colour_bar;
use crate::report::label::label as label_of_key;
use crate::report::plot::{self, Curve, Mark, Plot, height};
use crate::report::setting::prefix;
use crate::report::svg::{
    Area, BLUE, Drawn, FONT, Ticked, VERMILION, extremes, linear_ticks, logarithmic_label, logarithmic_ticks,
    shade, svg, tick,
};

/// Width and height of the picture.
const SIZE: (u32, u32) = (900, 640);

/// Font of the axes: whatever the viewer has for it.
const LABEL: (&str, u32) = (FONT, 15);

/// A quantity to draw: its name, its unit, and one value for each point, if there is one.
#[derive(Debug, Clone)]
pub(in crate::command) struct Quantity {
    pub(in crate::command) name: &'static str,
    /// Empty where it has none.
    pub(in crate::command) unit: &'static str,
    pub(in crate::command) values: Vec<Option<f64>>,
}

impl Quantity {
    /// Its name with the unit that its values are shown in, and the factor to it.
    pub(super) fn scaled(&self) -> (String, f64) {
        if self.unit.is_empty() {
            return (self.name.to_owned(), 1.0);
        }
        let largest = self.values.iter().flatten().filter(|value| value.is_finite());
        let (prefix, factor) = prefix(largest.fold(0.0, |largest, value| largest.max(value.abs())));
        (format!("{} [{prefix}{}]", self.name, self.unit), factor)
    }
}

/// What a picture says beside its values.
#[derive(Debug, Clone, Copy)]
pub(in crate::command) struct Words<'a> {
    pub(in crate::command) title: &'a str,
    /// Why a point has no value: what is white on a map.
    pub(in crate::command) without: &'a str,
    /// Which points are marked, and why; none where it is empty.
    pub(in crate::command) marked: (&'a [bool], &'a str),
}

/// An SVG picture; `None` without values, without an axis of several values, or with more than two.
pub(in crate::command) fn draw(
    words: Words<'_>,
    axes: &[Axis],
    quantities: &[Quantity],
) -> Result<Option<String>, String> {
    let (long, shown) = (long(axes), shown(quantities));
    match (&long[..], &shown[..]) {
        // The last axis runs fastest.
        ([up, across], [quantity, ..]) => {
            svg(SIZE, |area| map(area, words, [across, up], quantity)).map(Some)
        }
        ([axis], [_, ..]) => {
            let plots: Vec<Plot> = shown.iter().map(|quantity| curve(words, axis, quantity)).collect();
            plot::draw(SIZE, &plots).map(Some)
        }
        _ => Ok(None),
    }
}

/// The axes of several values.
pub(super) fn long(axes: &[Axis]) -> Vec<&Axis> {
    axes.iter().filter(|axis| axis.count() > 1).collect()
}

/// The quantities that have a value.
pub(super) fn shown(quantities: &[Quantity]) -> Vec<&Quantity> {
    let has_value = |quantity: &&Quantity| quantity.values.iter().flatten().any(|value| value.is_finite());
    quantities.iter().filter(has_value).collect()
}

/// An axis as that of a plot.
pub(super) fn across(axis: &Axis) -> plot::Axis {
    let span = [axis.value(0), axis.value(axis.count() - 1)];
    match axis.logarithmic {
        true => plot::Axis::logarithmic(label_of_key(&axis.key), span),
        false => plot::Axis::linear(label_of_key(&axis.key), span, 8),
    }
}

/// A quantity over one axis. Its line has a gap where it jumps.
pub(super) fn curve(words: Words<'_>, axis: &Axis, quantity: &Quantity) -> Plot {
    let (name, factor) = quantity.scaled();
    let points: Vec<(usize, (f64, f64))> = quantity
        .values
        .iter()
        .enumerate()
        .filter_map(|(index, value)| Some((index, (axis.value(index), factor * (*value)?))))
        .filter(|(_, (_, value))| value.is_finite())
        .collect();
    let [line, dots] = Curve::dotted("", BLUE, [1.8, 6.0], points.iter().map(|(_, point)| *point));
    let mut curves = vec![line.broken_at_jumps(), dots];
    let (marked, why) = words.marked;
    let rings: Vec<(f64, f64)> = points
        .iter()
        .filter(|(index, _)| marked.get(*index).copied().unwrap_or(false))
        .map(|(_, point)| *point)
        .collect();
    if !rings.is_empty() {
        curves.push(Curve::new(why, VERMILION, Mark::Rings(9.0), rings));
    }
    let up = plot::Axis::linear(name, height(&curves), 7);
    Plot { title: words.title.to_owned(), across: across(axis), up, curves }
}

/// The place of a value on its axis, in decades on a logarithmic one.
fn place(axis: &Axis, value: f64) -> f64 {
    if axis.logarithmic { value.log10() } else { value }
}

/// The ticks of an axis between two places.
fn ticks(axis: &Axis, [low, high]: [f64; 2]) -> Vec<f64> {
    if axis.logarithmic { logarithmic_ticks(low, high, 10) } else { linear_ticks(low, high, 8) }
}

fn label(axis: &Axis, place: f64, all: &[f64]) -> String {
    if axis.logarithmic { logarithmic_label(place, all) } else { tick(place) }
}

/// Edges of all cells of an axis, in its values.
pub(super) fn edges(axis: &Axis) -> Vec<f64> {
    let value = |place: f64| if axis.logarithmic { 10f64.powf(place) } else { place };
    let last = axis.count() - 1;
    (0..=last).map(|index| cell(axis, index).0).chain([cell(axis, last).1]).map(value).collect()
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

fn map(area: &Area<'_>, words: Words<'_>, [across, up]: [&Axis; 2], quantity: &Quantity) -> Drawn {
    let (name, factor) = quantity.scaled();
    let value = |value: &Option<f64>| value.filter(|value| value.is_finite()).map(|value| factor * value);
    let mut area = area.titled(words.title, (FONT, 18))?;
    // What is white is explained under the title.
    if quantity.values.iter().any(|cell| value(cell).is_none()) && !words.without.is_empty() {
        area = area.titled(&format!("white: {}", words.without), LABEL)?;
    }
    let (low, high) = extremes(quantity.values.iter().filter_map(value));
    let (body, scale) = area.split_horizontally(i32::try_from(SIZE.0).unwrap_or(0) - 130);
    let ends = [across, up].map(|axis| [cell(axis, 0).0, cell(axis, axis.count() - 1).1]);
    let [columns, rows] = [ticks(across, ends[0]), ticks(up, ends[1])];
    let mut chart = ChartBuilder::on(&body)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d(Ticked::new(ends[0], &columns), Ticked::new(ends[1], &rows))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(label_of_key(&across.key))
        .y_desc(label_of_key(&up.key))
        .label_style(LABEL)
        .x_label_formatter(&|x| label(across, *x, &columns))
        .y_label_formatter(&|y| label(up, *y, &rows))
        .draw()?;
    chart.draw_series(quantity.values.iter().enumerate().filter_map(|(index, cell_value)| {
        let (left, right) = cell(across, index % across.count());
        let (bottom, top) = cell(up, index / across.count());
        Some(Rectangle::new([(left, bottom), (right, top)], shade(value(cell_value)?, low, high).filled()))
    }))?;
    colour_bar(&scale, &name, [low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Axis {
        text.parse().expect("an axis")
    }

    /// The texts of a picture.
    fn texts(svg: &str) -> Vec<String> {
        let content =
            |element: &str| Some(element.split_once('>')?.1.split("</text").next()?.trim().to_owned());
        svg.split("<text").skip(1).filter_map(content).collect()
    }

    fn power(values: impl IntoIterator<Item = Option<f64>>) -> Quantity {
        Quantity { name: "mean power", unit: "W", values: values.into_iter().collect() }
    }

    #[test]
    fn a_map_has_round_ticks_no_power_below_zero_and_says_what_is_white() {
        let axes = [axis("load.resistance_ohm=1e3:1e5:5:log"), axis("excitation.frequency_hz=19:22:4")];
        let words = Words { title: "Title", without: "the run failed", marked: (&[], "") };
        let values = (0..20).map(|index| (index != 7).then_some(f64::from(index) * 1e-6));
        let told = texts(&draw(words, &axes, &[power(values)]).expect("drawn").expect("a picture"));
        for expected in ["white: the run failed", "mean power [µW]", "10³", "10⁴", "10⁵", "19", "22"] {
            assert!(told.iter().any(|text| text == expected), "{expected} is not in {told:?}");
        }
        // The last axis runs fastest, and goes across: its name is not turned.
        let svg = draw(words, &axes, &[power((0..20).map(|index| Some(f64::from(index))))]);
        let svg = svg.expect("drawn").expect("a picture");
        let turned =
            |name: &str| svg.split("<text").any(|text| text.contains(name) && text.contains("rotate"));
        assert!(turned("load resistance [Ω]") && !turned("excitation frequency [Hz]"));
        assert!(svg.contains("excitation frequency [Hz]") && !svg.contains("frequency_hz"), "no raw key");
        assert!(!told.iter().any(|text| text.contains("3.16") || text.starts_with('-')), "{told:?}");
        let all = (0..20).map(|index| Some(f64::from(index)));
        let told = texts(&draw(words, &axes, &[power(all)]).expect("drawn").expect("a picture"));
        assert!(!told.iter().any(|text| text.contains("white")), "{told:?}");
    }

    #[test]
    fn a_curve_has_a_gap_at_a_jump_and_marks_what_is_unstable() {
        let axes = [axis("excitation.frequency_hz=1:8:8")];
        let marked = [false, false, true, true, false, false, false, false];
        let words = Words { title: "Title", without: "", marked: (&marked, "no stable orbit") };
        let values = [1.0, 1.1, 1.2, 1.3, 9.0, 9.1, 9.2, 9.3].map(Some);
        let svg = draw(words, &axes, &[power(values)]).expect("drawn").expect("a picture");
        let told = texts(&svg);
        assert!(told.iter().any(|text| text == "no stable orbit"), "{told:?}");
        let line = svg.split("stroke-linejoin").nth(1).expect("a line").split("d=\"").nth(1).expect("a path");
        assert_eq!(line.split('"').next().map(|path| path.matches('M').count()), Some(2), "{line}");
        let rings = svg.split("#D55E00").filter(|part| part.contains("h0")).count();
        assert!(rings >= 2, "in the legend and at the points");
    }
}
