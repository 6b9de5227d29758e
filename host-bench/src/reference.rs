//! The independent reference: `std`, double precision, and no code of `model-core`.
//!
//! The physics is written again, in state variables of its own, and integrated by the crate `diffsol`
//! at tolerances near rounding. Everything that is measured as an integral is carried by the
//! integrator as a further state. The bump-stop harvester is linear between its events and is propagated
//! exactly instead.

mod base;
mod bridge;
mod bump_stop;
mod cantilever;
mod contact_separation;
mod effort;
mod integrals;
mod recorder;
mod root;
mod sliding;
mod store;

pub(crate) use self::base::{Base, LocalBase};
pub(crate) use self::bump_stop::BumpStopModes;
pub(crate) use self::cantilever::Cantilever;

use crate::outcome::Outcome;
use crate::scene_file::{BumpStop, Contact, Model, Scene};

/// How accurate, and what to record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceOptions {
    /// Relative tolerance of the integrator; what is propagated exactly meets any.
    pub tolerance: f64,
    /// Distance of recorded rows in s; `None`: no recording.
    pub record_every: Option<f64>,
    /// Steps of a triboelectric scene after which it is given up at the next event.
    pub most_steps: Option<u64>,
}

impl Default for ReferenceOptions {
    /// A tolerance of 10⁻¹²: ten times tighter the results of the shipped scene change by a few 10⁻¹¹,
    /// and the Newton iteration comes near to rounding.
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

/// Why the reference has nothing to say about a scene, if so.
#[must_use]
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
/// If the integrator cannot go on; the scene itself has been checked when it was read.
pub fn run(scene: &Scene, options: &ReferenceOptions) -> Result<Outcome, StepFailure> {
    match &scene.model {
        Model::ContactSeparation(model) => contact_separation::run(scene, model, options),
        Model::Sliding(model) => sliding::run(scene, model, options),
        Model::BumpStop(model) => bump_stop::run(scene, model, options),
    }
}
