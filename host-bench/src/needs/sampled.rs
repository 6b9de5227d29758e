//! Several runs of a scene whose motion is chaotic: their base accelerations differ by less than matters.
//!
//! The mean power of one window of such a scene is a random number. What a part changes is the change of its mean over
//! runs, and the scatter of the runs says how well that is known. More runs are added until the change is clearly within
//! the accuracy or clearly above it.

use rayon::prelude::*;

use super::cycles::run_cycles;
use crate::method::{Failure, Options};
use crate::outcome::Outcome;
use crate::scene_file::Scene;
use crate::seeds::student::quantile;
use crate::shift::shaken;

/// Relative distance of the base accelerations of two neighbouring runs over the accuracy. The powers of the outermost of
/// [`MOST_RUNS`] differ by a tenth of the accuracy, as much in one direction as in the other.
const DISTANCE: f64 = 1e-4;
/// Fewest and most runs, and most steps of all of them but the fewest.
pub(super) const FEWEST_RUNS: usize = 4;
const MOST_RUNS: usize = 512;
const MOST_STEPS: u64 = 1 << 26;
/// Part of the variance of independent runs below which that of the differences is no chance: of four runs in one of a
/// thousand cases.
const IN_COMMON: f64 = 0.01;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Runs of one scene by the same options.
pub(super) struct Sampled<'a> {
    scene: &'a Scene,
    options: Options,
    accuracy: f64,
    pub(super) runs: Vec<Outcome>,
}

impl<'a> Sampled<'a> {
    /// The runs after the first, which is that of the scene itself, are to come.
    pub(super) fn new(scene: &'a Scene, options: &Options, accuracy: f64, first: Outcome) -> Self {
        Self { scene, options: *options, accuracy, runs: vec![first] }
    }

    /// The most runs, by the steps of the first.
    pub(super) fn most_runs(&self) -> usize {
        let steps = self.runs.first().map_or(1, |run| (run.steps + run.rejected_steps).max(1));
        usize::try_from(MOST_STEPS / steps).unwrap_or(MOST_RUNS).clamp(FEWEST_RUNS, MOST_RUNS)
    }

    /// The first runs, of which there are at least `count`.
    pub(super) fn first(&self, count: usize) -> &[Outcome] {
        self.runs.get(..count).unwrap_or(&self.runs)
    }

    /// Adds runs up to a number of them.
    ///
    /// # Errors
    /// If one of them cannot be run.
    pub(super) fn grow(&mut self, count: usize) -> Result<(), Failure> {
        let (scene, options, accuracy) = (self.scene, &self.options, self.accuracy);
        let more: Result<Vec<Outcome>, Failure> = (self.runs.len()..count)
            .into_par_iter()
            .map(|index| {
                let shift = DISTANCE * accuracy * place(index);
                // A base at rest has no runs that differ.
                shaken(scene, shift)
                    .map_or_else(|| run_cycles(scene, options), |other| run_cycles(&other, options))
            })
            .collect();
        self.runs.extend(more?);
        Ok(())
    }
}

/// The places of the runs: 0, 1, −1, 2, −2, …
fn place(index: usize) -> f64 {
    let distance = index.div_ceil(2) as f64;
    if index % 2 == 1 { distance } else { -distance }
}

/// The mean of values; not-a-number of none.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance of the mean of some values, 0 of a single one, which then is known.
fn variance_of_mean(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    if values.len() < 2 { 0.0 } else { squares / (count * (count - 1.0)) }
}

/// The standard deviation of values over the magnitude of their mean; 0 of a single one.
pub(super) fn relative_deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    (variance_of_mean(values) * values.len() as f64).sqrt() / mean(values).abs()
}

