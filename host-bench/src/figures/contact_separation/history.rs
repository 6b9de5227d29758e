//! Figure 9: the gap over time, on both sides of where impacts begin and end.

use plotters::style::RGBColor;

use super::motion::{Case, Motion, WINDOW};
use super::{Figure, Panel, SETTLE, each};
use crate::method::Failure;
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, VERMILION};
use crate::scene_file::Scene;

/// Frequencies in Hz: two at the onset of impacts, two at the upper edge of the band.
pub(crate) const FREQUENCIES: [f64; 4] = [18.83, 18.84, 20.15, 20.20];

/// A panel: two frequencies with their colours, and the periods that are shown.
struct Pair {
    letter: char,
    title: &'static str,
    strips: [(f64, RGBColor); 2],
    periods: u32,
}

const PAIRS: [Pair; 2] = [
    Pair {
        letter: 'a',
        title: "Figure 9 (a), onset of impacts",
        strips: [(FREQUENCIES[0], BLUE), (FREQUENCIES[1], VERMILION)],
        // At the onset about twenty periods pass between impacts.
        periods: 60,
    },
    Pair {
        letter: 'b',
        title: "Figure 9 (b), upper edge",
        strips: [(FREQUENCIES[2], VERMILION), (FREQUENCIES[3], BLUE)],
        periods: 12,
    },
];

/// Periods from the start to the end.
const END: u32 = SETTLE + WINDOW;
/// Points in each period.
const PER_PERIOD: u32 = 60;
const SIZE: (u32, u32) = (1130, 520);

/// Runs the four cases and draws them.
pub(super) fn nine(
    base: &Scene,
    [charge_density, resistance]: [f64; 2],
    tolerance: f64,
    [base_g, start]: [&str; 2],
    done: &(dyn Fn() + Sync),
) -> Result<Figure, Failure> {
    let mut strips = Vec::new();
    for pair in &PAIRS {
        strips.extend(pair.strips.map(|(frequency, _)| (frequency, END - pair.periods)));
    }
    let histories = each(&strips, done, |&(frequency, from)| {
        let case = Case { charge_density, resistance, frequency, settle: SETTLE };
        case.motion(base, tolerance, PER_PERIOD, from)
    })?;
    let of = format!("{charge_density} µC/m², {resistance} MΩ, {base_g}");
    let panels = PAIRS.iter().zip(histories.chunks(2)).map(|(pair, histories)| panel(pair, &of, histories));
    let [onset, after, edge, beyond] = FREQUENCIES;
    Ok(Figure {
        label: "Figure 9",
        title: "Time histories of the gap where impacts begin and end",
        caption: format!(
            "Gap over the last periods of four runs of {END} periods at {charge_density} µC/m² and {resistance} MΩ; \
             at gap 0, where a dot is, the mass hits the dielectric. (a) At {onset:.2} Hz it comes close without touching, and the \
             slow beat, left over from the start, fades. At {after:.2} Hz the beat stays: every so many periods the \
             mass hits the dielectric, with a long free flight between. (b) At {edge:.2} Hz it hits in every \
             period; at {beyond:.2} Hz impacts are gone and the motion is much smaller. {start}"
        ),
        panels: panels.collect(),
        table: Vec::new(),
        csv: csv(
            "frequency_hz,period,time_s,gap_m",
            histories.iter().flat_map(|motion| {
                let row =
                    |&(period, gap)| [motion.frequency, period, period / motion.frequency, gap].map(number);
                motion.gaps.iter().map(row)
            }),
        ),
    })
}

fn panel(pair: &Pair, of: &str, histories: &[Motion]) -> Panel {
    let plots = histories.iter().zip(pair.strips).map(|(motion, (_, colour))| {
        Chart::new(
            format!(
                "{}: {:.2} Hz, {of}; {} impacts in the last {WINDOW} periods",
                pair.title, motion.frequency, motion.impacts
            ),
            Axis::linear(
                "time since the start [excitation periods]",
                [f64::from(END - pair.periods), f64::from(END)],
                13,
            ), // Dots at 0 stand above the axis.
            Axis::linear("gap [mm]", [-0.3, 6.0], 7),
            curves(motion, colour),
        )
    });
    Panel::new(format!("figure-9{}", pair.letter), SIZE, plots)
}

/// The gap, and the impacts of those that have any.
fn curves(motion: &Motion, colour: RGBColor) -> Vec<Curve> {
    let gap = motion.gaps.iter().map(|&(period, gap)| (period, 1e3 * gap));
    let impacts = motion.hits.iter().map(|period| (*period, 0.0));
    let mut curves = vec![Curve::new("", colour, Mark::Line(1.5), gap)];
    if !motion.hits.is_empty() {
        curves.push(Curve::new("impact", BLACK, Mark::Dots(7.0), impacts));
    }
    curves
}
