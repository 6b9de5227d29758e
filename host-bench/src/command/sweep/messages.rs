//! Messages on all points of a sweep: their warnings, and the best of them.

use super::points::{Compared, Point, Points};
use super::{Axis, indices};
use crate::embedded;
use crate::outcome::{LIMIT, MODEL};
use crate::resolution::is_of_a_far_sine;
use crate::run::run_scene;
use crate::shift::Best;

/// The warnings of the points together. A row has its own warnings in JSON and CSV.
pub(in crate::command) fn warnings(points: &[Point]) -> impl Iterator<Item = String> {
    let first = |kind| first_of(points, |warning| warning.starts_with(kind)).map(|(_, text)| text);
    // A sweep may go beyond the resonances on purpose.
    let all_far = first_of(points, is_of_a_far_sine).filter(|(count, _)| *count == points.len());
    let others = [most_created(points), all_far.map(|(_, text)| text)];
    others.into_iter().chain(KINDS.map(first)).flatten()
}

/// Beginnings of the warnings of which the first is printed: no stable orbit, accuracy, other motions, limits of the model.
const KINDS: [&str; 5] = ["steady state:", "accuracy:", "attractors:", LIMIT, MODEL];

/// The warning of the point whose force law created the largest share of the delivered energy, with the number of the points that warn.
fn most_created(points: &[Point]) -> Option<String> {
    let warned = points.iter().filter_map(|point| {
        let share = point.number("created_energy_share").map_or(0.0, f64::abs);
        let is_other = |warning: &&str| {
            !KINDS.iter().any(|kind| warning.starts_with(kind)) && !is_of_a_far_sine(warning)
        };
        let warning = point.warnings().find(is_other)?;
        Some((point, warning, share))
    });
    let count = warned.clone().count();
    let (point, warning, _) = warned.max_by(|(.., one), (.., other)| one.total_cmp(other))?;
    Some(format!("at {count} of {} points, the most at {}: {warning}", points.len(), point.place()))
}

/// The first point with the largest mean power, its index, and the power in W; `None` unless there are several points.
pub(super) fn best(points: &[Point]) -> Option<(usize, &Point, f64)> {
    let powers = points.iter().enumerate().rev();
    let powers = powers.filter_map(|(index, point)| Some((index, point, point.number("mean_power_w")?)));
    powers.max_by(|one, other| one.2.total_cmp(&other.2)).filter(|_| points.len() > 1)
}

pub(super) fn best_text(points: &[Point], (_, point, power): (usize, &Point, f64)) -> String {
    let accuracy = point.found.as_ref().ok().and_then(|fields| fields.get("accuracy"));
    let stated = match (accuracy.and_then(|accuracy| accuracy.get("total")?.as_f64()), point.is_stated()) {
        (Some(total), _) => format!(", stated error {total:.1e}"),
        (None, true) => ", stated error unknown".to_owned(),
        (None, false) => String::new(),
    };
    match is_level(points) {
        true => format!("mean_power_w {power:.3e} at all points: the keys do not change it{stated}"),
        false => format!("largest mean_power_w {power:.3e} at {}{stated}", point.place()),
    }
}

/// The best point of a curve in words; between two others that of a further run, at the vertex of the parabola through the three.
pub(super) fn refined_text(
    axis: &Axis,
    points: &Points<'_>,
    found: &[Point],
    best @ (at, _, top): (usize, &Point, f64),
) -> String {
    let power = |at: usize| found.get(at)?.number("mean_power_w");
    let Some((left, right)) = at.checked_sub(1).and_then(|before| power(before).zip(power(at + 1))) else {
        let is_at_an_end = !is_level(found) && (at == 0 || at + 1 == found.len());
        return best_text(found, best) + if is_at_an_end { ", at an end of the curve" } else { "" };
    };
    let vertex = at as f64 + 0.5 * (left - right) / (left - 2.0 * top + right);
    let value = axis.at(vertex / (axis.count() - 1) as f64);
    let run = |scene| run_scene(&scene, &points.arguments.options()).ok()?.mean_power_w;
    match points.scene(&[value]).ok().and_then(run).filter(|power| *power > top) {
        Some(power) => {
            let value: f64 = format!("{value:.5e}").parse().unwrap_or(value);
            format!(
                "largest mean_power_w {power:.3e} at {} = {value}, between two points of the curve",
                axis.key
            )
        }
        None => best_text(found, best),
    }
}

