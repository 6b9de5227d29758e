//! Figures 8, 10 and 11: the largest gap over frequency, and the bifurcation diagram.

use plotters::style::RGBColor;

use super::motion::{Case, Grid, Response, WINDOW};
use super::{DIAGRAM_SETTLE, Figure, Panel, SETTLE, table, try_each_counted};
use crate::method::Failure;
use crate::outcome::{csv, number, optional_number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, ORANGE, VERMILION};
use crate::scene_file::Scene;

/// Charge densities of figure 8 in µC/m².
pub(crate) const CHARGE_DENSITIES: [f64; 4] = [5.0, 20.0, 35.0, 50.0];
/// Load resistances of figure 11 in MΩ; figure 8 has the first and the last.
pub(crate) const RESISTANCES: [f64; 3] = [1.0, 10.0, 100.0];

const COLOURS: [RGBColor; 4] = [BLACK, BLUE, ORANGE, VERMILION];
/// Marks for curves that may coincide: the first is the widest, so that all are visible.
const NESTED: [(RGBColor, Mark); 3] =
    [(ORANGE, Mark::line(0, 5.0)), (BLUE, Mark::line(0, 2.4)), (BLACK, Mark::line(1, 1.3))];

/// Size of a panel: two stand beside each other on the page.
const SIZE: (u32, u32) = (560, 430);

/// The largest gap over frequency at one charge density and load.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sweep {
    /// Tribo-charge density in µC/m².
    pub charge_density: f64,
    /// Load resistance in MΩ.
    pub resistance: f64,
    /// One for each frequency, in rising order.
    pub responses: Vec<Response>,
}

impl Sweep {
    /// Frequency in Hz, largest gap in mm.
    fn points(&self) -> Vec<(f64, f64)> {
        let point = |response: &Response| Some((response.frequency, 1e3 * response.found.peak_gap_m?));
        self.responses.iter().filter_map(point).collect()
    }

    /// The runs at both ends of the band, and that with the largest gap.
    pub(super) fn marked(&self) -> Vec<Case> {
        let gap = |response: &&Response| response.found.peak_gap_m.unwrap_or(0.0);
        let most = self.responses.iter().max_by(|one, other| gap(one).total_cmp(&gap(other)));
        let frequencies = self.band().into_iter().flatten().chain(most.map(|most| most.frequency));
        let &Self { charge_density, resistance, .. } = self;
        frequencies.map(|frequency| Case { charge_density, resistance, frequency, settle: SETTLE }).collect()
    }

    /// First and last frequency in Hz at which the mass hits the dielectric.
    pub(crate) fn band(&self) -> Option<[f64; 2]> {
        let mut hit = self.responses.iter().filter(|response| response.found.impacts > 0);
        let first = hit.next()?;
        Some([first.frequency, hit.next_back().unwrap_or(first).frequency])
    }
}

/// The charge densities and loads that both figures need.
pub(crate) fn pairs() -> Vec<(f64, f64)> {
    let all = RESISTANCES.into_iter().flat_map(|load| CHARGE_DENSITIES.map(|density| (density, load)));
    all.filter(|&(density, load)| in_eight(load) || in_eleven(density)).collect()
}

fn in_eight(resistance: f64) -> bool {
    [RESISTANCES[0], RESISTANCES[2]].contains(&resistance)
}

fn in_eleven(charge_density: f64) -> bool {
    [CHARGE_DENSITIES[0], CHARGE_DENSITIES[3]].contains(&charge_density)
}

