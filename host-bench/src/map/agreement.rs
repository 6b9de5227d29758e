//! How well a map agrees with the full model at random places: errors, regimes, and the bounds that follow.

use model_core::energy::Response;
use model_core::energy::response_map::{Bounded, Branch};

use super::axes::{Axes, amplitude_of, level_of};
use super::column::BEYOND;
use crate::embedded::AmplitudeContinuation;
use crate::method::Failure;
use crate::stability::random::Source;

/// The largest error found in a part and in those beside it, times this, is the bound.
pub(super) const ALLOWANCE: f64 = 1.25;
/// The least and the largest margin beside a boundary, in levels: 1 % and 10 % of the amplitude.
const MARGINS: [f64; 2] = [29.4, 281.6];
/// Distance in levels from a boundary beyond which the regime should be right: 10 % of the amplitude.
const NEAR_A_BOUNDARY: f64 = 281.6;

/// A place with the steady motions there and what the map says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    pub place: OperatingPoint,
    pub truth: Truth,
    pub predicted: Response,
    /// Relative errors of the values for the lower and the upper motion, where both map and model have it.
    pub errors: [Option<f64>; 2],
    /// Whether the motions of the map are those of the model.
    pub regime: bool,
    /// Whether the place is more than 10 % of the amplitude from both boundaries.
    pub is_far: bool,
    /// Whether the value of every motion that there is lies within the bounds of the map.
    pub holds: bool,
}

impl Judged {
    /// The larger error.
    pub fn error(&self) -> Option<f64> {
        self.errors.into_iter().flatten().reduce(f64::max)
    }
}

/// The agreement over many places.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Agreement {
    /// Places by which the bounds were measured, and as many that check them.
    pub places: usize,
    /// Median of the relative error.
    pub median: f64,
    /// 90th percentile of the relative error.
    pub percentile_90: f64,
    pub largest: f64,
    /// Share of the places at which the bounds hold.
    pub bounds_hold: f64,
    /// Share of the places more than 10 % of the amplitude from a boundary at which the map has the motions that there are.
    pub regime_right: f64,
    /// Number of those places.
    pub far_places: usize,
    /// Median of the ratio of the upper to the lower bound, where the lower one is above 0; infinite if it is nowhere.
    pub median_bounds_ratio: f64,
}

impl Agreement {
    /// Of the places that check a map; `None` if none of them has an output power, so that there is no error.
    pub(super) fn of(checked: &[Judged]) -> Option<Self> {
        let mut errors: Vec<f64> = checked.iter().flat_map(|judged| judged.errors).flatten().collect();
        errors.sort_by(f64::total_cmp);
        let mut ratios: Vec<f64> = checked
            .iter()
            .filter_map(|judged| judged.predicted.income())
            .filter(|income| income.low > 0.0)
            .map(|income| f64::from(income.high / income.low))
            .collect();
        ratios.sort_by(f64::total_cmp);
        let at = |sorted: &[f64], part: f64| {
            sorted.get(((sorted.len() as f64 * part) as usize).min(sorted.len().saturating_sub(1))).copied()
        };
        let share = |of: &[&Judged], has: fn(&Judged) -> bool| {
            of.iter().filter(|judged| has(judged)).count() as f64 / of.len().max(1) as f64
        };
        let all: Vec<&Judged> = checked.iter().collect();
        let far: Vec<&Judged> = checked.iter().filter(|judged| judged.is_far).collect();
        Some(Self {
            places: checked.len(),
            median: at(&errors, 0.5)?,
            percentile_90: at(&errors, 0.9)?,
            largest: at(&errors, 1.0)?,
            bounds_hold: share(&all, |judged| judged.holds),
            regime_right: share(&far, |judged| judged.regime),
            far_places: far.len(),
            median_bounds_ratio: at(&ratios, 0.5).unwrap_or(f64::INFINITY),
        })
    }
}

/// The value of each motion; `None` of one that the map does not have.
pub(super) fn predicted_of(predicted: &Response) -> [Option<Bounded>; 2] {
    match *predicted {
        Response::One { branch: Branch::Lower, income } => [Some(income), None],
        Response::One { branch: Branch::Upper, income } => [None, Some(income)],
        Response::Two { lower, upper } => [Some(lower), Some(upper)],
        Response::Outside(_) => [None, None],
    }
}

/// Compares the values of a map with the steady motions; `boundaries` are the levels of both boundaries there.
pub(super) fn judge(
    predicted: Response,
    boundaries: [f64; 2],
    place: OperatingPoint,
    truth: Truth,
) -> Judged {
    let of = predicted_of(&predicted);
    let there = [truth.lower, truth.upper];
    let error = |index: usize| match (of[index], there[index]) {
        (Some(predicted), Some(truth)) if truth > 0.0 => {
            Some((f64::from(predicted.value) / truth - 1.0).abs())
        }
        // The whole value is wrong.
        (Some(predicted), Some(_)) if predicted.value > 0.0 => Some(1.0),
        _ => None,
    };
    let overall = predicted.income();
    let within = |index: usize| match (of[index].or(overall), there[index]) {
        (Some(predicted), Some(truth)) => {
            (f64::from(predicted.low)..=f64::from(predicted.high)).contains(&truth)
        }
        (None, Some(_)) => false,
        (_, None) => true,
    };
    let at = level_of(place.amplitude);
    Judged {
        place,
        truth,
        predicted,
        errors: [error(0), error(1)],
        regime: (0..2).all(|index| of[index].is_some() == there[index].is_some()),
        is_far: boundaries.iter().all(|boundary| (at - boundary).abs() > NEAR_A_BOUNDARY),
        holds: within(0) && within(1),
    }
}

