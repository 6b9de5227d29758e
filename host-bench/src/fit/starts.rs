//! Further starts, spread without chance, with the resonance where the data have theirs; and the free start of a ring-down.

use super::data::{Data, Rows};
use super::free::{Free, Place};
use super::model::{Interpolation, Problem, displace, origin, record, with_trace};
use crate::embedded::natural_frequency_hz;
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::scene_file::{Scene, Summary};

/// Largest distance of a start from the first one in logarithms, where no bounds are given: a factor of four.
const SPREAD: f64 = 1.386_294_361_119_890_6;
/// The same within bounds that are given: a factor of thirty.
const WIDEST: f64 = 3.4;
/// Least change of the logarithm of the natural frequency by that of a key that moves it.
const MOVES: f64 = 0.05;
/// Natural frequencies to try, relative to that of the largest response: an impact raises the frequency of a wide motion.
const RELATIVE: [f64; 4] = [1.0, 0.97, 0.92, 1.03];

/// The first `count` starts after the given one.
pub(crate) fn starts(problem: &Problem<'_>, start: &[f64], count: usize) -> Vec<Vec<f64>> {
    let mover = mover(problem, start);
    let target = problem.data.iter().find_map(frequency_of_peak);
    let mut all: Vec<Vec<f64>> = Vec::new();
    for number in 0..count {
        let mut at: Vec<f64> = start.to_vec();
        // The first few keep all else as it is.
        if number >= RELATIVE.len() {
            for (index, (coordinate, free)) in at.iter_mut().zip(&problem.free).enumerate() {
                let [low, high] = range(free, *coordinate);
                *coordinate = low + (high - low) * halton(number + 1 - RELATIVE.len(), index);
            }
        }
        match (mover, target) {
            // Every fourth of the others is left as it is drawn.
            (Some(index), Some(target)) if number < RELATIVE.len() || number % 4 != 0 => {
                align(problem, &mut at, index, target * RELATIVE[number % RELATIVE.len()]);
            }
            _ if number < RELATIVE.len() => continue,
            _ => {}
        }
        all.push(at);
    }
    all
}

/// The ends between which a coordinate is spread.
fn range(free: &Free, start: f64) -> [f64; 2] {
    let [low, high] = free.ends();
    let reach = match (free.place, free.unit, free.is_bounded) {
        // It is read off the data.
        (Place::StartOf(_), ..) => 0.1,
        (_, None, false) => SPREAD,
        (_, None, true) => WIDEST,
        (_, Some(_), false) => 1.0,
        (_, Some(_), true) => f64::INFINITY,
    };
    [low.max(start - reach), high.min(start + reach)]
}

/// The free number that moves the natural frequency most.
fn mover(problem: &Problem<'_>, start: &[f64]) -> Option<usize> {
    const CHANGE: f64 = 0.01;
    let frequency = |at: &[f64]| natural_frequency_hz(&problem.scene(at).ok()?).ok();
    let base = frequency(start)?;
    let moved = (0..start.len()).filter(|&index| problem.free[index].unit.is_none()).filter_map(|index| {
        let mut beside = start.to_vec();
        beside[index] += CHANGE;
        let slope = (frequency(&beside)? / base).ln().abs() / CHANGE;
        (slope > MOVES).then_some((index, slope))
    });
    moved.max_by(|one, other| one.1.total_cmp(&other.1)).map(|(index, _)| index)
}

/// Moves one coordinate until the natural frequency is `target`, as far as its bounds allow.
fn align(problem: &Problem<'_>, at: &mut [f64], index: usize, target: f64) {
    let [low, high] = problem.free[index].ends();
    let frequency = |at: &[f64]| Some(natural_frequency_hz(&problem.scene(at).ok()?).ok()?.ln());
    for _ in 0..6 {
        let Some(now) = frequency(at) else { return };
        let before = at[index];
        at[index] += 1e-3;
        let Some(beside) = frequency(at) else { return };
        let step = (target.ln() - now) * 1e-3 / (beside - now);
        at[index] = before + if step.is_finite() { step.clamp(-1.0, 1.0) } else { 0.0 };
        at[index] = at[index].clamp(low, high);
    }
}

