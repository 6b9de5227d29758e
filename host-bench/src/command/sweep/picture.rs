//! The picture of a sweep: curves over one axis; over two a map, and on a page its rows as curves.

use super::axis::Axis;
use crate::report::Picture;
use crate::report::chart::{self, Chart, Curve, FITTING, Mark};
use crate::report::setting::{axis_of, distinct_labels, scaled, words_and_unit};
use crate::report::svg::{BLUE, COLOURS, VERMILION, shade};

/// Most curves of one chart.
const MOST: usize = 24;

/// A quantity to draw: its name, its unit, and one value for each point, if there is one.
#[derive(Debug, Clone)]
pub(in crate::command) struct Quantity {
    pub(in crate::command) name: &'static str,
    /// Empty where it has none.
    pub(in crate::command) unit: &'static str,
    pub(in crate::command) values: Vec<Option<f64>>,
}

impl Quantity {
    /// Its name with the unit that its values are shown in, and the values in it, as far as they are finite.
    fn scaled(&self) -> (String, Vec<Option<f64>>) {
        let finite = || self.values.iter().map(|value| value.filter(|value| value.is_finite()));
        let (name, factor) = scaled(self.name, self.unit, finite().flatten());
        (name, finite().map(|value| value.map(|value| factor * value)).collect())
    }
}

#[derive(Debug, Clone, Copy)]
pub(in crate::command) struct Labels<'a> {
    pub(in crate::command) title: &'a str,
    /// Why a point has no value: what is white on a map.
    pub(in crate::command) without: &'a str,
    /// Which points are marked, and why; none where it is empty.
    pub(in crate::command) marked: (&'a [bool], &'a str),
}

/// The picture; `None` without values, without an axis of several values, or with more than two.
pub(in crate::command) fn picture(
    words: Labels<'_>,
    axes: &[Axis],
    quantities: &[Quantity],
) -> Option<Picture> {
    let long: Vec<&Axis> = axes.iter().filter(|axis| axis.count() > 1).collect();
    let scaled: Vec<_> = quantities.iter().map(Quantity::scaled).collect();
    let shown = || scaled.iter().filter(|(_, values)| values.iter().any(Option::is_some));
    let charts: Vec<Chart> = match long[..] {
        [axis] => shown().map(|quantity| curve(words, axis, quantity)).collect(),
        // The last axis runs fastest, and goes across.
        [rows, axis] => {
            let families = shown().map(|quantity| family(rows, axis, quantity));
            families.chain(shown().map(|quantity| map(words, [axis, rows], quantity))).collect()
        }
        _ => Vec::new(),
    };
    let title = words.title.to_owned();
    (!charts.is_empty()).then_some(Picture { title, width: 900, charts, ..Picture::default() })
}

/// Points of a few kinds over two axes, the last of which goes across: each kind has a name, a mark and a colour.
pub(in crate::command) fn kinds(
    title: &str,
    [rows, axis]: &[Axis; 2],
    kinds: impl Iterator<Item = (String, Vec<[f64; 2]>)>,
) -> Picture {
    let [(first, to_first), (second, to_second)] = [axis, rows].map(across);
    // A mark has room between its neighbours.
    let size = (300.0 / axis.count() as f64).clamp(3.0, 10.0);
    let kinds = kinds
        .map(|(name, points)| (name, points.into_iter().map(move |[x, y]| (to_first * x, to_second * y))));
    let curves = Curve::distinct(&COLOURS, (Mark::point, size), kinds);
    let chart = Chart { height: 560, ..Chart::new("", first, second, curves) };
    Picture { title: title.to_owned(), width: 900, charts: vec![chart], ..Picture::default() }
}

/// The axis of a chart, and the factor to the unit that it shows.
fn across(axis: &Axis) -> (chart::Axis, f64) {
    axis_of(&axis.key, axis.logarithmic, [axis.value(0), axis.value(axis.count() - 1)])
}

