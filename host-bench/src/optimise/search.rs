//! The search from the local maxima of the grid, and how flat the optima are.

use std::cell::RefCell;

use cobyla::{Func, RhoBeg, StopTols, minimize};

use super::grid::{MOST_OF_ALL, between, first, grid};
use super::{Optimum, Point, Request};
use crate::accuracy::run_as_it_is;
use crate::attractors::add_branches;
use crate::embedded;
use crate::method::Failure;
use crate::outcome::Outcome;
use crate::report::svg::tick;
use crate::run::each;
use crate::shift::Best;

/// Local maxima of the grid from which the search goes on.
const FOLLOWED: usize = 4;
/// Least part of the best value that another optimum has.
const LISTED: f64 = 0.5;
/// Runs of one search for each key.
const RUNS: usize = 40;
/// Most further searches from the best point, where there are several keys, and the part of the value that one must gain for the next.
const AGAIN: usize = 6;
const GAIN: f64 = 1e-4;
/// Part of a range to which a key is narrowed down.
const WITHIN: f64 = 1e-4;
/// Part of the best value within which a key may move.
pub(super) const FLAT: f64 = 0.01;
/// Steps in which the end of a flat range is sought, and halvings at its end.
const STEPS: i32 = 8;
const HALVINGS: usize = 5;
/// What a run that failed is worse than the worst point of the grid, as a part of the spread of the values.
const FAILED: f64 = 0.1;

/// Most runs over so many keys with a grid of so many points for each.
pub(crate) const fn most_runs(keys: usize, grid: usize, is_constrained: bool) -> usize {
    let searches = FOLLOWED * (1 + if keys > 1 { AGAIN } else { 0 }) * RUNS * keys;
    let aims = if is_constrained { 2 } else { 1 };
    (1 + MOST_OF_ALL) * grid.pow(keys as u32) + aims * searches + most_at_the_end(keys)
}

/// Most runs of the flat range, of the best point again and of its steady motion, and beside it.
const fn most_at_the_end(keys: usize) -> usize {
    let between_optima = 4 * FOLLOWED * FOLLOWED;
    FOLLOWED * 2 * keys * (STEPS as usize + HALVINGS) + between_optima + 2 + 2 * keys
}

