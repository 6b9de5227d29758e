//! The page with all figures.

use std::fmt::Write;

use super::{Figure, MOTION_TOLERANCE, RESPONSE_TOLERANCE};
use crate::report::html::{document, escaped};

/// The page; pictures are in it, numbers in files beside it.
#[must_use]
pub fn page(figures: &[Figure]) -> String {
    let mut body = String::from("<h1>Contact-separation harvester: figures 8 to 11 rebuilt</h1>\n");
    let _ = writeln!(
        body,
        "<p>After Fu, Ouyang and Davis, <i>Effects of electrical properties on vibrations via electromechanical \
         coupling in triboelectric energy harvesting</i>, J. Phys. D 53 (2020). Most numbers of the paper do not \
         survive in the text that we have. Mass, stiffness, electrode area, restitution, amplitude of the base, \
         the charge densities and the middle resistance are choices of this library, made so that the paper's \
         trends show: compare shapes and trends with the paper, not values.</p>"
    );
    let _ = writeln!(
        body,
        "<p>Run in double precision on the embedded core, the code of the firmware, with a relative tolerance \
         of {RESPONSE_TOLERANCE:.0e} for the frequency responses (figures 8 and 11) and of \
         {MOTION_TOLERANCE:.0e} for single motions (9 and 10).</p>"
    );
    for figure in figures {
        let _ = writeln!(body, "<h2>Figure {}. {}</h2>", figure.number, escaped(figure.title));
        body.push_str("<div class=\"panels\">\n");
        for panel in &figure.panels {
            let _ = writeln!(body, "<figure>{}</figure>", panel.svg.trim_end());
        }
        body.push_str("</div>\n");
        let _ = writeln!(body, "<p>{}</p>", escaped(&figure.caption));
        body.push_str(&table(&figure.table));
        let links = figure.panels.iter().map(|panel| format!("{}.svg", panel.name));
        let files = std::iter::once(format!("figure-{}.csv", figure.number)).chain(links);
        let links: Vec<String> = files.map(|file| format!("<a href=\"{file}\">{file}</a>")).collect();
        let _ = writeln!(body, "<p class=\"note\">{}</p>", links.join(" · "));
    }
    document("Contact-separation harvester: figures 8 to 11 rebuilt", &body)
}

fn table(rows: &[Vec<String>]) -> String {
    let Some((heading, rows)) = rows.split_first() else { return String::new() };
    let line = |row: &[String], tag: &str| {
        let cells = row.iter().map(|cell| format!("<{tag} class=\"number\">{}</{tag}>", escaped(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = rows.iter().map(|row| line(row, "td")).collect();
    format!("<div class=\"wide\"><table>\n<thead>{}</thead>\n{rows}</table></div>\n", line(heading, "th"))
}
