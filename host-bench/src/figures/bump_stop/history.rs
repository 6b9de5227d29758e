//! Figures 6, 8 and 9: some periods of the motion.

use plotters::style::RGBColor;

use super::motion::{CONTACT_FORCE, Motion, ROD, SETTLE, SHOWN, STOP_POINT, TIP, VOLTAGE};
use super::{Figure, Panel};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION};

/// Rows from one point of a curve to the next: 20 µs are a third of a pixel. Curves of the force take every row, because a
/// contact may be shorter.
const THIN: usize = 20;
const WIDE: (u32, u32) = (1130, 360);
const THREE_HIGH: (u32, u32) = (1130, 900);

/// A column over the periods shown, `scale` times as large.
fn curve(name: &str, colour: RGBColor, motion: &Motion, column: usize, scale: f64) -> Curve {
    let every = if column == CONTACT_FORCE { 1 } else { THIN };
    Curve::new(name, colour, Mark::Line(1.4), motion.over_periods(column, scale, every))
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

/// Figure 6.
pub(super) fn six(tip: &Motion, [base, note]: [&str; 2]) -> Figure {
    let plots = [
        ("Figure 6 (a)", "displacement [µm]", BLUE, STOP_POINT, 1e6),
        ("Figure 6 (b)", "contact force [N]", VERMILION, CONTACT_FORCE, 1.0),
        ("Figure 6 (c)", "voltage [V]", GREEN, VOLTAGE, 1.0),
    ]
    .map(|(title, up, colour, column, scale)| {
        plot(&format!("{title}: {base}"), up, vec![curve("", colour, tip, column, scale)])
    });
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

/// Figure 8.
pub(super) fn eight([tip, none]: [&Motion; 2], [base, note]: [&str; 2]) -> Figure {
    let curves = vec![
        curve("without impact", BLUE, none, VOLTAGE, 1.0),
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

/// Figure 9.
pub(super) fn nine([tip, mid, none]: [&Motion; 3], [base, note]: [&str; 2]) -> Figure {
    let curves = vec![
        curve("no stop", BLUE, none, VOLTAGE, 1.0),
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

/// All columns of one motion.
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
