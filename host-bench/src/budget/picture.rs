//! The day of a node as a picture: stored energy, income, the cost of estimation, and actions over the hours.

use plotters::style::RGBColor;

use super::outcome::{NodeDay, Sample, Source};
use crate::outcome::Format;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, FROM_ZERO, Mark};
use crate::report::svg::{BLACK, BLUE, COLOURS, VERMILION};
use crate::scene_file::HOURS;

/// The part of the income that estimating it is to cost at most.
const SHARE: f64 = 0.01;

/// The charts with the numbers of the day.
pub(crate) fn picture(day: &NodeDay, source: &Source) -> Picture {
    let charts = [Some(stored(day)), Some(income(day)), estimation(day), Some(actions(day))];
    Picture {
        title: format!("A day of a node: {}", source.scene),
        width: 980,
        charts: charts.into_iter().flatten().collect(),
        text: day.text(source, Format::Table),
        ..Picture::default()
    }
}

/// Curves over the hours of the day.
fn chart(title: &str, up: (&str, [f64; 2]), curves: Vec<Curve>) -> Chart {
    let across = Axis::linear("hour of the day", [0.0, HOURS as f64], 13);
    Chart::new(title, across, Axis::linear(up.0, up.1, 6), curves).grouped("hours", 320)
}

/// A dashed line over the day.
fn level(name: &str, colour: RGBColor, height: f64) -> Curve {
    Curve::new(name, colour, Mark::line(1, 1.0), [(0.0, height), (HOURS as f64, height)])
}

/// The value of each hour as steps.
fn steps(name: &str, index: usize, values: impl Iterator<Item = f64>) -> Curve {
    let steps = values.enumerate().map(|(hour, value)| (hour as f64, value));
    let steps = steps.flat_map(|(hour, value)| [(hour, value), (hour + 1.0, value)]);
    Curve::new(name, COLOURS[index % COLOURS.len()], Mark::line(index, 2.0), steps)
}

fn hour(sample: &Sample) -> f64 {
    f64::from(sample.second) / 3600.0
}

fn stored(day: &NodeDay) -> Chart {
    let points = day.samples.iter().map(|sample| (hour(sample), 1e3 * sample.stored_j));
    let curves = vec![
        Curve::new("stored", BLUE, Mark::line(0, 2.0), points),
        level("full", BLACK, 1e3 * day.capacity_j),
        Curve { mark: Mark::line(0, 1.0), ..level("lock-out", VERMILION, 1e3 * day.turn_off_j) },
    ];
    chart("Storage", ("stored energy [mJ]", FITTING), curves)
}

fn income(day: &NodeDay) -> Chart {
    // The power of an interval stands at its end and holds from the end of the interval before.
    let intervals = day.samples.windows(2).flat_map(|pair| match pair {
        [before, after] => vec![(hour(before), 1e6 * after.income_w), (hour(after), 1e6 * after.income_w)],
        _ => Vec::new(),
    });
    let curves = vec![Curve::new("", BLUE, Mark::line(0, 2.0), intervals)];
    chart("Harvester", ("harvested power [µW]", FROM_ZERO), curves)
}

/// What estimating the income takes at the node, hour by hour; `None` for a node that spends nothing on it.
fn estimation(day: &NodeDay) -> Option<Chart> {
    let powers = day.estimation.iter().enumerate().map(|(index, estimation)| {
        let powers = (0..HOURS).map(|hour| 1e9 * estimation.power_w(hour));
        steps(&estimation.outcome.name.line(), index, powers)
    });
    let limit = 1e9 * SHARE * day.account.income / f64::from(super::DAY_S);
    let limit = level("1 % of the day's mean income", BLACK, limit);
    let curves = powers.chain([limit]).collect();
    (!day.estimation.is_empty())
        .then(|| chart("Estimating the income", ("mean power [nW]", FROM_ZERO), curves))
}

fn actions(day: &NodeDay) -> Chart {
    let curves = day.actions.iter().enumerate().map(|(index, action)| {
        steps(&action.name.line(), index, action.by_hour.iter().map(|runs| f64::from(*runs)))
    });
    chart("Actions", ("runs per hour", FROM_ZERO), curves.collect())
}
