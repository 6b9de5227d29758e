//! The picture of an optimum: its curve over one key or its map over the first two, and the way of the search.

use plotters::style::RGBColor;

use super::{Optimum, Point, Range, Request};
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::setting::{axis_of, number_and_unit, scaled};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION, tick};

/// The title is plain text.
pub(crate) fn picture(found: &Optimum, request: &Request<'_>, title: String) -> Picture {
    let (words, unit) = number_and_unit(&request.quantity);
    let (quantity, factor) = scaled(&words, unit, found.points.iter().filter_map(Point::value));
    let shown = (request, quantity, factor);
    let first = match &request.ranges[..] {
        [only] => Some(curve(found, &shown, only)),
        [up, across, ..] => Some(map(found, &shown, [across, up])),
        [] => None,
    };
    let charts = first.into_iter().chain([history(found, &shown)]).collect();
    Picture { title, width: 900, charts, ..Picture::default() }
}

/// The request, what is sought with the unit in which it is shown, and the factor to it.
type Shown<'a> = (&'a Request<'a>, String, f64);

/// The readout of a point at the pointer besides its place: its value, that of each key, and which constraint it breaks.
fn note((request, quantity, factor): &Shown<'_>, point: &Point) -> String {
    let value = point.value().map(|value| tick(factor * request.signed(value)));
    let mut lines = vec![format!("{quantity}: {}", value.unwrap_or_else(|| "the run failed".to_owned()))];
    lines.extend(
        Optimum::values(request, point).into_iter().map(|(key, value)| format!("{key} = {value:.6e}")),
    );
    if let Some((_, margins)) = &point.found {
        let broken = request.constraints.iter().zip(margins).filter(|(_, margin)| **margin < 0.0);
        lines.extend(broken.map(|(constraint, _)| format!("breaks {}", constraint.text())));
    }
    lines.join("\n")
}

/// Points with their values in a colour; nothing where there are none.
fn dots<'a>(
    shown: &Shown<'_>,
    (name, colour, mark): (&str, RGBColor, Mark),
    points: impl Iterator<Item = (&'a Point, (f64, f64))>,
) -> Option<Curve> {
    let noted = points.map(|(point, place)| (place, note(shown, point)));
    Curve::noted(name, colour, mark, noted)
}

/// The axis of a key, and the factor to the unit that it shows.
fn axis(key: &Range) -> (Axis, f64) {
    axis_of(&key.key, key.is_logarithmic, [key.low, key.high])
}

/// The value over the only key.
fn curve(found: &Optimum, shown: &Shown<'_>, key: &Range) -> Chart {
    let (request, quantity, factor) = shown;
    let (across, to_shown) = axis(key);
    let place =
        |point: &Point| Some((to_shown * key.value(point.place[0]), factor * request.signed(point.value()?)));
    let mut points: Vec<(&Point, (f64, f64))> =
        found.points.iter().filter_map(|point| Some((point, place(point)?))).collect();
    points.sort_by(|one, other| one.1.0.total_cmp(&other.1.0));
    let line = Curve::new("", BLUE, Mark::line(0, 1.2), points.iter().map(|(_, place)| *place));
    let feasible = |is_feasible: bool| {
        points.iter().filter(move |(point, _)| point.feasible().is_some() == is_feasible).copied()
    };
    let best = place(&found.best).map(|place| (&found.best, place));
    let others = found.others.iter().filter_map(|(point, _)| Some((point, place(point)?)));
    let curves = [
        Some(line.broken_at_jumps()),
        dots(shown, ("runs", BLUE, Mark::point(0, 6.0)), feasible(true)),
        dots(shown, ("runs that break a constraint", BLACK, Mark::point(1, 6.0)), feasible(false)),
        dots(shown, ("other optima", BLACK, Mark::point(1, 11.0)), others.into_iter()),
        dots(shown, ("the best point", VERMILION, Mark::point(0, 11.0)), best.into_iter()),
    ];
    let up = Axis::linear(quantity.as_str(), FITTING, 7);
    Chart { height: 420, ..Chart::new("", across, up, curves.into_iter().flatten().collect()) }
}

