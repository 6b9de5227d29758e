//! The day of a node as a picture: stored energy, income, what knowing it costs, and actions over the hours.

use std::fmt::Write;

use plotters::style::RGBColor;

use super::outcome::{NodeDay, Sample, Source};
use crate::outcome::Format;
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped};
use crate::report::plot::{Axis, Curve, Mark, Plot, draw};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, VERMILION};
use crate::scene_file::HOURS;

/// Width of the picture, and height of a plot.
const SIZE: (u32, u32) = (980, 320);
/// The part of the income that knowing it is to cost at most.
const SHARE: f64 = 0.01;
/// Colours of the actions; more actions take them again from the first.
const COLOURS: [RGBColor; 4] = [GREEN, VERMILION, ORANGE, BLACK];

/// The picture as SVG text.
pub(crate) fn svg(day: &NodeDay) -> Result<String, String> {
    let plots = plots(day);
    draw((SIZE.0, SIZE.1 * plots.len() as u32), &plots)
}

fn plots(day: &NodeDay) -> Vec<Plot> {
    let all = [Some(stored(day)), Some(income(day)), knowing(day), Some(actions(day))];
    all.into_iter().flatten().collect()
}

/// A page with charts and the numbers; the picture stands there where scripts are switched off.
pub(crate) fn page(day: &NodeDay, source: &Source, svg: &str) -> String {
    let mut charts = Charts::default();
    let mut body = format!("<h1>A day of a node: {}</h1>\n{HINT}", escaped(source.scene));
    for plot in plots(day) {
        body += &charts.place(&plot, Look { height: 260, group: Some("hours") });
    }
    let _ = writeln!(body, "<noscript><figure>{svg}</figure></noscript>");
    body += &charts.scripts();
    let _ = writeln!(body, "<pre>{}</pre>", escaped(&day.text(source, Format::Table)));
    document("A day of a node", &body)
}

fn across(title: &'static str) -> Axis {
    Axis::linear(title, [0.0, HOURS as f64], 13)
}

/// An axis from 0 to a little above the largest value.
fn up(title: &'static str, values: impl Iterator<Item = f64>) -> Axis {
    let highest = values.fold(0.0, f64::max);
    Axis::linear(title, [0.0, if highest > 0.0 { 1.06 * highest } else { 1.0 }], 6)
}

fn hour(sample: &Sample) -> f64 {
    f64::from(sample.second) / 3600.0
}

fn stored(day: &NodeDay) -> Plot {
    let level = |energy: f64| vec![(0.0, 1e3 * energy), (HOURS as f64, 1e3 * energy)];
    let points = day.samples.iter().map(|sample| (hour(sample), 1e3 * sample.stored_j));
    Plot {
        title: "Storage".to_owned(),
        across: across("hour of the day"),
        up: up("stored energy [mJ]", std::iter::once(1e3 * day.capacity_j)),
        curves: vec![
            Curve::new("stored", BLUE, Mark::Line(2.0), points),
            Curve::new("full", BLACK, Mark::Dashes(1.0), level(day.capacity_j)),
            Curve::new("lock-out", VERMILION, Mark::Dashes(1.0), level(day.turn_off_j)),
        ],
    }
}

fn income(day: &NodeDay) -> Plot {
    // The power of an interval stands at its end and holds from the end of the interval before.
    let intervals = day.samples.windows(2).flat_map(|pair| match pair {
        [before, after] => vec![(hour(before), 1e6 * after.income_w), (hour(after), 1e6 * after.income_w)],
        _ => Vec::new(),
    });
    let points: Vec<(f64, f64)> = intervals.collect();
    Plot {
        title: "Harvester".to_owned(),
        across: across("hour of the day"),
        up: up("harvested power [µW]", points.iter().map(|point| point.1)),
        curves: vec![Curve::new("", BLUE, Mark::Line(2.0), points)],
    }
}

/// What knowing the income takes at the node, hour by hour; `None` for a node that spends nothing on it.
fn knowing(day: &NodeDay) -> Option<Plot> {
    if day.knowing.is_empty() {
        return None;
    }
    let hours = || 0..HOURS;
    let mut curves: Vec<Curve> = Vec::new();
    for (index, knowing) in day.knowing.iter().enumerate() {
        let steps = hours().flat_map(|hour| {
            let power = 1e9 * knowing.power_w(hour);
            [(hour as f64, power), (hour as f64 + 1.0, power)]
        });
        let colour = COLOURS[index % COLOURS.len()];
        curves.push(Curve::new(knowing.outcome.name.line(), colour, Mark::Line(2.0), steps));
    }
    let limit = 1e9 * SHARE * day.account.income / f64::from(super::DAY_S);
    let level = [(0.0, limit), (HOURS as f64, limit)];
    curves.push(Curve::new("1 % of the day's mean income", BLUE, Mark::Dashes(1.0), level));
    let highest = curves.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(0.0, f64::max);
    Some(Plot {
        title: "Knowing the income".to_owned(),
        across: across("hour of the day"),
        up: up("mean power [nW]", std::iter::once(highest)),
        curves,
    })
}

fn actions(day: &NodeDay) -> Plot {
    let runs = day.actions.iter().flat_map(|action| action.by_hour).map(f64::from);
    let curves = day.actions.iter().enumerate().map(|(index, action)| {
        let steps = action.by_hour.iter().enumerate().flat_map(|(hour, runs)| {
            let (hour, runs) = (hour as f64, f64::from(*runs));
            [(hour, runs), (hour + 1.0, runs)]
        });
        Curve::new(action.name.line(), COLOURS[index % COLOURS.len()], Mark::Line(2.0), steps)
    });
    Plot {
        title: "Actions".to_owned(),
        across: across("hour of the day"),
        up: up("runs per hour", runs),
        curves: curves.collect(),
    }
}
