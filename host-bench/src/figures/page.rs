//! The page with the figures of a chapter.

use std::fmt::Write;

use super::Chapter;
use crate::report::html::{document, escaped};

/// The page; pictures are in it, numbers in files beside it.
pub fn page(chapter: &Chapter) -> String {
    let mut body = format!("<h1>{}</h1>\n{}", escaped(chapter.title), chapter.introduction);
    for figure in &chapter.figures {
        let _ = writeln!(body, "<h2>{}. {}</h2>", figure.label, escaped(figure.title));
        body.push_str("<div class=\"panels\">\n");
        for panel in &figure.panels {
            let _ = writeln!(body, "<figure>{}</figure>", panel.svg.trim_end());
        }
        body.push_str("</div>\n");
        let _ = writeln!(body, "<p>{}</p>", escaped(&figure.caption));
        body.push_str(&table(&figure.table));
        let links = figure.panels.iter().map(|panel| format!("{}.svg", panel.name));
        let files = std::iter::once(format!("{}.csv", figure.stem())).chain(links);
        let links: Vec<String> = files.map(|file| format!("<a href=\"{file}\">{file}</a>")).collect();
        let _ = writeln!(body, "<p class=\"note\">{}</p>", links.join(" · "));
    }
    document(chapter.title, &body)
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
