//! What the absence of a part changes: two runs compared.

use serde::Serialize;

use crate::outcome::{Outcome, standard_error_of_sum};

/// Standard errors of the mean within which a difference may be chance.
const CONFIDENCE: f64 = 2.0;

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
    /// Impacts or contacts in the window.
    pub(crate) impacts: Option<u64>,
    /// Twice the standard error of the mean of the change of the mean power, from the parts of the window; `None` where
    /// the motion is not chaotic.
    pub(crate) sampling_error: Option<f64>,
}

impl Change {
    /// Compares `run` with the run `full` of the full scene.
    pub(crate) fn between(full: &Outcome, run: &Outcome, is_chaotic: bool) -> Self {
        let store = |outcome: &Outcome| outcome.store.and_then(|store| store.store_voltage_v);
        Self {
            mean_power: relative(full.mean_power_w, run.mean_power_w),
            rms_voltage: relative(full.rms_voltage_v, run.rms_voltage_v),
            store_voltage: relative(store(full), store(run)),
            displacement: match (full.largest_motion_m(), run.largest_motion_m()) {
                (Some(0.0), Some(0.0)) => Some(0.0),
                (full, run) => relative(full, run),
            },
            impacts: impacts(run),
            sampling_error: is_chaotic.then(|| sampling_error(&full.block_energies_j, &run.block_energies_j)),
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
        let chance = self.sampling_error.unwrap_or(0.0);
        if self.largest() + chance <= accuracy {
            Some(true)
        } else if self.largest() - chance > accuracy {
            Some(false)
        } else {
            None
        }
    }
}

/// The relative change of a quantity; infinite where the full scene has none of it and the run has, `None` where both
/// have none.
fn relative(full: Option<f64>, run: Option<f64>) -> Option<f64> {
    match (full?, run?) {
        (0.0, 0.0) => None,
        (0.0, _) => Some(f64::INFINITY),
        (full, run) => Some(run / full - 1.0),
    }
}

/// Impacts or contacts in the window; `None` in a sliding scene.
pub(crate) fn impacts(outcome: &Outcome) -> Option<u64> {
    let separating = outcome.contact_separation().map(|found| found.impacts);
    separating.or(outcome.bump_stop().map(|found| found.contacts))
}

/// Twice the standard error of the difference of two sums of energies, over the magnitude of the first.
pub(super) fn sampling_error(full: &[f64], run: &[f64]) -> f64 {
    let apart: Vec<f64> = full.iter().zip(run).map(|(full, run)| run - full).collect();
    let whole: f64 = full.iter().sum();
    CONFIDENCE * standard_error_of_sum(&apart) / whole.abs()
}
