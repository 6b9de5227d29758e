//! Runs a scene by the integrator that the options name: the embedded core, a peer on the host, or the reference.

use crate::embedded;
use crate::method::{Failure, Method, Options};
use crate::outcome::{Margin, Outcome, created_energy_warning};
use crate::peer;
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{Model, Scene};

/// Most rows of a recorded motion.
const MOST_ROWS: f64 = 2e7;

pub fn run_scene(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    options.check()?;
    options.check_scene(scene)?;
    if let Some(every) = options.trace_every_s
        && scene.run.duration_s / every > MOST_ROWS
    {
        let least = scene.run.duration_s / MOST_ROWS;
        return Err(Failure::Input(format!(
            "--trace-every {every}: must be at least {least:e} for at most {MOST_ROWS:e} rows"
        )));
    }
    let mut outcome = match (options.method, &scene.model) {
        (Method::Reference, _) => by_reference(scene, options),
        _ if options.steady_state => embedded::steady_state(scene, options),
        (Method::TrBdf2 | Method::Rk4 | Method::Newmark, Model::BumpStop(model)) => {
            peer::bump_stop(scene, model, options)
        }
        _ => embedded::run(scene, options),
    }?;
    outcome.warnings.extend(outcome.created.and_then(|created| created_energy_warning(scene, created)));
    outcome.warnings.extend(outcome.margins.limits.iter().filter_map(Margin::warning));
    Ok(outcome)
}

/// As [`run_scene`], with a run that stopped on its way as text.
pub(crate) fn try_run_scene(scene: &Scene, options: &Options) -> Result<Result<Outcome, String>, Failure> {
    stopped_as_text(run_scene(scene, options))
}

/// A run that stopped on its way as text, and bad input as a failure.
pub(crate) fn stopped_as_text<T>(run: Result<T, Failure>) -> Result<Result<T, String>, Failure> {
    match run {
        Ok(found) => Ok(Ok(found)),
        Err(Failure::Step(error) | Failure::StepLimitExceeded(error)) => Ok(Err(error)),
        Err(error @ Failure::Input(_)) => Err(error),
    }
}

fn by_reference(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    if let Some(refusal) = reference::refusal(scene) {
        return Err(Failure::Input(refusal));
    }
    let default = ReferenceOptions::default();
    let options = ReferenceOptions {
        tolerance: options.tolerance.unwrap_or(default.tolerance),
        record_every: options.trace_every_s,
        ..default
    };
    reference::run(scene, &options).map_err(|failure| Failure::Step(failure.to_string()))
}
