//! Shipped scenes with changes, and their runs.

use rayon::prelude::*;

use crate::method::{Failure, Options};
use crate::outcome::{BumpStopOutcome, Outcome};
use crate::run::run_scene;
use crate::scene_file::{self, Override, Scene};

/// The scenes of the second paper far below the resonance: the stop at the tip, at mid-span, and none.
pub(super) const PAPER: [&str; 3] = ["bump-stop-paper", "bump-stop-paper-mid-span", "bump-stop-paper-none"];
/// Those near the resonance, 220 Hz into 1 MΩ.
pub(super) const NEAR_RESONANCE: [&str; 3] = ["bump-stop-tip", "bump-stop-mid-span", "bump-stop-none"];

/// Keys and their values.
pub(super) type Changes<'a> = &'a [(&'a str, &'a str)];

/// A shipped scene with these keys changed.
pub(super) fn scene(name: &str, changes: Changes<'_>) -> Result<Scene, Failure> {
    let overrides: Vec<Override> = changes.iter().map(|(key, value)| Override::new(key, value)).collect();
    Ok(scene_file::read(&scene_file::shipped(name), &overrides)?)
}

/// Runs a shipped scene with these keys changed, by the default method.
pub(super) fn run(name: &str, changes: Changes<'_>) -> Result<Outcome, Failure> {
    run_scene(&scene(name, changes)?, &Options::default())
}

/// The result for each case, in their order, on all cores.
pub(super) fn each<C: Sync, R: Send>(
    cases: &[C],
    work: impl Fn(&C) -> Result<R, Failure> + Sync + Send,
) -> Result<Vec<R>, Failure> {
    cases.par_iter().with_max_len(1).map(work).collect()
}

/// The result for each of some cases, in their order, on all cores.
pub(super) fn each_of<C: Sync, R: Send, const N: usize>(
    cases: [C; N],
    work: impl Fn(&C) -> Result<R, Failure> + Sync + Send,
) -> Result<[R; N], Failure> {
    let count = |found: Vec<R>| Failure::Input(format!("{} results of {N} cases", found.len()));
    each(&cases, work)?.try_into().map_err(count)
}

/// The numbers of a bump-stop run.
pub(super) fn bump_stop(outcome: &Outcome) -> Result<&BumpStopOutcome, Failure> {
    outcome.bump_stop().ok_or_else(|| Failure::Input("a bump-stop scene must be run".to_owned()))
}

/// The number, or not-a-number, which meets no assertion.
pub(super) fn value(number: Option<f64>) -> f64 {
    number.unwrap_or(f64::NAN)
}
