//! The motion over the last periods of a run, and figures 6, 8 and 9, some of its periods.

use plotters::style::RGBColor;

use super::{Figure, Panel};
use crate::embedded::{ContactInterval, chattering_phases};
use crate::method::{Failure, Options};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION};
use crate::run::run_scene;
use crate::scene_file::{RunSpan, Scene};

/// Periods of the base before those that are shown. The free motion of the beam decays by a factor of e in 3 periods.
pub(super) const SETTLE: u32 = 22;
/// Periods that are shown.
pub(super) const SHOWN: u32 = 3;
/// Length of each step, and distance of the samples, in s. Contacts last some 4 µs.
pub(super) const STEP_S: f64 = 1e-6;

/// Columns of a row: time in s, displacements in m, voltage in V, force in N.
const TIME: usize = 0;
/// Displacement of the tip.
pub const TIP: usize = 1;
/// Displacement of the beam at the stop.
pub const STOP_POINT: usize = 2;
/// Displacement of the rod's face.
pub const ROD: usize = 3;
/// Voltage at the terminals.
pub const VOLTAGE: usize = 4;
/// Contact force.
pub const CONTACT_FORCE: usize = 5;

/// Samples over the periods that are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Frequency of the base in Hz.
    pub frequency: f64,
    pub rows: Vec<Vec<f64>>,
}

pub(super) fn options() -> Options {
    Options { step_s: Some(STEP_S), ..Options::default() }
}

/// The scene over the periods before and those shown.
pub(super) fn spanned(scene: &Scene) -> Result<(Scene, f64), Failure> {
    let frequency = scene
        .excitation
        .single_frequency()
        .ok_or_else(|| Failure::of_file(scene, "excitation.kind must be \"sine\""))?;
    let run = RunSpan {
        duration_s: f64::from(SETTLE + SHOWN) / frequency,
        settle_s: f64::from(SETTLE) / frequency,
    };
    Ok((Scene { run, ..scene.clone() }, frequency))
}

impl Motion {
    /// The last periods of a run from rest.
    pub fn of(scene: &Scene) -> Result<Self, Failure> {
        let (scene, frequency) = spanned(scene)?;
        let outcome = run_scene(&scene, &Options { trace_every_s: Some(STEP_S), ..options() })?;
        let mut rows = outcome.trace.map(|trace| trace.rows).unwrap_or_default();
        rows.retain(|row| row.first().is_some_and(|time| *time >= scene.run.settle_s));
        Ok(Self { frequency, rows })
    }

    /// A column over time in periods since the start, `scale` times as large; every so many rows.
    pub fn over_periods(&self, column: usize, scale: f64, every: usize) -> Vec<(f64, f64)> {
        let point = |row: &Vec<f64>| Some((row.get(TIME)? * self.frequency, row.get(column)? * scale));
        self.rows.iter().step_by(every).filter_map(point).collect()
    }

    /// A column over time in µs since `from` in s, `scale` times as large, within two instants in s.
    pub fn within(&self, [from, to]: [f64; 2], column: usize, scale: f64) -> Vec<(f64, f64)> {
        let rows = self.rows.iter().filter(|row| (from..=to).contains(&row[TIME]));
        rows.filter_map(|row| Some((1e6 * (row[TIME] - from), row.get(column)? * scale))).collect()
    }

    /// First and last instant in s of the longest chattering phase that is shown.
    pub fn longest_cluster(&self) -> Option<[f64; 2]> {
        let touching =
            self.rows.iter().filter(|row| row.get(CONTACT_FORCE).is_some_and(|force| *force > 0.0));
        let samples: Vec<ContactInterval> =
            touching.map(|row| ContactInterval { begins_s: row[TIME], ends_s: row[TIME] }).collect();
        let phases = chattering_phases(&samples, 1.0 / self.frequency);
        let spans = phases.filter_map(|phase| Some([phase.first()?.begins_s, phase.last()?.ends_s]));
        spans.max_by(|one, other| (one[1] - one[0]).total_cmp(&(other[1] - other[0])))
    }

    /// First and last instant in s of the longest contact within two instants in s.
    pub fn longest_contact(&self, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let rows: Vec<&Vec<f64>> = self.rows.iter().filter(|row| (from..=to).contains(&row[TIME])).collect();
        let touches = |row: &Vec<f64>| row.get(CONTACT_FORCE).is_some_and(|force| *force > 0.0);
        let runs = rows.chunk_by(|one, next| touches(one) == touches(next));
        let contacts = runs.filter(|run| run.first().is_some_and(|row| touches(row)));
        let longest = contacts.max_by_key(|run| run.len())?;
        Some([longest.first()?[TIME], longest.last()?[TIME]])
    }
}

/// Rows from one point of a curve to the next: 20 µs are a third of a pixel. Curves of the force take every row: contacts are short.
const THIN: usize = 20;
const WIDE: (u32, u32) = (1130, 360);
const THREE_HIGH: (u32, u32) = (1130, 900);

/// A column over the periods shown, `scale` times as large.
fn curve(name: &str, colour: RGBColor, motion: &Motion, column: usize, scale: f64) -> Curve {
    let every = if column == CONTACT_FORCE { 1 } else { THIN };
    Curve::new(name, colour, Mark::line(0, 1.4), motion.over_periods(column, scale, every))
}

