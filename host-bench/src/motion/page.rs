//! The picture as a page: time histories, spectrum and portrait are charts with zoom and hover; of the energy flow the pointer
//! shows the parts.

use std::fmt::Write;

use super::{COLOURS, STRIP, Series, View, WIDTH, Wanted, energy, history, lines, phase};
use crate::method::Failure;
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped};
use crate::report::plot::Plot;

/// How the portrait stands in the page.
const PORTRAIT: Look<'_> = Look { height: 560, group: None };

/// The page.
pub(crate) fn page(wanted: &Wanted<'_>, series: &[Series]) -> Result<String, Failure> {
    let has = |view: View| wanted.views.contains(&view);
    let mut charts = Charts::default();
    let mut body = format!("<h1>{}</h1>\n{HINT}", escaped(wanted.title));
    // The page has the title of the first.
    let untitled = |plot: Plot| Plot { title: String::new(), ..plot };
    if has(View::History) {
        let together = Look { height: STRIP, group: Some("time") };
        for (index, name) in wanted.quantities.iter().enumerate() {
            body += &charts.place(&untitled(history(wanted, series, name, index == 0)), together);
        }
    }
    if has(View::Spectrum)
        && let Some(plot) = lines(wanted, series)
    {
        body += &charts.place(&plot, Look::ALONE);
    }
    if has(View::Phase)
        && let Some(plot) = phase(wanted, series)
    {
        body += &charts.place_orbits(&plot, PORTRAIT);
    }
    if has(View::Energy)
        && let Some((_, svg)) = energy::flow(WIDTH, series, COLOURS)
    {
        let _ = writeln!(body, "<figure>{svg}</figure>");
    }
    body += &charts.scripts();
    Ok(document(wanted.title, &body))
}
