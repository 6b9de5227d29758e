//! The shipped scene at another charge density and load: its resonance, and figures 3 to 5, amplitude and RMS voltage over frequency.

use plotters::style::RGBColor;

use super::{DENSITIES, Figure, Panel, TOLERANCE, ohms};
use crate::embedded::resonance_peak;
use crate::method::{Failure, Options};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, VERMILION, range};
use crate::scene_file::{Load, Scene};
use crate::steady_state;
use crate::steady_state::Resonance;

/// Range of frequencies in Hz that contains all peaks, and number of frequencies of the scan. The range goes from 30 mHz
/// below the lowest peak to 20 mHz above the natural frequency of the shipped beam.
const AROUND_PEAKS: ([f64; 2], usize) = ([18.31, 18.40], 10);

/// The values that differ from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Case {
    /// Tribo-charge density in µC/m².
    pub charge_density: f64,
    /// Load resistance in Ω; 0 is a short circuit.
    pub resistance: f64,
}

/// The peak of the steady state over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Peak {
    pub case: Case,
    /// Frequency in Hz at which the amplitude is largest.
    pub frequency_hz: f64,
    /// That amplitude in m, half the distance of the extremes.
    pub amplitude_m: f64,
    /// Largest RMS voltage over frequency, in V.
    pub rms_voltage_v: f64,
}

impl Case {
    /// The steady states over `points` frequencies between two in Hz, and the peaks.
    pub(crate) fn resonance(
        &self,
        base: &Scene,
        range: [f64; 2],
        points: usize,
    ) -> Result<Resonance, Failure> {
        let load = Load::Resistor { resistance_ohm: self.resistance };
        let mut scene = Scene { load, ..base.clone() };
        scene.sliding_mut()?.parameters.charge_density_c_per_m2 = self.charge_density * 1e-6;
        let options = Options { tolerance: Some(TOLERANCE), ..Options::default() };
        let at = format!("{} uC/m^2, {} ohm", self.charge_density, self.resistance);
        let (found, _) =
            resonance_peak(&scene, range, points, &options).map_err(|failure| failure.of_case(&at))?;
        found.ok_or_else(|| {
            Failure::Step(format!("{at}: no stable orbit of one period from {} to {} Hz", range[0], range[1]))
        })
    }

    /// The peak of the steady state over frequency.
    pub(crate) fn peak(&self, base: &Scene) -> Result<Peak, Failure> {
        let (range, points) = AROUND_PEAKS;
        let found = self.resonance(base, range, points)?;
        // Without a voltage the place of the largest voltage has no meaning.
        let silent = found.rms_voltage.value == 0.0;
        if found.amplitude.at_edge || (found.rms_voltage.at_edge && !silent) {
            return Err(Failure::Step(format!(
                "{} uC/m^2, {} ohm: the peak is not between {} and {} Hz",
                self.charge_density, self.resistance, range[0], range[1]
            )));
        }
        Ok(Peak {
            case: *self,
            frequency_hz: found.amplitude.frequency_hz,
            amplitude_m: found.amplitude.value,
            rms_voltage_v: found.rms_voltage.value,
        })
    }
}

/// Charge densities of figure 3 in µC/m².
const FIGURE_THREE: [f64; 5] = [10.0, 20.0, 40.0, 80.0, 120.0];
/// Resistance of figure 3 in Ω.
const LOAD: f64 = 1e8;
/// Resistances of figures 4 and 5 in Ω.
pub(super) const RESISTANCES: [f64; 5] = [0.0, 1e7, 5e7, 1e8, 1e10];
/// Their colours, and those of the charge densities of figure 3.
pub(super) const COLOURS: [RGBColor; 5] = [BLACK, GREEN, BLUE, ORANGE, VERMILION];

