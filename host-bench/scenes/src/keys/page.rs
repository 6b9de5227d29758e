//! The keys of scene files for a terminal.

use super::{Row, rows};
use crate::outcome::folded;

/// A table of the file with its rows.
struct Part {
    title: String,
    note: &'static str,
    rows: Vec<Row>,
}

fn parts(scene: Option<&str>) -> Vec<Part> {
    let (tables, rows): (Vec<Row>, Vec<Row>) = rows(scene).into_iter().partition(|row| row.is_table);
    let mut parts: Vec<Part> = Vec::new();
    for row in rows {
        let same = |part: &&mut Part| part.rows[0].scene == row.scene && part.rows[0].table == row.table;
        if let Some(part) = parts.iter_mut().rev().find(same) {
            part.rows.push(row);
            continue;
        }
        let path = |table: &Row| format!("{}.{}", table.table, table.key);
        let is_around =
            |table: &&Row| table.scene == row.scene && path(table).trim_start_matches('.') == row.table;
        let around = tables.iter().find(is_around);
        let note = around.map_or("", |table| table.meaning);
        parts.push(Part { title: title(&row, around), note, rows: vec![row] });
    }
    parts
}

fn title(first: &Row, table: Option<&Row>) -> String {
    let Some(table) = table else { return "The whole file".to_owned() };
    let name = if table.bounds == "a list of tables" {
        format!("`[[{}]]`", first.table)
    } else {
        format!("`[{}]`", first.table)
    };
    let of = first.scene.map_or(String::new(), |scene| format!(" of {scene}"));
    match table.default.as_str() {
        "required" => format!("{name}{of}"),
        default => format!("{name}{of}, optional: {default}"),
    }
}

/// The keys for a terminal, of one scene or of all.
pub fn text(scene: Option<&str>) -> String {
    let mut text = String::new();
    for part in parts(scene) {
        let note = if part.note.is_empty() { String::new() } else { format!(": {}", part.note) };
        text += &(folded(&format!("{}{note}", plain(&part.title)), 2) + "\n");
        let cells: Vec<[String; 5]> = part
            .rows
            .iter()
            .map(|row| {
                let kind = row.kind.unwrap_or_default().to_owned();
                [kind, row.key.to_owned(), row.unit.to_owned(), plain(&row.bounds), plain(&row.default)]
            })
            .collect();
        // A long cell does not widen the others.
        let width = |column: usize| {
            let widths =
                cells.iter().map(|cells| cells[column].chars().count()).filter(|width| *width <= WIDEST);
            // A column of long cells only is not aligned, and not left out.
            let empty = cells.iter().all(|cells| cells[column].is_empty());
            widths.max().unwrap_or(0).max(usize::from(!empty))
        };
        let widths: [usize; 5] = std::array::from_fn(width);
        for (cells, row) in cells.iter().zip(&part.rows) {
            let mut line = " ".to_owned();
            for (cell, width) in cells.iter().zip(widths).filter(|(_, width)| *width > 0) {
                line += &format!(" {cell:<width$} ");
            }
            text += &(folded(&format!("{line} {}", plain(row.meaning)), 6) + "\n");
        }
        text.push('\n');
    }
    text
}

/// Widest cell in letters that the others of its column are aligned with.
const WIDEST: usize = 44;

fn plain(text: &str) -> String {
    text.replace('`', "")
}
