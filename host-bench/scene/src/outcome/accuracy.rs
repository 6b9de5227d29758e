//! The accuracy statement of a run.

use serde::Serialize;

/// Estimated relative error of the mean power, by source; where no power is delivered, of the largest motion and the RMS
/// voltage. `None`, and `null` in JSON, is unknown, or does not apply: no chaos, no trace, double precision, no layer.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Accuracy {
    /// Of a chaotic motion, by the finite number of runs: six standard errors of the mean power over an ensemble of displaced
    /// starts.
    pub chaos: Option<f64>,
    /// By the finite step: from a run with half the step or a sixteenth of the tolerance, or in fixed steps of half the mean
    /// length where that takes hardly more steps; in a chaotic motion from the means of both ensembles. In double precision it
    /// includes the rounding, because no operation of the two runs rounds alike.
    pub step: Option<f64>,
    /// By rounding in single precision: from a run in double precision; in a chaotic motion it is a part of `step`.
    pub rounding: Option<f64>,
    /// By the relaxation of a fast circuit that no step resolves, of a charge at the start or of a storage that discharges within
    /// a step: it is that of `step`, from a run with a short first step too, and counts once.
    pub boundary_layers: Option<f64>,
    /// The sum; `None` if that by the step, or another that was to be estimated, is unknown.
    pub total: Option<f64>,
    /// By the straight line between two samples of a trace: from a run on a trace with three more samples between two,
    /// on the cubic through four. It is an error of the trace, not of the run, and no part of the total.
    pub sampling: Option<f64>,
    /// Relative standard error of the mean over the window as that of a longer run, from sixteen parts of the window; of a
    /// chaotic motion and under a random or recorded excitation. It is no error of the run, and no part of the total.
    pub window: Option<f64>,
    /// The duration of the run in s with which `window` would be half as large.
    pub window_halved_s: Option<f64>,
    /// Steps of the runs of the statement over those of the run.
    #[serde(skip)]
    pub work: f64,
}

impl Accuracy {
    /// The statement with the sum of its sources; the bias by the step and the scatter of a chaotic motion are independent.
    #[must_use]
    pub fn summed(self) -> Self {
        let Self { chaos, step, rounding, .. } = self;
        let total = step.map(|step| step.hypot(chaos.unwrap_or(0.0)) + rounding.unwrap_or(0.0));
        Self { total, ..self }
    }
}
