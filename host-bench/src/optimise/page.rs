//! The page of an optimum: its curve or its map with zoom and hover, and the way of the search.

use super::picture::{grid_cells, value_beyond};
use super::{Found, Point, Range, Request};
use crate::report::charts::{Charts, HINT, Look};
use crate::report::field::{Field, Told};
use crate::report::html::{document, escaped};
use crate::report::label::label;
use crate::report::plot::{Axis, Curve, Mark, Plot, height};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION, extremes, tick};

const MAP: Look<'_> = Look { height: 560, group: None };
const HISTORY: Look<'_> = Look { height: 320, group: None };

/// The page; `title` is plain text.
pub(crate) fn page(found: &Found, request: &Request<'_>, title: &str) -> Result<String, String> {
    let mut charts = Charts::default();
    let mut body = format!("<h1>{}</h1>\n{HINT}", escaped(title));
    match &request.ranges[..] {
        [only] => body += &charts.place(&curve(found, request, only), Look::ALONE),
        [up, across, ..] => {
            let (plot, field) = map(found, request, [up, across]);
            body += &charts.place_field(&plot, &field, MAP);
            if field.values.iter().any(Option::is_none) {
                body += "<p class=\"note\">White: no point of the grid has a value there and keeps the constraints.</p>\n";
            }
            if request.ranges.len() > 2 {
                body +=
                    "<p class=\"note\">Each cell has the best value of the grid over the other keys.</p>\n";
            }
        }
        [] => {}
    }
    body += &charts.place(&history(found, request), HISTORY);
    body += &charts.scripts();
    Ok(document(title, &body))
}

/// What the pointer tells of a point besides its place: its value, that of each key, and which constraint it breaks.
fn note(request: &Request<'_>, point: &Point) -> String {
    let value =
        point.value().map_or_else(|| "the run failed".to_owned(), |value| tick(request.signed(value)));
    let mut lines = vec![format!("value: {value}")];
    lines
        .extend(Found::values(request, point).into_iter().map(|(key, value)| format!("{key} = {value:.6e}")));
    if let Some((_, margins)) = &point.found {
        let broken = request.constraints.iter().zip(margins).filter(|(_, margin)| **margin < 0.0);
        lines.extend(broken.map(|(constraint, _)| format!("breaks {}", constraint.text())));
    }
    lines.join("\n")
}

/// Points with their values in a colour; nothing where there are none.
fn dots<'a>(
    request: &Request<'_>,
    (name, colour, size): (&str, plotters::style::RGBColor, f64),
    points: impl Iterator<Item = (&'a Point, (f64, f64))>,
) -> Option<Curve> {
    let (places, notes): (Vec<(f64, f64)>, Vec<String>) =
        points.map(|(point, place)| (place, note(request, point))).unzip();
    (!places.is_empty()).then(|| Curve::new(name, colour, Mark::Dots(size), places).with_notes(notes))
}

/// The value over the only key.
fn curve(found: &Found, request: &Request<'_>, key: &Range) -> Plot {
    let place = |point: &Point| Some((key.value(point.place[0]), request.signed(point.value()?)));
    let mut points: Vec<(&Point, (f64, f64))> =
        found.points.iter().filter_map(|point| Some((point, place(point)?))).collect();
    points.sort_by(|one, other| one.1.0.total_cmp(&other.1.0));
    let line =
        Curve::new("", BLUE, Mark::Line(1.2), points.iter().map(|(_, place)| *place)).broken_at_jumps();
    let kept = |is_kept: bool| {
        points.iter().filter(move |(point, _)| point.feasible().is_some() == is_kept).copied()
    };
    let best = place(&found.best).map(|place| (&found.best, place));
    let curves: Vec<Curve> = [
        Some(line),
        dots(request, ("runs", BLUE, 6.0), kept(true)),
        dots(request, ("runs that break a constraint", BLACK, 5.0), kept(false)),
        dots(request, ("the best point", VERMILION, 10.0), best.into_iter()),
    ]
    .into_iter()
    .flatten()
    .collect();
    let span = [key.low, key.high];
    Plot {
        title: String::new(),
        across: axis(key, span),
        up: Axis::linear(request.quantity.as_str(), height(&curves), 7),
        curves,
    }
}