/// Finds the best point; calls `ahead` with each stage of the work and the most runs of it.
pub(crate) fn optimise(
    request: &Request<'_>,
    ahead: &(dyn Fn(&'static str, usize) + Sync),
) -> Result<Optimum, Failure> {
    let keys = request.ranges.len();
    request.check_names()?;
    let grid = grid(keys, request.grid);
    ahead("grid", grid.len());
    let mut points = first(request, &grid)?;
    points.extend(each(&grid[points.len()..], |place| request.point(place)));
    let values: Vec<f64> = points.iter().filter_map(Point::value).collect();
    if values.is_empty() {
        return Err(Failure::Input(format!(
            "{} {}: cannot be sought: at none of the {} points of the grid is it a number, with all constraints",
            request.option(),
            request.quantity,
            points.len()
        )));
    }
    let between = between(&points, keys, request.grid);
    ahead("points between", between.places.len());
    points.extend(each(&between.places, |place| request.point(place)));
    let spacing = 1.0 / (request.grid - 1) as f64;
    let mut ends = Vec::new();
    let aims: &[bool] = if request.constraints.is_empty() { &[true] } else { &[true, false] };
    for &constrained in aims {
        let starts = maxima(&points, constrained, spacing, FOLLOWED);
        let rounds = 1 + if keys > 1 { AGAIN } else { 0 };
        ahead("searches, at most", starts.len() * rounds * RUNS * keys);
        let followed =
            |start: &Point| followed(request, &points, start.clone(), (constrained, &between.steps), rounds);
        let (found, ran): (Vec<Point>, Vec<Vec<Point>>) = each(&starts, followed).into_iter().unzip();
        points.extend(ran.into_iter().flatten());
        if constrained {
            ends = found;
        }
    }
    let best = best_of(&points, true, 1).into_iter().find(|point| point.feasible().is_some());
    let Some(best) = best else { return Err(nowhere(request, &points)) };
    let unconstrained = (!request.constraints.is_empty()).then(|| best_of(&points, false, 1)[0].clone());
    ahead("flat ranges, at most", most_at_the_end(keys));
    let flat_of = |point: &Point| flat(request, point);
    let flat = flat_of(&best);
    let others = others(request, &best, ends, spacing).into_iter();
    let others = others.map(|point| (point.clone(), flat_of(&point))).collect();
    let scene = request.scene(&best.place)?;
    let mut outcome = request.counted(run_as_it_is(&scene, &request.options))?;
    if !request.single_start {
        add_branches(&scene, &request.options, &mut outcome);
    }
    let is_level = values.len() > 1 && points.iter().filter_map(Point::value).all(|value| value == values[0]);
    let level = is_level.then(|| {
        format!("{} is the same at all points that were run: the keys do not change it", request.quantity)
    });
    let doubts = level.into_iter().chain(doubt(request, &best, &outcome));
    let doubts = doubts.chain(request.unapproached(&best.place, &outcome)).collect();
    let runs = request.runs.counts();
    let searched = searched(request, between.places.len());
    Ok(Optimum { best, unconstrained, flat, others, searched, outcome, points, runs, doubts })
}

/// The best point of at most `rounds` searches, each from the best point of the last, and all points that they ran: one linear
/// approximation does not follow a ridge to its end.
fn followed(
    request: &Request<'_>,
    points: &[Point],
    mut start: Point,
    (constrained, steps): (bool, &[f64]),
    rounds: usize,
) -> (Point, Vec<Point>) {
    let mut ran = Vec::new();
    for _ in 0..rounds {
        ran.extend(search(request, points, &start, (constrained, steps)));
        let Some(end) = best_of(&ran, constrained, 1).pop() else { break };
        let [(lack, value), (less, larger)] = [&start, &end].map(|point| rank(point, constrained));
        if (less, larger) > (lack, value) {
            start = end;
        }
        if less <= lack && larger - value <= GAIN * value.abs() {
            break;
        }
    }
    (start, ran)
}

fn searched(request: &Request<'_>, between: usize) -> String {
    let steps = request.ranges.iter().map(|range| {
        let step = match range.is_logarithmic {
            true => {
                format!("a factor of {:.3}", (range.high / range.low).powf(1.0 / (request.grid - 1) as f64))
            }
            false => tick((range.high - range.low) / (request.grid - 1) as f64),
        };
        format!("{} in steps of {step}", range.key)
    });
    let steps: Vec<String> = steps.collect();
    let finer = match between {
        0 => String::new(),
        count => format!(", with {count} points between them at the resonance"),
    };
    format!(
        "{}{finer}, and from the best local maxima on. Not searched: peaks between the points that are narrower than a \
         step and no resonance of one sine",
        steps.join(", ")
    )
}

/// The best of the points without a better one within a spacing of the grid in each key; of one key, better than both beside them.
fn maxima(points: &[Point], constrained: bool, spacing: f64, count: usize) -> Vec<Point> {
    let sorted = best_of(points, constrained, usize::MAX);
    let near = |one: &Point, other: &Point| {
        one.place.iter().zip(&other.place).all(|(one, other)| (one - other).abs() < 1.001 * spacing)
    };
    let mut along: Vec<&Point> = sorted.iter().collect();
    along.sort_by(|one, other| one.place[0].total_cmp(&other.place[0]));
    let is_maximum = |at: &usize| {
        let point = &sorted[*at];
        if point.place.len() > 1 {
            return !sorted[..*at].iter().any(|better| near(better, point));
        }
        let place = along.iter().position(|other| other.place == point.place).unwrap_or(0);
        let beside =
            [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter_map(|at| along.get(at));
        beside.into_iter().all(|other| rank(other, constrained) <= rank(point, constrained))
    };
    (0..sorted.len()).filter(is_maximum).take(count).map(|at| sorted[at].clone()).collect()
}

/// The ends of searches that are optima beside the best: between them and each better one the value falls below theirs.
fn others(request: &Request<'_>, best: &Point, mut ends: Vec<Point>, spacing: f64) -> Vec<Point> {
    let mut found = vec![best.clone()];
    ends.sort_by(|one, other| {
        other.feasible().unwrap_or(f64::NAN).total_cmp(&one.feasible().unwrap_or(f64::NAN))
    });
    let least = best.value().map_or(f64::INFINITY, |value| value - LISTED * value.abs());
    for end in ends {
        let Some(value) = end.feasible().filter(|value| *value >= least) else { continue };
        let falls = |better: &Point| {
            let is_near =
                better.place.iter().zip(&end.place).all(|(one, other)| (one - other).abs() < 0.25 * spacing);
            let middle = |part: f64| -> Vec<f64> {
                better.place.iter().zip(&end.place).map(|(one, other)| one + part * (other - one)).collect()
            };
            let is_below = |part: &f64| {
                request
                    .point(&middle(*part))
                    .feasible()
                    .is_none_or(|between| between < value - GAIN * value.abs())
            };
            !is_near && [0.5, 0.25, 0.75, 0.9].iter().any(is_below)
        };
        if found.iter().all(falls) {
            found.push(end);
        }
    }
    found.split_off(1)
}

/// A warning where the value at the best point may be that of a lucky run.
fn doubt(request: &Request<'_>, best: &Point, outcome: &Outcome) -> Option<String> {
    let signed = |point: &Point| point.value().map(|value| request.signed(value));
    Best {
        quantity: &request.quantity,
        place: &best.place,
        value: signed(best)?,
        scene: request.scene(&best.place).ok()?,
        options: request.options,
        verdict: outcome.steady_state.as_ref().map(|found| found.steady_state),
        shoot: &|scene, options| request.counted(embedded::steady_state(scene, options)),
        at: &|place| signed(&request.point(place)),
    }
    .doubt()
}

/// What a point lacks of the constraints, at most 0, and its value: the higher the better, the first before the second.
fn rank(point: &Point, constrained: bool) -> (f64, f64) {
    match &point.found {
        None => (f64::NEG_INFINITY, f64::NEG_INFINITY),
        Some((value, margins)) => {
            let lack = margins.iter().copied().fold(0.0_f64, f64::min);
            (if constrained { lack } else { 0.0 }, *value)
        }
    }
}

/// The best points: those that keep the constraints, the higher the better; then the others by what they lack.
fn best_of(points: &[Point], constrained: bool, count: usize) -> Vec<Point> {
    let mut sorted: Vec<&Point> = points.iter().filter(|point| point.found.is_some()).collect();
    sorted.sort_by(|one, other| {
        let (one, other) = (rank(one, constrained), rank(other, constrained));
        other.0.total_cmp(&one.0).then(other.1.total_cmp(&one.1))
    });
    sorted.into_iter().take(count).cloned().collect()
}

/// A search by linear approximations within the range and the constraints (M. J. D. Powell's COBYLA, 1994), with all points
/// that it ran. The values are scaled by the spread of the grid; a run that fails is worse than all of them.
fn search(
    request: &Request<'_>,
    known: &[Point],
    start: &Point,
    (constrained, steps): (bool, &[f64]),
) -> Vec<Point> {
    let values = || known.iter().filter_map(Point::value);
    let (low, high) = values()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let spread = if high > low { high - low } else { high.abs().max(f64::MIN_POSITIVE) };
    let ran: RefCell<Vec<Point>> = RefCell::new(Vec::new());
    // The objective and each constraint ask for the same place.
    let at = |place: &[f64]| -> Point {
        let place: Vec<f64> = place.iter().map(|part| part.clamp(0.0, 1.0)).collect();
        let last = ran.borrow().iter().rev().find(|point| point.place == place).cloned();
        last.unwrap_or_else(|| {
            let point = request.point(&place);
            ran.borrow_mut().push(point.clone());
            point
        })
    };
    let objective = |place: &[f64], _: &mut ()| match at(place).value() {
        Some(value) => (high - value) / spread,
        None => 1.0 + FAILED,
    };
    let margin = |index: usize| {
        let at = &at;
        move |place: &[f64], _: &mut ()| match at(place).found {
            Some((_, margins)) => margins[index],
            None => -1.0,
        }
    };
    let margins: Vec<_> = (0..if constrained { request.constraints.len() } else { 0 }).map(margin).collect();
    let margins: Vec<&dyn Func<()>> = margins.iter().map(|margin| margin as &dyn Func<()>).collect();
    let tolerance = StopTols { xtol_abs: vec![WITHIN; start.place.len()], ..StopTols::default() };
    // Its own end is of no account: the best point that was run is taken.
    let _ = minimize(
        objective,
        &start.place,
        &vec![(0.0, 1.0); start.place.len()],
        &margins,
        (),
        RUNS * start.place.len(),
        RhoBeg::Set(steps.to_vec()),
        Some(tolerance),
    );
    ran.into_inner()
}

/// The failure where no point keeps the constraints.
fn nowhere(request: &Request<'_>, points: &[Point]) -> Failure {
    let nearest = best_of(points, true, 1);
    let place = nearest.first().map_or_else(String::new, |point| {
        let values = Optimum::values(request, point);
        let values: Vec<String> =
            values.into_iter().map(|(key, value)| format!("{key} = {value:e}")).collect();
        let lack = point.found.iter().flat_map(|(_, margins)| margins).copied().fold(0.0_f64, f64::min);
        format!("; the nearest, at {}, misses one by {:.2e} of its bound", values.join(", "), -lack)
    });
    Failure::Step(format!("--subject-to: no point of {} keeps all constraints{place}", points.len()))
}

/// For each key the range around the best point, the others held, in which the value stays within 1 % and the constraints are kept.
fn flat(request: &Request<'_>, best: &Point) -> Vec<[f64; 2]> {
    let Some(value) = best.value() else { return Vec::new() };
    let least = value - FLAT * value.abs();
    let sides: Vec<(usize, f64)> =
        (0..best.place.len()).flat_map(|index| [(index, -1.0), (index, 1.0)]).collect();
    let ends = each(&sides, |&(index, sign)| {
        let centre = best.place[index];
        let reach = if sign < 0.0 { centre } else { 1.0 - centre };
        let is_in = |distance: f64| {
            let mut place = best.place.clone();
            place[index] = (centre + sign * distance).clamp(0.0, 1.0);
            request.point(&place).feasible().is_some_and(|value| value >= least)
        };
        // Outwards from near, so that a second optimum far off is no part of it.
        let mut near = 0.0;
        let mut far = None;
        for step in (0..STEPS).rev() {
            let distance = reach * 0.5_f64.powi(step);
            if is_in(distance) {
                near = distance;
            } else {
                far = Some(distance);
                break;
            }
        }
        if let Some(mut far) = far {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (near + far);
                *(if is_in(middle) { &mut near } else { &mut far }) = middle;
            }
        }
        request.ranges[index].value(centre + sign * near)
    });
    ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}
