//! The picture of a map: each slice with values and boundaries, power and regime of each cell at the pointer, and the places that check it.

use model_core::energy::Response;
use model_core::energy::response_map::Branch;
use plotters::style::RGBColor;

use super::axes::amplitude_of;
use super::{Column, Judged, Map};
use crate::method::Failure;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark, Readout};
use crate::report::setting::prefix;
use crate::report::svg::{BLACK, VERMILION};

/// Cells over frequency and over amplitude.
const CELLS: [usize; 2] = [128, 64];
/// Cells over amplitude of which [`best`] is the largest.
const ROWS: usize = 48;
/// Which motions the map has in a cell.
const REGIMES: [&str; 4] = [
    "one motion, the lower one",
    "one motion, the upper one",
    "two motions: the lower one, bounds of both",
    "outside",
];

/// All slices on a page, the first in an SVG; `title` is plain text.
pub(crate) fn picture(map: &Map, title: &str) -> Result<Picture, Failure> {
    let charts = (0..map.slices.len()).map(|slice| chart(map, slice)).collect::<Result<_, _>>()?;
    Ok(Picture { title: format!("Response map of {title}"), width: 900, charts, ..Picture::default() })
}

/// The picture as SVG, and as a page.
pub fn drawn(map: &Map, title: &str) -> Result<[String; 2], Failure> {
    let picture = picture(map, title)?;
    Ok([picture.svg()?, picture.page()?])
}

fn chart(map: &Map, slice: usize) -> Result<Chart, Failure> {
    let (lookup, axes) = (map.image.map()?, &map.axes);
    let (name, unit) = if lookup.is_current() { ("charge per second", "A") } else { ("mean power", "W") };
    let [low, high] = axes.amplitudes.map(f64::ln);
    let [across, up] = CELLS;
    let middle = |index: usize, count: usize| (2 * index + 1) as f64 / (2 * count) as f64;
    let parts: Vec<f64> = (0..across).map(|index| middle(index, across)).collect();
    let frequencies: Vec<f64> = parts.iter().map(|part| axes.frequency(*part)).collect();
    let amplitudes: Vec<f64> = (0..up).map(|index| (low + (high - low) * middle(index, up)).exp()).collect();
    let at = |index: usize| [amplitudes[index / across], frequencies[index % across]].map(|at| at as f32);
    let cells: Vec<Response> = (0..across * up)
        .map(at)
        .map(|[amplitude, frequency]| lookup.in_slice_at(slice, amplitude, frequency))
        .collect();
    let largest = cells.iter().filter_map(|cell| Some(f64::from(cell.income()?.value))).fold(0.0, f64::max);
    let (sign, factor) = prefix(largest);
    let of = |number: usize| -> Vec<Option<f64>> {
        let numbers = cells.iter().map(move |cell| {
            let income = cell.income()?;
            Some(factor * f64::from([income.value, income.low, income.high][number]))
        });
        numbers.collect()
    };
    let [value, lowest, highest] = [0, 1, 2].map(of);
    let title = |of: &str| format!("{of} [{sign}{unit}]");
    let coloured = value.iter().map(|value| value.filter(|value| *value > 0.0)).collect();
    let numbers = (0..=across).map(|index| axes.frequency(index as f64 / across as f64)).collect();
    let place = [Axis::of_numbers("frequency [Hz]", numbers), Axis::logarithmic("amplitude [m/s²]", FITTING)];
    let scale = Axis::logarithmic(title(name), FITTING);
    let mut chart = Chart::map(place, [parts, amplitudes], scale, coloured);
    if let Some(field) = &mut chart.field {
        let detuning =
            frequencies.iter().map(|frequency| (frequency - axes.centre_hz) / axes.half_bandwidth_hz);
        let detuning = Readout::Column("detuning [half-bandwidths]".to_owned(), detuning.collect());
        field.readouts.splice(0..1, [Readout::Column("frequency [Hz]".to_owned(), frequencies), detuning]);
        field.readouts.pop();
        field.readouts.extend([
            Readout::Cell(title(name), value),
            Readout::Cell(title("at least"), lowest),
            Readout::Cell(title("at most"), highest),
            Readout::Text(&REGIMES, cells.iter().map(regime).collect()),
        ]);
    }
    if lookup.is_current() {
        chart.title = format!("storage at {:.2} V", lookup.voltage(slice));
    }
    chart.curves = [boundaries(map, slice), places(map, slice)].concat();
    chart.note = format!(
        "The abscissa is even in the detuning: the distance from {:.4} Hz in half-bandwidths of {:.4} Hz, compressed \
         far from it. White: no output power, or none in the map.",
        axes.centre_hz, axes.half_bandwidth_hz
    );
    chart.is_of_page = slice > 0;
    Ok(chart)
}

