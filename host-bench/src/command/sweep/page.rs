//! A sweep as a page: charts over one axis, over two its rows as curves and the map.

use std::fmt::Write;

use super::axis::Axis;
use super::picture::{Quantity, Words, across, curve, edges, long, shown};
use crate::report::charts::{Charts, HINT, Look};
use crate::report::field::{Field, Told};
use crate::report::html::{document, escaped};
use crate::report::label::label;
use crate::report::plot::{self, Curve, Plot, height};
use crate::report::svg::{extremes, shade, tick};

/// Most curves of one chart.
const MOST: usize = 24;
/// Charts show the same part of the abscissa.
const LOOK: Look<'_> = Look { height: 360, group: Some("over") };
const MAP: Look<'_> = Look { height: 480, group: None };

/// The page; `None` without values, without an axis of several values, or with more than two.
pub(in crate::command) fn page(
    words: Words<'_>,
    axes: &[Axis],
    quantities: &[Quantity],
) -> Result<Option<String>, String> {
    let (long, shown) = (long(axes), shown(quantities));
    if shown.is_empty() {
        return Ok(None);
    }
    let mut charts = Charts::default();
    let mut body = format!("<h1>{}</h1>\n{HINT}", escaped(words.title));
    match long[..] {
        [axis] => {
            for quantity in shown {
                let plot = Plot { title: String::new(), ..curve(words, axis, quantity) };
                body += &charts.place(&plot, LOOK);
            }
        }
        [rows, axis] => {
            for quantity in &shown {
                body += &charts.place(&family(rows, axis, quantity), LOOK);
            }
            if rows.count() > MOST {
                let every = rows.count().div_ceil(MOST);
                let _ =
                    writeln!(body, "<p class=\"note\">One of {every} values of {}.</p>", escaped(&rows.key));
            }
            for quantity in &shown {
                let (plot, field) = map([rows, axis], quantity);
                body += &charts.place_field(&plot, &field, MAP);
            }
            if shown.iter().any(|quantity| quantity.values.iter().any(Option::is_none)) {
                let _ = writeln!(body, "<p class=\"note\">White: {}.</p>", escaped(words.without));
            }
        }
        _ => return Ok(None),
    }
    body += &charts.scripts();
    Ok(Some(document(words.title, &body)))
}

/// The cells over both axes.
fn map([rows, axis]: [&Axis; 2], quantity: &Quantity) -> (Plot, Field) {
    let (name, factor) = quantity.scaled();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite()).map(|value| factor * value);
    let [columns, lines] = [rising(axis), rising(rows)];
    let at = |row: usize, column: usize| quantity.values.get(row * axis.count() + column).copied().flatten();
    let values: Vec<Option<f64>> =
        lines.iter().flat_map(|&row| columns.iter().map(move |&column| finite(at(row, column)))).collect();
    let (least, most) = extremes(values.iter().flatten().copied());
    let ends = if least <= most { [least, most] } else { [0.0; 2] };
    let all = |axis: &Axis, order: &[usize]| order.iter().map(|&index| axis.value(index)).collect();
    let edges = [edges(axis), edges(rows)].map(|mut edges| {
        edges.sort_by(f64::total_cmp);
        edges
    });
    let span = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
    let plot = Plot {
        title: name.clone(),
        across: across(axis).over(span(&edges[0])),
        up: across(rows).over(span(&edges[1])),
        curves: Vec::new(),
    };
    let tells = vec![
        Told::Column(label(&axis.key), all(axis, &columns)),
        Told::Row(label(&rows.key), all(rows, &lines)),
        Told::Cell(name, values.clone()),
    ];
    (plot, Field { edges, values, ends, words: ends.map(tick), tells, numbers: None })
}

/// The indices of an axis in the order of its values.
fn rising(axis: &Axis) -> Vec<usize> {
    let count = axis.count();
    if axis.value(0) < axis.value(count - 1) { (0..count).collect() } else { (0..count).rev().collect() }
}

/// A curve over the axis for each value of the rows, or for every so many of them.
fn family(rows: &Axis, axis: &Axis, quantity: &Quantity) -> Plot {
    let (name, factor) = quantity.scaled();
    let every = rows.count().div_ceil(MOST);
    let last = (rows.count() - 1) as f64;
    let curves: Vec<Curve> = (0..rows.count())
        .step_by(every)
        .flat_map(|row| {
            let points = (0..axis.count()).filter_map(|column| {
                let value = (*quantity.values.get(row * axis.count() + column)?)?;
                Some((axis.value(column), factor * value))
            });
            // The lightest yellow would not be seen on white.
            let colour = shade(row as f64, 0.0, 1.15 * last);
            let name = format!("{} = {}", rows.key, tick(rows.value(row)));
            let [line, dots] = Curve::dotted(name, colour, [1.6, 5.0], points);
            [line.broken_at_jumps(), dots]
        })
        .collect();
    let up = plot::Axis::linear(name, height(&curves), 7);
    Plot { title: String::new(), across: across(axis), up, curves }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_over_two_axes_has_a_curve_for_each_row_and_the_map() {
        let axes: Vec<Axis> = ["load.resistance_ohm=1e3:1e5:3:log", "excitation.frequency_hz=19:22:4"]
            .map(|text| text.parse().expect("an axis"))
            .into();
        let values = (0..12).map(|index| (index != 7).then_some(f64::from(index) * 1e-6));
        let quantity = Quantity { name: "mean power", unit: "W", values: values.collect() };
        let words = Words { title: "a & b", without: "the run failed", marked: (&[], "") };
        let page = page(words, &axes, &[quantity]).expect("drawn").expect("a page");
        assert!(page.contains("<h1>a &amp; b</h1>") && page.contains("White: the run failed"));
        // Eleven cells have a colour.
        let shades =
            page.split("\"shades\":[").nth(1).and_then(|rest| rest.split(']').next()).expect("a map");
        assert_eq!(shades.matches("null").count(), 1);
        assert_eq!(shades.split(',').count(), 12);
        for value in ["1000", "1e4", "1e5"] {
            assert!(page.contains(&format!("\"name\":\"load.resistance_ohm = {value}\"")), "{value}");
        }
        assert_eq!(page.matches("\"named\":").count(), 3);
    }
}