/// Runs each pair at each frequency, on all cores.
pub(crate) fn sweeps(
    base: &Scene,
    pairs: &[(f64, f64)],
    grid: Grid,
    tolerance: f64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Sweep>, Failure> {
    let cases: Vec<Case> = pairs
        .iter()
        .flat_map(|&(charge_density, resistance)| {
            let case = move |frequency| Case { charge_density, resistance, frequency, settle: SETTLE };
            grid.frequencies().map(case)
        })
        .collect();
    let responses = try_each_counted(&cases, done, |case| case.response(base, tolerance))?;
    let parts = responses.chunks(grid.frequencies().count().max(1));
    let sweep = |(&(charge_density, resistance), responses): (&(f64, f64), &[Response])| Sweep {
        charge_density,
        resistance,
        responses: responses.to_vec(),
    };
    Ok(pairs.iter().zip(parts).map(sweep).collect())
}

pub(super) fn eight(sweeps: &[Sweep], grid: Grid, [base, start]: [&str; 2]) -> Figure {
    let wanted: Vec<&Sweep> = sweeps.iter().filter(|sweep| in_eight(sweep.resistance)).collect();
    let up = gap_axis(&wanted);
    let panel = |letter: char, resistance: f64| {
        let sweeps = wanted.iter().filter(|sweep| sweep.resistance == resistance);
        let named = sweeps.map(|sweep| (format!("{} µC/m²", sweep.charge_density), sweep.points()));
        let curves = Curve::distinct(&COLOURS, (Mark::line, 1.8), named);
        let curves = curves.into_iter().map(Curve::broken_at_jumps).collect();
        let title = format!("Figure 8 ({letter}): load {resistance} MΩ, {base}");
        let chart = Chart::new(title, frequency_axis(grid.span(), 9), up.clone(), curves);
        Panel::new(format!("figure-8{letter}"), SIZE, [chart])
    };
    Figure {
        label: "Figure 8",
        title: "Frequency responses of the gap for four charge densities",
        caption: format!(
            "Largest gap between mass and dielectric in {WINDOW} excitation periods, after {SETTLE}, over frequency, \
             for four tribo-charge densities, with (a) a small and (b) a large load resistance. More charge pulls \
             the mass towards the dielectric: the largest gap falls, and the band in which the mass hits the \
             dielectric moves to the left and, most of all with the large resistance, becomes wider. Ripples at \
             the left of a band are motions that do not repeat themselves; \
             at single frequencies there the mass does not hit the dielectric. A gap in a curve is a jump. {start}"
        ),
        table: bands(&wanted),
        panels: vec![panel('a', RESISTANCES[0]), panel('b', RESISTANCES[2])],
        csv: numbers(&wanted),
    }
}

pub(super) fn eleven(sweeps: &[Sweep], grid: Grid, [base, start]: [&str; 2]) -> Figure {
    let [few, .., many] = CHARGE_DENSITIES;
    let wanted: Vec<&Sweep> = sweeps.iter().filter(|sweep| in_eleven(sweep.charge_density)).collect();
    let up = gap_axis(&wanted);
    let panel = |letter: char, density: f64, title: String, span: [f64; 2], up: Axis| {
        let sweeps = wanted.iter().filter(|sweep| sweep.charge_density == density);
        let curves = sweeps.zip(NESTED).map(|(sweep, (colour, mark))| {
            Curve::new(format!("{} MΩ", sweep.resistance), colour, mark, sweep.points()).broken_at_jumps()
        });
        let chart = Chart::new(title, frequency_axis(span, 9), up, curves.collect());
        Panel::new(format!("figure-11{letter}"), SIZE, [chart])
    };
    let near = Axis::linear("largest gap [mm]", LOCAL[1], 8);
    Figure {
        label: "Figure 11",
        title: "Frequency responses of the gap for three load resistances",
        caption: format!(
            "Largest gap in {WINDOW} excitation periods, after {SETTLE}, over frequency, for three load resistances, \
             at (a) a small and (b) a large charge density, and (c) the upper part of (b) again, larger. At the \
             small charge density the load does nothing to the motion: the curves, drawn with different widths, \
             lie on each other. At the large one impacts begin at a lower frequency as the resistance grows, and \
             the band is a little wider. A gap in a curve is a jump. {start}"
        ),
        table: bands(&wanted),
        panels: vec![
            panel('a', few, format!("Figure 11 (a): {few} µC/m², {base}"), grid.span(), up.clone()),
            panel('b', many, format!("Figure 11 (b): {many} µC/m², {base}"), grid.span(), up),
            panel('c', many, format!("Figure 11 (c): {many} µC/m², {base}, local view"), LOCAL[0], near),
        ],
        csv: numbers(&wanted),
    }
}

/// The local view: frequencies in Hz, gaps in mm.
const LOCAL: [[f64; 2]; 2] = [[18.6, 20.4], [4.6, 5.6]];

/// First and last frequency with impacts of each sweep.
fn bands(sweeps: &[&Sweep]) -> Vec<Vec<String>> {
    let rows = sweeps.iter().map(|sweep| {
        let band = sweep.band().map(|band| band.map(|frequency| format!("{frequency:.2}")));
        let [from, to] = band.unwrap_or_else(|| ["-".to_owned(), "-".to_owned()]);
        let gap = sweep.points().iter().map(|point| point.1).fold(0.0, f64::max);
        [sweep.charge_density.to_string(), sweep.resistance.to_string(), from, to, format!("{gap:.3}")]
    });
    let headings =
        ["charge density [µC/m²]", "load [MΩ]", "impacts from [Hz]", "to [Hz]", "largest gap [mm]"];
    table(headings, rows)
}

pub(super) fn frequency_axis(span: [f64; 2], ticks: usize) -> Axis {
    Axis::linear("excitation frequency [Hz]", span, ticks)
}

/// An axis in whole half millimetres that contains all gaps, the same for all panels of a figure.
fn gap_axis(sweeps: &[&Sweep]) -> Axis {
    let gaps = sweeps.iter().flat_map(|sweep| sweep.points()).map(|point| point.1);
    let (low, high) = gaps.fold((f64::INFINITY, 0.0_f64), |(low, high), gap| (low.min(gap), high.max(gap)));
    let low = if low.is_finite() { low } else { 0.0 };
    let span = [(2.0 * low).floor() / 2.0, ((2.0 * high).ceil() / 2.0).max(0.5)];
    Axis::linear("largest gap [mm]", span, 8)
}

fn numbers(sweeps: &[&Sweep]) -> String {
    let rows = sweeps.iter().flat_map(|sweep| {
        sweep.responses.iter().map(|Response { frequency, found, rms_voltage_v, mean_power_w }| {
            [
                number(sweep.resistance * 1e6),
                number(sweep.charge_density / 1e6),
                number(*frequency),
                optional_number(found.peak_gap_m),
                optional_number(found.min_gap_m),
                found.impacts.to_string(),
                optional_number(found.impacts_per_period),
                optional_number(*rms_voltage_v),
                optional_number(*mean_power_w),
            ]
        })
    });
    csv(
        "load_resistance_ohm,charge_density_c_per_m2,frequency_hz,peak_gap_m,min_gap_m,impacts,\
         impacts_per_period,rms_voltage_v,mean_power_w",
        rows,
    )
}

const DIAGRAM_SIZE: (u32, u32) = (900, 520);

/// The gap in m at the start of each period of the measuring window, for each frequency.
pub(crate) fn diagram(
    base: &Scene,
    [charge_density, resistance]: [f64; 2],
    grid: Grid,
    tolerance: f64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<(f64, Vec<f64>)>, Failure> {
    let frequencies: Vec<f64> = grid.frequencies().collect();
    try_each_counted(&frequencies, done, |&frequency| {
        let case = Case { charge_density, resistance, frequency, settle: DIAGRAM_SETTLE };
        Ok((frequency, case.stroboscopic(base, tolerance)?))
    })
}

/// Figure 10 from the diagram.
pub(super) fn ten(
    diagram: &[(f64, Vec<f64>)],
    [charge_density, resistance]: [f64; 2],
    grid: Grid,
    [base, start]: [&str; 2],
) -> Figure {
    let all = || diagram.iter().flat_map(|(frequency, gaps)| gaps.iter().map(|gap| (*frequency, 1e3 * gap)));
    let (low, high) =
        all().fold((f64::INFINITY, 0.0_f64), |(low, high), (_, gap)| (low.min(gap), high.max(gap)));
    let low = if low.is_finite() { low } else { 0.0 };
    let plot = Chart::new(
        format!("Figure 10: {charge_density} µC/m², {resistance} MΩ, {base}"),
        frequency_axis(grid.span(), 11),
        Axis::linear(
            "gap at the start of each period [mm]",
            [(10.0 * low - 0.5).floor() / 10.0, (10.0 * high + 0.5).ceil() / 10.0],
            9,
        ),
        vec![Curve::new("", BLUE, Mark::point(0, 2.0), all())],
    );
    Figure {
        label: "Figure 10",
        title: "Bifurcation diagram of the position of the mass",
        caption: format!(
            "Gap at the start of each of {WINDOW} excitation periods, where the base acceleration rises through 0, \
             over frequency. One dot: the motion repeats itself in every period; a few dots: in so many periods; \
             a column of scattered dots: not at all. The motion is periodic up to the first impact, hardly \
             ever repeats itself for half a hertz above it, and then has one impact in every period, here and \
             there beside a motion of three periods, until impacts end. The dots come after {DIAGRAM_SETTLE} \
             periods: just below the first impact, what is left of the start fades slowly. {start}"
        ),
        panels: vec![Panel::new("figure-10", DIAGRAM_SIZE, [plot])],
        table: Vec::new(),
        csv: csv(
            "frequency_hz,period,gap_m",
            diagram.iter().flat_map(|(frequency, gaps)| {
                let row = |(period, gap): (u32, &f64)| [number(*frequency), period.to_string(), number(*gap)];
                (DIAGRAM_SETTLE..).zip(gaps).map(row)
            }),
        ),
    }
}
