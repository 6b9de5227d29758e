//! What is known of the errors of a run: its accuracy statement, and the energy that a force law creates.

use serde::Serialize;

use crate::scene_file::Scene;

/// Estimated relative error of the mean power, by source; where no power is delivered, of the largest motion and the RMS
/// voltage. `None`, and `null` in JSON, is unknown, or does not apply: no chaos, no trace, double precision, no layer.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Accuracy {
    /// Of a chaotic motion, by the finite number of runs: three standard errors of the mean power over an ensemble of displaced starts.
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
    pub fn summed(self) -> Self {
        let Self { chaos, step, rounding, .. } = self;
        let total = step.map(|step| step.hypot(chaos.unwrap_or(0.0)) + rounding.unwrap_or(0.0));
        Self { total, ..self }
    }
}

/// Share of the delivered energy above which a run warns of created energy.
const NOTABLE: f64 = 1e-2;

/// The energy that the force law of a triboelectric scene created in the measuring window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CreatedEnergy {
    /// What the field gained from the motion less what the motion lost to the force, in J. Negative: energy vanished.
    pub created_energy_j: f64,
    /// It over the energy that was delivered to the load in the same window. `None` where none was delivered, and where the
    /// error of the integration hides it.
    pub created_energy_share: Option<f64>,
}

impl CreatedEnergy {
    /// Of the created and the delivered energy in J, and the larger of the remainders in J of the mechanical and the
    /// electrical ledger, to which the created energy is known.
    ///
    /// With a load near 0 Ω or an open one the force is a function of the position: a cycle of the motion creates nothing,
    /// the load takes next to nothing, and their quotient would be that of two errors.
    pub fn new(created_energy_j: f64, delivered_energy_j: f64, remainder_j: f64) -> Self {
        let is_known = created_energy_j == 0.0
            || remainder_j.abs() <= created_energy_j.abs().max(NOTABLE * delivered_energy_j);
        let share = (delivered_energy_j > 0.0 && is_known).then(|| created_energy_j / delivered_energy_j);
        Self { created_energy_j, created_energy_share: share.filter(|share| share.is_finite()) }
    }
}

/// The warning of a scene whose force law is not derived from the field, where the energy that it created is more than
/// a hundredth of the delivered energy.
pub fn created_energy_warning(scene: &Scene, created: CreatedEnergy) -> Option<String> {
    let [law, passive] = scene.model.summary().not_conserved?;
    let share = created.created_energy_share.filter(|share| share.abs() > NOTABLE)?;
    let does = if share > 0.0 { "creates" } else { "loses" };
    Some(format!(
        "{law} {does} energy: created_energy_j = {:.3e} is {share:.3} times the delivered energy; {passive} conserves it",
        created.created_energy_j,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(created: f64, delivered: f64, remainder: f64) -> Option<f64> {
        CreatedEnergy::new(created, delivered, remainder).created_energy_share
    }

    #[test]
    fn the_share_is_of_the_delivered_energy_and_absent_without_it() {
        assert_eq!(share(3.0, 2.0, 0.0), Some(1.5));
        assert_eq!(share(-1.0, 2.0, 0.0), Some(-0.5));
        for delivered in [0.0, -0.0, -1.0, f64::NAN] {
            assert_eq!(share(1.0, delivered, 0.0), None, "{delivered}");
        }
        assert_eq!(share(0.0, 0.0, 0.0), None);
        assert_eq!(share(1e300, 1e-300, 0.0), None);
        assert_eq!(share(f64::NAN, 1.0, 0.0), None);
    }

    #[test]
    fn the_share_is_absent_where_the_remainder_of_the_ledger_hides_it() {
        // As large as what was created, and more than a hundredth of what was delivered.
        assert_eq!(share(1.0, 1e-3, 2.0), None);
        assert_eq!(share(1.0, 1e-3, 0.5), Some(1e3));
        assert_eq!(share(1.0, 1e-3, f64::NAN), None);
        // A small share is known to a hundredth.
        assert_eq!(share(1e-4, 1.0, 5e-3), Some(1e-4));
        // Nothing is created where force and field are one expression.
        assert_eq!(share(0.0, 1e-3, 2.0), Some(0.0));
    }
}
