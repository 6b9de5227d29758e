//! The picture as a page with zoom, hover and toggles: one file, readable without a network.
//!
//! uPlot 1.6.32 (MIT, its licence beside it) draws the time histories and the spectrum; portrait and energy flow are pictures.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{COLOURS, PANEL, Series, View, WIDTH, Wanted, energy, fault, history, lines, phase};
use crate::method::Failure;
use crate::report::html::{document, escaped};
use crate::report::plot::{self, Curve, Mark, Plot};

const LIBRARY: &str = include_str!("uplot/uPlot.iife.min.js");
const STYLE: &str = include_str!("uplot/uPlot.min.css");
/// Makes a chart of each object of `charts`. Time histories share their zoom and their cursor.
const SCRIPT: &str = include_str!("page.js");

/// The page.
pub(crate) fn page(wanted: &Wanted<'_>, series: &[Series]) -> Result<String, Failure> {
    let has = |view: View| wanted.views.contains(&view);
    let mut charts: Vec<Value> = Vec::new();
    if has(View::History) {
        let plots = wanted.quantities.iter().enumerate();
        charts.extend(plots.map(|(index, name)| chart(&history(wanted, series, name, index == 0), true)));
    }
    if has(View::Spectrum) {
        charts.extend(lines(wanted, series).map(|plot| chart(&plot, false)));
    }
    let mut body = format!(
        "<h1>{}</h1>\n<p>Drag over a chart to zoom, double-click for all of it; a click on a name hides its curve.</p>\n\
         <style>{STYLE}</style>\n<div id=\"charts\"></div>\n",
        escaped(wanted.title)
    );
    if has(View::Phase)
        && let Some(plot) = phase(wanted, series)
    {
        let _ = writeln!(body, "<figure>{}</figure>", plot::draw(PANEL, &[plot]).map_err(fault)?);
    }
    if has(View::Energy)
        && let Some((_, svg)) = energy::flow(WIDTH, series, COLOURS)
    {
        let _ = writeln!(body, "<figure>{svg}</figure>");
    }
    // A text in the data must not end the script.
    let data = Value::Array(charts).to_string().replace("</", "<\\/");
    let _ = writeln!(body, "<script>{LIBRARY}</script>\n<script>const charts = {data};\n{SCRIPT}</script>");
    Ok(document(wanted.title, &body))
}

/// A plot as the script wants it.
fn chart(plot: &Plot, in_time: bool) -> Value {
    json!({
        "across": plot.across.title,
        "up": plot.up.title,
        "logarithmic": [plot.across.is_logarithmic(), plot.up.is_logarithmic()],
        "inTime": in_time,
        "curves": plot.curves.iter().map(|one| curve(one, &plot.up.title)).collect::<Vec<_>>(),
    })
}

fn curve(curve: &Curve, quantity: &str) -> Value {
    // Seven digits are more than a screen shows.
    let short = |value: f64| format!("{value:.6e}").parse::<f64>().unwrap_or(value);
    let points = || curve.points.iter().filter(|point| point.0.is_finite() && point.1.is_finite());
    json!({
        "name": if curve.name.is_empty() { quantity } else { &curve.name },
        "colour": format!("#{:02X}{:02X}{:02X}", curve.colour.0, curve.colour.1, curve.colour.2),
        "dots": matches!(curve.mark, Mark::Dots(_) | Mark::Rings(_)),
        // Nine digits of the time: two rows must not have the same.
        "x": points().map(|point| format!("{:.9e}", point.0).parse::<f64>().unwrap_or(point.0)).collect::<Vec<f64>>(),
        "y": points().map(|point| short(point.1)).collect::<Vec<f64>>(),
    })
}
