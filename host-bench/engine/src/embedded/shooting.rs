//! The periodic steady state of a triboelectric scene, and its resonance, by shooting.

use std::time::Instant as Stopwatch;

use model_core::hybrid::Automaton;
use model_core::integrate::{ExponentialRadau, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::observer::ALL_POWERS;
use model_core::scalar::Mathematics;
use model_core::scene::Scene as CoreScene;

use super::excitation::{HostExcitation, Setting, with_setting};
use super::triboelectric::{Prepared, STATES, Simulated, Triboelectric, prepared};
use crate::steady_state::{ForcedSystem, Orbit, Resonance, Response, Spent, Verdict, resonance};
use harvester_scene::method::{Failure, Method, Options};
use harvester_scene::outcome::{Outcome, Particular, SteadyState};
use harvester_scene::scene_file::{Excitation, RunSpan, Scene};

/// An orbit of a scene of the core.
type OrbitOf<A> = Orbit<<A as Automaton<f64, STATES, ALL_POWERS>>::Mode, STATES, ALL_POWERS>;

/// The steady state of a scene by shooting; the scene's own run where it has no stable orbit of one period.
pub(super) fn steady_state<M: Mathematics<f64>, T: Triboelectric>(
    setting: Setting<'_, f64>,
    model: &T,
) -> Result<Outcome, Failure> {
    let prepared = prepared::<f64, M, T>(setting, model)?;
    let typical = model.typical(&prepared.core);
    match setting.options.method {
        Method::Rk4 => prepared.steady(RungeKutta4, &model.start(), &typical),
        Method::TrBdf2 => prepared.steady(TrBdf2, &model.start(), &typical),
        _ => prepared.steady(ExponentialRadau, &model.start(), &typical),
    }
}

/// The peaks over `points` frequencies of a range in Hz, and the simulated periods that they took.
pub(super) fn peaks<M: Mathematics<f64>, T: Triboelectric>(
    (scene, model): (&Scene, &T),
    range: [f64; 2],
    points: usize,
    options: &Options,
) -> Result<(Option<Resonance>, f64), Failure> {
    let (mut known, mut spent) = (None, Spent::default());
    let found = resonance(range, points, |frequency_hz| {
        let mut scene = scene.clone();
        if let Excitation::Sine(tone) = &mut scene.excitation {
            tone.frequency_hz = frequency_hz;
        }
        with_setting::<f64, M, _>(&scene, options, |setting| {
            let prepared = prepared::<f64, M, T>(setting, model)?;
            let typical = model.typical(&prepared.core);
            match options.method {
                Method::Rk4 => {
                    prepared.followed(RungeKutta4, &model.start(), &typical, &mut known, &mut spent)
                }
                Method::TrBdf2 => prepared.followed(TrBdf2, &model.start(), &typical, &mut known, &mut spent),
                _ => prepared.followed(ExponentialRadau, &model.start(), &typical, &mut known, &mut spent),
            }
        })
    })?;
    Ok((found, spent.periods))
}

impl<A, T> Prepared<'_, f64, A, T>
where
    A: CoreScene<f64, STATES, ALL_POWERS> + Copy,
    T: Triboelectric,
{
    fn forced<'a, I>(
        &'a self,
        simulation: &'a Simulated<f64, A, I, STATES>,
    ) -> ForcedSystem<'a, A, HostExcitation<'a, f64>, I, STATES, ALL_POWERS> {
        ForcedSystem {
            harvester: simulation.scene(),
            excitation: &self.setting.excitation,
            frequency_hz: self.setting.scene.excitation.single_frequency().unwrap_or(f64::NAN),
            driver: simulation.driver(),
        }
    }

    /// The outcome of one period of the stable orbit to which the motion from `start` goes; of the whole run where there
    /// is none.
    fn steady<I: Integrator<f64>>(
        &self,
        integrator: I,
        start: &A::Start,
        typical: &[f64; STATES],
    ) -> Result<Outcome, Failure> {
        let simulation = self.simulation(integrator);
        let state = self.start(&simulation, start)?;
        let (run, forced) = (self.run(&simulation), self.forced(&simulation));
        let began = Stopwatch::now();
        let mut spent = Spent::default();
        let verdict = forced
            .steady_state(state, typical, &mut spent)
            .map_err(|error| run.step_failure(&error, &state))?;
        let (from, span) = match &verdict {
            Verdict::StablePeriodOne(orbit) => {
                let settle_s = orbit.start.clock.seconds::<f64>();
                (orbit.start, RunSpan { duration_s: settle_s + 1.0 / forced.frequency_hz, settle_s })
            }
            Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound => {
                (state, self.setting.scene.run)
            }
        };
        let mut outcome = run.measured(from, &span)?;
        let simulated_s = span.duration_s - from.clock.seconds::<f64>();
        outcome.steady_state = Some(SteadyState {
            steady_state: verdict.name(),
            largest_multiplier: verdict.orbit().map(Orbit::largest_multiplier),
            simulated_periods: spent.periods + simulated_s * forced.frequency_hz,
        });
        outcome.steps += spent.work.steps;
        outcome.rejected_steps += spent.work.rejected;
        outcome.newton_iterations += spent.work.iterations;
        outcome.events += spent.work.events;
        outcome.wall_s = began.elapsed().as_secs_f64();
        if outcome.is_of_an_orbit()
            && let Particular::ContactSeparation(motion) = &mut outcome.particular
        {
            // An orbit has no first impact.
            motion.first_impact_s = None;
        }
        Ok(outcome)
    }

    /// The response of the orbit that `known` leads to, or the start.
    fn followed<I: Integrator<f64>>(
        &self,
        integrator: I,
        start: &A::Start,
        typical: &[f64; STATES],
        known: &mut Option<OrbitOf<A>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        let simulation = self.simulation(integrator);
        let state = self.start(&simulation, start)?;
        let found = self.forced(&simulation).followed(known, state, typical, spent);
        found.map_err(|error| self.run(&simulation).step_failure(&error, &state))
    }
}