/// Range of frequencies in Hz, and their number: they are 5 mHz apart, and the width at half power is 130 mHz.
const WIDE: ([f64; 2], usize) = ([18.0, 18.75], 151);
/// Ranges in Hz around the peaks of the small and the large charge density.
const NEAR: [[f64; 2]; 2] = [[18.355, 18.385], [18.32, 18.40]];
/// Number of frequencies in each of these ranges.
const NEAR_POINTS: usize = 41;
/// Size of a panel: two stand beside each other on the page.
const SIZE: (u32, u32) = (560, 430);

/// Steady states over frequency at one charge density and load.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Response {
    case: Case,
    /// Frequency in Hz, amplitude in m, RMS voltage in V, in rising order of frequency.
    points: Vec<[f64; 3]>,
}

/// The cases of figures 3 to 5, each once.
pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> =
        FIGURE_THREE.map(|charge_density| Case { charge_density, resistance: LOAD }).to_vec();
    for charge_density in DENSITIES {
        cases.extend(RESISTANCES.map(|resistance| Case { charge_density, resistance }));
    }
    let mut once: Vec<Case> = Vec::new();
    for case in cases {
        if !once.contains(&case) {
            once.push(case);
        }
    }
    once
}

impl Response {
    /// Over the wide range, with more points around the peaks.
    pub(super) fn of(base: &Scene, case: &Case) -> Result<Self, Failure> {
        let (wide, points) = WIDE;
        let mut found = case.resonance(base, wide, points)?.responses;
        for (density, near) in DENSITIES.iter().zip(NEAR) {
            if case.charge_density == *density {
                found.extend(case.resonance(base, near, NEAR_POINTS)?.responses);
            }
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        let point = |(frequency, response): (f64, Option<steady_state::Response>)| {
            response.map(|response| [frequency, response.amplitude_m, response.rms_voltage_v])
        };
        Ok(Self { case: *case, points: found.into_iter().filter_map(point).collect() })
    }
}

/// What a panel shows: the title of its ordinate, and the value at a point.
type Shown = (&'static str, fn(&[f64; 3]) -> f64);
const AMPLITUDE: Shown = ("amplitude of the tip [mm]", |[_, amplitude, _]| 1e3 * amplitude);
const VOLTAGE: Shown = ("RMS voltage [V]", |[.., voltage]| *voltage);

/// A panel over a range of frequencies; its ordinate begins at 0 unless it is a local view.
fn panel(
    name: &str,
    title: String,
    (ordinate, value): Shown,
    [span, local]: [Option<[f64; 2]>; 2],
    curves: &[(String, &Response)],
) -> Panel {
    let across = span.or(local).unwrap_or(WIDE.0);
    let named = curves.iter().map(|(name, response)| {
        (name.as_str(), response.points.iter().map(|point| (point[0], value(point))))
    });
    let curves = Curve::distinct(&COLOURS, (Mark::line, 1.6), named);
    let peaks = curves.iter().map(|curve| curve.points.iter().map(|point| point.1).fold(0.0, f64::max));
    let (low, high) = if local.is_some() { range(peaks) } else { (0.0, 1.04 * peaks.fold(0.0, f64::max)) };
    // The local view begins below the lowest peak, by half the distance of the peaks.
    let low = if local.is_some() { low - 0.5 * (high - low) } else { low };
    // A curve that is 0 throughout, as a voltage into 0 Ω, stands above the axis.
    let silent = curves.iter().any(|curve| curve.points.iter().all(|point| point.1 == 0.0));
    let low = if silent { -0.03 * high } else { low };
    let plot = Chart::new(
        title,
        Axis::linear("excitation frequency [Hz]", across, 7),
        Axis::linear(ordinate, [low, high], 8),
        curves,
    );
    Panel::new(name, SIZE, [plot])
}

pub(super) fn three(all: &[Response], [base, note]: [&str; 2]) -> Figure {
    let case = |charge_density| (f64::to_string(&charge_density), Case { charge_density, resistance: LOAD });
    let wanted = of(all, FIGURE_THREE.map(case));
    let load = ohms(LOAD);
    let drawn = |letter: char, shown| {
        let title = format!("Figure 3 ({letter}): charge density in µC/m², {load}, {base}");
        panel(&format!("figure-3{letter}"), title, shown, [Some(WIDE.0), None], &wanted)
    };
    Figure {
        label: "Figure 3",
        title: "Frequency responses of tip and voltage for five charge densities",
        caption: format!(
            "(a) Amplitude of the tip, half the distance of its extremes, and (b) RMS voltage, over the frequency of \
             the base, at a load of {load}. More charge presses the slider harder on the patch: friction takes \
             more, the amplitude falls and the peak moves a little to the left, while the voltage still \
             grows. {note}"
        ),
        panels: vec![drawn('a', AMPLITUDE), drawn('b', VOLTAGE)],
        table: Vec::new(),
        csv: numbers(wanted.iter().map(|(_, response)| *response)),
    }
}

fn of(all: &[Response], cases: [(String, Case); 5]) -> Vec<(String, &Response)> {
    let found = |(name, case)| Some((name, all.iter().find(|response| response.case == case)?));
    cases.into_iter().filter_map(found).collect()
}

/// Amplitude, local view of it, and voltage at one charge density.
fn at_density(
    all: &[Response],
    (number, which): (u32, usize),
    base: &str,
    [label, title]: [&'static str; 2],
    caption: String,
) -> Figure {
    let charge_density = DENSITIES[which];
    let wanted =
        of(all, RESISTANCES.map(|resistance| (ohms(resistance), Case { charge_density, resistance })));
    let drawn = |letter: char, what: &str, shown, spans| {
        let title = format!("Figure {number} ({letter}): {charge_density} µC/m², {base}, {what}");
        panel(&format!("figure-{number}{letter}"), title, shown, spans, &wanted)
    };
    Figure {
        label,
        title,
        caption,
        panels: vec![
            drawn('a', "amplitude", AMPLITUDE, [Some(WIDE.0), None]),
            drawn('b', "local view", AMPLITUDE, [None, Some(NEAR[which])]),
            drawn('c', "RMS voltage", VOLTAGE, [Some(WIDE.0), None]),
        ],
        table: Vec::new(),
        csv: numbers(wanted.iter().map(|(_, response)| *response)),
    }
}

pub(super) fn four(all: &[Response], [base, note]: [&str; 2]) -> Figure {
    let caption = format!(
        "At {} µC/m²: (a) amplitude of the tip, (b) its peaks again, larger, and (c) RMS voltage, which the \
         paper does not show here. The load does little to the motion: only around the peak does the amplitude \
         fall with growing resistance, by 2 %. {note}",
        DENSITIES[0]
    );
    let title = "Frequency responses for five load resistances, small charge density";
    at_density(all, (4, 0), base, ["Figure 4", title], caption)
}

pub(super) fn five(all: &[Response], [base, note]: [&str; 2]) -> Figure {
    let caption = format!(
        "At {} µC/m²: (a) amplitude of the tip, and beyond the paper (b) its peaks again, larger, and (c) RMS \
         voltage. With growing resistance the peak moves to the left and its amplitude falls a little; \
         with more it comes back to the right and falls further. {note}",
        DENSITIES[1]
    );
    let title = "Frequency responses for five load resistances, large charge density";
    at_density(all, (5, 1), base, ["Figure 5", title], caption)
}

fn numbers<'a>(responses: impl Iterator<Item = &'a Response>) -> String {
    let rows = responses.flat_map(|Response { case, points }| {
        points.iter().map(|&[frequency, amplitude, voltage]| {
            [1e-6 * case.charge_density, case.resistance, frequency, amplitude, voltage].map(number)
        })
    });
    csv("charge_density_c_per_m2,load_resistance_ohm,frequency_hz,amplitude_m,rms_voltage_v", rows)
}
