//! The steady motions at one frequency: through rising, then through falling amplitudes.

use super::axes::{amplitude_of, level_of};
use crate::embedded::{Found, Held, Motion};
use crate::method::Failure;

/// Ratio of an amplitude to the next, in levels: a fifth of an octave.
const STEP: f64 = 2048.0 / 5.0;
/// Bisections of a step in which a motion ends: to 0.2 % of the amplitude.
const BISECTIONS: u32 = 6;
/// How far beyond the map a boundary is sought, in levels: two octaves.
pub(super) const BEYOND: f64 = 2.0 * 2048.0;

/// Halvings of a step where the logarithm of the value is not straight, to a hundredth of the amplitude, and of a motion that
/// is not periodic, whose value scatters: the node values are fitted to all of its points.
const HALVINGS: [u32; 2] = [4, 3];
/// Octaves by which the value in the middle of a step may differ from the mean of its ends.
const STRAIGHT: f64 = 0.03;

/// The steady motions at one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub frequency_hz: f64,
    /// Level of the amplitude at which a rising sweep leaves the lower branch; the highest that is sought if it does not.
    pub rising: f64,
    /// Level of the amplitude at which a falling sweep leaves the upper branch.
    pub falling: f64,
    /// Whether the boundaries were found, not an end of the search.
    pub found: bool,
    /// Level of the amplitude and value along the lower branch, rising.
    pub lower: Vec<(f64, f64)>,
    /// The same of the upper branch.
    pub upper: Vec<(f64, f64)>,
}

/// A steady motion on the way through the amplitudes, with its state.
#[derive(Clone, Copy)]
struct Point {
    level: f64,
    motion: Motion,
    state: usize,
}

impl Point {
    fn new(held: &mut dyn Held, level: f64, motion: Motion) -> Self {
        Self { level, motion, state: held.keep() }
    }
}

/// Adds points between two of one motion, in the direction of the way, until the logarithm of its value is straight between
/// them. The state is then one of these points.
fn refine(
    held: &mut dyn Held,
    [from, to]: [Point; 2],
    halvings: u32,
    values: &mut Vec<(f64, f64)>,
) -> Result<(), Failure> {
    let ends = [from, to].map(|end| end.motion.value);
    if halvings == 0 || ends == [0.0; 2] {
        return Ok(());
    }
    held.go_back(from.state);
    let level = 0.5 * (from.level + to.level);
    let motion = held.settle(amplitude_of(level))?;
    if motion.is_upper != from.motion.is_upper {
        return Ok(());
    }
    values.push((level, motion.value));
    let middle = Point::new(held, level, motion);
    // Without a yield at an end this is not finite.
    let off = motion.value.log2() - 0.5 * (ends[0].log2() + ends[1].log2());
    if off.abs() < STRAIGHT {
        return Ok(());
    }
    refine(held, [from, middle], halvings - 1, values)?;
    refine(held, [middle, to], halvings - 1, values)
}

/// How often a step to a point is halved: not beyond the map.
fn halvings(point: Point, [lowest, highest]: [f64; 2]) -> u32 {
    let is_inside = (lowest - STEP..=highest + STEP).contains(&point.level);
    if is_inside { HALVINGS[usize::from(point.motion.found == Found::Mean)] } else { 0 }
}

/// Takes a harvester through the amplitudes.
pub(super) fn column(
    held: &mut dyn Held,
    frequency_hz: f64,
    amplitudes: [f64; 2],
) -> Result<Column, Failure> {
    let [lowest, highest] = amplitudes.map(level_of);
    let (floor, cap) = (lowest - BEYOND, highest + BEYOND);
    let mut column = Column {
        frequency_hz,
        rising: cap,
        falling: cap,
        found: false,
        lower: Vec::new(),
        upper: Vec::new(),
    };
    let (mut steps, mut steps_down) = (Vec::new(), Vec::new());
    let left = rise(held, [floor, cap], &mut steps, &mut column.lower)?;
    let mut level = match left {
        Some([last, beyond]) => {
            column.rising = last.max(floor);
            beyond
        }
        // Larger than any amplitude that is asked for: a motion that small amplitudes do not lead to.
        None => cap + BEYOND,
    };
    let from_rest = left.is_none();
    if from_rest {
        held.rest();
    }
    // To above the map, or to the amplitude at which the upper motion was reached.
    let top = highest.max(column.rising) + STEP;
    let mut end = None;
    loop {
        let motion = held.settle(amplitude_of(level))?;
        // Next to the boundary a motion may have contact at one amplitude and none at the next.
        if motion.is_upper {
            column.upper.push((level, motion.value));
            end = Some(Point::new(held, level, motion));
        }
        if level >= top {
            break;
        }
        level = (level + STEP).min(top);
    }
    if let Some(end) = end {
        column.falling = fall(held, end, floor, &mut steps_down, &mut column.upper)?.min(column.rising);
        column.found = left.is_some() && column.rising > floor;
    }
    // After both ways, which these points must not change.
    let map = [lowest, highest];
    for (steps, values) in [(steps, &mut column.lower), (steps_down, &mut column.upper)] {
        for step in steps {
            refine(held, step, halvings(step[1], map), values)?;
        }
        values.sort_by(|one, other| one.0.total_cmp(&other.0));
        values.dedup_by(|one, other| (one.0 - other.0).abs() < 1e-6);
    }
    Ok(column)
}

