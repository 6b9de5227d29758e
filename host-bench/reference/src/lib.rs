//! The independent reference: `std`, double precision, and no code of `model-core`.
//!
//! The physics is written again, in other state variables than those of the core. Radau5 of the crate `differential-equations`
//! integrates the triboelectric scenes at tolerances near rounding, and every measured integral with them. The bump-stop harvester is
//! linear between its events and is propagated exactly.

mod bump_stop;
mod contact_separation;
mod ledger;
mod schedule;
mod sliding;
mod storage;
#[cfg(test)]
mod test_support;
mod triboelectric;

use contact_separation::ContactSeparation;
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{BumpStop, Contact, Model, Scene};
use sliding::Sliding;

/// The reason why the reference refuses a scene, if it does.
pub fn refusal(scene: &Scene) -> Option<String> {
    let Model::BumpStop(BumpStop { stop: Some(stop), .. }) = &scene.model else { return None };
    (stop.contact == Contact::DisplacementConstraint).then(|| {
        format!(
            "{}: stop.contact = \"displacement-constraint\": must be another one with --method reference; its \
             forces are those of a time step and have no limit as it shrinks, so there is nothing to refer to",
            scene.file.display()
        )
    })
}

/// Runs a scene on the reference.
///
/// # Errors
/// If the integrator cannot go on. The scene itself was checked when it was read.
pub fn run(scene: &Scene, options: &ReferenceOptions) -> Result<Outcome, StepFailure> {
    match &scene.model {
        Model::ContactSeparation(model) => {
            let start = ContactSeparation::new(&model.parameters, scene.load, &model.initial);
            triboelectric::run(scene, start, options)
        }
        Model::Sliding(model) => {
            triboelectric::run(scene, Sliding::new(&model.parameters, scene.load, &model.initial), options)
        }
        Model::BumpStop(model) => bump_stop::run(scene, model, options, |_| {}),
    }
}

/// How accurate, and what to record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceOptions {
    /// Relative tolerance of the integrator. The bump-stop reference is exact and does not use it.
    pub tolerance: f64,
    /// Distance of recorded rows in s; `None`: no recording.
    pub record_every: Option<f64>,
    /// Steps of a triboelectric scene after which the run is given up at the next event.
    pub most_steps: Option<u64>,
}

impl Default for ReferenceOptions {
    /// A tolerance of 10⁻¹². A tenfold tighter one changes the mean powers of the shipped scenes under one sine by less than 10⁻¹⁰.
    fn default() -> Self {
        Self { tolerance: 1e-12, record_every: None, most_steps: None }
    }
}

/// A run that could not be finished.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{reason} at {time_s} s ({state})")]
pub struct StepFailure {
    /// What went wrong.
    pub reason: String,
    /// Simulated time in s.
    pub time_s: f64,
    /// The last good state, in words.
    pub state: String,
}
