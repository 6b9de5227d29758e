//! The independent reference: `std`, double precision, and no code of `model-core`.
//!
//! The physics is written again, in other state variables than those of the core. The crate `diffsol`
//! integrates the triboelectric scenes at tolerances near rounding, and with them every measured integral as a
//! further state. The bump-stop harvester is linear between its events and is propagated exactly.

mod bump_stop;
mod contact_separation;
mod ledger;
mod options;
mod recorder;
mod schedule;
mod sliding;
mod storage;
#[cfg(test)]
mod test_support;
mod totals;
mod triboelectric;

use self::contact_separation::ContactSeparation;
pub use self::options::{ReferenceOptions, StepFailure};
use self::sliding::Sliding;
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{BumpStop, Contact, Model, Scene};

/// The reason why the reference refuses a scene, if it does.
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
