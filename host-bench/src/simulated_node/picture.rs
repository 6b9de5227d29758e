//! Hours of each strategy as a picture: income, stored energy, actions, the cost of estimation; and the quarters of years.

use harvester_scene::market::Processor;
use plotters::style::RGBColor;

use super::compared::{Extent, Name, STORAGES, Setup, Storage, moves};
use super::plant::Run;
use super::timeline::Timeline;
use super::years::Quarter;
use crate::outcome::name;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, FROM_ZERO, Mark};
use crate::report::setting::with_unit;
use crate::report::svg::COLOURS;

const GREY: RGBColor = RGBColor(190, 196, 202);

/// A timeline of a harvester by each strategy, with the first part of the rows, and 10 mF where the rows have it.
pub(crate) fn picture(harvester: &str, extent: &Extent, line: &Timeline) -> Picture {
    let storage = extent.storages.iter().find(|one| **one == STORAGES[2]).unwrap_or(&extent.storages[0]);
    let processor = Processor::named(extent.parts[0]).expect("a part");
    let setup = Setup { processor, storage: *storage, spread: 0.2, seeds: 1 };
    let scale = 1e3 * setup.settings(line).scale;
    let runs: Vec<(Name, Run)> = Name::ALL.map(|name| (name, setup.run(name, line, 0, 120))).into();
    let true_hours = line.minutes.chunks(60).map(|minutes| minutes.iter().sum::<f64>());
    let level = |hour: usize, value: f64| [(hour as f64, value), (hour as f64 + 1.0, value)];
    let hours = |run: &Run, of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        run.hours.iter().enumerate().flat_map(|(at, hour)| level(hour.index, of(at))).collect()
    };
    let estimated = |run: &Run| hours(run, &|at| scale / 3.6 * run.hours[at].estimated);
    let estimation = |run: &Run| {
        let spent = |at: usize| run.hours.get(at).map_or(0.0, |hour| hour.spent);
        let before = |at: usize| if at == 0 { 0.0 } else { spent(at - 1) };
        hours(run, &|at| 1e3 * scale / 3.6 * (spent(at) - before(at)))
    };
    let stored = |run: &Run| {
        let minutes = run.stored.iter().step_by(60).enumerate();
        minutes.map(|(minute, energy)| (minute as f64 / 60.0, scale * energy)).collect()
    };
    let acted = |run: &Run| {
        let steps = run.acted.iter().enumerate();
        steps.map(|(count, second)| (f64::from(*second) / 3600.0, count as f64 + 1.0)).collect()
    };
    let truth = true_hours.enumerate().flat_map(|(hour, energy)| level(hour, scale / 3.6 * energy));
    let truth = Curve::new("true", GREY, Mark::line(0, 11.0), truth);
    let chart = |title: &str, up: &str, first: Option<Curve>, of: &dyn Fn(&Run) -> Vec<(f64, f64)>| {
        let named = runs.iter().map(|(name, run)| {
            let points = of(run);
            let none = if points.iter().any(|point| point.1 > 0.0) { "" } else { ": none" };
            (format!("{name:?}{none}").to_lowercase(), points)
        });
        // Over another a curve is narrower: both are seen where they are one.
        let narrower = |at: usize, width: f64| Mark::line(at, width - at as f64);
        let curves = first.into_iter().chain(Curve::distinct(&COLOURS, (narrower, 7.5), named)).collect();
        let across = Axis::linear("time [h]", [0.0, line.minutes.len() as f64 / 60.0], 12);
        Chart::new(title, across, Axis::linear(up, FROM_ZERO, 6), curves).grouped("hours", 320)
    };
    let charts = vec![
        chart("Income of each hour", "mean power [µW]", Some(truth), &estimated),
        chart("Storage", "stored energy [mJ]", None, &stored),
        chart("Actions", "actions since the start", None, &acted),
        chart("Estimating the income", "mean power [nW]", None, &estimation),
    ];
    let course =
        extent.courses.iter().find(|course| moves(line.kind, **course)).map(name).unwrap_or_default();
    let (part, storage, capacitance) = (processor.name, storage.name, with_unit(storage.capacitance, "F"));
    let title = format!(
        "A node by each strategy: {harvester} as designed, {course}, {part}, {storage}, {capacitance}"
    );
    Picture { title, width: 980, charts, ..Picture::default() }
}

/// The title of a chart of quarters, its ordinate, the worse of two values, and the value.
type Panel = (&'static str, &'static str, fn(f64, f64) -> f64, fn(&Quarter) -> f64);

const PANELS: [Panel; 3] = [
    ("Hours inside their bound, least", "share [%]", f64::min, |one| 100.0 * one.inside),
    ("Median bound, largest", "over that of the first quarter", f64::max, |one| one.bound_over_first),
    ("Cost of estimation, largest", "over the income [%]", f64::max, |one| 100.0 * one.share),
];

/// The quarters of each tier on each storage, of all stresses and nights the worst.
pub(crate) fn of_years(quarters: &[Quarter]) -> Picture {
    let last = quarters.iter().map(|one| one.quarter).max().unwrap_or(1);
    let chart = |tier: &'static str, (title, up, worse, of): Panel| {
        let named = STORAGES[..6].iter().map(|Storage { name, capacitance, .. }| {
            let at = |quarter: u32| {
                let here = |one: &&Quarter| {
                    (one.tier, one.quarter) == (tier, quarter)
                        && (one.storage, one.capacitance_f) == (*name, *capacitance)
                };
                (f64::from(quarter), quarters.iter().filter(here).map(of).fold(f64::NAN, worse))
            };
            (format!("{name} of {capacitance} F"), (1..=last).map(at).collect::<Vec<_>>())
        });
        let dotted = |at: usize, width: f64| Mark::dotted(at, [width, 4.0 * width]);
        let curves = Curve::distinct(&COLOURS, (dotted, 1.5), named);
        let across = Axis::linear("quarter of a year", [0.5, f64::from(last) + 0.5], 10);
        Chart::new(format!("{title}: {tier}"), across, Axis::linear(up, FITTING, 6), curves)
            .grouped("quarters", 280)
    };
    let charts =
        PANELS.into_iter().flat_map(|panel| ["voltage", "map"].map(|tier| chart(tier, panel))).collect();
    let title = "Years of a node, quarter by quarter: the worst of all stresses and nights".to_owned();
    Picture { title, width: 1280, charts, ..Picture::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn years_show_the_worst_run_of_each_storage() {
        let of = |index: usize, tier, quarter, inside| {
            let Storage { name: storage, capacitance: capacitance_f, .. } = STORAGES[index];
            Quarter { storage, capacitance_f, tier, quarter, inside, ..Quarter::default() }
        };
        let quarters = [
            of(0, "voltage", 1, 1.0),
            of(0, "voltage", 2, 0.99),
            of(0, "voltage", 1, 0.96),
            of(0, "map", 1, 0.9),
            of(1, "voltage", 1, 0.98),
        ];
        let found = of_years(&quarters);
        let points = |chart: usize, curve: usize| &found.charts[chart].curves[curve].points;
        assert_eq!((found.charts.len(), found.charts[0].curves.len()), (6, 6));
        assert_eq!(points(0, 0), &[(1.0, 96.0), (2.0, 99.0)]);
        assert!(
            (points(0, 1)[0], points(1, 0)[0]) == ((1.0, 98.0), (1.0, 90.0)) && points(1, 1)[0].1.is_nan()
        );
        assert!(found.svg().is_ok_and(|text| text.contains("capacitor of 0.00047 F")));
    }
}
