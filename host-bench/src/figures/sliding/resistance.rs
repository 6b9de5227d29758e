//! Figure 6: the peak over the load resistance, and both sweeps as tables.

use std::fmt::Write;

use plotters::style::RGBColor;

use super::response::{COLOURS, RESISTANCES};
use super::{Case, DENSITIES, Figure, Panel, Peak, ohms};
use crate::outcome::number;
use crate::report::plot::{self, Axis, Curve, Mark, Plot};
use crate::report::svg::{BLACK, BLUE, VERMILION, range};

/// Resistances within a decade, and the decades in Ω.
const WITHIN: [f64; 11] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.5];
const DECADES: [f64; 5] = [1e5, 1e6, 1e7, 1e8, 1e9];
/// The first and the last resistance above 0, in Ω.
const SPAN: [f64; 2] = [1e5, 1e10];

/// Charge densities of the sweep in µC/m², and its resistances in Ω.
const CHARGES: [f64; 8] = [0.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0];
const LOADS: [f64; 2] = [1e7, 1e8];
/// Resistances of the printed sweep, in Ω.
const ROWS: [f64; 12] = [0.0, 1e5, 1e6, 5e6, 1e7, 2e7, 5e7, 1e8, 2e8, 5e8, 1e9, 1e10];

/// Colours of the small and the large charge density.
const PAIR: [RGBColor; 2] = [BLUE, VERMILION];
const SIZE: (u32, u32) = (560, 430);
const TALL: (u32, u32) = (560, 620);

/// All resistances of the curves, rising from 0.
fn resistances() -> Vec<f64> {
    let above = DECADES.iter().flat_map(|decade| WITHIN.map(|factor| factor * decade));
    std::iter::once(0.0).chain(above).chain([SPAN[1]]).collect()
}

/// Both sweeps.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for charge_density in DENSITIES {
        cases.extend(resistances().into_iter().map(|resistance| Case { charge_density, resistance }));
    }
    for resistance in LOADS {
        for charge_density in CHARGES {
            let case = Case { charge_density, resistance };
            if !cases.contains(&case) {
                cases.push(case);
            }
        }
    }
    cases
}

fn of(peaks: &[Peak], charge_density: f64, resistance: f64) -> Option<&Peak> {
    peaks.iter().find(|peak| peak.case == Case { charge_density, resistance })
}

/// The peaks at one charge density, rising in resistance.
fn along(peaks: &[Peak], charge_density: f64) -> Vec<&Peak> {
    resistances().iter().filter_map(|&resistance| of(peaks, charge_density, resistance)).collect()
}

/// Figure 6.
pub(super) fn six(peaks: &[Peak], natural: f64, note: &str) -> Result<Figure, String> {
    let shift = |peak: &Peak| 1e3 * (peak.frequency_hz - natural);
    let amplitude = |peak: &Peak| 1e3 * peak.amplitude_m;
    Ok(Figure {
        label: "Figure 6",
        title: "Resonance frequency and amplitude over the load resistance",
        caption: format!(
            "The peak of the amplitude, from a short circuit to {}: (a) its height over its frequency at {} µC/m², \
             a loop that runs from the black dot to the left and down and back to the right; (b) its shift from \
             the natural frequency and (c) its height over the resistance, at {} and at {} µC/m²; dashed, the value \
             of the short circuit; (d) the rise of (c), larger: the height over that of the short circuit, minus \
             one. With growing resistance the frequency first falls; with much charge it then rises beyond its value \
             without resistance. The amplitude first rises by a little, then falls, and levels out. In the paper (a) \
             is a curve in space, with the resistance as the third axis; (d) is ours. {note}",
            ohms(SPAN[1]),
            DENSITIES[1],
            DENSITIES[0],
            DENSITIES[1]
        ),
        panels: vec![
            looping(&along(peaks, DENSITIES[1]), shift, amplitude)?,
            over_resistance('b', "shift of the peak [mHz]", peaks, shift)?,
            over_resistance('c', "amplitude of the peak [mm]", peaks, amplitude)?,
            rise(peaks)?,
        ],
        table: Vec::new(),
        csv: csv(DENSITIES.iter().flat_map(|&density| along(peaks, density)), natural),
    })
}

