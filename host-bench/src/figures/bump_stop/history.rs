//! Figures 6, 8 and 9: some periods of the motion.

use std::fmt::Write;

use plotters::style::RGBColor;

use super::motion::{CONTACT_FORCE, Motion, ROD, SETTLE, SHOWN, STOP_POINT, TIP, VOLTAGE};
use super::{Figure, Panel};
use crate::outcome::number;
use crate::report::plot::{self, Axis, Curve, Mark, Plot};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION, range};

/// Rows from one point of a curve to the next: 5 µs are half a pixel. Curves of the force take every row, because a contact
/// may be shorter.
const THIN: usize = 5;
const WIDE: (u32, u32) = (1130, 360);
const THREE_HIGH: (u32, u32) = (1130, 900);

fn time_axis() -> Axis {
    let span = [SETTLE, SETTLE + SHOWN].map(f64::from);
    Axis::linear("time since the start [excitation periods]", span, 7)
}

fn curve(name: &str, colour: RGBColor, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.to_owned(), colour, mark: Mark::Line(1.4), points }
}

fn plot(title: &str, up: &'static str, curves: Vec<Curve>) -> Plot {
    let (low, high) = range(curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    Plot { title: title.to_owned(), across: time_axis(), up: Axis::linear(up, [low, high], 7), curves }
}

/// Figure 6.
pub(super) fn six(tip: &Motion, note: &str) -> Result<Figure, String> {
    let plots = [
        plot(
            "Figure 6 (a)",
            "displacement [µm]",
            vec![curve("", BLUE, tip.over_periods(STOP_POINT, 1e6, THIN))],
        ),
        plot(
            "Figure 6 (b)",
            "contact force [N]",
            vec![curve("", VERMILION, tip.over_periods(CONTACT_FORCE, 1.0, 1))],
        ),
        plot("Figure 6 (c)", "voltage [V]", vec![curve("", GREEN, tip.over_periods(VOLTAGE, 1.0, THIN))]),
    ];
    Ok(Figure {
        label: "Figure 6",
        title: "Displacement, contact force and voltage with the stop at the tip",
        caption: format!(
            "{SHOWN} periods after {SETTLE}: (a) displacement of the tip relative to the base, towards the stop, \
             which stands at 0; (b) contact force; (c) voltage. Once a period the beam comes to the stop and hits it \
             again and again before it leaves; the impacts excite high modes, which are seen in the voltage. The \
             peaks of the force are those of ten modes each, the impulses converge with modes, the peaks do \
             not. {note}"
        ),
        panels: vec![Panel { name: "figure-6".to_owned(), svg: plot::draw(THREE_HIGH, &plots)? }],
        table: Vec::new(),
        csv: whole(tip),
    })
}

/// Figure 8.
pub(super) fn eight([tip, none]: [&Motion; 2], note: &str) -> Result<Figure, String> {
    let curves = vec![
        curve("without impact", BLUE, none.over_periods(VOLTAGE, 1.0, THIN)),
        curve("with impact, stop at the tip", VERMILION, tip.over_periods(VOLTAGE, 1.0, THIN)),
    ];
    let plot = plot("Figure 8", "voltage [V]", curves);
    Ok(Figure {
        label: "Figure 8",
        title: "Voltage with and without impact",
        caption: format!(
            "{SHOWN} periods after {SETTLE}: the stop keeps the beam from swinging, and the voltage is far \
             lower. {note}"
        ),
        panels: vec![Panel { name: "figure-8".to_owned(), svg: plot::draw(WIDE, &[plot])? }],
        table: Vec::new(),
        csv: voltages(&[("tip", tip), ("none", none)]),
    })
}

/// Figure 9.
pub(super) fn nine([tip, mid, none]: [&Motion; 3], note: &str) -> Result<Figure, String> {
    let curves = vec![
        curve("no stop", BLUE, none.over_periods(VOLTAGE, 1.0, THIN)),
        curve("stop at mid-span", BLACK, mid.over_periods(VOLTAGE, 1.0, THIN)),
        curve("stop at the tip", VERMILION, tip.over_periods(VOLTAGE, 1.0, THIN)),
    ];
    let highest = |motion: &Motion| {
        let voltages = motion.rows.iter().filter_map(|row| row.get(VOLTAGE));
        voltages.fold(0.0_f64, |highest, voltage| highest.max(voltage.abs()))
    };
    let root = |motion: &Motion| {
        let squares: f64 =
            motion.rows.iter().filter_map(|row| row.get(VOLTAGE)).map(|voltage| voltage * voltage).sum();
        (squares / motion.rows.len() as f64).sqrt()
    };
    let rows = [("none", none), ("mid-span", mid), ("tip", tip)].map(|(name, motion)| {
        [name.to_owned(), format!("{:.3}", root(motion)), format!("{:.3}", highest(motion))]
    });
    let plot = plot("Figure 9", "voltage [V]", curves);
    Ok(Figure {
        label: "Figure 9",
        title: "Voltage for three places of the stop",
        caption: format!(
            "{SHOWN} periods after {SETTLE}, with the stop at the tip, at mid-span, and without one. With the stop \
             at mid-span the voltage has higher peaks than with the stop at the tip: it goes with the slope of the \
             tip, which a stop at the tip holds down. At mid-span the motion does not repeat itself in every period. {note}"
        ),
        panels: vec![Panel { name: "figure-9".to_owned(), svg: plot::draw(WIDE, &[plot])? }],
        table: crate::figures::table(
            ["stop", "RMS voltage over these periods [V]", "peak voltage [V]"],
            rows.into_iter(),
        ),
        csv: voltages(&[("tip", tip), ("mid-span", mid), ("none", none)]),
    })
}

/// All columns of one motion.
fn whole(motion: &Motion) -> String {
    let mut text = String::from(
        "time_s,tip_displacement_m,stop_point_displacement_m,rod_tip_displacement_m,voltage_v,contact_force_n\n",
    );
    for row in &motion.rows {
        let cell = |column: usize| row.get(column).copied().map(number).unwrap_or_default();
        let _ = writeln!(text, "{}", [0, TIP, STOP_POINT, ROD, VOLTAGE, CONTACT_FORCE].map(cell).join(","));
    }
    text
}

/// The voltages of several, as they are drawn.
fn voltages(motions: &[(&str, &Motion)]) -> String {
    let mut text = String::from("stop,time_s,voltage_v\n");
    for (name, motion) in motions {
        for (period, voltage) in motion.over_periods(VOLTAGE, 1.0, THIN) {
            let _ = writeln!(text, "{name},{},{}", number(period / motion.frequency), number(voltage));
        }
    }
    text
}
