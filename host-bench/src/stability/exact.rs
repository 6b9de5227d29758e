//! The runs that are more accurate, and what is compared of two runs.

use crate::embedded::DEFAULT_SHORT_STEP_S;
use crate::method::{Options, Precision};
use crate::outcome::{Outcome, standard_error_of_sum};
use crate::reference::{self, ReferenceOptions};
use crate::run::{each, run_scene};
use crate::scene_file::{Model, Scene};
use crate::shift::{SHIFT, shifted};

/// Halvings of the tolerance of a triboelectric run, and of the steps of a bump-stop run, that give the tighter run.
pub(super) const HALVINGS: [u32; 2] = [5, 2];
/// The same of the runs whose mean is compared: their scatter is above their error by the step.
pub(super) const HALVINGS_OF_MEAN: [u32; 2] = [3, 2];
/// Attempted steps of the tighter run and steps of the reference over those of the run.
const MORE_ATTEMPTS: u64 = 8;
/// Tolerance of the reference: its errors are far below what is judged.
pub(super) const REFERENCE_TOLERANCE: f64 = 1e-10;
/// Its tolerance for a run that is beyond its statement by it.
pub(super) const CLOSER_TOLERANCE: f64 = 1e-12;
/// Part of what the storage holds below which an energy is nothing: a full storage takes what the peaks between steps are above it.
const NOTHING: f64 = 3e-7;
/// Tolerances at which it must give the same numbers, with the parts of what is allowed: one of them may agree by chance.
const LOOSER_TOLERANCES: [(f64, f64); 2] = [(1e-9, 0.5), (1e-8, 2.0)];

/// What is compared of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers {
    /// Mean power in W.
    power_w: f64,
    /// Whether the energy delivered is 0, or nothing beside what the storage holds.
    is_nothing: bool,
    /// Peak gap, amplitude of the slider, or peak displacement of the tip in m.
    motion_m: f64,
    /// RMS voltage in V.
    voltage_v: f64,
    /// Energy in J in each part of the window; empty for the reference.
    pub(super) block_energies_j: Vec<f64>,
}

/// The quantity by which a run is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The mean power.
    Power,
    /// Where no power is delivered: the peak gap, amplitude or displacement, and the RMS voltage.
    Motion,
}

impl Numbers {
    /// Of a run; `None` without a measuring window.
    pub(super) fn of(outcome: &Outcome) -> Option<Self> {
        let stored_j = outcome.store.as_ref().and_then(|store| store.stored_energy_j).unwrap_or(0.0);
        Some(Self {
            power_w: outcome.mean_power_w?,
            is_nothing: outcome.delivered_energy_j?.abs() <= NOTHING * stored_j.max(0.0),
            motion_m: outcome.largest_motion_m()?,
            voltage_v: outcome.rms_voltage_v.unwrap_or(0.0),
            block_energies_j: outcome.block_energies_j.clone(),
        })
    }

    /// Of a run of this mean power in W and these energies in J.
    #[cfg(test)]
    pub(super) fn with(power_w: f64, block_energies_j: Vec<f64>) -> Self {
        Self { power_w, is_nothing: power_w == 0.0, motion_m: 0.0, voltage_v: 0.0, block_energies_j }
    }

    /// The quantity by which two runs are compared: the power, unless one has none and the other next to nothing.
    pub(super) fn quantity(&self, other: &Self) -> Quantity {
        let one_has_none = self.power_w == 0.0 || other.power_w == 0.0;
        if one_has_none && self.is_nothing && other.is_nothing { Quantity::Motion } else { Quantity::Power }
    }

    /// The relative difference of a quantity from that of `exact`.
    pub(super) fn error(&self, exact: &Self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Power => relative(self.power_w, exact.power_w),
            Quantity::Motion => {
                relative(self.motion_m, exact.motion_m).max(relative(self.voltage_v, exact.voltage_v))
            }
        }
    }

    /// What differs from `exact`, in words.
    pub(super) fn difference(&self, exact: &Self, quantity: Quantity) -> String {
        match quantity {
            Quantity::Power => format!("mean power {:e} W instead of {:e} W", self.power_w, exact.power_w),
            Quantity::Motion => format!(
                "motion {:e} m instead of {:e} m, RMS voltage {:e} V instead of {:e} V",
                self.motion_m, exact.motion_m, self.voltage_v, exact.voltage_v
            ),
        }
    }

    /// The value of which the statistics of chaotic motions are compared.
    pub(super) fn value(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Power => self.power_w,
            Quantity::Motion => self.motion_m,
        }
    }
}

