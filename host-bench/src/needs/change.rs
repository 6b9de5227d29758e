//! What the absence of a part changes: two runs compared, or the means of several.

use serde::Serialize;

use super::sampled;
use crate::outcome::{Outcome, standard_error_of_sum};

/// Intervals by which a change must be beyond the accuracy or within it while more runs can be added: looking several
/// times would find chance more often than once in twenty.
const EARLY: f64 = 2.0;

/// What a run has in place of what the full scene has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Change {
    /// Relative change of the mean power; `None` if both deliver none.
    pub(crate) mean_power: Option<f64>,
    /// Relative change of the RMS voltage; `None` if both have none.
    pub(crate) rms_voltage: Option<f64>,
    /// Relative change of the voltage of the storage at the end; `None` if one of the two has none.
    pub(crate) store_voltage: Option<f64>,
    /// Relative change of the peak displacement; 0 if nothing moves in both.
    pub(crate) displacement: Option<f64>,
    /// Impacts or contacts in the window, of the first run.
    pub(crate) impacts: Option<u64>,
    /// Half the 95 % interval of the changes that decide, the largest of them, from the scatter of the runs; `None` where
    /// the motion is not chaotic.
    pub(crate) sampling_error: Option<f64>,
    /// Number of runs that were compared.
    pub(crate) runs: usize,
    /// The corner of the range at which it is found; `None` at the scene's own point.
    pub(crate) at: Option<Corner>,
}

/// Amplitude in m/s² and frequency in Hz.
pub(crate) type Corner = [f64; 2];

/// A corner as text.
pub(crate) fn corner_name([amplitude, frequency]: Corner) -> String {
    format!("{} m/s² and {frequency} Hz", (1e6 * amplitude).round() / 1e6)
}

impl Change {
    /// Compares `run` with the run `full` of the full scene, neither of them chaotic.
    pub(crate) fn between(full: &Outcome, run: &Outcome) -> Self {
        let change = Self::of_means(std::slice::from_ref(full), std::slice::from_ref(run));
        Self { sampling_error: None, ..change }
    }

    /// Compares the means of several runs with those of the full scene; a single run of it is exact.
    pub(crate) fn of_means(full: &[Outcome], runs: &[Outcome]) -> Self {
        let of = |value: fn(&Outcome) -> Option<f64>| {
            let [full, runs] = [full, runs].map(|all| all.iter().map(value).collect::<Option<Vec<f64>>>());
            sampled::change(&full?, &runs?)
        };
        let store = |outcome: &Outcome| outcome.store.and_then(|store| store.store_voltage_v);
        let electrical = [of(|run| run.mean_power_w), of(|run| run.rms_voltage_v), of(store)];
        let displacement = of(Outcome::largest_motion_m).or_else(|| {
            let is_at_rest = |run: &Outcome| run.largest_motion_m() == Some(0.0);
            full.iter().chain(runs).all(is_at_rest).then_some([0.0; 2])
        });
        let errors = electrical.iter().flatten().map(|[_, error]| *error).reduce(f64::max);
        let [mean_power, rms_voltage, store_voltage] =
            electrical.map(|change| change.map(|[change, _]| change));
        Self {
            mean_power,
            rms_voltage,
            store_voltage,
            displacement: displacement.map(|[change, _]| change),
            impacts: runs.first().and_then(impacts),
            sampling_error: errors.or(displacement.map(|[_, error]| error)),
            runs: runs.len(),
            at: None,
        }
    }

    /// The largest of the changes that decide: power, RMS voltage and storage. Where the full scene has none of them, the
    /// displacement.
    pub(crate) fn largest(&self) -> f64 {
        let electrical = [self.mean_power, self.rms_voltage, self.store_voltage];
        let magnitudes = electrical.into_iter().flatten().map(f64::abs);
        // Not-a-number counts as a change.
        let larger = |one: f64, other: f64| if one.is_nan() || one > other { one } else { other };
        let largest = magnitudes.reduce(larger).or(self.displacement.map(f64::abs));
        largest.filter(|change| !change.is_nan()).unwrap_or(f64::INFINITY)
    }

    /// Whether the change is within `accuracy`; `None` where that may be chance.
    pub(crate) fn is_within(&self, accuracy: f64) -> Option<bool> {
        self.is_within_by(accuracy, 1.0)
    }

    /// What may be the largest of the changes that decide.
    pub(super) fn most(&self) -> f64 {
        self.largest() + self.sampling_error.unwrap_or(0.0)
    }

    /// Whether more runs would hardly change whether it is within `accuracy`.
    pub(super) fn is_clear(&self, accuracy: f64) -> bool {
        self.is_within_by(accuracy, EARLY).is_some()
    }

    /// Whether the change is within `accuracy` by some intervals.
    fn is_within_by(&self, accuracy: f64, intervals: f64) -> Option<bool> {
        let chance = intervals * self.sampling_error.unwrap_or(0.0);
        if self.largest() + chance <= accuracy {
            Some(true)
        } else if self.largest() - chance > accuracy {
            Some(false)
        } else {
            None
        }
    }
}

/// Impacts or contacts in the window; `None` in a sliding scene.
pub(crate) fn impacts(outcome: &Outcome) -> Option<u64> {
    let separating = outcome.contact_separation().map(|found| found.impacts);
    separating.or(outcome.bump_stop().map(|found| found.contacts))
}

/// The larger of the change from one run to the other and two standard errors of the sum of the changes in the parts of
/// the window, over that of `one`: as far as two runs of a chaotic motion are apart, also where their sums are not.
pub(super) fn apart(one: &Outcome, other: &Outcome) -> f64 {
    let blocks = one.block_energies_j.iter().zip(&other.block_energies_j);
    let apart: Vec<f64> = blocks.map(|(one, other)| other - one).collect();
    let whole: f64 = one.block_energies_j.iter().sum();
    let by_parts = 2.0 * standard_error_of_sum(&apart) / whole.abs();
    // Not-a-number without power.
    Change::between(one, other).largest().max(by_parts)
}
