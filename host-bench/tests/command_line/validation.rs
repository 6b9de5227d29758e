//! The command `validation`: its formats, and the page that has its table.

use super::tool::{accepted, folder, json, place, refused};

#[test]
fn the_page_has_the_table_and_the_formats_have_the_same_rows() {
    let table = accepted(&["validation"]);
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/validation.md");
    let page = std::fs::read_to_string(page).expect("the page");
    assert!(page.contains(&table), "validation > the table of docs/validation.md\n{table}");
    let first = page.lines().find(|line| !line.is_empty() && !line.starts_with('#')).expect("a line");
    assert!(
        first.contains("Neither") && first.contains("force law") && first.contains("friction"),
        "{first}"
    );
    let rows = json(&["validation"]);
    let rows = rows.as_array().expect("rows");
    let csv = accepted(&["validation", "--format", "csv"]);
    let names = ["quantity", "source", "start", "measured", "ours", "relative_difference", "fitted"];
    assert_eq!(csv.lines().next(), Some(names.join(",").as_str()));
    assert_eq!([csv.lines().count(), table.lines().count()], [rows.len() + 1; 2]);
    for row in rows {
        assert_eq!(row.as_object().map(|row| row.keys().eq(names)), Some(true), "{row}");
    }
}

#[test]
fn the_picture_has_what_was_measured() {
    let file = place(&folder("validation"), "measured.svg");
    accepted(&["-q", "validation", "--picture", &file]);
    let picture = std::fs::read_to_string(&file).expect("the picture");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/figures/validation.svg");
    assert_eq!(picture, std::fs::read_to_string(shipped).expect("the picture of the page"));
    for text in ["peak power [mW/g²]", "load [Ω]", "open-circuit resonance, 48.1 Hz", "measured, cycle 2"] {
        assert!(picture.contains(text), "{text}");
    }
    refused(&["validation", "--picture", "measured.png"], &["--picture", "measured.png"]);
}
