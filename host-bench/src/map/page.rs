//! A map as a page: each slice as a chart with zoom, the yield and the regime of each cell at the pointer, and the places that
//! check it.

use std::fmt::Write;

use model_core::energy::Response;
use model_core::energy::response_map::Branch;
use plotters::style::RGBColor;

use super::axes::amplitude_of;
use super::{Judged, Map};
use crate::method::Failure;
use crate::report::charts::{Charts, HINT, Look};
use crate::report::field::{Field, Told};
use crate::report::html::{document, escaped};
use crate::report::plot::{Axis, Curve, Mark, Plot};
use crate::report::setting::{prefix, with_unit};
use crate::report::svg::{BLACK, VERMILION, extremes};

/// Cells over frequency and over amplitude.
const CELLS: [usize; 2] = [128, 64];
const LOOK: Look<'_> = Look { height: 560, group: None };
/// Light enough on the darkest cells, and seen on the page.
const LIGHT: RGBColor = RGBColor(216, 222, 228);
/// What the map tells of a cell.
const REGIMES: [&str; 4] = [
    "one motion, the lower one",
    "one motion, the upper one",
    "two motions: the lower one, bounds of both",
    "outside",
];

/// The page; `title` is plain text.
pub fn page(map: &Map, title: &str) -> Result<String, Failure> {
    let mut charts = Charts::default();
    let mut body = format!("<h1>Response map of {}</h1>\n{HINT}", escaped(title));
    let told = map.image.map()?;
    let quantity = if told.is_current() { ("charge per second", "A") } else { ("mean power", "W") };
    for slice in 0..map.slices.len() {
        let (field, [x, y]) = field(map, slice, quantity)?;
        let curves = [boundaries(map, slice), places(map, slice)].concat();
        let title = if told.is_current() {
            format!("storage at {:.3} V", told.voltage(slice))
        } else {
            String::new()
        };
        let plot = Plot {
            title,
            across: Axis::linear("frequency [Hz]", x, 8),
            up: Axis::logarithmic("amplitude [m/s²]", y),
            curves,
        };
        body += &charts.place_field(&plot, &field, LOOK);
    }
    let _ = writeln!(
        body,
        "<p class=\"note\">The abscissa is even in the detuning: the distance from {:.4} Hz in half-bandwidths of {:.4} Hz, \
         compressed far from it. What is white has no yield, or the map has none.</p>",
        map.axes.centre_hz, map.axes.half_bandwidth_hz
    );
    body += &charts.scripts();
    Ok(document(title, &body))
}

/// The cells of a slice, and the spans of both axes.
fn field(map: &Map, slice: usize, (name, unit): (&str, &str)) -> Result<(Field, [[f64; 2]; 2]), Failure> {
    let told = map.image.map()?;
    let axes = &map.axes;
    let [low, high] = axes.amplitudes.map(f64::ln);
    let [across, up] = CELLS;
    let part = |index: usize, count: usize| index as f64 / count as f64;
    let amplitude = |part: f64| (low + (high - low) * part).exp();
    let parts: Vec<f64> = (0..=across).map(|index| part(index, across)).collect();
    let frequencies: Vec<f64> =
        (0..across).map(|index| axes.frequency(part(2 * index + 1, 2 * across))).collect();
    let amplitudes: Vec<f64> = (0..up).map(|index| amplitude(part(2 * index + 1, 2 * up))).collect();
    let cells: Vec<Response> = (0..across * up)
        .map(|index| {
            let place = [amplitudes[index / across], frequencies[index % across]];
            let [amplitude, frequency] = place.map(|number| number as f32);
            told.in_slice_at(slice, amplitude, frequency)
        })
        .collect();
    let of = |number: usize| {
        let numbers = cells.iter().map(move |cell| {
            let income = cell.income()?;
            Some(f64::from([income.value, income.low, income.high][number]))
        });
        numbers.collect::<Vec<Option<f64>>>()
    };
    let [value, lowest, highest] = [0, 1, 2].map(of);
    let values: Vec<Option<f64>> =
        value.iter().map(|value| value.filter(|value| *value > 0.0).map(f64::log10)).collect();
    let (least, most) = extremes(values.iter().flatten().copied());
    let ends = if least <= most { [least, most] } else { [0.0; 2] };
    let (sign, factor) = prefix(10f64.powf(ends[1]));
    let scaled = |values: Vec<Option<f64>>| {
        values.into_iter().map(|value| value.map(|value| factor * value)).collect()
    };
    let title = |of: &str| format!("{of} [{sign}{unit}]");
    let regimes = cells.iter().map(|cell| match cell {
        Response::One { branch: Branch::Lower, .. } => 0,
        Response::One { branch: Branch::Upper, .. } => 1,
        Response::Two { .. } => 2,
        Response::Outside(_) => 3,
    });
    let detuning = frequencies.iter().map(|frequency| (frequency - axes.centre_hz) / axes.half_bandwidth_hz);
    let tells = vec![
        Told::Column("frequency [Hz]".to_owned(), frequencies.clone()),
        Told::Column("detuning [half-bandwidths]".to_owned(), detuning.collect()),
        Told::Row("amplitude [m/s²]".to_owned(), amplitudes.clone()),
        Told::Cell(title(name), scaled(value)),
        Told::Cell(title("at least"), scaled(lowest)),
        Told::Cell(title("at most"), scaled(highest)),
        Told::Text(&REGIMES, regimes.collect()),
    ];
    let field = Field {
        numbers: Some(parts.iter().map(|part| axes.frequency(*part)).collect()),
        edges: [parts, (0..=up).map(|index| amplitude(part(index, up))).collect()],
        values,
        ends,
        words: ends.map(|end| with_unit(10f64.powf(end), unit)),
        tells,
    };
    Ok((field, [[0.0, 1.0], axes.amplitudes]))
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
        Curve::new(name, LIGHT, mark, points.collect::<Vec<(f64, f64)>>())
    };
    let [rising, falling] = [|column: &super::Column| column.rising, |column: &super::Column| column.falling]
        .map(|of| columns.iter().map(of).collect::<Vec<f64>>());
    vec![
        curve("the lower motion ends as the amplitude rises", Mark::Line(2.0), rising),
        curve("the upper motion ends as the amplitude falls", Mark::Dashes(2.0), falling),
    ]
}

/// The random places that check the map, with what the full model has there.
fn places(map: &Map, slice: usize) -> Vec<Curve> {
    let curve = |name: &str, colour: RGBColor, holds: bool| {
        let of_slice =
            map.checked.iter().filter(|judged| judged.place.slice == slice && judged.holds == holds);
        let (points, notes): (Vec<(f64, f64)>, Vec<String>) =
            of_slice.map(|judged| (at(map, judged), note(judged))).unzip();
        (!points.is_empty()).then(|| Curve::new(name, colour, Mark::Dots(5.0), points).with_notes(notes))
    };
    let holds = curve("checked: the bounds hold", BLACK, true);
    holds.into_iter().chain(curve("checked: the bounds do not hold", VERMILION, false)).collect()
}

fn at(map: &Map, judged: &Judged) -> (f64, f64) {
    let (below, part) = map.axes.column(judged.place.frequency_hz);
    ((below as f64 + part) / (map.axes.frequencies.len() - 1) as f64, judged.place.amplitude)
}

/// What the full model has at a place beside what the map tells.
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
