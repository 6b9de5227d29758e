//! The steady motions at one frequency: through rising, then through falling amplitudes.

use super::axes::{amplitude_of, level_of};
use crate::embedded::Held;
use crate::method::Failure;

/// Ratio of an amplitude to the next, in levels: a fifth of an octave.
const STEP: f64 = 2048.0 / 5.0;
/// Bisections of a step in which a motion ends: to 0.2 % of the amplitude.
const BISECTIONS: u32 = 6;
/// How far beyond the map a boundary is sought, in levels: two octaves.
pub(super) const BEYOND: f64 = 2.0 * 2048.0;

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
    let left = rise(held, [floor, cap], &mut column.lower)?;
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
    loop {
        let motion = held.settle(amplitude_of(level))?;
        if !motion.is_upper {
            break;
        }
        column.upper.push((level, motion.value));
        if level >= top {
            break;
        }
        level = (level + STEP).min(top);
    }
    if column.upper.is_empty() {
        return Ok(column);
    }
    column.falling = fall(held, level, floor, &mut column.upper)?.min(column.rising);
    column.upper.sort_by(|one, other| one.0.total_cmp(&other.0));
    column.upper.dedup_by(|one, other| (one.0 - other.0).abs() < 1e-6);
    column.found = left.is_some() && column.rising > floor;
    Ok(column)
}

/// Follows the lower motion from rest upwards: the level at which it was seen last, and one at which it was left. `None` if
/// it is not left.
fn rise(
    held: &mut dyn Held,
    [floor, cap]: [f64; 2],
    values: &mut Vec<(f64, f64)>,
) -> Result<Option<[f64; 2]>, Failure> {
    held.rest();
    let mut level = floor;
    let mut last = None;
    while level < cap + STEP {
        let at = level.min(cap);
        let motion = held.settle(amplitude_of(at))?;
        if motion.is_upper {
            let Some((mut good, mut state)) = last else { return Ok(Some([floor, at])) };
            let mut bad = at;
            let mut upper = held.keep();
            for _ in 0..BISECTIONS {
                held.go_back(state);
                let middle = 0.5 * (good + bad);
                let motion = held.settle(amplitude_of(middle))?;
                if motion.is_upper {
                    (bad, upper) = (middle, held.keep());
                } else {
                    values.push((middle, motion.value));
                    (good, state) = (middle, held.keep());
                }
            }
            held.go_back(upper);
            return Ok(Some([good, bad]));
        }
        values.push((at, motion.value));
        last = Some((at, held.keep()));
        level += STEP;
    }
    Ok(None)
}

/// Follows the upper motion from its state at `level` downwards: the lowest level at which it was seen.
fn fall(held: &mut dyn Held, level: f64, floor: f64, values: &mut Vec<(f64, f64)>) -> Result<f64, Failure> {
    let (mut good, mut state) = (level, held.keep());
    while good > floor {
        let mut bad = (good - STEP).max(floor);
        let motion = held.settle(amplitude_of(bad))?;
        if motion.is_upper {
            values.push((bad, motion.value));
            (good, state) = (bad, held.keep());
            continue;
        }
        for _ in 0..BISECTIONS {
            held.go_back(state);
            let middle = 0.5 * (good + bad);
            let motion = held.settle(amplitude_of(middle))?;
            if motion.is_upper {
                values.push((middle, motion.value));
                (good, state) = (middle, held.keep());
            } else {
                bad = middle;
            }
        }
        return Ok(good);
    }
    Ok(good)
}

/// The binary logarithm of the value along a branch at a level: linear between its points, beyond its lower end along the
/// first line, beyond its upper end as at the end. `None` without a value above 0.
pub(super) fn along(branch: &[(f64, f64)], level: f64) -> Option<f64> {
    let points: Vec<(f64, f64)> =
        branch.iter().filter(|(_, value)| *value > 0.0).map(|&(at, value)| (at, value.log2())).collect();
    let (&first, &last) = (points.first()?, points.last()?);
    if level >= last.0 {
        return Some(last.1);
    }
    let above = points.iter().position(|point| point.0 > level)?.max(1);
    let (low, high) = match points[..] {
        [_] => return Some(first.1),
        _ => (points[above - 1], points[above]),
    };
    Some(low.1 + (high.1 - low.1) * (level - low.0) / (high.0 - low.0))
}