fn plot(title: &str, up: &'static str, curves: Vec<Curve>) -> Chart {
    let span = [SETTLE, SETTLE + SHOWN].map(f64::from);
    Chart::new(
        title,
        Axis::linear("time since the start [excitation periods]", span, 7),
        Axis::linear(up, FITTING, 7),
        curves,
    )
}

pub(super) fn six(tip: &Motion, [base, note]: [&str; 2]) -> Figure {
    let plots = [
        (format!("Figure 6 (a): {base}"), "displacement [µm]", BLUE, STOP_POINT, 1e6),
        ("(b)".to_owned(), "contact force [N]", VERMILION, CONTACT_FORCE, 1.0),
        ("(c)".to_owned(), "voltage [V]", GREEN, VOLTAGE, 1.0),
    ]
    .map(|(title, up, colour, column, scale)| plot(&title, up, vec![curve("", colour, tip, column, scale)]));
    Figure {
        label: "Figure 6",
        title: "Displacement, contact force and voltage with the stop at the tip",
        caption: format!(
            "{SHOWN} periods after {SETTLE}: (a) displacement of the tip relative to the base, towards the stop, \
             which stands 10 µm away; (b) contact force; (c) voltage. Once a period the beam comes to the stop, hits \
             it some hundred times, rests on it and leaves; the impacts excite high modes, which are seen in the \
             voltage. The peaks of the force are those of ten modes each, the impulses converge with modes, the \
             peaks do not. {note}"
        ),
        panels: vec![Panel::new("figure-6", THREE_HIGH, plots)],
        table: Vec::new(),
        csv: whole(tip),
    }
}

pub(super) fn eight([tip, none]: [&Motion; 2], [base, note]: [&str; 2]) -> Figure {
    let curves = vec![
        Curve { mark: Mark::line(1, 1.4), ..curve("without impact", BLUE, none, VOLTAGE, 1.0) },
        curve("with impact, stop at the tip", VERMILION, tip, VOLTAGE, 1.0),
    ];
    let plot = plot(&format!("Figure 8: {base}"), "voltage [V]", curves);
    Figure {
        label: "Figure 8",
        title: "Voltage with and without impact",
        caption: format!(
            "{SHOWN} periods after {SETTLE}: the voltage is lower during contact, and out of contact it is close to that \
             without a stop. {note}"
        ),
        panels: vec![Panel::new("figure-8", WIDE, [plot])],
        table: Vec::new(),
        csv: voltages(&[("tip", tip), ("none", none)]),
    }
}

pub(super) fn nine([tip, mid, none]: [&Motion; 3], [base, note]: [&str; 2]) -> Figure {
    let curves = vec![
        Curve { mark: Mark::line(1, 1.4), ..curve("no stop", BLUE, none, VOLTAGE, 1.0) },
        curve("stop at mid-span", BLACK, mid, VOLTAGE, 1.0),
        curve("stop at the tip", VERMILION, tip, VOLTAGE, 1.0),
    ];
    let rows = [("none", none), ("mid-span", mid), ("tip", tip)].map(|(name, motion)| {
        let voltages = || motion.rows.iter().filter_map(|row| row.get(VOLTAGE));
        let highest = voltages().fold(0.0_f64, |highest, voltage| highest.max(voltage.abs()));
        let squares: f64 = voltages().map(|voltage| voltage * voltage).sum();
        let root = (squares / motion.rows.len() as f64).sqrt();
        [name.to_owned(), format!("{root:.3}"), format!("{highest:.3}")]
    });
    let plot = plot(&format!("Figure 9: {base}"), "voltage [V]", curves);
    Figure {
        label: "Figure 9",
        title: "Voltage for three places of the stop",
        caption: format!(
            "{SHOWN} periods after {SETTLE}, with the stop at the tip, at mid-span, and without one. With the stop \
             at mid-span the voltage has higher peaks than with the stop at the tip: it goes with the slope of the \
             tip, which a stop at the tip holds down. RMS voltages with a stop are below that without one; the peaks \
             are above it, because the beam rings after it leaves the stop. {note}"
        ),
        panels: vec![Panel::new("figure-9", WIDE, [plot])],
        table: crate::figures::table(
            ["stop", "RMS voltage over these periods [V]", "peak voltage [V]"],
            rows.into_iter(),
        ),
        csv: voltages(&[("tip", tip), ("mid-span", mid), ("none", none)]),
    }
}

fn whole(motion: &Motion) -> String {
    let cell = |row: &Vec<f64>, column: usize| row.get(column).copied().map(number).unwrap_or_default();
    csv(
        "time_s,tip_displacement_m,stop_point_displacement_m,rod_tip_displacement_m,voltage_v,contact_force_n",
        motion
            .rows
            .iter()
            .map(|row| [0, TIP, STOP_POINT, ROD, VOLTAGE, CONTACT_FORCE].map(|at| cell(row, at))),
    )
}

/// The voltages of several, as they are drawn.
fn voltages(motions: &[(&str, &Motion)]) -> String {
    let rows = motions.iter().flat_map(|(name, motion)| {
        let row =
            |(period, voltage)| [(*name).to_owned(), number(period / motion.frequency), number(voltage)];
        motion.over_periods(VOLTAGE, 1.0, THIN).into_iter().map(row)
    });
    csv("stop,time_s,voltage_v", rows)
}