/// The margin beside the boundaries, in levels: the farthest at which the regime is not as they say, at most [`MARGINS`].
pub(super) fn margin(measured: &[(OperatingPoint, Truth, [f64; 2])]) -> f64 {
    let farthest = measured
        .iter()
        .map(|(place, truth, [rising, falling])| {
            let at = level_of(place.amplitude);
            // By how much a boundary lies on the wrong side of the place.
            let lower = if truth.lower.is_some() == (at <= *rising) { 0.0 } else { (at - rising).abs() };
            let upper = if truth.upper.is_some() == (at >= *falling) { 0.0 } else { (at - falling).abs() };
            lower.max(upper)
        })
        .fold(0.0, f64::max);
    (ALLOWANCE * farthest).clamp(MARGINS[0], MARGINS[1])
}

/// Ratio of an amplitude to the next on the way to the place, in levels: a quarter of an octave.
const STEP: f64 = 512.0;
/// How far below the place the rising way begins: two octaves. A motion from rest overshoots to twice its amplitude.
const BELOW: f64 = 2.0 * 2048.0;

/// A place of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    pub slice: usize,
    pub frequency_hz: f64,
    /// In m/s².
    pub amplitude: f64,
}

/// The steady motions at a place: what each gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
}

/// Places with uniform detuning and logarithm of the amplitude.
pub(super) fn random(axes: &Axes, slices: usize, seed: u64, count: usize) -> Vec<OperatingPoint> {
    (0..count)
        .map(|number| {
            let mut source = Source::new(seed, number as u64);
            let frequency_hz = axes.frequency(source.uniform(0.0, 1.0));
            let amplitude = source.logarithmic(axes.amplitudes[0], axes.amplitudes[1]);
            // As a node has them.
            let [frequency_hz, amplitude] = [frequency_hz, amplitude].map(|number| f64::from(number as f32));
            OperatingPoint { slice: number % slices, frequency_hz, amplitude }
        })
        .collect()
}

/// The steady motions at a place: through rising amplitudes from rest, and through falling ones from `above`, a level at
/// which there is the upper motion only.
pub(super) fn truth(
    continuation: &mut dyn AmplitudeContinuation,
    place: &OperatingPoint,
    above: f64,
) -> Result<Truth, Failure> {
    let at = level_of(place.amplitude);
    continuation.rest();
    let mut rising = None;
    let mut level = at - BELOW;
    while level < at + 0.5 * STEP {
        let amplitude = if (level - at).abs() < 1e-6 { place.amplitude } else { amplitude_of(level) };
        let motion = continuation.settle(amplitude)?;
        rising = Some(motion);
        level += STEP;
    }
    let mut top = above.max(at) + STEP;
    if rising.is_none_or(|motion| !motion.is_upper) {
        continuation.rest();
        let mut motion = continuation.settle(amplitude_of(top))?;
        if !motion.is_upper {
            top += BEYOND;
            motion = continuation.settle(amplitude_of(top))?;
        }
        let mut level = top;
        // Whole steps end at the place.
        while motion.is_upper && level > at + 1e-6 {
            let steps = ((level - at) / STEP).ceil();
            level -= (level - at) / steps;
            let amplitude = if level - at < 1e-6 { place.amplitude } else { amplitude_of(level) };
            motion = continuation.settle(amplitude)?;
        }
        return Ok(Truth {
            lower: rising.map(|motion| motion.value),
            upper: motion.is_upper.then_some(motion.value),
        });
    }
    Ok(Truth { lower: None, upper: rising.map(|motion| motion.value) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(branch: Branch, value: f32) -> Response {
        Response::One { branch, income: Bounded { value, low: 0.9 * value, high: 1.2 * value } }
    }

    #[test]
    fn a_place_is_judged_by_every_motion_there() {
        let place = OperatingPoint { slice: 0, frequency_hz: 20.0, amplitude: 1.0 };
        let at = level_of(1.0);
        let far = [at + 500.0, at + 400.0];
        let judged = judge(one(Branch::Lower, 2.0), far, place, Truth { lower: Some(1.9), upper: None });
        assert!(judged.regime && judged.holds && judged.is_far);
        assert!((judged.error().unwrap_or(0.0) - 0.1 / 1.9).abs() < 1e-6);
        // Another motion that the map does not have.
        let judged = judge(one(Branch::Lower, 2.0), far, place, Truth { lower: Some(1.9), upper: Some(9.0) });
        assert!(!judged.regime && !judged.holds);
        // The other motion only: wrong, and within the bounds by chance.
        let judged = judge(one(Branch::Lower, 2.0), far, place, Truth { lower: None, upper: Some(2.1) });
        assert!(!judged.regime && judged.holds && judged.error().is_none());
        let near = [at + 100.0, at + 400.0];
        let judged = judge(one(Branch::Upper, 2.0), near, place, Truth { lower: None, upper: Some(3.0) });
        assert!(judged.regime && !judged.holds && !judged.is_far);
    }

    #[test]
    fn a_map_without_output_agrees_with_nothing() {
        let place = OperatingPoint { slice: 0, frequency_hz: 20.0, amplitude: 1.0 };
        let far = [level_of(1.0) + 500.0; 2];
        let judged = |predicted, truth| judge(one(Branch::Lower, predicted), far, place, truth);
        // A slider that sticks: the model gives no power, and the map says so.
        let stuck = judged(0.0, Truth { lower: Some(0.0), upper: None });
        assert!(stuck.holds && stuck.regime);
        assert_eq!(Agreement::of(&[stuck; 30]), None);
        let moving = judged(2.0, Truth { lower: Some(1.9), upper: None });
        let found = Agreement::of(&[stuck, moving]).expect("an error");
        assert_eq!((found.places, found.median), (2, moving.error().unwrap_or(0.0)));
    }
}
