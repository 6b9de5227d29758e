//! The part of the report about the bump-stop harvester.

use std::fmt::Write;

use super::html::escaped;
use crate::work_precision::bump_stop::{BumpStopComparison, TARGET_ERROR, table};

/// Heading, table and notes of one scene.
pub(super) fn section(comparison: &BumpStopComparison) -> String {
    let class = |index: usize| if index < table::WORDS { "" } else { " class=\"number\"" };
    let mut text = String::from("<h2>Bump-stop harvester</h2>\n");
    let _ = writeln!(
        text,
        "<p>A piezoelectric cantilever that hits a rod, by the core's method (exact modal steps, the contact a \
         discrete gradient) beside general methods on the host. {}</p>",
        escaped(&comparison.title())
    );
    text.push_str("<div class=\"wide\"><table>\n<thead><tr>");
    for (index, heading) in table::HEADINGS.iter().enumerate() {
        let _ = write!(text, "<th{}>{}</th>", class(index), escaped(heading));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for row in &comparison.rows {
        text.push_str(if row.reaches_target() { "<tr>" } else { "<tr class=\"beyond\">" });
        for (index, cell) in row.cells().iter().enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(index), escaped(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody>\n</table></div>\n");
    let _ = writeln!(
        text,
        "<p class=\"note\">Grey: RMS voltage not within {TARGET_ERROR:.0e} of the reference.</p>"
    );
    for note in comparison.notes() {
        let _ = writeln!(text, "<p class=\"note\">{}</p>", escaped(&note));
    }
    text
}
