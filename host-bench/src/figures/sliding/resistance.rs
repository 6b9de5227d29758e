//! Figure 6: the peak over the load resistance, and both sweeps as tables.

use super::resonance::{COLOURS, RESISTANCES};
use super::{Case, DENSITIES, Figure, Panel, Peak, ohms};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
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

pub(super) fn six(peaks: &[Peak], natural: f64, [base, note]: [&str; 2]) -> Figure {
    let shift = |peak: &Peak| 1e3 * (peak.frequency_hz - natural);
    let amplitude = |peak: &Peak| 1e3 * peak.amplitude_m;
    Figure {
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
            looping(&along(peaks, DENSITIES[1]), base, shift, amplitude),
            over_resistance(('b', base), "shift of the peak [mHz]", peaks, shift),
            over_resistance(('c', base), "amplitude of the peak [mm]", peaks, amplitude),
            rise(peaks, base),
        ],
        table: Vec::new(),
        csv: numbers(DENSITIES.iter().flat_map(|&density| along(peaks, density)), natural),
    }
}

/// The curve that the peak runs along, with the resistances of figures 4 and 5 marked.
fn looping(
    peaks: &[&Peak],
    base: &str,
    shift: impl Fn(&Peak) -> f64,
    amplitude: impl Fn(&Peak) -> f64,
) -> Panel {
    let place = |peak: &&Peak| (shift(peak), amplitude(peak));
    let line = Curve::new("", BLUE, Mark::line(0, 1.2), peaks.iter().map(place));
    let marked = RESISTANCES.map(|resistance| {
        let there = peaks.iter().filter(move |peak| peak.case.resistance == resistance);
        (ohms(resistance), there.map(place))
    });
    let marks = Curve::distinct(&COLOURS, (Mark::point, 9.0), marked);
    let (left, right) = range(line.points.iter().map(|point| point.0));
    let plot = Chart::new(
        format!("Figure 6 (a): {} µC/m², {base}, loads from 0 Ω to {}", DENSITIES[1], ohms(SPAN[1])),
        Axis::linear("shift of the peak from the natural frequency [mHz]", [left, right], 6),
        Axis::linear("amplitude of the peak [mm]", FITTING, 8),
        std::iter::once(line).chain(marks).collect(),
    );
    Panel::new("figure-6a", SIZE, [plot])
}

/// A value at each resistance above 0.
fn above_short(peaks: &[Peak], density: f64, name: &str, value: impl Fn(&Peak) -> f64) -> Curve {
    let above = along(peaks, density).into_iter().filter(|peak| peak.case.resistance > 0.0);
    let colour = if density < DENSITIES[1] { BLUE } else { VERMILION };
    let points = above.map(|peak| (peak.case.resistance, value(peak)));
    Curve::new(name, colour, Mark::dotted(0, [1.6, 4.5]), points)
}

/// The dashed line of a value at all resistances.
fn level(value: f64) -> Curve {
    Curve::new("", BLACK, Mark::line(1, 1.0), SPAN.map(|resistance| (resistance, value)))
}

/// Both charge densities, one above the other.
fn over_resistance(
    (letter, base): (char, &str),
    title: &'static str,
    peaks: &[Peak],
    value: impl Fn(&Peak) -> f64,
) -> Panel {
    let plots = DENSITIES.into_iter().filter_map(|density| {
        let curves = vec![level(value(of(peaks, density, 0.0)?)), above_short(peaks, density, "", &value)];
        Some(Chart::new(
            format!("Figure 6 ({letter}): {density} µC/m², {base}"),
            Axis::logarithmic("load resistance [Ω]", SPAN),
            Axis::linear(title, FITTING, 6),
            curves,
        ))
    });
    Panel::new(format!("figure-6{letter}"), TALL, plots)
}

/// The rise of the amplitude before its fall, in parts of the amplitude of the short circuit.
fn rise(peaks: &[Peak], base: &str) -> Panel {
    let curves = DENSITIES.into_iter().filter_map(|density| {
        let shorted = of(peaks, density, 0.0)?.amplitude_m;
        let value = |peak: &Peak| 1e2 * (peak.amplitude_m / shorted - 1.0);
        Some(above_short(peaks, density, &format!("{density} µC/m²"), value))
    });
    let plot = Chart::new(
        format!("Figure 6 (d): the rise of the amplitude, {base}"),
        Axis::logarithmic("load resistance [Ω]", [SPAN[0], 1e8]),
        Axis::linear("amplitude against 0 Ω [%]", [-0.04, 0.04], 8),
        curves.chain([level(0.0)]).collect(),
    );
    Panel::new("figure-6d", SIZE, [plot])
}

/// Shift in Hz, amplitude in mm, RMS voltage in V, as they are printed.
fn cells(peaks: &[Peak], (charge_density, resistance): (f64, f64), natural: f64) -> [String; 3] {
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
    let cases = LOADS.map(|load| CHARGES.map(|density| (density, load)));
    Figure {
        label: "Charge sweep",
        title: "The peak over the charge density",
        ..sweep(peaks, natural, headings, &cases, |(density, _)| density.to_string(), ("at two loads", note))
    }
}

pub(super) fn resistance_sweep(peaks: &[Peak], natural: f64, note: &str) -> Figure {
    let headings = ["load", "20 µC/m²: shift [Hz]", "[mm]", "[V]", "120 µC/m²: shift [Hz]", "[mm]", "[V]"];
    let cases = DENSITIES.map(|density| ROWS.map(|load| (density, load)));
    let at = "at a small and a large charge density";
    Figure {
        label: "Resistance sweep",
        title: "The peak over the load resistance",
        ..sweep(peaks, natural, headings, &cases, |(_, load)| ohms(load), (at, note))
    }
}

/// A table with both columns of `cases` beside each other; each case is a charge density and a resistance.
fn sweep<const N: usize>(
    peaks: &[Peak],
    natural: f64,
    headings: [&str; 7],
    cases: &[[(f64, f64); N]; 2],
    name: impl Fn((f64, f64)) -> String,
    (at, note): (&str, &str),
) -> Figure {
    let [one, other] = cases;
    let rows = one.iter().zip(other).map(|(&one, &other)| {
        let [[a, b, c], [d, e, f]] = [one, other].map(|case| cells(peaks, case, natural));
        [name(one), a, b, c, d, e, f]
    });
    let found = cases.iter().flatten().filter_map(|&(density, resistance)| of(peaks, density, resistance));
    Figure {
        label: "",
        title: "",
        caption: format!(
            "Shift of the peak of the amplitude from the natural frequency, its height, and the largest RMS voltage \
             over frequency, {at}. {note}"
        ),
        panels: Vec::new(),
        table: crate::figures::table(headings, rows),
        csv: numbers(found, natural),
    }
}

fn numbers<'a>(peaks: impl Iterator<Item = &'a Peak>, natural: f64) -> String {
    let row = |peak: &Peak| {
        [
            1e-6 * peak.case.charge_density,
            peak.case.resistance,
            peak.frequency_hz,
            peak.frequency_hz - natural,
            peak.amplitude_m,
            peak.rms_voltage_v,
        ]
        .map(number)
    };
    csv(
        "charge_density_c_per_m2,load_resistance_ohm,peak_frequency_hz,peak_shift_hz,peak_amplitude_m,\
         max_rms_voltage_v",
        peaks.map(row),
    )
}
