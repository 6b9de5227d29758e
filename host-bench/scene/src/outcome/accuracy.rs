//! The accuracy statement of a run.

use serde::Serialize;

/// Estimated relative error of the mean power, by source; where no power is delivered, of the largest motion and the RMS
/// voltage. `None`, and `null` in JSON, is unknown, or does not apply: no
/// trace, double precision, no layer.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Accuracy {
    /// By the finite step: from a run with half the step or a sixteenth of the tolerance; where that tolerance takes hardly more
    /// steps, from one in fixed steps too; for bump-stop from one in default steps where its own are longer, and from how the
    /// steps before converged. In double precision it includes the rounding, because no operation of the two runs
    /// rounds alike.
    pub step: Option<f64>,
    /// By rounding in single precision: from a run in double precision.
    pub rounding: Option<f64>,
    /// By the relaxation of a fast circuit that no step resolves: of a storage behind the bridge of a triboelectric scene
    /// that discharges within a step, from a run in fixed steps.
    pub boundary_layers: Option<f64>,
    /// By the straight line between two samples of a trace: from a run on a trace with three more samples between two,
    /// on the cubic through four.
    pub sampling: Option<f64>,
    /// The sum; `None` if that by the step, or another that was to be estimated, is unknown.
    pub total: Option<f64>,
}

impl Accuracy {
    /// The statement with the sum of its sources.
    #[must_use]
    pub fn summed(self) -> Self {
        let Self { step, rounding, boundary_layers, sampling, .. } = self;
        let others: f64 = [rounding, boundary_layers, sampling].into_iter().flatten().sum();
        Self { total: step.map(|step| step + others), ..self }
    }
}
