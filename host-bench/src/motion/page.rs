//! The picture as a page: time histories and spectrum are charts with zoom and hover, portrait and energy flow are pictures.

use std::fmt::Write;

use super::{COLOURS, PANEL, STRIP, Series, View, WIDTH, Wanted, energy, fault, history, lines, phase};
use crate::method::Failure;
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped};
use crate::report::plot::{self, Plot};

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
        let _ = writeln!(body, "<figure>{}</figure>", plot::draw(PANEL, &[plot]).map_err(fault)?);
    }
    if has(View::Energy)
        && let Some((_, svg)) = energy::flow(WIDTH, series, COLOURS)
    {
        let _ = writeln!(body, "<figure>{svg}</figure>");
    }
    body += &charts.scripts();
    Ok(document(wanted.title, &body))
}
