//! The cost of a sweep of steady states against that of runs of the same scenes.

use std::fmt;

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
        let options = Options { steady_state: false, ..arguments.scene.options() };
        // A run that fails leaves nothing to compare with.
        try_run_scene(scene, &options)?.ok().map(|run| [outcome.wall_s, run.wall_s])
    } else {
        None
    };
    Ok(Some(Compared {
        periods: [steady.simulated_periods, frequency * scene.run.duration_s],
        seconds,
        is_stable: outcome.is_of_an_orbit(),
    }))
}

/// All points together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Costs {
    points: usize,
    stable: usize,
    /// Of the points with a stable orbit.
    stable_periods: [f64; 2],
    periods: [f64; 2],
    seconds: Option<[f64; 2]>,
}

impl Costs {
    /// The sums; `None` over no points.
    pub(super) fn of<'a>(points: impl Iterator<Item = &'a Compared>) -> Option<Self> {
        let mut costs =
            Self { points: 0, stable: 0, stable_periods: [0.0; 2], periods: [0.0; 2], seconds: None };
        let add = |one: [f64; 2], other: [f64; 2]| [one[0] + other[0], one[1] + other[1]];
        for point in points {
            costs.points += 1;
            costs.periods = add(costs.periods, point.periods);
            if point.is_stable {
                costs.stable += 1;
                costs.stable_periods = add(costs.stable_periods, point.periods);
            }
            if let Some(seconds) = point.seconds {
                costs.seconds = Some(add(costs.seconds.unwrap_or_default(), seconds));
            }
        }
        (costs.points > 0).then_some(costs)
    }
}

impl fmt::Display for Costs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ratio = |[steady, run]: [f64; 2]| run / steady;
        write!(
            f,
            "steady state at {} of {} points: {:.0} simulated periods each, the run has {:.1} times as many; \
             at all points, the run included where there is none, {:.1} times as many",
            self.stable,
            self.points,
            self.stable_periods[0] / self.stable.max(1) as f64,
            ratio(self.stable_periods),
            ratio(self.periods),
        )?;
        match self.seconds {
            Some(seconds) => write!(f, "; the runs took {:.1} times as long", ratio(seconds)),
            None => Ok(()),
        }
    }
}
