//! Convergence in the number of modes and in the step.

use plotters::style::RGBColor;

use super::{Figure, Panel, try_each_counted};
use crate::method::{Failure, Options};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, ORANGE, VERMILION, range, tick};
use crate::run::run_scene;
use crate::scene_file::{BumpStopStart, Contact, RunSpan, Scene};

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
pub(crate) struct ConvergenceRun {
    pub(crate) rms_voltage: f64,
    peak_force: f64,
    pub(crate) mean_force: f64,
    pub(crate) contacts_per_period: f64,
}

/// Runs the scene with these numbers of modes, this contact and this span.
pub(crate) fn found(
    base: &Scene,
    (beam, rod): (usize, usize),
    contact: Contact,
    run: RunSpan,
    options: &Options,
) -> Result<ConvergenceRun, Failure> {
    let mut scene = Scene { run, ..base.clone() };
    let model = scene.bump_stop_mut()?;
    model.parameters.beam_modes = beam;
    if let Some(stop) = &mut model.stop {
        stop.rod_modes = rod;
        stop.contact = contact;
    }
    model.initial = BumpStopStart::at_rest(beam, rod);
    let outcome = run_scene(&scene, options)?;
    let motion = outcome.bump_stop().ok_or_else(|| Failure::Input("another scene was run".to_owned()))?;
    let value = |value: Option<f64>| value.unwrap_or(f64::NAN);
    Ok(ConvergenceRun {
        rms_voltage: value(outcome.rms_voltage_v),
        peak_force: value(motion.peak_force_n),
        mean_force: value(motion.mean_force_n),
        contacts_per_period: value(motion.contacts_per_period),
    })
}

impl ConvergenceRun {
    /// As the last columns of CSV.
    fn cells(&self) -> [String; 4] {
        [self.rms_voltage, self.mean_force, self.peak_force, self.contacts_per_period].map(number)
    }

    /// As printed: RMS voltage in V, mean force in mN, peak force in N, contacts per period.
    fn printed(&self) -> [String; 4] {
        [
            format!("{:.4}", self.rms_voltage),
            format!("{:.2}", 1e3 * self.mean_force),
            format!("{:.2}", self.peak_force),
            format!("{:.1}", self.contacts_per_period),
        ]
    }
}

/// Place of the stop (0 at the tip, 1 at mid-span), modes of the rod and modes of the beam, and the numbers of the run.
pub(super) type ModesPoint = ([usize; 3], ConvergenceRun);

/// All counts of modes, with the stop at the tip and at mid-span.
pub(super) fn in_modes(scenes: [&Scene; 2], done: &(dyn Fn() + Sync)) -> Result<Vec<ModesPoint>, Failure> {
    let mut cases = Vec::new();
    // The longest runs first, so that all cores end at about the same time.
    for beam in BEAM.into_iter().rev() {
        cases.extend(ROD.into_iter().rev().flat_map(|rod| [[0, rod, beam], [1, rod, beam]]));
    }
    let options = Options::default();
    let mut points = try_each_counted(&cases, done, |&[place, rod, beam]| {
        let contact = Contact::ResidualFlexibility;
        Ok(([place, rod, beam], found(scenes[place], (beam, rod), contact, MODES_RUN, &options)?))
    })?;
    points.sort_by_key(|(case, _)| *case);
    Ok(points)
}

/// Place in the list of laws and step near contact in s, and the numbers of the run.
pub(super) type StepPoint = ((usize, f64), ConvergenceRun);

/// All steps under both laws, with the stop at the tip.
pub(super) fn in_step(scene: &Scene, done: &(dyn Fn() + Sync)) -> Result<Vec<StepPoint>, Failure> {
    let cases: Vec<(usize, f64)> =
        STEPS.into_iter().flat_map(|step_s| (0..LAWS.len()).map(move |law| (law, step_s))).collect();
    try_each_counted(&cases, done, |&(law, step_s)| {
        let long_step_s = Some(LONG_STEP_S.max(step_s));
        let options = Options { step_s: Some(step_s), long_step_s, ..Options::default() };
        Ok(((law, step_s), found(scene, STEP_MODES, LAWS[law].0, STEP_RUN, &options)?))
    })
}

/// Width of the lines and diameter of the dots.
const STROKES: Mark = Mark::dotted(0, [1.6, 6.0]);