fn axis(key: &Range, span: [f64; 2]) -> Axis {
    if key.is_logarithmic {
        Axis::logarithmic(label(&key.key), span)
    } else {
        Axis::linear(label(&key.key), span, 8)
    }
}

/// The grid over two keys with all runs.
fn map(found: &Found, request: &Request<'_>, keys: [&Range; 2]) -> (Plot, Field) {
    let [up, across] = keys;
    let values = grid_cells(found, request);
    let (least, most) = extremes(values.iter().flatten().copied());
    let ends = if least <= most { [least, most] } else { [0.0; 2] };
    let last = (request.grid - 1) as f64;
    let edges = |key: &Range| -> Vec<f64> {
        (0..=request.grid).map(|index| value_beyond(key, (index as f64 - 0.5) / last)).collect()
    };
    let middles = |key: &Range| (0..request.grid).map(|index| key.value(index as f64 / last)).collect();
    let edges = [edges(across), edges(up)];
    let span = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
    let spans = [span(&edges[0]), span(&edges[1])];
    let field = Field {
        words: ends.map(tick),
        tells: vec![
            Told::Column(across.key.clone(), middles(across)),
            Told::Row(up.key.clone(), middles(up)),
            Told::Cell(request.quantity.clone(), values.clone()),
        ],
        numbers: None,
        edges,
        values,
        ends,
    };
    let place = |point: &Point| (across.value(point.place[1]), up.value(point.place[0]));
    let searched = &found.points[request.grid.pow(request.ranges.len() as u32)..];
    let searched = searched.iter().map(|point| (point, place(point)));
    let runs = dots(request, ("runs of the searches", BLACK, 4.0), searched);
    let best = std::iter::once((&found.best, place(&found.best)));
    let best = dots(request, ("the best point", VERMILION, 12.0), best);
    let plot = Plot {
        title: String::new(),
        across: axis(across, spans[0]),
        up: axis(up, spans[1]),
        curves: runs.into_iter().chain(best).collect(),
    };
    (plot, field)
}

/// The value of each run in their order, and the best so far.
fn history(found: &Found, request: &Request<'_>) -> Plot {
    let grid = request.grid.pow(request.ranges.len() as u32);
    let numbered =
        || found.points.iter().enumerate().map(|(index, point)| (index, (index + 1) as f64, point));
    let of = |is_grid: bool, is_kept: bool| {
        numbered()
            .filter(move |(index, _, point)| {
                (*index < grid) == is_grid && point.feasible().is_some() == is_kept
            })
            .filter_map(|(_, number, point)| Some((point, (number, request.signed(point.value()?)))))
    };
    let mut best: Option<f64> = None;
    let mut steps = Vec::new();
    for (_, number, point) in numbered() {
        best = best.into_iter().chain(point.feasible()).reduce(f64::max);
        if let Some(best) = best {
            steps.push((number, request.signed(best)));
        }
    }
    let curves: Vec<Curve> = [
        // Below the runs, which the pointer then finds first.
        Some(Curve::new("the best so far", VERMILION, Mark::Line(1.6), steps)),
        dots(request, ("grid", BLUE, 5.0), of(true, true)),
        dots(request, ("searches", GREEN, 5.0), of(false, true)),
        dots(request, ("runs that break a constraint", BLACK, 4.0), of(true, false).chain(of(false, false))),
    ]
    .into_iter()
    .flatten()
    .collect();
    Plot {
        title: "the way of the search".to_owned(),
        across: Axis::linear("run", [1.0, found.points.len() as f64], 8),
        up: Axis::linear(request.quantity.as_str(), height(&curves), 6),
        curves,
    }
}
