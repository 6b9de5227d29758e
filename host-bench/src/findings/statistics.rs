//! Statistics of sampled signals, and extremes over a grid.

use harvester_scene::root::lowest_point;

use crate::method::Failure;

/// The point of the least `of` among those of a grid and those that `at` measures beside the least of these, at places that are found to
/// the part `within`; and whether it is inside: at an end of the grid there may be a lower one beyond.
pub(super) fn least<P: Copy>(
    points: &[P],
    place: impl Fn(usize) -> f64,
    at: impl Fn(f64) -> Result<P, Failure>,
    of: impl Fn(&P) -> f64,
    within: f64,
) -> Result<(P, bool), Failure> {
    let last = points.len() - 1;
    let inner = (0..=last).min_by(|one, other| of(&points[*one]).total_cmp(&of(&points[*other])));
    let lowest = inner.unwrap_or(0);
    let range = [lowest.saturating_sub(1), last.min(lowest + 1)].map(place);
    let between = at(lowest_point(|place| at(place).map(|point| of(&point)), range, within)?)?;
    let is_between = of(&between) < of(&points[lowest]);
    Ok((if is_between { between } else { points[lowest] }, is_between || (1..last).contains(&lowest)))
}

pub(super) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value * value)).sqrt()
}

/// Mean; not-a-number of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Largest value; not-a-number of nothing, or if a value is.
pub(super) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    extreme(values, f64::max)
}

/// Smallest value; not-a-number of nothing, or if a value is.
pub(super) fn smallest(values: impl Iterator<Item = f64>) -> f64 {
    extreme(values, f64::min)
}

fn extreme(values: impl Iterator<Item = f64>, pick: fn(f64, f64) -> f64) -> f64 {
    // `f64::max` and `f64::min` ignore a not-a-number.
    let or_nan =
        |one: f64, other: f64| if one.is_nan() || other.is_nan() { f64::NAN } else { pick(one, other) };
    values.reduce(or_nan).unwrap_or(f64::NAN)
}

/// Largest less smallest value; not-a-number of nothing, or if a value is.
pub(super) fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    largest(values.clone()) - smallest(values)
}

/// The middle value; not-a-number of nothing.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Pearson's coefficient of correlation.
pub(super) fn correlation(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let [one, other] = [mean(pairs.clone().map(|pair| pair.0)), mean(pairs.clone().map(|pair| pair.1))];
    let moment = |product: fn(f64, f64) -> f64| mean(pairs.clone().map(|(x, y)| product(x - one, y - other)));
    moment(|x, y| x * y) / (moment(|x, _| x * x) * moment(|_, y| y * y)).sqrt()
}

/// Part of the power of a signal, without its mean, above a frequency in Hz: by the discrete Fourier transform of
/// samples every `every_s` seconds over a whole number of periods.
pub(super) fn share_above(samples: &[f64], every_s: f64, frequency_hz: f64) -> f64 {
    let count = samples.len() as f64;
    let average = mean(samples.iter().copied());
    let power = mean(samples.iter().map(|sample| (sample - average).powi(2)));
    let lines = (frequency_hz * count * every_s).floor() as u32;
    let below: f64 = (1..=lines)
        .map(|line| {
            // Goertzel's recurrence.
            let turn = std::f64::consts::TAU * f64::from(line) / count;
            let factor = 2.0 * turn.cos();
            let [last, before] = samples
                .iter()
                .fold([0.0, 0.0], |[last, before], sample| [sample - average + factor * last - before, last]);
            let square = last * last + before * before - factor * last * before;
            2.0 * square / (count * count)
        })
        .sum();
    (1.0 - below / power).abs()
}
