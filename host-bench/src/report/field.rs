//! A map of colours in a chart: cells between edges, and what the pointer tells of each.

use std::fmt::Write;

use serde_json::{Value, json};

use super::charts::short;
use super::html::escaped;
use super::svg::shade;

/// Shades from the least to the largest value.
const SHADES: usize = 64;

/// Cells between the edges of columns and rows; the columns run fastest.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    /// Edges on the abscissa and on the ordinate, rising, one more than columns and rows.
    pub(crate) edges: [Vec<f64>; 2],
    /// What the colour of each cell is of; a cell without is white.
    pub(crate) values: Vec<Option<f64>>,
    /// The values of the first and of the last colour.
    pub(crate) ends: [f64; 2],
    /// What stands at both ends of the scale of colours.
    pub(crate) words: [String; 2],
    /// What the pointer tells of a cell.
    pub(crate) tells: Vec<Told>,
    /// The numbers at the edges of the abscissa, where these are places and not numbers.
    pub(crate) numbers: Option<Vec<f64>>,
}

/// What the pointer tells: a quantity with its unit in brackets, and its value.
#[derive(Debug, Clone)]
pub(crate) enum Told {
    /// Of each column.
    Column(String, Vec<f64>),
    /// Of each row.
    Row(String, Vec<f64>),
    /// Of each cell.
    Cell(String, Vec<Option<f64>>),
    /// Of each cell one of these texts, by its index.
    Text(&'static [&'static str], Vec<usize>),
}

impl Told {
    fn json(&self) -> Value {
        let numbers = |values: &[f64]| values.iter().map(|value| short(*value)).collect::<Vec<Value>>();
        match self {
            Self::Column(title, values) => {
                json!({ "of": "column", "title": title, "values": numbers(values) })
            }
            Self::Row(title, values) => json!({ "of": "row", "title": title, "values": numbers(values) }),
            Self::Cell(title, values) => {
                let values: Vec<f64> = values.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
                json!({ "of": "cell", "title": title, "values": numbers(&values) })
            }
            Self::Text(texts, indices) => json!({ "of": "cell", "texts": texts, "values": indices }),
        }
    }
}

/// A colour as CSS has it; 0 is the first, 1 the last.
fn colour(part: f64) -> String {
    let colour = shade(part, 0.0, 1.0);
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}

impl Field {
    /// As the script wants it.
    pub(super) fn json(&self) -> Value {
        let [least, most] = self.ends;
        let last = (SHADES - 1) as f64;
        let index = |value: f64| {
            let part = if most > least { (value - least) / (most - least) } else { 0.5 };
            (part.clamp(0.0, 1.0) * last).round() as usize
        };
        let [x, y] = &self.edges;
        json!({
            "x": x,
            "y": y,
            "palette": (0..SHADES).map(|index| colour(index as f64 / last)).collect::<Vec<String>>(),
            "shades": self.values.iter().map(|value| value.map(index)).collect::<Vec<Option<usize>>>(),
            "tells": self.tells.iter().map(Told::json).collect::<Vec<Value>>(),
            "numbers": self.numbers,
        })
    }

    /// The scale of the colours as HTML.
    pub(super) fn scale(&self) -> String {
        let [least, most] = self.words.each_ref().map(|word| escaped(word));
        let mut stops = String::new();
        for index in 0..=8 {
            let _ = write!(stops, ",{}", colour(f64::from(index) / 8.0));
        }
        format!(
            "<p class=\"scale\">{least} <span style=\"background:linear-gradient(to right{stops})\"></span> {most}</p>\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_shades_texts_and_gaps() {
        let field = Field {
            edges: [vec![0.0, 1.0, 2.0], vec![1.0, 2.0]],
            values: vec![Some(3.0), None],
            ends: [1.0, 3.0],
            words: ["1 W".to_owned(), "<3 W".to_owned()],
            tells: vec![
                Told::Cell("power [W]".to_owned(), vec![Some(3.0), None]),
                Told::Text(&["one motion", "outside"], vec![0, 1]),
            ],
            numbers: None,
        };
        let json = field.json();
        assert_eq!(json["shades"], json!([63, null]));
        assert_eq!(json["palette"][63], "#FDE725");
        assert_eq!(json["tells"][0]["values"], json!([3.0, null]));
        assert_eq!(json["tells"][1]["texts"][1], "outside");
        assert!(field.scale().contains("&lt;3 W") && field.scale().contains("#FDE725"));
        // One value alone has the middle colour.
        let level = Field { values: vec![Some(1.0); 2], ends: [1.0, 1.0], ..field };
        assert_eq!(level.json()["shades"], json!([32, 32]));
    }
}