/// A quantity over one axis. Its line has a gap where it jumps.
fn curve(words: Labels<'_>, axis: &Axis, (name, values): &(String, Vec<Option<f64>>)) -> Chart {
    let (across, factor) = across(axis);
    let point =
        |(index, value): (usize, &Option<f64>)| Some((index, (factor * axis.value(index), (*value)?)));
    let points: Vec<(usize, (f64, f64))> = values.iter().enumerate().filter_map(point).collect();
    let line = Curve::new("", BLUE, Mark::dotted(0, [1.8, 6.0]), points.iter().map(|(_, point)| *point));
    let mut curves = vec![line.broken_at_jumps()];
    let has_gap = curves[0].points.iter().any(|point| point.0.is_nan());
    let note = if has_gap { "a gap in the line: the value jumps, as from one motion to another" } else { "" };
    let (marked, why) = words.marked;
    let rings = points.iter().filter(|(index, _)| marked.get(*index).copied().unwrap_or(false));
    let rings = Curve::new(why, VERMILION, Mark::point(1, 9.0), rings.map(|(_, point)| *point));
    curves.extend(Some(rings).filter(|rings| !rings.points.is_empty()));
    let up = chart::Axis::linear(name.as_str(), FITTING, 7);
    Chart { note: note.to_owned(), ..Chart::new("", across, up, curves).grouped("over", 320) }
}

/// The cells over both axes.
fn map(words: Labels<'_>, axes: [&Axis; 2], (name, values): &(String, Vec<Option<f64>>)) -> Chart {
    // The indices of an axis in the order of its values.
    let [columns, rows] = axes.map(|axis| {
        let mut indices: Vec<usize> = (0..axis.count()).collect();
        indices.sort_by(|one, other| axis.value(*one).total_cmp(&axis.value(*other)));
        indices
    });
    let at = |row: usize, column: usize| values.get(row * columns.len() + column).copied().flatten();
    let cells = rows.iter().flat_map(|&row| columns.iter().map(move |&column| (row, column)));
    let cells = cells.map(|(row, column)| at(row, column)).collect();
    let [(first, to_first), (second, to_second)] = axes.map(across);
    let middles = [(axes[0], &columns, to_first), (axes[1], &rows, to_second)]
        .map(|(axis, order, factor)| order.iter().map(|&index| factor * axis.value(index)).collect());
    let scale = chart::Axis::linear(name.as_str(), FITTING, 8);
    let map = Chart::map([first, second], middles, scale, cells);
    let note = if map.has_white() { format!("white: {}", words.without) } else { String::new() };
    Chart { note, ..map }
}