/// RMS voltage over the number of beam modes.
pub(super) fn modes_figure(points: &[ModesPoint], [base, note]: [&str; 2]) -> Figure {
    let places = ["tip", "mid-span"];
    let panel = |(index, (letter, place)): (usize, (char, &str))| {
        let here = || points.iter().filter(move |([place, ..], _)| *place == index);
        let curves = ROD.into_iter().zip(ROD_COLOURS).map(|(wanted, colour)| {
            let of = here().filter(|([_, rod, _], _)| *rod == wanted);
            let points = of.map(|([.., beam], found)| (*beam as f64, found.rms_voltage));
            Curve::new(format!("{wanted} of the rod"), colour, STROKES, points)
        });
        let highest = here().map(|(_, found)| found.rms_voltage).fold(0.0, f64::max);
        let plot = Chart::new(
            format!("Modes ({letter}): stop at the {place}, {base}"),
            Axis::linear("modes of the beam", [0.0, 21.0], 11),
            Axis::linear("RMS voltage [V]", [0.0, 1.1 * highest], 8),
            curves.collect(),
        );
        Panel::new(format!("convergence-in-modes-{letter}"), SIZE, [plot])
    };
    let case =
        |[place, rod, beam]: &[usize; 3]| [places[*place].to_owned(), beam.to_string(), rod.to_string()];
    let csv = csv(
        "stop,beam_modes,rod_modes,rms_voltage_v,mean_force_n,peak_force_n,contacts_per_period",
        points.iter().map(|(modes, found)| case(modes).into_iter().chain(found.cells())),
    );
    let row = |(modes, found): &ModesPoint| {
        let [place, beam, rod] = case(modes);
        let [voltage, mean, peak, _] = found.printed();
        [place, beam, rod, voltage, mean, peak]
    };
    Figure {
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
        panels: ['a', 'b'].into_iter().zip(places).enumerate().map(panel).collect(),
        table: crate::figures::table(
            ["stop", "beam modes", "rod modes", "RMS voltage [V]", "mean force [mN]", "peak force [N]"],
            points.iter().map(row),
        ),
        csv,
    }
}

/// RMS voltage and peak force over the step.
pub(super) fn step_figure(points: &[StepPoint], [base, note]: [&str; 2]) -> Figure {
    let row = |((law, step_s), found): &StepPoint| {
        let [voltage, mean, peak, contacts] = found.printed();
        [LAWS[*law].1.to_owned(), tick(1e6 * step_s), voltage, mean, peak, contacts]
    };
    let headings = [
        "contact",
        "step [µs]",
        "RMS voltage [V]",
        "mean force [mN]",
        "peak force [N]",
        "contacts per period",
    ];
    let csv = csv(
        "contact,step_s,rms_voltage_v,mean_force_n,peak_force_n,contacts_per_period",
        points.iter().map(|((law, step_s), found)| {
            [LAWS[*law].1.to_owned(), number(*step_s)].into_iter().chain(found.cells())
        }),
    );
    let (beam, rod) = STEP_MODES;
    Figure {
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
        panels: step_panels(points, base),
        table: crate::figures::table(headings, points.iter().map(row)),
        csv,
    }
}

fn step_panels(points: &[StepPoint], base: &str) -> Vec<Panel> {
    let across = Axis::logarithmic("step near contact [s]", [0.9 * STEPS[0], 1.1 * STEPS[STEPS.len() - 1]]);
    let curves = |value: fn(&ConvergenceRun) -> f64| -> Vec<Curve> {
        let laws = LAWS.iter().enumerate();
        laws.map(|(index, (_, name, colour))| {
            let of = points.iter().filter(|((law, _), _)| *law == index);
            let points = of.map(|((_, step_s), found)| (*step_s, value(found)));
            Curve::new(*name, *colour, STROKES, points)
        })
        .collect()
    };
    let (voltages, forces) = (curves(|found| found.rms_voltage), curves(|found| found.peak_force));
    let highest = voltages.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(0.0, f64::max);
    let (low, high) = range(forces.iter().flat_map(|curve| &curve.points).map(|point| point.1.log10()));
    let span = [10f64.powf(low.floor()), 10f64.powf(high.ceil())];
    let plots = [
        Chart::new(
            format!("Step (a), stop at the tip: {base}"),
            across.clone(),
            Axis::linear("RMS voltage [V]", [0.0, 1.2 * highest], 8),
            voltages,
        ),
        Chart::new(
            format!("Step (b), stop at the tip: {base}"),
            across,
            Axis::logarithmic("peak contact force [N]", span),
            forces,
        ),
    ];
    let panel = |(letter, plot)| Panel::new(format!("convergence-in-step-{letter}"), SIZE, [plot]);
    ['a', 'b'].into_iter().zip(plots).map(panel).collect()
}
