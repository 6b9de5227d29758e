//! Maps of the grid: two quantities across and up, the classes of the cases at each pair of values as coloured parts
//! of a cell, single beside double precision.

use std::fmt::Write;

use clap::ValueEnum as _;

use super::{Case, Class, Row};
use crate::method::Precision;
use crate::outcome::name;
use crate::report::html::escaped;
use crate::report::svg::{FONT, power_of_ten, tick};

/// A quantity of a case.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// The quantity with its unit.
    pub(super) title: &'static str,
    /// The key of the scene, or [`STEP`].
    pub(super) key: &'static str,
}

/// The key of the option `--step`.
pub(super) const STEP: &str = "--step";

/// Which cases a map shows: those of a scene with both quantities.
#[derive(Debug, Clone, Copy)]
pub(super) struct Map {
    /// The beginning of the name of the shipped scene.
    pub(super) scene: &'static str,
    pub(super) across: Axis,
    pub(super) up: Axis,
}

/// The default of `--step`, below every step.
const DEFAULT: f64 = f64::NEG_INFINITY;

impl Axis {
    fn value(&self, case: &Case) -> Option<f64> {
        if self.key == STEP { Some(case.step_s.unwrap_or(DEFAULT)) } else { case.number(self.key) }
    }
}

/// Sizes in pixels.
const CELL_HEIGHT: usize = 24;
const WIDE: usize = 46;
const NARROW: usize = 27;
/// Most columns of wide cells.
const FEW: usize = 10;
const LEFT: usize = 74;
const ABOVE: usize = 56;
const BELOW: usize = 44;
const BETWEEN: usize = 30;
const RIGHT: usize = 20;

/// A cell: its column, its row from below, and how many cases of each class it has.
type Cell = ([usize; 2], Vec<(Class, usize)>);

impl Map {
    /// The pairs of a case and its row that belong to this map.
    fn points<'a>(&self, cases: &'a [Case], rows: &'a [Row]) -> Vec<([f64; 2], &'a Case, &'a Row)> {
        let both = cases.iter().zip(rows).filter(|(case, _)| case.scene.starts_with(self.scene));
        both.filter_map(|(case, row)| Some(([self.across.value(case)?, self.up.value(case)?], case, row)))
            .collect()
    }

    /// The map as SVG text; `None` where no case has both quantities. The rows are those of the cases.
    pub(super) fn svg(&self, cases: &[Case], rows: &[Row]) -> Option<String> {
        let points = self.points(cases, rows);
        if points.is_empty() {
            return None;
        }
        let [columns, lines] = [0, 1].map(|index| values(points.iter().map(|(place, ..)| place[index])));
        let cell_width = if columns.len() > FEW { NARROW } else { WIDE };
        let (width, height) = (cell_width * columns.len(), CELL_HEIGHT * lines.len());
        let (legend, legend_width) = legend();
        let all = [(2 * (LEFT + width) + BETWEEN + RIGHT).max(legend_width), ABOVE + height + BELOW];
        let mut text = format!(
            "<svg width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" xmlns=\"http://www.w3.org/2000/svg\" \
             font-family=\"{FONT}\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#FFFFFF\"/>\n",
            all[0], all[1]
        );
        text.push_str(&legend);
        for (index, precision) in [Precision::F32, Precision::F64].into_iter().enumerate() {
            let left = LEFT + index * (width + LEFT + BETWEEN);
            let cells = cells(&points, precision, &columns, &lines);
            self.panel(&mut text, left, cell_width, precision, (&columns, &lines), &cells);
        }
        text.push_str("</svg>\n");
        Some(text)
    }

    fn panel(
        &self,
        text: &mut String,
        left: usize,
        cell_width: usize,
        precision: Precision,
        (columns, lines): (&[f64], &[f64]),
        cells: &[Cell],
    ) {
        let (width, height) = (cell_width * columns.len(), CELL_HEIGHT * lines.len());
        let (middle, bottom) = (left + width / 2, ABOVE + height);
        let _ = writeln!(
            text,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"bold\">{}</text>",
            ABOVE - 8,
            precision.name()
        );
        for (index, value) in columns.iter().enumerate() {
            let x = left + index * cell_width + cell_width / 2;
            let label = label(*value);
            let _ = writeln!(
                text,
                "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{label}</text>",
                bottom + 16
            );
        }
        for (index, value) in lines.iter().enumerate() {
            let y = bottom - index * CELL_HEIGHT - CELL_HEIGHT / 2 + 4;
            let label = label(*value);
            let _ = writeln!(
                text,
                "<text x=\"{}\" y=\"{y}\" text-anchor=\"end\" font-size=\"11\">{label}</text>",
                left - 6
            );
        }
        let _ = writeln!(
            text,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 36,
            escaped(self.across.title)
        );
        let (x, y) = (left - LEFT + 14, ABOVE + height / 2);
        let _ = writeln!(
            text,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" transform=\"rotate(-90 {x} {y})\">{}</text>",
            escaped(self.up.title)
        );
        for ([column, line], classes) in cells {
            let place = [left + column * cell_width, bottom - (line + 1) * CELL_HEIGHT];
            let words = [(&self.across, columns[*column]), (&self.up, lines[*line])]
                .map(|(axis, value)| format!("{} {}", axis.title, label(value)));
            cell(text, place, cell_width, &words.join(", "), classes);
        }
    }
}