/// The relative change from the mean of `full` to that of `runs`, and half its 95 % interval by Student's t. Where runs at
/// the same places have most of their scatter in common, they are compared with each other: it cancels. `None` where both
/// means are 0.
pub(super) fn change(full: &[f64], runs: &[f64]) -> Option<[f64; 2]> {
    let apart = Apart::of(full, runs)?;
    let alike = full.get(..runs.len()).filter(|_| runs.len() > 1).and_then(|full| {
        let ratio = mean(runs) / mean(full);
        let differences: Vec<f64> = full.iter().zip(runs).map(|(full, run)| run - ratio * full).collect();
        let variance = variance_of_mean(&differences);
        (variance < IN_COMMON * apart.variance).then_some(Apart { variance, ..Apart::of(full, runs)? })
    });
    Some(alike.unwrap_or(apart).with_interval())
}

/// Two means.
struct Apart {
    from: f64,
    to: f64,
    /// Variance of the second less its ratio to the first times the first.
    variance: f64,
    /// The smaller number of runs of the two that scatter; `None` if none does.
    count: Option<usize>,
}

impl Apart {
    /// Of independent runs; `None` if both means are 0.
    fn of(full: &[f64], runs: &[f64]) -> Option<Self> {
        let (from, to) = (mean(full), mean(runs));
        let variance = variance_of_mean(runs) + (to / from).powi(2) * variance_of_mean(full);
        let count = [full.len(), runs.len()].into_iter().filter(|count| *count > 1).min();
        (from != 0.0 || to != 0.0).then_some(Self { from, to, variance, count })
    }

    fn with_interval(&self) -> [f64; 2] {
        if self.from == 0.0 {
            return [f64::INFINITY, 0.0];
        }
        let freedom = self.count.map(|count| u32::try_from(count - 1).unwrap_or(u32::MAX));
        let t = freedom.map_or(0.0, |freedom| quantile(freedom, CONFIDENCE));
        [self.to / self.from - 1.0, t * self.variance.sqrt() / self.from.abs()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_as_far_to_one_side_as_to_the_other() {
        assert_eq!([0, 1, 2, 3, 4].map(place), [0.0, 1.0, -1.0, 2.0, -2.0]);
    }

    #[test]
    fn what_two_samples_have_in_common_is_no_scatter_of_their_change() {
        let full = [1.0, 1.1, 0.9, 1.05, 0.95];
        let doubled = full.map(|value| 2.0 * value);
        let [ratio, error] = change(&full, &doubled[..4]).expect("a change");
        assert!((ratio - 1.0).abs() < 1e-15 && error < 1e-15, "{ratio} {error}");
        let [ratio, error] = change(&full[..1], &doubled).expect("a change");
        // By hand: mean 2, variance of the mean (0 + 0.04 + 0.04 + 0.01 + 0.01) / 20, t of 4 degrees of freedom 2.776.
        assert!((ratio - 1.0).abs() < 1e-15, "{ratio}");
        assert!((error - 2.776_445 * 0.005_f64.sqrt()).abs() < 1e-6, "{error}");
    }

    #[test]
    fn an_interval_holds_the_change_of_the_means_in_nineteen_of_twenty_cases() {
        // Uniform numbers of a linear congruence, sums of twelve of them, almost Gaussian.
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut sample = |mean: f64, count: usize| -> Vec<f64> {
            let mut one = || mean + 0.05 * (0..12).map(|_| uniform()).sum::<f64>();
            (0..count).map(|_| one()).collect()
        };
        for [full, runs] in [[8, 8], [16, 4], [4, 16], [1, 8]] {
            let cases = 2000;
            let held = (0..cases).filter(|_| {
                let exact = vec![1.0];
                let full = if full == 1 { exact } else { sample(1.0, full) };
                let [ratio, error] = change(&full, &sample(1.02, runs)).expect("a change");
                (ratio - 0.02).abs() <= error
            });
            // Three standard errors of such a count are 30; fewer degrees of freedom than there are make the interval wider.
            let held = held.count();
            assert!((1870..=1990).contains(&held), "{full} {runs}: {held}");
        }
    }
}
