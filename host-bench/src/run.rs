//! Runs a scene by the integrator of the options: the embedded core, a peer on the host, or the reference. Many on all cores.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

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

/// What `job` gives for each item, in their order, on all cores.
pub(crate) fn each<I: Sync, T: Send>(items: &[I], job: impl Fn(&I) -> T + Sync) -> Vec<T> {
    // None of them fails.
    in_order(items.len(), &|index| Ok(job(&items[index]))).unwrap_or_default()
}

/// As `each`, until one fails.
///
/// # Errors
/// The first failure in the order of the items, of those that were begun.
pub fn try_each<I: Sync, T: Send>(
    items: &[I],
    job: impl Fn(&I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    in_order(items.len(), &|index| job(&items[index]))
}

/// What `job` gives for the numbers below `count`, compiled for each type and not for each job.
fn in_order<T: Send>(
    count: usize,
    job: &(dyn Fn(usize) -> Result<T, Failure> + Sync),
) -> Result<Vec<T>, Failure> {
    let none: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let found = Mutex::new((none, None::<(usize, Failure)>));
    on_all_cores(count, &|index| {
        let own = job(index);
        let (found, failed) = &mut *found.lock().unwrap_or_else(PoisonError::into_inner);
        match own {
            Ok(own) => found[index] = Some(own),
            Err(failure) if failed.as_ref().is_none_or(|(first, _)| index < *first) => {
                *failed = Some((index, failure));
            }
            Err(_) => {}
        }
        failed.is_none()
    });
    let (found, failed) = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut all = Vec::with_capacity(count);
    for own in found.into_iter().flatten() {
        all.push(own);
    }
    failed.map_or(Ok(all), |(_, failure)| Err(failure))
}

/// Calls `job` with the numbers below `count`, until it gives false. One task for each: some take a hundred times as long as
/// others. The one place with rayon's iterators: each use of them compiles hundreds of functions for its own types.
fn on_all_cores(count: usize, job: &(dyn Fn(usize) -> bool + Sync)) {
    (0..count).into_par_iter().with_max_len(1).all(job);
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
