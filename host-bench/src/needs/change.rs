//! What the absence of a part changes: two runs compared.

use serde::Serialize;

use crate::outcome::Outcome;

/// Standard errors of the mean within which a difference may be chance.
const CONFIDENCE: f64 = 2.0;

/// What a run has in place of what the full scene has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Change {
    /// Relative change of the mean power; `None` if the full scene delivers none.
    pub(crate) mean_power: Option<f64>,
    /// Relative change of the RMS voltage; `None` if the full scene has none.
    pub(crate) rms_voltage: Option<f64>,
    /// Relative change of the voltage of the storage at the end; `None` if one of the two has none.
    pub(crate) store_voltage: Option<f64>,
    /// Relative change of the peak displacement.
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
            displacement: relative(displacement(full), displacement(run)),
            impacts: impacts(run),
            sampling_error: is_chaotic.then(|| sampling_error(&full.block_energies_j, &run.block_energies_j)),
        }
    }

    /// The largest of the changes that decide: power, RMS voltage and storage. Where the full scene has none of them, the
    /// displacement.
    pub(crate) fn largest(&self) -> f64 {
        let electrical = [self.mean_power, self.rms_voltage, self.store_voltage];
        let largest = electrical.into_iter().flatten().map(f64::abs).reduce(f64::max);
        // Not-a-number counts as a change.
        largest.or(self.displacement.map(f64::abs)).filter(|change| !change.is_nan()).unwrap_or(f64::INFINITY)
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

fn relative(full: Option<f64>, run: Option<f64>) -> Option<f64> {
    let full = full.filter(|full| *full != 0.0)?;
    Some(run? / full - 1.0)
}

/// The peak displacement in m that the kind of scene has.
fn displacement(outcome: &Outcome) -> Option<f64> {
    let separating = outcome.contact_separation().and_then(|found| found.peak_gap_m);
    let sliding = outcome.sliding().and_then(|found| found.peak_displacement_m);
    separating.or(sliding).or(outcome.bump_stop().and_then(|found| found.peak_tip_displacement_m))
}

/// Impacts or contacts in the window; `None` in a sliding scene.
pub(crate) fn impacts(outcome: &Outcome) -> Option<u64> {
    let separating = outcome.contact_separation().map(|found| found.impacts);
    separating.or(outcome.bump_stop().map(|found| found.contacts))
}

/// Twice the standard error of the mean difference of the energies in parts of two windows, over the mean of the
/// magnitudes of the second.
pub(super) fn sampling_error(full: &[f64], run: &[f64]) -> f64 {
    let apart: Vec<f64> = full.iter().zip(run).map(|(full, run)| run - full).collect();
    let count = apart.len() as f64;
    let mean = apart.iter().sum::<f64>() / count;
    let squares: f64 = apart.iter().map(|apart| (apart - mean).powi(2)).sum();
    let whole: f64 = run.iter().sum();
    CONFIDENCE * (squares * count / (count - 1.0)).sqrt() / whole.abs()
}
