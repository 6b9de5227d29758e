//! Figure 10: the bifurcation diagram.

use super::motion::{Case, Grid, WINDOW};
use super::response::frequency_axis;
use super::{DIAGRAM_SETTLE, Figure, Panel, each};
use crate::method::Failure;
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::BLUE;
use crate::scene_file::Scene;

const SIZE: (u32, u32) = (900, 520);

/// The gap in m at the start of each period of the measuring window, for each frequency.
pub(crate) fn diagram(
    base: &Scene,
    [charge_density, resistance]: [f64; 2],
    grid: Grid,
    tolerance: f64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<(f64, Vec<f64>)>, Failure> {
    let frequencies: Vec<f64> = grid.frequencies().collect();
    each(&frequencies, done, |&frequency| {
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
        vec![Curve::new("", BLUE, Mark::Dots(2.0), all())],
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
        panels: vec![Panel::new("figure-10", SIZE, [plot])],
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