/// The different values, rising.
fn values(all: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = all.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn cells(
    points: &[([f64; 2], &Case, &Row)],
    precision: Precision,
    columns: &[f64],
    lines: &[f64],
) -> Vec<Cell> {
    let mut cells = Vec::new();
    for (column, across) in columns.iter().enumerate() {
        for (line, up) in lines.iter().enumerate() {
            let here = points
                .iter()
                .filter(|(place, case, _)| *place == [*across, *up] && case.precision == precision);
            let classes: Vec<Class> = here.map(|(.., row)| row.class).collect();
            let count = |class: &Class| classes.iter().filter(|found| *found == class).count();
            let counts = Class::value_variants().iter().map(|class| (*class, count(class)));
            let counts: Vec<(Class, usize)> = counts.filter(|(_, count)| *count > 0).collect();
            if !counts.is_empty() {
                cells.push(([column, line], counts));
            }
        }
    }
    cells
}

/// A cell with a part for each class, as wide as its share; the counts show where the pointer rests.
fn cell(
    text: &mut String,
    [left, top]: [usize; 2],
    cell_width: usize,
    words: &str,
    classes: &[(Class, usize)],
) {
    let all: usize = classes.iter().map(|(_, count)| count).sum();
    let inner = (cell_width - 2) as f64;
    let mut x = (left + 1) as f64;
    let counts: Vec<String> =
        classes.iter().map(|(class, count)| format!("{count} {}", name(class).replace('-', " "))).collect();
    let _ = write!(text, "<g><title>{}: {}</title>", escaped(words), counts.join(", "));
    for (class, count) in classes {
        let width = inner * *count as f64 / all as f64;
        let _ = write!(
            text,
            "<rect x=\"{x:.1}\" y=\"{}\" width=\"{width:.1}\" height=\"{}\" fill=\"{}\"/>",
            top + 1,
            CELL_HEIGHT - 2,
            colour(*class)
        );
        x += width;
    }
    text.push_str("</g>\n");
}

/// The classes with their colours, in one line, and its width.
fn legend() -> (String, usize) {
    let mut text = String::new();
    let mut x = 14;
    for class in Class::value_variants() {
        let word = name(class).replace('-', " ");
        let _ = writeln!(
            text,
            "<rect x=\"{x}\" y=\"8\" width=\"12\" height=\"12\" fill=\"{}\" stroke=\"#57606A\" stroke-width=\"0.5\"/>\
             <text x=\"{}\" y=\"18\">{word}</text>",
            colour(*class),
            x + 17
        );
        x += 17 + 7 * word.len() + 14;
    }
    (text, x)
}

/// Colours of Okabe and Ito, and greys.
fn colour(class: Class) -> &'static str {
    match class {
        Class::Right => "#009E73",
        Class::Chaotic => "#0072B2",
        Class::Undecided => "#F0E442",
        Class::Warned => "#E69F00",
        Class::Refused => "#D0D7DE",
        Class::NamedError => "#8C959F",
        Class::TooDear => "#56B4E9",
        Class::Unjudged => "#CC79A7",
        Class::Wrong => "#D55E00",
        Class::Broken => "#000000",
    }
}

/// A value on an axis: a power of ten as such.
fn label(value: f64) -> String {
    let exponent = value.log10();
    if value == DEFAULT {
        "default".to_owned()
    } else if value == f64::INFINITY {
        "∞".to_owned()
    } else if value > 0.0 && (exponent - exponent.round()).abs() < 1e-9 && !(0.1..=10.0).contains(&value) {
        power_of_ten(exponent)
    } else {
        tick(value)
    }
}
