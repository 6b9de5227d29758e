//! The steady motions at one frequency, through rising, then through falling amplitudes, and the node values fitted to them.

use super::axes::{amplitude_of, level_of};
use crate::embedded::{AmplitudeContinuation, Motion, MotionKind};
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
#[derive(Debug, Clone, PartialEq, Default)]
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
    fn new(continuation: &mut dyn AmplitudeContinuation, level: f64, motion: Motion) -> Self {
        Self { level, motion, state: continuation.keep() }
    }
}

/// Adds points between two of one motion, in the direction of the way, until the logarithm of its value is straight between
/// them. The state is then one of these points.
fn refine(
    continuation: &mut dyn AmplitudeContinuation,
    [from, to]: [Point; 2],
    halvings: u32,
    values: &mut Vec<(f64, f64)>,
) -> Result<(), Failure> {
    let ends = [from, to].map(|end| end.motion.value);
    if halvings == 0 || ends == [0.0; 2] {
        return Ok(());
    }
    continuation.go_back(from.state);
    let level = 0.5 * (from.level + to.level);
    let motion = continuation.settle(amplitude_of(level))?;
    if motion.is_upper != from.motion.is_upper {
        return Ok(());
    }
    values.push((level, motion.value));
    let middle = Point::new(continuation, level, motion);
    // Without an output power at an end this is not finite.
    let off = motion.value.log2() - 0.5 * (ends[0].log2() + ends[1].log2());
    if off.abs() < STRAIGHT {
        return Ok(());
    }
    refine(continuation, [from, middle], halvings - 1, values)?;
    refine(continuation, [middle, to], halvings - 1, values)
}

/// How often a step to a point is halved: not beyond the map.
fn halvings(point: Point, [lowest, highest]: [f64; 2]) -> u32 {
    let is_inside = (lowest - STEP..=highest + STEP).contains(&point.level);
    if is_inside { HALVINGS[usize::from(point.motion.found == MotionKind::Mean)] } else { 0 }
}

pub(super) fn column(
    continuation: &mut dyn AmplitudeContinuation,
    frequency_hz: f64,
    amplitudes: [f64; 2],
) -> Result<Column, Failure> {
    let [lowest, highest] = amplitudes.map(level_of);
    let (floor, cap) = (lowest - BEYOND, highest + BEYOND);
    let mut column = Column { frequency_hz, rising: cap, falling: cap, ..Column::default() };
    let (mut steps, mut steps_down) = (Vec::new(), Vec::new());
    let left = rise(continuation, [floor, cap], &mut steps, &mut column.lower)?;
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
        continuation.rest();
    }
    // To above the map, or to the amplitude at which the upper motion was reached.
    let top = highest.max(column.rising) + STEP;
    let mut end = None;
    loop {
        let motion = continuation.settle(amplitude_of(level))?;
        // Next to the boundary a motion may have contact at one amplitude and none at the next.
        if motion.is_upper {
            column.upper.push((level, motion.value));
            end = Some(Point::new(continuation, level, motion));
        }
        if level >= top {
            break;
        }
        level = (level + STEP).min(top);
    }
    if let Some(end) = end {
        column.falling =
            fall(continuation, end, floor, &mut steps_down, &mut column.upper)?.min(column.rising);
        column.found = left.is_some() && column.rising > floor;
    }
    // After both ways, which these points must not change.
    let map = [lowest, highest];
    for (steps, values) in [(steps, &mut column.lower), (steps_down, &mut column.upper)] {
        for step in steps {
            refine(continuation, step, halvings(step[1], map), values)?;
        }
        values.sort_by(|one, other| one.0.total_cmp(&other.0));
        values.dedup_by(|one, other| (one.0 - other.0).abs() < 1e-6);
    }
    Ok(column)
}

