//! Convergence in the number of modes and in the step.

use std::fmt::Write;

use plotters::style::RGBColor;
use rayon::prelude::*;

use super::{Figure, Panel};
use crate::method::{Failure, Options};
use crate::outcome::number;
use crate::report::plot::{self, Axis, Curve, Mark, Plot};
use crate::report::svg::{BLACK, BLUE, ORANGE, VERMILION, range, tick};
use crate::run::run_scene;
use crate::scene_file::{BumpStopStart, Contact, Model, RunSpan, Scene};

/// Numbers of modes of the beam and of the rod.
const BEAM: [usize; 9] = [1, 2, 3, 4, 6, 8, 10, 14, 20];
const ROD: [usize; 3] = [0, 2, 10];
const ROD_COLOURS: [RGBColor; 3] = [ORANGE, BLUE, BLACK];

/// Steps near contact in s, with [`STEP_MODES`]. The step in free flight is 20 µs, or the step near contact if longer.
const STEPS: [f64; 7] = [1e-7, 2e-7, 5e-7, 1e-6, 2e-6, 5e-6, 1e-5];
const STEP_MODES: (usize, usize) = (10, 3);
const LONG_STEP_S: f64 = 2e-5;
const LAWS: [(Contact, &str, RGBColor); 2] = [
    (Contact::ResidualFlexibility, "residual flexibility", BLUE),
    (Contact::DisplacementConstraint, "displacement constraint", VERMILION),
];

/// Runs of the convergence in modes: 88 periods measured after 88, at 1 µs.
const MODES_RUN: RunSpan = RunSpan { duration_s: 0.8, settle_s: 0.4 };
/// Runs of the convergence in step: 44 periods measured after 44.
const STEP_RUN: RunSpan = RunSpan { duration_s: 0.4, settle_s: 0.2 };

const SIZE: (u32, u32) = (560, 430);

/// Number of runs of both.
pub(super) fn runs() -> usize {
    2 * BEAM.len() * ROD.len() + LAWS.len() * STEPS.len()
}

/// The numbers of a run, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Found {
    rms_voltage: f64,
    peak_force: f64,
    mean_force: f64,
    contacts_per_period: f64,
}

/// Runs the scene with these numbers of modes, this contact and this span.
fn found(
    base: &Scene,
    (beam, rod): (usize, usize),
    contact: Contact,
    run: RunSpan,
    options: &Options,
) -> Result<Found, Failure> {
    let Model::BumpStop(mut model) = base.model.clone() else {
        return Err(Failure::of_file(base, "scene must be \"bump-stop\" here"));
    };
    model.parameters.beam_modes = beam;
    if let Some(stop) = &mut model.stop {
        stop.rod_modes = rod;
        stop.contact = contact;
    }
    model.initial = BumpStopStart::at_rest(beam, rod);
    let outcome = run_scene(&Scene { model: Model::BumpStop(model), run, ..base.clone() }, options)?;
    let motion = outcome.bump_stop().ok_or_else(|| Failure::Input("another scene was run".to_owned()))?;
    let value = |value: Option<f64>| value.unwrap_or(f64::NAN);
    Ok(Found {
        rms_voltage: value(outcome.rms_voltage_v),
        peak_force: value(motion.peak_force_n),
        mean_force: value(motion.mean_force_n),
        contacts_per_period: value(motion.contacts_per_period),
    })
}

/// Numbers of a run with `beam` and `rod` modes; `place` is 0 for the stop at the tip and 1 for mid-span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModesPoint {
    place: usize,
    beam: usize,
    rod: usize,
    found: Found,
}

/// All counts of modes, with the stop at the tip and at mid-span.
pub(super) fn in_modes(scenes: [&Scene; 2], done: &(dyn Fn() + Sync)) -> Result<Vec<ModesPoint>, Failure> {
    let mut cases = Vec::new();
    // The longest runs first, so that all cores end at about the same time.
    for beam in BEAM.into_iter().rev() {
        cases.extend(ROD.into_iter().rev().flat_map(|rod| [(0, beam, rod), (1, beam, rod)]));
    }
    let options = Options::default();
    let point = |&(place, beam, rod): &(usize, usize, usize)| {
        let scene = scenes.get(place).copied().unwrap_or(scenes[0]);
        let found = found(scene, (beam, rod), Contact::ResidualFlexibility, MODES_RUN, &options);
        done();
        Ok(ModesPoint { place, beam, rod, found: found? })
    };
    let mut points: Vec<ModesPoint> = cases.par_iter().map(point).collect::<Result<_, Failure>>()?;
    points.sort_by_key(|point| (point.place, point.rod, point.beam));
    Ok(points)
}