/// `|found − exact|` over the magnitude of `exact`; 0 where both are 0.
pub(super) fn relative(found: f64, exact: f64) -> f64 {
    if found == exact { 0.0 } else { ((found - exact) / exact).abs() }
}

/// Whether the reference gives a quantity of `exact`, which is its own, under a base or from a start that differs by [`SHIFT`] and at larger
/// tolerances too. It does not where it resolves a stiff circuit or a noise of kHz badly, and where a power is that of its rounding.
pub(super) fn reference_repeats(
    scene: &Scene,
    most_attempts: u64,
    (exact, quantity, allowed): (&Numbers, Quantity, f64),
) -> bool {
    // At a kink of the base a step ends at every tolerance.
    let shifted = shifted(scene, SHIFT);
    let scene = shifted.as_ref().unwrap_or(scene);
    LOOSER_TOLERANCES.into_iter().all(|(tolerance, part)| {
        by_reference(scene, most_attempts, tolerance)
            .is_some_and(|looser| looser.error(exact, quantity) <= part * allowed)
    })
}

/// A scene on the reference; `None` if it is refused or does not come to its end.
pub(super) fn by_reference(scene: &Scene, most_attempts: u64, tolerance: f64) -> Option<Numbers> {
    let options = ReferenceOptions {
        tolerance,
        most_steps: Some(most_attempts.saturating_mul(MORE_ATTEMPTS)),
        ..ReferenceOptions::default()
    };
    if reference::refusal(scene).is_some() {
        return None;
    }
    Numbers::of(&reference::run(scene, &options).ok()?)
}

/// A scene in double precision with a tighter tolerance, or shorter steps, than `options`; `None` if it does not come to its end.
pub(super) fn tighter(scene: &Scene, options: &Options, halvings: [u32; 2]) -> Option<Numbers> {
    let is_bump_stop = matches!(scene.model, Model::BumpStop(_));
    let more = halvings[usize::from(is_bump_stop)];
    let longest_s = if is_bump_stop { DEFAULT_SHORT_STEP_S } else { f64::INFINITY };
    let step_s = options.step_s.map(|step_s| step_s.min(longest_s));
    let options = Options {
        precision: Some(Precision::F64),
        step_s,
        halvings: options.halvings + more,
        // A bare run of bump-stop does not measure the voltage, which is compared where no power is delivered.
        bare: !is_bump_stop || options.bare,
        blocks: !options.bare,
        most_attempts: options.most_attempts.map(|most| most.saturating_mul(MORE_ATTEMPTS)),
        ..*options
    };
    Numbers::of(&run_scene(scene, &options).ok()?)
}

/// Standard errors by which the statistics of two runs of a chaotic motion may differ: 3 in 1000 differ by more.
const STANDARD_ERRORS: f64 = 3.0;
/// Standard deviations of a few runs by which the largest motion of another may differ from their mean: by Student's
/// distribution with four degrees of freedom one in 100 differs by more.
const DEVIATIONS: f64 = 5.0;
/// Standard error of the difference over the mean above which the statistics are too uncertain to agree.
const MOST_UNCERTAIN: f64 = 0.2;
/// Difference over the mean above which statistics that may be the same by their sampling errors are not taken to agree.
const MOST_APART: f64 = 0.1;

/// How the statistics of a run compare with those of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    /// They agree within their sampling error, and within a tenth of the mean.
    Agree,
    /// They agree within their sampling error, but differ by more than a tenth of the mean, or the sampling error is more
    /// than a fifth of the mean.
    Undecided,
    Differ,
}

/// The more accurate run of a scene, and those with a displaced start or a changed base acceleration.
#[derive(Debug)]
pub(super) struct Ensemble(Vec<Numbers>);

impl Ensemble {
    /// With `pairs` of runs besides that of the scene itself.
    pub(super) fn of(scene: &Scene, options: &Options, pairs: i32, halvings: [u32; 2]) -> Self {
        let scene_at = |place: i32| shifted(scene, f64::from(place) * SHIFT);
        // The scene itself is the first.
        let places: Vec<i32> =
            std::iter::once(0).chain((1..=pairs).flat_map(|place| [place, -place])).collect();
        let of = |&place: &i32| tighter(&scene_at(place)?, options, halvings);
        Self(each(&places, of).into_iter().flatten().collect())
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
    use super::super::Case;
    use super::*;
    use crate::method::Precision;

    fn ensemble(changes: &[&str]) -> Ensemble {
        let case = Case::of("contact-separation", changes, Precision::F64);
        Ensemble::of(&case.read().expect("a scene"), &case.options(), 2, HALVINGS)
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