/// A curve over the axis for each value of the rows, or for every so many of them.
fn family(rows: &Axis, axis: &Axis, (name, values): &(String, Vec<Option<f64>>)) -> Chart {
    let every = rows.count().div_ceil(MOST);
    let (across, factor) = across(axis);
    let (words, unit) = words_and_unit(&rows.key);
    let drawn: Vec<usize> = (0..rows.count()).step_by(every).collect();
    let labels = distinct_labels(&drawn.iter().map(|row| rows.value(*row)).collect::<Vec<_>>(), &unit);
    let curve = |(number, (&row, label)): (usize, (&usize, &String))| {
        let value = |column: usize| values.get(row * axis.count() + column).copied().flatten();
        let point = |column| Some((factor * axis.value(column), value(column)?));
        let points = (0..axis.count()).filter_map(point);
        // The lightest yellow would not be seen on white.
        let colour = shade(row as f64, 0.0, 1.15 * (rows.count() - 1) as f64);
        Curve::new(format!("{words} = {label}"), colour, Mark::dotted(number, [1.6, 5.0]), points)
            .broken_at_jumps()
    };
    let curves = drawn.iter().zip(&labels).enumerate().map(curve).collect();
    let chart = Chart::new("", across, chart::Axis::linear(name.as_str(), FITTING, 7), curves);
    let note = format!("{} of the {} values of {words} are drawn.", drawn.len(), rows.count());
    let note = if every > 1 { note } else { String::new() };
    Chart { note, is_of_page: true, ..chart.grouped("over", 360) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Axis {
        text.parse().expect("an axis")
    }

    fn texts(svg: &str) -> Vec<String> {
        let content =
            |element: &str| Some(element.split_once('>')?.1.split("</text").next()?.trim().to_owned());
        svg.split("<text").skip(1).filter_map(content).collect()
    }

    fn power(values: impl IntoIterator<Item = Option<f64>>) -> Quantity {
        Quantity { name: "mean power", unit: "W", values: values.into_iter().collect() }
    }

    fn draw(words: Labels<'_>, axes: &[Axis], quantity: Quantity) -> String {
        picture(words, axes, &[quantity]).expect("a picture").svg().expect("drawn")
    }

    #[test]
    fn a_map_has_round_ticks_no_power_below_zero_and_says_what_is_white() {
        let axes = [axis("load.resistance_ohm=1e3:1e5:5:log"), axis("excitation.frequency_hz=19:22:4")];
        let words = Labels { title: "Title", without: "the run failed", marked: (&[], "") };
        let values = (0..20).map(|index| (index != 7).then_some(f64::from(index) * 1e-6));
        let messages = texts(&draw(words, &axes, power(values)));
        for expected in ["white: the run failed", "mean power [µW]", "10³", "10⁴", "10⁵", "19", "22"] {
            assert!(messages.iter().any(|text| text == expected), "{expected} is not in {messages:?}");
        }
        // The last axis runs fastest, and goes across: its name is not turned.
        let svg = draw(words, &axes, power((0..20).map(|index| Some(f64::from(index)))));
        let turned =
            |name: &str| svg.split("<text").any(|text| text.contains(name) && text.contains("rotate"));
        assert!(turned("load resistance [Ω]") && !turned("excitation frequency [Hz]"));
        assert!(svg.contains("excitation frequency [Hz]") && !svg.contains("frequency_hz"), "no raw key");
        assert!(!messages.iter().any(|text| text.contains("3.16") || text.starts_with('-')), "{messages:?}");
        let all = (0..20).map(|index| Some(f64::from(index)));
        let messages = texts(&draw(words, &axes, power(all)));
        assert!(!messages.iter().any(|text| text.contains("white")), "{messages:?}");
    }

    #[test]
    fn a_curve_has_a_gap_at_a_jump_and_marks_what_is_unstable() {
        let axes = [axis("excitation.frequency_hz=1:8:8")];
        let marked = [false, false, true, true, false, false, false, false];
        let words = Labels { title: "Title", without: "", marked: (&marked, "no stable orbit") };
        let values = [1.0, 1.1, 1.2, 1.3, 9.0, 9.1, 9.2, 9.3].map(Some);
        let svg = draw(words, &axes, power(values));
        let messages = texts(&svg);
        assert!(messages.iter().any(|text| text == "no stable orbit"), "{messages:?}");
        let line = svg.split("stroke-linejoin").nth(1).expect("a line").split("d=\"").nth(1).expect("a path");
        assert_eq!(line.split('"').next().map(|path| path.matches('M').count()), Some(2), "{line}");
        let rings = svg.split("#D55E00").filter(|part| part.contains("h0")).count();
        assert!(rings >= 2, "in the legend and at the points");
    }

    #[test]
    fn a_page_over_two_axes_has_a_curve_for_each_row_and_the_map() {
        let axes: Vec<Axis> = ["load.resistance_ohm=1e3:1e5:3:log", "excitation.frequency_hz=19:22:4"]
            .map(|text| text.parse().expect("an axis"))
            .into();
        let quantity = power((0..12).map(|index| (index != 7).then_some(f64::from(index) * 1e-6)));
        let words = Labels { title: "a & b", without: "the run failed", marked: (&[], "") };
        let page = picture(words, &axes, &[quantity]).expect("a picture").page().expect("drawn");
        assert!(page.contains("<h1>a &amp; b</h1>") && page.contains("white: the run failed"));
        // Eleven cells have a colour.
        let shades =
            page.split("\"shades\":[").nth(1).and_then(|rest| rest.split(']').next()).expect("a map");
        assert_eq!(shades.matches("null").count(), 1);
        assert_eq!(shades.split(',').count(), 12);
        for value in ["1 kΩ", "10 kΩ", "100 kΩ"] {
            assert!(page.contains(&format!("\"name\":\"load resistance = {value}\"")), "{value}");
        }
        assert_eq!(page.matches("\"named\":").count(), 3);
    }
}