/// Numbers of a run with a step; `law` is a place in the list of laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepPoint {
    law: usize,
    step_s: f64,
    found: Found,
}

/// All steps under both laws, with the stop at the tip.
pub(super) fn in_step(scene: &Scene, done: &(dyn Fn() + Sync)) -> Result<Vec<StepPoint>, Failure> {
    let cases: Vec<(usize, f64)> =
        STEPS.into_iter().flat_map(|step_s| (0..LAWS.len()).map(move |law| (law, step_s))).collect();
    let point = |&(law, step_s): &(usize, f64)| {
        let options = Options {
            step_s: Some(step_s),
            long_step_s: Some(LONG_STEP_S.max(step_s)),
            ..Options::default()
        };
        let found = found(scene, STEP_MODES, LAWS[law].0, STEP_RUN, &options);
        done();
        Ok(StepPoint { law, step_s, found: found? })
    };
    cases.par_iter().map(point).collect()
}

/// A line through points, with a dot at each.
fn dotted(name: String, colour: RGBColor, points: Vec<(f64, f64)>) -> [Curve; 2] {
    [
        Curve { name, colour, mark: Mark::Line(1.6), points: points.clone() },
        Curve { name: String::new(), colour, mark: Mark::Dots(6.0), points },
    ]
}

/// RMS voltage over the number of beam modes.
pub(super) fn modes_figure(points: &[ModesPoint], note: &str) -> Result<Figure, String> {
    let places = ["tip", "mid-span"];
    let panel = |(index, (letter, place)): (usize, (char, &str))| {
        let curves = ROD.iter().zip(ROD_COLOURS).flat_map(|(&rod, colour)| {
            let of = points.iter().filter(|point| point.place == index && point.rod == rod);
            let points = of.map(|point| (point.beam as f64, point.found.rms_voltage)).collect();
            dotted(format!("{rod} of the rod"), colour, points)
        });
        let highest = points.iter().filter(|point| point.place == index).map(|point| point.found.rms_voltage);
        let plot = Plot {
            title: format!("Convergence in modes ({letter}): stop at the {place}"),
            across: Axis::linear("modes of the beam", [0.0, 21.0], 11),
            up: Axis::linear("RMS voltage [V]", [0.0, 1.1 * highest.fold(0.0, f64::max)], 8),
            curves: curves.collect(),
        };
        Ok::<_, String>(Panel {
            name: format!("convergence-in-modes-{letter}"),
            svg: plot::draw(SIZE, &[plot])?,
        })
    };
    let panels: Result<Vec<Panel>, String> =
        ['a', 'b'].into_iter().zip(places).enumerate().map(panel).collect();
    let mut csv = String::from(
        "stop,beam_modes,rod_modes,rms_voltage_v,mean_force_n,peak_force_n,contacts_per_period\n",
    );
    for ModesPoint { place, beam, rod, found } in points {
        let _ = writeln!(csv, "{},{beam},{rod},{}", places[*place], cells(found));
    }
    let row = |point: &ModesPoint| {
        let found = &point.found;
        [
            places[point.place].to_owned(),
            point.beam.to_string(),
            point.rod.to_string(),
            format!("{:.4}", found.rms_voltage),
            format!("{:.2}", 1e3 * found.mean_force),
            format!("{:.2}", found.peak_force),
        ]
    };
    Ok(Figure {
        label: "Convergence in modes",
        title: "RMS voltage over the number of modes",
        caption: format!(
            "RMS voltage over {:.1} s after {:.1} s, over the number of beam modes, for three numbers of rod modes, with \
             the stop (a) at the tip and (b) at mid-span. The modes left out keep their static compliance. From four \
             modes of the beam on the voltage stays within an eighth with the stop at the tip, where it depends on the \
             kind of motion that a truncation settles on, and within two hundredths with the stop at mid-span; the mean \
             force stays within 5 %, the peak force goes on changing. {note}",
            MODES_RUN.window_s(),
            MODES_RUN.settle_s
        ),
        panels: panels?,
        table: crate::figures::table(
            ["stop", "beam modes", "rod modes", "RMS voltage [V]", "mean force [mN]", "peak force [N]"],
            points.iter().map(row),
        ),
        csv,
    })
}

