//! A sweep as a page: charts over one axis, over two the map and its rows as curves.

use std::fmt::Write;

use super::axis::Axis;
use super::picture::{Quantity, Words, across, curve, draw, long, shown};
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped};
use crate::report::plot::{self, Curve, Plot, height};
use crate::report::svg::{shade, tick};

/// Most curves of one chart.
const MOST: usize = 24;
/// Charts show the same part of the abscissa.
const LOOK: Look<'_> = Look { height: 360, group: Some("over") };

/// The page; `None` without values, without an axis of several values, or with more than two.
pub(super) fn page(
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
            for quantity in shown {
                body += &charts.place(&family(rows, axis, quantity), LOOK);
            }
            if rows.count() > MOST {
                let every = rows.count().div_ceil(MOST);
                let _ =
                    writeln!(body, "<p class=\"note\">One of {every} values of {}.</p>", escaped(&rows.key));
            }
            let map = draw(words, axes, quantities)?.unwrap_or_default();
            let _ = writeln!(body, "<figure>{map}</figure>");
        }
        _ => return Ok(None),
    }
    body += &charts.scripts();
    Ok(Some(document(words.title, &body)))
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
        assert!(page.contains("<h1>a &amp; b</h1>") && page.contains("<svg"));
        for value in ["1000", "1e4", "1e5"] {
            assert!(page.contains(&format!("\"name\":\"load.resistance_ohm = {value}\"")), "{value}");
        }
        assert_eq!(page.matches("\"named\":").count(), 3);
    }
}