/// All runs over the first two keys: the colour of a cell is the best value found in it that keeps the constraints.
fn map(found: &Optimum, shown: &Shown<'_>, keys: [&Range; 2]) -> Chart {
    let (request, quantity, factor) = shown;
    let count = request.grid;
    let nearest = |part: f64| (part.clamp(0.0, 1.0) * (count - 1) as f64).round() as usize;
    let mut cells: Vec<Option<f64>> = vec![None; count * count];
    for point in found.points.iter().chain([&found.best]) {
        let cell = &mut cells[nearest(point.place[0]) * count + nearest(point.place[1])];
        *cell = cell.iter().copied().chain(point.feasible()).reduce(f64::max);
    }
    let cells = cells.into_iter().map(|best| best.map(|value| factor * request.signed(value)));
    let part = |index: usize| index as f64 / (count - 1) as f64;
    let [(across, to_across), (up, to_up)] = keys.map(axis);
    let at = |columns: f64, rows: f64| (to_across * keys[0].value(columns), to_up * keys[1].value(rows));
    let middles = (0..count).map(|index| at(part(index), part(index))).unzip::<_, _, Vec<_>, Vec<_>>();
    let scale = Axis::linear(quantity.as_str(), FITTING, 8);
    let mut chart = Chart::map([across, up], middles.into(), scale, cells.collect());
    let place = |point: &Point| at(point.place[1], point.place[0]);
    let searched = found.points.iter().skip(count.pow(request.ranges.len() as u32));
    let searched = searched.map(|point| (point, place(point)));
    let best = std::iter::once((&found.best, place(&found.best)));
    let optima = found.others.iter().map(|(point, _)| (point, place(point)));
    let curves = [
        dots(shown, ("runs between the points and of the searches", BLACK, Mark::point(0, 2.5)), searched),
        dots(shown, ("other optima", BLACK, Mark::point(1, 13.0)), optima),
        dots(shown, ("the best point", VERMILION, Mark::point(0, 13.0)), best),
    ];
    chart.curves.extend(curves.into_iter().flatten());
    let notes = [
        Some("the colour of a cell is the best value found in it"),
        (request.ranges.len() > 2).then_some("over the other keys"),
        chart.has_white().then_some("white: none that keeps the constraints"),
    ];
    Chart { note: notes.into_iter().flatten().collect::<Vec<_>>().join(", "), ..chart }
}

/// The value of each run in their order, and the best so far.
fn history(found: &Optimum, shown: &Shown<'_>) -> Chart {
    let (request, quantity, factor) = shown;
    let grid = request.grid.pow(request.ranges.len() as u32);
    let numbered =
        || found.points.iter().enumerate().map(|(index, point)| (index, (index + 1) as f64, point));
    let of = |is_grid: bool, is_feasible: bool| {
        numbered()
            .filter(move |(index, _, point)| {
                (*index < grid) == is_grid && point.feasible().is_some() == is_feasible
            })
            .filter_map(|(_, number, point)| Some((point, (number, factor * request.signed(point.value()?)))))
    };
    let steps = numbered().scan(None, |best: &mut Option<f64>, (_, number, point)| {
        *best = best.iter().copied().chain(point.feasible()).reduce(f64::max);
        Some(best.map(|best| (number, factor * request.signed(best))))
    });
    let broken = of(true, false).chain(of(false, false));
    let curves = [
        // Below the runs, which the pointer then finds first.
        Some(Curve::new("the best so far", VERMILION, Mark::line(0, 1.6), steps.flatten())),
        dots(shown, ("grid", BLUE, Mark::point(0, 5.0)), of(true, true)),
        dots(shown, ("searches", GREEN, Mark::point(1, 5.0)), of(false, true)),
        dots(shown, ("runs that break a constraint", BLACK, Mark::point(0, 2.5)), broken),
    ];
    let across = Axis::linear("run", [1.0, found.points.len() as f64], 8);
    let up = Axis::linear(quantity.as_str(), FITTING, 6);
    let chart = Chart::new("the way of the search", across, up, curves.into_iter().flatten().collect());
    let others = found.runs[0].saturating_sub(found.points.len());
    let note = format!(
        "not drawn: {others} runs where the value is within 1 %, of the best point again, and beside it"
    );
    Chart { note: if others > 0 { note } else { String::new() }, ..chart }
}