/// Whether all points have the same mean power: none of them is the best.
fn is_level(points: &[Point]) -> bool {
    let mut powers = points.iter().map(|point| point.number("mean_power_w"));
    let first = powers.next();
    powers.all(|power| Some(power) == first)
}

/// The warning of a best point that may be a lucky one: neither one of all, nor the mean of an ensemble, whose error is stated.
pub(super) fn doubt(
    axes: &[Axis],
    points: &Points<'_>,
    found: &[Point],
    (index, point, value): (usize, &Point, f64),
) -> Option<String> {
    if is_level(found) || point.number("mean_power_standard_error_w").is_some() {
        return None;
    }
    let options = points.arguments.options();
    let own: Vec<f64> = point.values.iter().map(|(_, value)| *value).collect();
    let moved: Vec<usize> = (0..axes.len()).filter(|&axis| axes[axis].count() > 1).collect();
    let indices = indices(axes, index);
    let part = |&axis: &usize| indices[axis] as f64 / (axes[axis].count() - 1) as f64;
    let parts: Vec<f64> = moved.iter().map(part).collect();
    let at = |parts: &[f64]| {
        let mut values = own.clone();
        moved.iter().zip(parts).for_each(|(&axis, part)| values[axis] = axes[axis].at(*part));
        run_scene(&points.scene(&values).ok()?, &options).ok()?.mean_power_w
    };
    Best {
        quantity: "mean_power_w",
        place: &parts,
        value,
        scene: points.scene(&own).ok()?,
        options,
        verdict: point.text("steady_state"),
        shoot: &embedded::steady_state,
        at: &at,
    }
    .doubt()
}

/// How many points have a warning of a kind, and the first of them in words.
fn first_of(points: &[Point], is_of_kind: impl Fn(&str) -> bool) -> Option<(usize, String)> {
    let warned = points
        .iter()
        .filter_map(|point| Some((point, point.warnings().find(|warning| is_of_kind(warning))?)));
    let count = warned.clone().count();
    let (point, warning) = warned.clone().next()?;
    Some((count, format!("at {count} of {} points, the first at {}: {warning}", points.len(), point.place())))
}

/// The costs of all points together in words; `None` over no points.
pub(super) fn costs<'a>(points: impl Iterator<Item = &'a Compared>) -> Option<String> {
    let points: Vec<&Compared> = points.collect();
    let stable: Vec<&Compared> = points.iter().copied().filter(|point| point.is_stable).collect();
    let sum = |points: &[&Compared]| {
        points.iter().fold([0.0; 2], |[a, b], point| [a + point.periods[0], b + point.periods[1]])
    };
    let ratio = |[steady, run]: [f64; 2]| run / steady;
    let times = |points: &[&Compared]| format!("the run has {:.1} times as many", ratio(sum(points)));
    let each = match stable.len() {
        0 => "none of them has a stable orbit".to_owned(),
        count => {
            format!("{:.0} simulated periods each, {}", sum(&stable)[0] / count as f64, times(&stable))
        }
    };
    let of_all = format!("; at all points, the run included where there is none, {}", times(&points));
    let of_all = if (1..points.len()).contains(&stable.len()) { of_all } else { String::new() };
    let text = format!("steady state at {} of {} points: {each}{of_all}", stable.len(), points.len());
    let seconds = points.iter().filter_map(|point| point.seconds).reduce(|[a, b], [c, d]| [a + c, b + d]);
    let slower = seconds.map(|seconds| format!("; the runs took {:.1} times as long", ratio(seconds)));
    (!points.is_empty()).then(|| text + &slower.unwrap_or_default())
}
