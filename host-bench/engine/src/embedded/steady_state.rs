//! The outcome of a search for the steady state, for any scene.

use std::fmt::Debug;
use std::time::Instant as Stopwatch;

use model_core::excitation::Excitation;
use model_core::hybrid::{Automaton, HybridState, StepError};
use model_core::integrate::Method as Integrator;

use crate::steady_state::{ForcedSystem, Orbit, Search, Spent, Verdict};
use harvester_scene::method::Failure;
use harvester_scene::outcome::{Outcome, SteadyState};
use harvester_scene::scene_file::RunSpan;

/// The outcome of one period of the stable orbit to which the motion from `start` goes; of the whole
/// `run` where there is none.
///
/// `measured` makes a run from a state to the end of a span; `failed` words a step that cannot be taken.
pub(super) fn sought<A, E, I, Mode, const N: usize, const P: usize>(
    forced: &ForcedSystem<'_, A, E, I>,
    start: HybridState<f64, Mode, N, P>,
    search: &Search<N>,
    run: &RunSpan,
    failed: impl FnOnce(StepError<f64>) -> Failure,
    measured: impl FnOnce(HybridState<f64, Mode, N, P>, &RunSpan) -> Result<Outcome, Failure>,
) -> Result<Outcome, Failure>
where
    Mode: Copy + Debug + PartialEq,
    A: Automaton<f64, N, P, Mode = Mode>,
    E: Excitation<f64>,
    I: Integrator<f64>,
{
    let began = Stopwatch::now();
    let mut spent = Spent::default();
    let verdict = forced.steady_state(start, search, &mut spent).map_err(failed)?;
    let (from, span) = match &verdict {
        Verdict::StablePeriodOne(orbit) => {
            let settle_s = orbit.start.clock.seconds::<f64>();
            (orbit.start, RunSpan { duration_s: settle_s + 1.0 / forced.frequency_hz, settle_s })
        }
        Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound => (start, *run),
    };
    let mut outcome = measured(from, &span)?;
    let simulated_s = span.duration_s - from.clock.seconds::<f64>();
    outcome.steady_state = Some(SteadyState {
        steady_state: verdict.name(),
        largest_multiplier: verdict.orbit().map(Orbit::largest_multiplier),
        simulated_periods: spent.periods + simulated_s * forced.frequency_hz,
    });
    outcome.steps += spent.steps;
    outcome.rejected_steps += spent.rejected;
    outcome.newton_iterations += spent.iterations;
    outcome.events += spent.events;
    outcome.wall_s = began.elapsed().as_secs_f64();
    Ok(outcome)
}
