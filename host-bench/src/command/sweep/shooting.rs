//! The cost of a sweep of steady states against that of runs of the same scenes.

use super::SweepArguments;
use crate::method::{Failure, Options};
use crate::outcome::Outcome;
use crate::run::try_run_scene;
use crate::scene_file::Scene;

/// One point: the steady state, and the run of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compared {
    /// Simulated periods of each.
    periods: [f64; 2],
    /// Time of each in s, if the run was made.
    seconds: Option<[f64; 2]>,
    is_stable: bool,
}

/// Compares the steady state with the run, which is made if the arguments ask for it; `None` if no steady
/// state was sought.
pub(super) fn compared(
    scene: &Scene,
    outcome: &Outcome,
    arguments: &SweepArguments,
) -> Result<Option<Compared>, Failure> {
    let (Some(steady), Some(frequency)) = (&outcome.steady_state, scene.excitation.single_frequency()) else {
        return Ok(None);
    };
    let seconds = if arguments.compare {
        let options = Options { steady_state: false, ..arguments.scene.options };
        // A run that fails leaves nothing to compare with.
        try_run_scene(scene, &options)?.ok().map(|run| [outcome.processor_s, run.processor_s])
    } else {
        None
    };
    Ok(Some(Compared {
        periods: [steady.simulated_periods, frequency * scene.run.duration_s],
        seconds,
        is_stable: outcome.is_of_an_orbit(),
    }))
}

/// The costs of all points together in words; `None` over no points.
pub(super) fn told<'a>(points: impl Iterator<Item = &'a Compared>) -> Option<String> {
    let points: Vec<&Compared> = points.collect();
    let stable: Vec<&Compared> = points.iter().copied().filter(|point| point.is_stable).collect();
    let sum = |points: &[&Compared]| {
        points.iter().fold([0.0; 2], |[a, b], point| [a + point.periods[0], b + point.periods[1]])
    };
    let ratio = |[steady, run]: [f64; 2]| run / steady;
    let of_stable = sum(&stable);
    let text = format!(
        "steady state at {} of {} points: {:.0} simulated periods each, the run has {:.1} times as many; \
         at all points, the run included where there is none, {:.1} times as many",
        stable.len(),
        points.len(),
        of_stable[0] / stable.len().max(1) as f64,
        ratio(of_stable),
        ratio(sum(&points)),
    );
    let seconds = points.iter().filter_map(|point| point.seconds).reduce(|[a, b], [c, d]| [a + c, b + d]);
    let slower = seconds.map(|seconds| format!("; the runs took {:.1} times as long", ratio(seconds)));
    (!points.is_empty()).then(|| text + &slower.unwrap_or_default())
}
