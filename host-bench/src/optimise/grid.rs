//! The grid over the ranges, and the places between its points that make it as fine as a resonance.

use super::{Point, Request, check_quantity};
use crate::method::Failure;
use crate::run::each;

/// Distance of a resonance in logarithms of the frequency within which the grid is as fine as its bandwidth: a coupling moves
/// the resonance by less. Most points between two of the grid, and most of all over those of the grid.
const NEAR: f64 = 0.15;
const MOST_BETWEEN: f64 = 12.0;
pub(super) const MOST_OF_ALL: usize = 4;

/// The places between the points of a grid that resolve the resonance, and the first step of a search along each key.
pub(super) struct Between {
    pub(super) places: Vec<Vec<f64>>,
    pub(super) steps: Vec<f64>,
}

/// The places along the key that moves the resonances most, between two points of the grid of which one is near a resonance
/// or which have one between them, so that they are as close as its bandwidth.
pub(super) fn between(points: &[Point], keys: usize, count: usize) -> Between {
    let spacing = 1.0 / (count - 1) as f64;
    let pairs = |key: usize| {
        let stride = count.pow((keys - 1 - key) as u32);
        let has_next = move |at: &usize| at / stride % count + 1 < count;
        (0..points.len()).filter(has_next).map(move |at| [&points[at], &points[at + stride]])
    };
    // Parts of a bandwidth between two points, the most of all resonances that are near.
    let parts = |[one, next]: [&Point; 2]| {
        let ends = one.tuning.distances.iter().zip(&next.tuning.distances);
        let near = ends.filter(|(here, there)| here.min(**there) < NEAR && here.max(**there) > -NEAR);
        let bandwidth = one.tuning.bandwidth.min(next.tuning.bandwidth).max(1e-3);
        near.map(|(here, there)| (there - here).abs() / bandwidth).fold(0.0, f64::max)
    };
    let moved = |key: &usize| pairs(*key).map(parts).fold(0.0, f64::max);
    let key = (0..keys).max_by(|one, other| moved(one).total_cmp(&moved(other))).unwrap_or(0);
    let most = (MOST_OF_ALL * points.len()) as f64;
    let all: f64 = pairs(key).map(|pair| parts(pair).ceil().clamp(1.0, MOST_BETWEEN) - 1.0).sum();
    let mut steps = vec![0.5 * spacing; keys];
    let mut places = Vec::new();
    for pair in pairs(key) {
        let wanted = parts(pair).ceil().clamp(1.0, MOST_BETWEEN) - 1.0;
        let inner = (wanted * (most / all.max(1.0)).min(1.0)).floor() as usize;
        for index in 1..=inner {
            let mut place = pair[0].place.clone();
            place[key] += spacing * index as f64 / (inner + 1) as f64;
            places.push(place);
            steps[key] = f64::min(steps[key], spacing / (inner + 1) as f64);
        }
    }
    Between { places, steps }
}

/// The first points of the grid, one for each core, until one succeeds. Refuses bad input at a corner, and quantities that cannot be sought.
pub(super) fn first(request: &Request<'_>, grid: &[Vec<f64>]) -> Result<Vec<Point>, Failure> {
    let corners = grid.iter().filter(|place| place.iter().all(|part| *part == 0.0 || *part == 1.0));
    for place in corners {
        request.options.check_scene(&request.scene(place)?)?;
    }
    let mut points = Vec::new();
    let mut reason = None;
    for places in grid.chunks(rayon::current_num_threads().max(1)) {
        let tried = each(places, |place| request.run(place));
        // The first run that succeeds has the names.
        let mut named =
            places.iter().zip(&tried).filter_map(|(place, tried)| Some((place, tried.as_ref().ok()?)));
        let numbers = named.next().map(|(place, outcome)| request.numbers(place, outcome)).transpose()?;
        if let Some(numbers) = &numbers {
            request.quantities().try_for_each(|(option, name)| check_quantity(option, name, numbers))?;
        }
        for (place, tried) in places.iter().zip(tried) {
            let tried = request.counted(tried);
            if let Err(failure) = &tried {
                reason.get_or_insert_with(|| failure.to_string());
            }
            points.push(request.judged(place, tried.ok()));
        }
        if numbers.is_some() {
            return Ok(points);
        }
    }
    let reason = reason.unwrap_or_default();
    Err(Failure::Step(format!("all {} points of the grid fail, the first: {reason}", grid.len())))
}

/// The places of a grid, the last key running fastest.
pub(super) fn grid(keys: usize, count: usize) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new()];
    for _ in 0..keys {
        let longer = |place: &Vec<f64>| {
            let place = place.clone();
            (0..count).map(move |index| [&place[..], &[index as f64 / (count - 1) as f64]].concat())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}
