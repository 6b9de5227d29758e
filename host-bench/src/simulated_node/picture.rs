//! A day of each strategy as a picture: income estimated and true, stored energy, actions, the cost of estimation.

use harvester_scene::market::Processor;
use plotters::style::RGBColor;

use super::compared::{Name, STORAGES, Setup};
use super::harvester::Kind;
use super::plant::Run;
use super::timeline::{Course, Timeline};
use crate::method::Failure;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FROM_ZERO, Mark};
use crate::report::svg::{BLACK, COLOURS};

const HOURS: usize = 24;

/// A random day of a harvester as designed, with an nRF52832, 10 mF, and a standing power that is off by up to
/// 20 %.
pub(crate) fn picture(kind: Kind) -> Result<Picture, Failure> {
    let line = Timeline::new(kind, true, Course::Random, HOURS, 1)?;
    let setup = Setup {
        processor: Processor::named("nrf52832").expect("a part"),
        storage: STORAGES[2],
        spread: 0.2,
        seeds: 1,
    };
    let scale = 1e3 * setup.settings(&line).scale;
    let runs: Vec<(Name, Run)> = Name::ALL.map(|name| (name, setup.run(name, &line, 7, 120))).into();
    let true_hours = line.minutes.chunks(60).map(|minutes| minutes.iter().sum::<f64>());
    let hours = |run: &Run, of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        run.hours.iter().enumerate().map(|(at, hour)| (hour.index as f64 + 0.5, of(at))).collect()
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
    let truth = true_hours.enumerate().map(|(hour, energy)| (hour as f64 + 0.5, scale / 3.6 * energy));
    let truth = Curve::new("true", BLACK, Mark::Rings(7.0), truth);
    let chart = |title: &str, up: &str, first: Option<Curve>, of: &dyn Fn(&Run) -> Vec<(f64, f64)>| {
        let of_run = |((name, run), colour): (&(Name, Run), RGBColor)| {
            let points = of(run);
            let curve = Curve::new(format!("{name:?}").to_lowercase(), colour, Mark::Line(1.5), points);
            Some(curve).filter(|curve| curve.points.iter().any(|point| point.1 > 0.0))
        };
        let curves = first.into_iter().chain(runs.iter().zip(COLOURS).filter_map(of_run)).collect();
        let across = Axis::linear("hour of the day", [0.0, HOURS as f64], 13);
        Chart::new(title, across, Axis::linear(up, FROM_ZERO, 6), curves).grouped("hours", 320)
    };
    let charts = vec![
        chart("Income of each hour", "mean power [µW]", Some(truth), &estimated),
        chart("Storage", "stored energy [mJ]", None, &stored),
        chart("Actions", "actions since midnight", None, &acted),
        chart("Estimating the income", "mean power [nW]", None, &estimation),
    ];
    let title = "A day of a node by each strategy".to_owned();
    Ok(Picture { title, width: 980, charts, ..Picture::default() })
}