/// Follows the lower motion from rest upwards: the level at which it was seen last, and one at which it was left. `None` if
/// it is not left.
fn rise(
    held: &mut dyn Held,
    [floor, cap]: [f64; 2],
    steps: &mut Vec<[Point; 2]>,
    values: &mut Vec<(f64, f64)>,
) -> Result<Option<[f64; 2]>, Failure> {
    held.rest();
    let mut level = floor;
    let mut last: Option<Point> = None;
    while level < cap + STEP {
        let at = level.min(cap);
        let motion = held.settle(amplitude_of(at))?;
        if motion.is_upper {
            let Some(mut good) = last else { return Ok(Some([floor, at])) };
            let mut bad = Point::new(held, at, motion);
            for _ in 0..BISECTIONS {
                held.go_back(good.state);
                let middle = 0.5 * (good.level + bad.level);
                let motion = held.settle(amplitude_of(middle))?;
                let middle = Point::new(held, middle, motion);
                if motion.is_upper {
                    bad = middle;
                } else {
                    values.push((middle.level, motion.value));
                    steps.push([good, middle]);
                    good = middle;
                }
            }
            held.go_back(bad.state);
            return Ok(Some([good.level, bad.level]));
        }
        values.push((at, motion.value));
        let point = Point::new(held, at, motion);
        if let Some(before) = last {
            steps.push([before, point]);
        }
        last = Some(point);
        level += STEP;
    }
    Ok(None)
}

/// Follows the upper motion from a point downwards: the lowest level at which it was seen.
fn fall(
    held: &mut dyn Held,
    from: Point,
    floor: f64,
    steps: &mut Vec<[Point; 2]>,
    values: &mut Vec<(f64, f64)>,
) -> Result<f64, Failure> {
    let mut good = from;
    held.go_back(good.state);
    while good.level > floor {
        let mut bad = (good.level - STEP).max(floor);
        let motion = held.settle(amplitude_of(bad))?;
        if motion.is_upper {
            values.push((bad, motion.value));
            let point = Point::new(held, bad, motion);
            steps.push([good, point]);
            good = point;
            continue;
        }
        for _ in 0..BISECTIONS {
            held.go_back(good.state);
            let middle = 0.5 * (good.level + bad);
            let motion = held.settle(amplitude_of(middle))?;
            if motion.is_upper {
                values.push((middle, motion.value));
                let point = Point::new(held, middle, motion);
                steps.push([good, point]);
                good = point;
            } else {
                bad = middle;
            }
        }
        return Ok(good.level);
    }
    Ok(good.level)
}

/// Levels and binary logarithms of the values above 0.
pub(super) fn logarithms(branch: &[(f64, f64)]) -> Vec<(f64, f64)> {
    branch.iter().filter(|(_, value)| *value > 0.0).map(|&(at, value)| (at, value.log2())).collect()
}

/// The value at a level: linear between the points, beyond the lower end along the first line, beyond the upper end as at
/// the end.
pub(super) fn between(points: &[(f64, f64)], level: f64) -> f64 {
    let above = points.partition_point(|point| point.0 <= level);
    match (points, above.checked_sub(1)) {
        ([], _) => f64::NEG_INFINITY,
        ([only], _) => only.1,
        (_, Some(last)) if above == points.len() => points[last].1,
        _ => {
            let (low, high) = (points[above.max(1) - 1], points[above.max(1)]);
            low.1 + (high.1 - low.1) * (level - low.0) / (high.0 - low.0)
        }
    }
}

/// The binary logarithm of the value along a branch at a level; `None` without a value above 0.
pub(super) fn along(branch: &[(f64, f64)], level: f64) -> Option<f64> {
    let points = logarithms(branch);
    (!points.is_empty()).then(|| between(&points, level))
}