/// The frequency of the largest response of a sweep, or of the free motion of a ring-down, in Hz.
pub(crate) fn frequency_of_peak(data: &Data) -> Option<f64> {
    let column = data.columns.iter().find(|column| column.name != "voltage_v").or(data.columns.first())?;
    match &data.rows {
        Rows::Sweep(rows) => {
            let largest = (0..rows.len()).max_by(|&a, &b| column.values[a].total_cmp(&column.values[b]))?;
            Some(rows[largest].frequency_hz)
        }
        Rows::Trace { spacing_s, acceleration: None } => {
            // From the first to the last rise through the mean.
            let mean = column.values.iter().sum::<f64>() / column.values.len() as f64;
            let rises: Vec<f64> = column
                .values
                .windows(2)
                .enumerate()
                .filter(|(_, pair)| pair[0] < mean && pair[1] >= mean)
                .map(|(index, pair)| index as f64 + (mean - pair[0]) / (pair[1] - pair[0]))
                .collect();
            let ([first, .., last], count) = (&rises[..], rises.len()) else { return None };
            Some((count - 1) as f64 / ((last - first) * spacing_s))
        }
        Rows::Trace { acceleration: Some(_), .. } => None,
    }
}

/// The radical inverse of a number in the prime with an index: J. H. Halton, Numer. Math. 2 (1960) 84.
fn halton(number: usize, index: usize) -> f64 {
    const PRIMES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    let base = PRIMES[index % PRIMES.len()];
    let (mut rest, mut part, mut value) = (number, 1.0, 0.0);
    while rest > 0 {
        part /= base as f64;
        value += part * (rest % base) as f64;
        rest /= base;
    }
    value
}

/// Displacement of the first mode in √kg·m by which its displacement at the tip is measured.
const PROBE: f64 = 1e-6;
/// Displacement of the tip in m that a ring-down without a displacement begins with.
const TIP: f64 = 1e-4;
/// Factor from the start to the bounds.
const FARTHEST: f64 = 20.0;

/// Adds the displacement at the start of each ring-down, unless a displacement at the start is free already.
pub(super) fn free_starts(
    scene: &Scene,
    data: &[Data],
    options: &Options,
    free: &mut Vec<Free>,
) -> Result<(), Failure> {
    const KEYS: [&str; 4] = [
        "initial.gap_m",
        "initial.displacement_m",
        "initial.modal_displacement",
        "initial.rod_modal_displacement",
    ];
    if free.iter().any(|free| KEYS.iter().any(|key| free.name.starts_with(key))) {
        return Ok(());
    }
    let count = data.iter().filter(|data| data.is_ring_down()).count();
    let key = scene.model.summary().start_key;
    for (index, data) in data.iter().enumerate().filter(|(_, data)| data.is_ring_down()) {
        let start = start(scene, data, options)?;
        let of_file = Name::of_file(&data.file).line();
        let is_gap = scene.contact_separation().is_ok();
        let reach = FARTHEST * start.abs();
        free.push(Free {
            name: if count == 1 { key.to_owned() } else { format!("{key} of {of_file}") },
            place: Place::StartOf(index),
            start,
            low: if is_gap { 0.0 } else { -reach },
            high: reach,
            is_bounded: false,
            unit: Some(start.abs()),
        });
    }
    Ok(())
}

/// The first displacement of the data as the scene has it.
fn start(scene: &Scene, data: &Data, options: &Options) -> Result<f64, Failure> {
    let column = data.columns.iter().find(|column| column.name != "voltage_v");
    let first = column.and_then(|column| column.values.first()).copied();
    let with_default = |value: f64, default: f64| if value == 0.0 { default } else { value };
    if scene.bump_stop().is_err() {
        let Summary { rest_m, length_m, .. } = scene.model.summary();
        let usual = rest_m + 0.5 * length_m;
        return Ok(with_default(first.map_or(usual, |first| first + origin(scene, data)), usual));
    }
    let mut probed = with_trace(scene, data, Interpolation::Smooth);
    displace(&mut probed, PROBE);
    let tip = record(&probed, data, options)?.and_then(|rows| rows.first().map(|row| row[0]));
    let tip = tip.filter(|tip| *tip != 0.0).unwrap_or(PROBE);
    Ok(PROBE / tip * with_default(first.unwrap_or(TIP), TIP))
}

#[cfg(test)]
mod tests {
    use super::halton;

    #[test]
    fn the_sequence_fills_each_part_once() {
        // A little above, because a twenty-seventh has a rounding.
        let part = |number: usize| (halton(number, 1) * 27.0 + 1e-9) as usize;
        let mut parts: Vec<usize> = (1..=27).map(part).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..27).collect::<Vec<usize>>());
        assert_eq!([1, 2, 3].map(|number| halton(number, 0)), [0.5, 0.25, 0.75]);
    }
}