/// Follows the lower motion from rest upwards: the level where it was seen last, and one where it was left. `None` if it is not.
fn rise(
    continuation: &mut dyn AmplitudeContinuation,
    [floor, cap]: [f64; 2],
    steps: &mut Vec<[Point; 2]>,
    values: &mut Vec<(f64, f64)>,
) -> Result<Option<[f64; 2]>, Failure> {
    continuation.rest();
    let mut level = floor;
    let mut last: Option<Point> = None;
    while level < cap + STEP {
        let at = level.min(cap);
        let motion = continuation.settle(amplitude_of(at))?;
        if motion.is_upper {
            let Some(mut good) = last else { return Ok(Some([floor, at])) };
            let mut bad = Point::new(continuation, at, motion);
            for _ in 0..BISECTIONS {
                continuation.go_back(good.state);
                let middle = 0.5 * (good.level + bad.level);
                let motion = continuation.settle(amplitude_of(middle))?;
                let middle = Point::new(continuation, middle, motion);
                if motion.is_upper {
                    bad = middle;
                } else {
                    values.push((middle.level, motion.value));
                    steps.push([good, middle]);
                    good = middle;
                }
            }
            continuation.go_back(bad.state);
            return Ok(Some([good.level, bad.level]));
        }
        values.push((at, motion.value));
        let point = Point::new(continuation, at, motion);
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
    continuation: &mut dyn AmplitudeContinuation,
    from: Point,
    floor: f64,
    steps: &mut Vec<[Point; 2]>,
    values: &mut Vec<(f64, f64)>,
) -> Result<f64, Failure> {
    let mut good = from;
    continuation.go_back(good.state);
    while good.level > floor {
        let mut bad = (good.level - STEP).max(floor);
        let motion = continuation.settle(amplitude_of(bad))?;
        if motion.is_upper {
            values.push((bad, motion.value));
            let point = Point::new(continuation, bad, motion);
            steps.push([good, point]);
            good = point;
            continue;
        }
        for _ in 0..BISECTIONS {
            continuation.go_back(good.state);
            let middle = 0.5 * (good.level + bad);
            let motion = continuation.settle(amplitude_of(middle))?;
            if motion.is_upper {
                values.push((middle, motion.value));
                let point = Point::new(continuation, middle, motion);
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

/// The value at a level: linear between the points, beyond the lower end along the first line, beyond the upper end as at the end.
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

// Node values fitted to all points along a branch.
//
// A node that takes the value of one point has all of its scatter where the motion is not periodic, and the chord between two
// nodes is off by the whole bend of the values between them. The fitted values are those whose chords have the least squares
// of the distances from the points' own chords, by the integral over the amplitude. Where the value is steep as at a threshold
// it counts less: a chord cannot follow it, and would be drawn off from the amplitudes beside it.

/// Levels between two places at which the distances are taken.
const GRID: f64 = 16.0;
/// Weight of the value by the points at a node itself, for nodes that no point is beside.
const OWN: f64 = 1e-3;
/// Octaves of the value in an octave of the amplitude from which it is steep: twice those of a linear harvester.
const STEEP: f64 = 4.0;
/// Octaves below the largest value of a branch that is nothing, as in an image.
const NOTHING: f64 = 32.0;

/// Values at nodes of rising level, fitted to the binary logarithms of the values along a branch up to the level `end`.
pub(super) fn fitted(branch: &[(f64, f64)], nodes: &[f64], end: f64) -> Option<Vec<f64>> {
    let points = logarithms(branch);
    let (first, last) = (points.first()?.0, points.last()?.0.min(end));
    let floor = points.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max) - NOTHING;
    let value = |level: f64| between(&points, level).max(floor);
    // The normal equations: a symmetric matrix with three diagonals, and the right side.
    let (mut diagonal, mut beside) = (vec![OWN; nodes.len()], vec![0.0; nodes.len()]);
    let mut right: Vec<f64> = nodes.iter().map(|&node| OWN * value(node)).collect();
    for (cell, pair) in nodes.windows(2).enumerate() {
        let width = pair[1] - pair[0];
        let count = (width / GRID).ceil();
        for index in 0..count as usize {
            let part = (index as f64 + 0.5) / count;
            let level = pair[0] + part * width;
            if !(first..=last).contains(&level) {
                continue;
            }
            let slope = (value(level + GRID) - value(level - GRID)) / (2.0 * GRID) * 2048.0;
            let weight = width / count / GRID / (1.0 + (slope / STEEP).powi(2));
            diagonal[cell] += weight * (1.0 - part).powi(2);
            diagonal[cell + 1] += weight * part.powi(2);
            beside[cell] += weight * part * (1.0 - part);
            right[cell] += weight * (1.0 - part) * value(level);
            right[cell + 1] += weight * part * value(level);
        }
    }
    for index in 1..nodes.len() {
        let factor = beside[index - 1] / diagonal[index - 1];
        diagonal[index] -= factor * beside[index - 1];
        right[index] -= factor * right[index - 1];
    }
    let mut values = vec![0.0; nodes.len()];
    let mut above = 0.0;
    for index in (0..nodes.len()).rev() {
        above = (right[index] - beside[index] * above) / diagonal[index];
        values[index] = above;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::along;
    use super::*;

    const NODES: [f64; 5] = [1000.0, 1100.0, 1300.0, 1700.0, 2500.0];

    #[test]
    fn chords_between_the_nodes_are_met() {
        let values = [-30.0_f64, -28.0, -27.5, -24.0, -23.0];
        let points: Vec<(f64, f64)> =
            NODES.into_iter().zip(values).map(|(level, value)| (level, value.exp2())).collect();
        let found = fitted(&points, &NODES, 1e9).expect("values above 0");
        for (found, expected) in found.iter().zip(values) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn scatter_from_point_to_point_averages_out() {
        // A power law, every second point 20 % above and every other 20 % below it.
        let exact = |level: f64| level / 1024.0 - 30.0;
        let points: Vec<(f64, f64)> = (0..101)
            .map(|index| {
                let level = 1000.0 + 15.0 * f64::from(index);
                (level, exact(level).exp2() * if index % 2 == 0 { 1.2 } else { 1.0 / 1.2 })
            })
            .collect();
        let found = fitted(&points, &NODES, 1e9).expect("values above 0");
        for (index, (&level, found)) in NODES.iter().zip(&found).enumerate() {
            let own = (along(&points, level).expect("a value") - exact(level)).abs();
            let off = (found - exact(level)).abs();
            assert!(off < 0.12, "{level}: {off}");
            assert!(index == 0 || off < 0.6 * own || own < 0.1, "{level}: {off} {own}");
        }
    }

    #[test]
    fn nodes_beyond_the_points_have_the_value_at_their_end() {
        let points = [(1000.0, 1.0), (1200.0, 1.0)];
        let found = fitted(&points, &NODES, 1150.0).expect("values above 0");
        assert!(found.iter().all(|value| value.abs() < 1e-9), "{found:?}");
        assert_eq!(fitted(&[(1000.0, 0.0)], &NODES, 1e9), None);
    }
}
