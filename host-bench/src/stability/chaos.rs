//! Whether a motion is chaotic: runs from starts that are slightly displaced diverge, and statistics agree.

use rayon::prelude::*;

use super::exact::{Numbers, Quantity, relative, tighter};
use crate::method::Options;
use crate::outcome::standard_error_of_sum;
use crate::scene_file::Scene;
use crate::shift::{SHIFT, shifted};

/// Standard errors by which the statistics of two runs of a chaotic motion may differ: 3 in 1000 differ by more.
const STANDARD_ERRORS: f64 = 3.0;
/// Standard deviations of a few runs by which the largest motion of another may differ from their mean: by Student's
/// distribution with four degrees of freedom one in 100 differs by more.
const DEVIATIONS: f64 = 5.0;
/// Standard error of the difference over the mean above which the statistics are too uncertain to agree.
const MOST_UNCERTAIN: f64 = 0.2;
/// Difference over the mean above which statistics that may be the same by their sampling errors are not told to agree.
const MOST_APART: f64 = 0.1;

/// How the statistics of a run compare with those of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    /// They agree within their sampling error, and within a tenth of the mean.
    Agree,
    /// They agree within their sampling error, but differ by more than a tenth of the mean, or the sampling error is more
    /// than a fifth of the mean.
    Undecided,
    /// They differ.
    Differ,
}

/// The more accurate run of a scene, and those with a displaced start or a changed base acceleration.
#[derive(Debug)]
pub(super) struct Ensemble(Vec<Numbers>);

impl Ensemble {
    /// With `pairs` of runs besides that of the scene itself.
    pub(super) fn of(scene: &Scene, options: &Options, pairs: i32) -> Self {
        let scene_at = |place: i32| shifted(scene, f64::from(place) * SHIFT);
        // The scene itself is the first.
        let places: Vec<i32> =
            std::iter::once(0).chain((1..=pairs).flat_map(|place| [place, -place])).collect();
        Self(places.into_par_iter().filter_map(|place| tighter(&scene_at(place)?, options)).collect())
    }

    /// The mean of a quantity; not-a-number without runs.
    pub(super) fn mean(&self, quantity: Quantity) -> f64 {
        self.0.iter().map(|run| run.value(quantity)).sum::<f64>() / self.0.len() as f64
    }

    /// Whether some of the runs differ from the first by more than `allowed`, in a part of the window or as a whole.
    pub(super) fn diverges(&self, quantity: Quantity, allowed: f64) -> bool {
        let Some((first, others)) = self.0.split_first() else { return false };
        others.iter().any(|other| {
            other.error(first, quantity) > allowed
                || (quantity == Quantity::Power && largest_difference(first, other) > allowed)
        })
    }

    /// Whether a run has the statistics of these: the mean power within the sampling error of both, the largest motion
    /// within the scatter.
    pub(super) fn compare(&self, found: &Numbers, quantity: Quantity) -> Comparison {
        let count = self.0.len() as f64;
        let mean = self.mean(quantity);
        let apart = (found.value(quantity) - mean).abs();
        // Of the difference, and how many of it are allowed.
        let (error, most) = match quantity {
            Quantity::Power => {
                let of_mean: f64 = self.0.iter().map(|run| sampling_error(run).powi(2)).sum();
                let relative = (sampling_error(found).powi(2) + of_mean / count.powi(2)).sqrt();
                (relative * mean.abs(), STANDARD_ERRORS)
            }
            Quantity::Motion => {
                let squares: f64 = self.0.iter().map(|run| (run.value(quantity) - mean).powi(2)).sum();
                ((squares / (count - 1.0)).sqrt(), DEVIATIONS)
            }
        };
        let size = mean.abs();
        match apart <= most * error {
            true if error <= MOST_UNCERTAIN * size && apart <= MOST_APART * size => Comparison::Agree,
            true => Comparison::Undecided,
            false => Comparison::Differ,
        }
    }
}

/// The largest difference of the energies in a part of the window, over the mean energy in a part.
fn largest_difference(one: &Numbers, other: &Numbers) -> f64 {
    let blocks = one.block_energies_j.iter().zip(&other.block_energies_j);
    let largest = blocks.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    let mean = one.block_energies_j.iter().sum::<f64>() / one.block_energies_j.len().max(1) as f64;
    relative(mean + largest, mean)
}

/// The relative standard error of the mean power, from the parts of the window.
fn sampling_error(run: &Numbers) -> f64 {
    let whole: f64 = run.block_energies_j.iter().sum();
    let error = standard_error_of_sum(&run.block_energies_j) / whole.abs();
    if error.is_finite() { error } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Precision;
    use crate::stability::Case;

    fn ensemble(changes: &[&str]) -> Ensemble {
        let case = Case::of("contact-separation", changes, Precision::F64);
        Ensemble::of(&case.read().expect("a scene"), &case.options(), 2)
    }

    #[test]
    fn a_periodic_motion_does_not_diverge_and_excuses_nothing() {
        let periodic = ensemble(&["run={duration_periods=36,settle_periods=20}"]);
        assert_eq!(periodic.0.len(), 5);
        assert!(!periodic.diverges(Quantity::Power, 0.01));
    }

    #[test]
    fn statistics_agree_within_the_sampling_error_only() {
        let run = |energies: [f64; 4], power_w| Numbers::with(power_w, energies.to_vec());
        let runs = Ensemble(vec![run([1.0, 1.2, 0.8, 1.0], 4.0), run([0.8, 1.0, 1.2, 1.0], 4.0)]);
        assert!(runs.diverges(Quantity::Power, 0.01));
        let compare = |energies, power_w| runs.compare(&run(energies, power_w), Quantity::Power);
        assert_eq!(compare([1.2, 1.1, 0.9, 1.0], 4.2), Comparison::Agree);
        assert_eq!(compare([2.2, 2.1, 1.9, 2.0], 8.2), Comparison::Differ);
        // The sampling error allows a difference of a third of the mean.
        assert_eq!(compare([1.0, 1.9, 0.9, 1.6], 5.4), Comparison::Undecided);
        // Nearly all of the energy in one part: a standard error as large as the mean.
        assert_eq!(compare([0.0, 0.0, 8.2, 0.0], 8.2), Comparison::Undecided);
    }
}
