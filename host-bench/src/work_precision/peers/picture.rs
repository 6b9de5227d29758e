//! The comparison as a picture: one plot for each scene.

use plotters::style::RGBColor;

use super::Comparison;
use crate::method::Failure;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION, extremes};

/// One more colour of Okabe and Ito.
const SKY: RGBColor = RGBColor(86, 180, 233);

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
        curves.push(Curve::new(first.method, colour, Mark::Dotted(widths), points));
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