/// The index of the motions of a cell in [`REGIMES`].
fn regime(cell: &Response) -> usize {
    match cell {
        Response::One { branch: Branch::Lower, .. } => 0,
        Response::One { branch: Branch::Upper, .. } => 1,
        Response::Two { .. } => 2,
        Response::Outside(_) => 3,
    }
}

/// The largest income of the map on cells: slice, frequency in Hz, amplitude in m/s², and the income.
pub(crate) fn best(map: &Map) -> Result<Option<(usize, f64, f64, f64)>, Failure> {
    let lookup = map.image.map()?;
    let [low, high] = map.axes.amplitudes.map(f64::log10);
    let (across, up) = (CELLS[0], ROWS);
    let part = |index: usize, count: usize| index as f64 / (count - 1) as f64;
    let cells = (0..map.slices.len() * across * up).filter_map(|index| {
        let (slice, cell) = (index / (across * up), index % (across * up));
        let frequency = map.axes.frequency(part(cell % across, across));
        let amplitude = 10f64.powf(low + (high - low) * part(cell / across, up));
        let income = lookup.in_slice_at(slice, amplitude as f32, frequency as f32).income()?;
        Some((slice, frequency, amplitude, f64::from(income.value)))
    });
    Ok(cells.max_by(|one, other| one.3.total_cmp(&other.3)))
}

/// The amplitudes at which the motions end when the amplitude rises and when it falls.
fn boundaries(map: &Map, slice: usize) -> Vec<Curve> {
    let columns = &map.slices[slice];
    if !columns.iter().any(|column| column.found) {
        return Vec::new();
    }
    let [low, high] = map.axes.amplitudes;
    let last = (columns.len() - 1) as f64;
    let curve = |name: &str, mark: Mark, levels: Vec<f64>| {
        let points = levels.into_iter().enumerate();
        let points = points.map(|(index, level)| (index as f64 / last, amplitude_of(level).clamp(low, high)));
        Curve::new(name, BLACK, mark, points.collect::<Vec<(f64, f64)>>())
    };
    let [rising, falling] = [|column: &Column| column.rising, |column: &Column| column.falling]
        .map(|of| columns.iter().map(of).collect::<Vec<f64>>());
    vec![
        curve("the lower motion ends as the amplitude rises", Mark::line(0, 2.0), rising),
        curve("the upper motion ends as the amplitude falls", Mark::line(1, 2.0), falling),
    ]
}

/// The random places that check the map, hidden at first, with what the full model has there.
fn places(map: &Map, slice: usize) -> Vec<Curve> {
    let curve = |name: &str, colour: RGBColor, mark: Mark, holds: bool| {
        let of_slice =
            map.checked.iter().filter(|judged| judged.place.slice == slice && judged.holds == holds);
        let noted = of_slice.map(|judged| (at(map, judged), note(judged)));
        Curve::noted(name, colour, mark, noted).map(|curve| Curve { is_hidden: true, ..curve })
    };
    let holds = curve("checked: the bounds hold", BLACK, Mark::point(0, 5.0), true);
    let fails = curve("checked: the bounds do not hold", VERMILION, Mark::point(1, 9.0), false);
    holds.into_iter().chain(fails).collect()
}

fn at(map: &Map, judged: &Judged) -> (f64, f64) {
    let (below, part) = map.axes.column(judged.place.frequency_hz);
    ((below as f64 + part) / (map.axes.frequencies.len() - 1) as f64, judged.place.amplitude)
}

/// What the full model has at an operating point beside the values of the map.
fn note(judged: &Judged) -> String {
    let motion = |name: &str, truth: Option<f64>, error: Option<f64>| {
        let truth = truth?;
        let error =
            error.map_or_else(String::new, |error| format!(", the map is {:.2} % off", 100.0 * error));
        Some(format!("full model, {name} motion: {truth:.4e}{error}"))
    };
    let [lower, upper] = judged.errors;
    let lines = [motion("lower", judged.truth.lower, lower), motion("upper", judged.truth.upper, upper)];
    let lines: Vec<String> = lines.into_iter().flatten().collect();
    lines.join("\n")
}