fn cells(found: &Found) -> String {
    let cells = [found.rms_voltage, found.mean_force, found.peak_force, found.contacts_per_period];
    cells.map(number).join(",")
}

/// RMS voltage and peak force over the step.
pub(super) fn step_figure(points: &[StepPoint], note: &str) -> Result<Figure, String> {
    let row = |point: &StepPoint| {
        let found = &point.found;
        [
            LAWS[point.law].1.to_owned(),
            tick(1e6 * point.step_s),
            format!("{:.4}", found.rms_voltage),
            format!("{:.2}", 1e3 * found.mean_force),
            format!("{:.2}", found.peak_force),
            format!("{:.1}", found.contacts_per_period),
        ]
    };
    let headings = [
        "contact",
        "step [µs]",
        "RMS voltage [V]",
        "mean force [mN]",
        "peak force [N]",
        "contacts per period",
    ];
    let mut csv =
        String::from("contact,step_s,rms_voltage_v,mean_force_n,peak_force_n,contacts_per_period\n");
    for StepPoint { law, step_s, found } in points {
        let _ = writeln!(csv, "{},{},{}", LAWS[*law].1, number(*step_s), cells(found));
    }
    let (beam, rod) = STEP_MODES;
    Ok(Figure {
        label: "Convergence in step",
        title: "RMS voltage and peak force over the step",
        caption: format!(
            "(a) RMS voltage and (b) peak contact force over {:.1} s after {:.1} s, over the step near contact, with {beam} \
             modes of the beam, {rod} of the rod and the stop at the tip, under the contact by residual flexibility and \
             under the paper's constraint of displacements. Both contacts give much the same voltage. The peak force of the \
             constraint is made by the step: it grows as one over the step, and so do the contacts in a period. The peak \
             force of the residual flexibility converges. {note}",
            STEP_RUN.window_s(),
            STEP_RUN.settle_s
        ),
        panels: step_panels(points)?,
        table: crate::figures::table(headings, points.iter().map(row)),
        csv,
    })
}

fn step_panels(points: &[StepPoint]) -> Result<Vec<Panel>, String> {
    let across = Axis::logarithmic("step near contact [s]", [0.9 * STEPS[0], 1.1 * STEPS[STEPS.len() - 1]]);
    let curves = |value: fn(&Found) -> f64| -> Vec<Curve> {
        let of = |index: usize| points.iter().filter(move |point| point.law == index);
        let laws = LAWS.iter().enumerate();
        laws.flat_map(|(index, (_, name, colour))| {
            let points = of(index).map(|point| (point.step_s, value(&point.found))).collect();
            dotted((*name).to_owned(), *colour, points)
        })
        .collect()
    };
    let (voltages, forces) = (curves(|found| found.rms_voltage), curves(|found| found.peak_force));
    let highest = voltages.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(0.0, f64::max);
    let (low, high) = range(forces.iter().flat_map(|curve| &curve.points).map(|point| point.1.log10()));
    let span = [10f64.powf(low.floor()), 10f64.powf(high.ceil())];
    let plots = [
        Plot {
            title: "Convergence in step (a): RMS voltage".to_owned(),
            across: across.clone(),
            up: Axis::linear("RMS voltage [V]", [0.0, 1.2 * highest], 8),
            curves: voltages,
        },
        Plot {
            title: "Convergence in step (b): peak force".to_owned(),
            across,
            up: Axis::logarithmic("peak contact force [N]", span),
            curves: forces,
        },
    ];
    let panel = |(letter, plot)| {
        Ok(Panel { name: format!("convergence-in-step-{letter}"), svg: plot::draw(SIZE, &[plot])? })
    };
    ['a', 'b'].into_iter().zip(plots).map(panel).collect()
}