/// The curve that the peak runs along, with the resistances of figures 4 and 5 marked.
fn looping(
    peaks: &[&Peak],
    shift: impl Fn(&Peak) -> f64,
    amplitude: impl Fn(&Peak) -> f64,
) -> Result<Panel, String> {
    let points: Vec<(f64, f64)> = peaks.iter().map(|peak| (shift(peak), amplitude(peak))).collect();
    let (left, right) = range(points.iter().map(|point| point.0));
    let (low, high) = range(points.iter().map(|point| point.1));
    let line = Curve { name: String::new(), colour: BLUE, mark: Mark::Line(1.2), points };
    let marks = RESISTANCES.iter().zip(COLOURS).map(|(resistance, colour)| Curve {
        name: ohms(*resistance),
        colour,
        mark: Mark::Dots(9.0),
        points: peaks
            .iter()
            .filter(|peak| peak.case.resistance == *resistance)
            .map(|peak| (shift(peak), amplitude(peak)))
            .collect(),
    });
    let plot = Plot {
        title: format!("Figure 6 (a): {} µC/m², loads from 0 Ω to {}", DENSITIES[1], ohms(SPAN[1])),
        across: Axis::linear("shift of the peak from the natural frequency [mHz]", [left, right], 6),
        up: Axis::linear("amplitude of the peak [mm]", [low, high], 8),
        curves: std::iter::once(line).chain(marks).collect(),
    };
    Ok(Panel { name: "figure-6a".to_owned(), svg: plot::draw(SIZE, &[plot])? })
}

/// Both charge densities, one above the other.
fn over_resistance(
    letter: char,
    title: &'static str,
    peaks: &[Peak],
    value: impl Fn(&Peak) -> f64,
) -> Result<Panel, String> {
    let plots = DENSITIES.iter().zip(PAIR).map(|(&density, colour)| {
        let along = along(peaks, density);
        let shorted = along.iter().filter(|peak| peak.case.resistance == 0.0).map(|peak| value(peak));
        let level: Vec<(f64, f64)> =
            shorted.flat_map(|value| SPAN.map(|resistance| (resistance, value))).collect();
        let points: Vec<(f64, f64)> = along
            .iter()
            .filter(|peak| peak.case.resistance > 0.0)
            .map(|peak| (peak.case.resistance, value(peak)))
            .collect();
        let (low, high) = range(points.iter().chain(&level).map(|point| point.1));
        Plot {
            title: format!("Figure 6 ({letter}): {density} µC/m²"),
            across: Axis::logarithmic("load resistance [Ω]", SPAN),
            up: Axis::linear(title, [low, high], 6),
            curves: vec![
                Curve { name: String::new(), colour: BLACK, mark: Mark::Dashes(1.0), points: level },
                Curve { name: String::new(), colour, mark: Mark::Line(1.6), points: points.clone() },
                Curve { name: String::new(), colour, mark: Mark::Dots(4.5), points },
            ],
        }
    });
    let svg = plot::draw(TALL, &plots.collect::<Vec<_>>())?;
    Ok(Panel { name: format!("figure-6{letter}"), svg })
}

/// The rise of the amplitude before its fall, in parts of the amplitude of the short circuit.
fn rise(peaks: &[Peak]) -> Result<Panel, String> {
    let mut curves = Vec::new();
    for (density, colour) in DENSITIES.into_iter().zip(PAIR) {
        let Some(shorted) = of(peaks, density, 0.0) else { continue };
        let above = along(peaks, density).into_iter().filter(|peak| peak.case.resistance > 0.0);
        let points: Vec<(f64, f64)> = above
            .map(|peak| (peak.case.resistance, 1e2 * (peak.amplitude_m / shorted.amplitude_m - 1.0)))
            .collect();
        let name = format!("{density} µC/m²");
        curves.push(Curve { name, colour, mark: Mark::Line(1.6), points: points.clone() });
        curves.push(Curve { name: String::new(), colour, mark: Mark::Dots(4.5), points });
    }
    let level = SPAN.map(|resistance| (resistance, 0.0)).to_vec();
    curves.push(Curve { name: String::new(), colour: BLACK, mark: Mark::Dashes(1.0), points: level });
    let plot = Plot {
        title: "Figure 6 (d): the rise of the amplitude".to_owned(),
        across: Axis::logarithmic("load resistance [Ω]", [SPAN[0], 1e8]),
        up: Axis::linear("amplitude against 0 Ω [%]", [-0.04, 0.04], 8),
        curves,
    };
    Ok(Panel { name: "figure-6d".to_owned(), svg: plot::draw(SIZE, &[plot])? })
}

