//! The comparison as text, as CSV and as a picture: one plot for each scene.

use comfy_table::presets;
use plotters::style::RGBColor;

use super::{Comparison, Row, TARGETS, reaching};
use crate::method::Failure;
use crate::outcome::{small, table};
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, extremes};
use crate::rows::Rows;

/// Error of the best row of a method from which it counts as wrong.
const WRONG: f64 = 1e-2;

/// Three significant digits.
fn digits(value: f64) -> String {
    let before = value.abs().log10().floor() as i32 + 1;
    format!("{value:.*}", usize::try_from(3 - before).unwrap_or(0))
}

/// What a method that does not reach an error does instead.
fn instead(rows: &[Row]) -> &'static str {
    let least = rows.iter().filter_map(|row| row.error).fold(f64::INFINITY, f64::min);
    let last = rows.last().and_then(|row| row.failure.as_deref());
    match last {
        Some(_) if least > WRONG => "fails (1)",
        _ if least > WRONG => "wrong",
        _ => "not reached",
    }
}

impl Comparison {
    /// The cost in millions of instructions, or in ms, per simulated second.
    fn shown(&self, row: &Row) -> String {
        let scale = if self.by_count { 1e-6 } else { 1e3 };
        row.cost(self.by_count).map_or_else(|| "-".to_owned(), |cost| digits(scale * cost))
    }

    /// A line of the table of a scene: for each error the setting, cost, and time in µs.
    fn line(&self, rows: &[Row]) -> Vec<String> {
        let name = rows.first().map_or("", |row| row.method);
        let mut cells = vec![name.to_owned()];
        for target in TARGETS {
            match reaching(rows, target) {
                Some(row) => {
                    let time = row.seconds_per_simulated_second.map(|seconds| digits(1e6 * seconds));
                    let spread = row.time_spread.map(|spread| format!(" +{:.0} %", 100.0 * spread));
                    let time = time.unwrap_or_default() + &spread.unwrap_or_default();
                    cells.extend([row.setting(), self.shown(row), time]);
                }
                None => cells.extend([String::new(), instead(rows).to_owned(), String::new()]),
            }
        }
        let least = rows.iter().filter_map(|row| row.error).reduce(f64::min);
        cells.push(small(least));
        cells
    }

    fn unit(&self) -> &'static str {
        if self.by_count { "M instructions" } else { "ms" }
    }

    fn text(&self) -> String {
        let overrides = self.case.overrides.join(" --set ");
        let mut headings = vec!["method".to_owned()];
        for target in TARGETS {
            headings.extend([format!("at {target:.0e}"), self.unit().to_owned(), "us".to_owned()]);
        }
        headings.push("least error".to_owned());
        let lines = self.methods.iter().map(|rows| self.line(rows));
        let mut text = format!(
            "{}: {}.toml --set {overrides}; by the reference: mean power {:.6e} W\n\n{}",
            self.case.name,
            self.case.file,
            self.mean_power_w,
            table(presets::ASCII_MARKDOWN, headings, lines, 1)
        );
        for rows in &self.methods {
            if instead(rows).starts_with("fails")
                && let Some(Row { method, failure: Some(failure), .. }) = rows.last()
            {
                text += &format!("(1) {method}: {failure}.\n");
            }
        }
        text + "\n"
    }

    fn ratios(&self) -> Vec<String> {
        let mut cells = vec![self.case.name.to_owned()];
        for target in TARGETS {
            let names = [true, false].map(|peer| self.best(peer, target).map_or("-", |row| row.method));
            cells.push(self.ratio(target).map_or_else(|| "-".to_owned(), digits));
            cells.push(names.join(" / "));
        }
        cells
    }
}

/// All tables, and below them the ratios.
pub(crate) fn text(comparisons: &[Comparison]) -> String {
    let tables: String = comparisons.iter().map(Comparison::text).collect();
    let mut headings = vec!["scene".to_owned()];
    for target in TARGETS {
        headings.extend([format!("{target:.0e}"), "best peer / best of the core".to_owned()]);
    }
    let ratios = table(presets::ASCII_MARKDOWN, headings, comparisons.iter().map(Comparison::ratios), 1);
    format!(
        "{tables}T is the period of the excitation. Costs are per simulated second, of the loosest setting that meets an error of mean power together with \
         the next finer one. Instructions are those of the whole run, counted by valgrind, less those of a run of no \
         duration; times are processor times, the least of some runs and the largest above it. The core runs alone, with parts chosen at compile time \
         and one power.\n\nCost of the best peer over that of the best method of the core\n\n{ratios}"
    )
}

/// One line for each row.
pub(crate) fn csv(comparisons: &[Comparison]) -> String {
    Rows::of(comparisons.iter().flat_map(|comparison| comparison.methods.iter().flatten())).csv()
}

/// The colours of the methods of the core and of the peers.
const CORE: [RGBColor; 3] = [BLUE, VERMILION, BLACK];
const PEERS: [RGBColor; 5] = [GREEN, ORANGE, PURPLE, SKY, BLACK];

/// Widths of line and dot of the core, and of a peer.
const THICK: [f64; 2] = [3.0, 9.0];
const THIN: [f64; 2] = [1.2, 5.0];

/// Errors that are drawn.
const ERRORS: [f64; 2] = [1e-7, 1.0];

/// All charts as SVG text, one above the other.
pub(crate) fn draw(comparisons: &[Comparison]) -> Result<String, Failure> {
    let charts = comparisons.iter().map(chart).collect();
    Picture { width: 1400, charts, ..Picture::default() }.svg()
}

fn chart(comparison: &Comparison) -> Chart {
    let mut curves: Vec<Curve> = Vec::new();
    let (mut cores, mut peers) = (CORE.iter().cycle(), PEERS.iter().cycle());
    for rows in &comparison.methods {
        let Some(first) = rows.first() else { continue };
        let (colour, widths) = if first.peer { (peers.next(), THIN) } else { (cores.next(), THICK) };
        let colour = colour.copied().unwrap_or(BLACK);
        let points = rows.iter().filter_map(|row| {
            let (cost, error) = (row.cost(comparison.by_count)?, row.error?);
            (ERRORS[0]..=ERRORS[1]).contains(&error).then_some((cost, error))
        });
        curves.push(Curve::new(first.method, colour, Mark::dotted(0, widths), points));
    }
    let costs = curves.iter().flat_map(|curve| &curve.points).map(|point| point.0);
    let (least, most) = extremes(costs);
    let decade = |value: f64, round: fn(f64) -> f64| 10f64.powf(round(value.log10()));
    let across = if comparison.by_count {
        "instructions per simulated second"
    } else {
        "host seconds per simulated second"
    };
    // Without a point there is nothing to scale.
    let span = if least < most { [decade(least, f64::floor), decade(most, f64::ceil)] } else { [1.0, 10.0] };
    let title = format!("{}: error of mean power against cost", comparison.case.name);
    let up = Axis::logarithmic("relative error of mean power", ERRORS);
    Chart { height: 420, ..Chart::new(title, Axis::logarithmic(across, span), up, curves) }
}