/// Shift in Hz, amplitude in mm, RMS voltage in V, as they are printed.
fn cells(peaks: &[Peak], charge_density: f64, resistance: f64, natural: f64) -> [String; 3] {
    let Some(peak) = of(peaks, charge_density, resistance) else { return [(); 3].map(|()| "-".to_owned()) };
    [
        format!("{:+.5}", peak.frequency_hz - natural),
        format!("{:.4}", 1e3 * peak.amplitude_m),
        format!("{:.3}", peak.rms_voltage_v),
    ]
}

/// The peaks over the charge density.
pub(super) fn charge_sweep(peaks: &[Peak], natural: f64, note: &str) -> Figure {
    let headings =
        ["charge [µC/m²]", "10 MΩ: shift [Hz]", "[mm]", "[V]", "100 MΩ: shift [Hz]", "[mm]", "[V]"];
    let rows = CHARGES.iter().map(|&density| {
        let [one, other] = LOADS.map(|load| cells(peaks, density, load, natural));
        let ([a, b, c], [d, e, f]) = (one, other);
        [density.to_string(), a, b, c, d, e, f]
    });
    Figure {
        label: "Charge sweep",
        title: "The peak over the charge density",
        caption: format!(
            "Shift of the peak of the amplitude from the natural frequency, its height, and the largest RMS voltage \
             over frequency, at two loads. {note}"
        ),
        panels: Vec::new(),
        table: crate::figures::table(headings, rows),
        csv: csv(
            LOADS
                .iter()
                .flat_map(|&load| CHARGES.iter().filter_map(move |&density| of(peaks, density, load))),
            natural,
        ),
    }
}

/// The peaks over the resistance.
pub(super) fn resistance_sweep(peaks: &[Peak], natural: f64, note: &str) -> Figure {
    let headings = ["load", "20 µC/m²: shift [Hz]", "[mm]", "[V]", "120 µC/m²: shift [Hz]", "[mm]", "[V]"];
    let rows = ROWS.iter().map(|&resistance| {
        let [one, other] = DENSITIES.map(|density| cells(peaks, density, resistance, natural));
        let ([a, b, c], [d, e, f]) = (one, other);
        [ohms(resistance), a, b, c, d, e, f]
    });
    Figure {
        label: "Resistance sweep",
        title: "The peak over the load resistance",
        caption: format!(
            "Shift of the peak of the amplitude from the natural frequency, its height, and the largest RMS voltage \
             over frequency, at a small and a large charge density. {note}"
        ),
        panels: Vec::new(),
        table: crate::figures::table(headings, rows),
        csv: csv(
            DENSITIES
                .iter()
                .flat_map(|&density| ROWS.iter().filter_map(move |&load| of(peaks, density, load))),
            natural,
        ),
    }
}

fn csv<'a>(peaks: impl Iterator<Item = &'a Peak>, natural: f64) -> String {
    let mut text = String::from(
        "charge_density_c_per_m2,load_resistance_ohm,peak_frequency_hz,peak_shift_hz,peak_amplitude_m,\
         max_rms_voltage_v\n",
    );
    for peak in peaks {
        let cells = [
            1e-6 * peak.case.charge_density,
            peak.case.resistance,
            peak.frequency_hz,
            peak.frequency_hz - natural,
            peak.amplitude_m,
            peak.rms_voltage_v,
        ];
        let _ = writeln!(text, "{}", cells.map(number).join(","));
    }
    text
}
