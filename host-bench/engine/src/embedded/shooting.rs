//! The periodic steady state of a triboelectric scene, and its resonance, by shooting.

use model_core::hybrid::{Automaton, HybridState};
use model_core::integrate::{Method as Integrator, RungeKutta4, TrBdf2};
use model_core::observer::ALL_POWERS;
use model_core::scene::Scene as CoreScene;

use super::excitation::HostExcitation;
use super::run::Report;
use super::steady_state::sought;
use super::triboelectric::{Prepared, STATES, Simulated};
use crate::steady_state::{ForcedSystem, Orbit, Response, Search, Spent};
use harvester_scene::method::{Failure, Method};
use harvester_scene::outcome::{Outcome, Particular};

/// The modes of a scene of the core.
type ModeOf<A> = <A as Automaton<f64, STATES, ALL_POWERS>>::Mode;
/// An orbit of a scene of the core.
pub(super) type OrbitOf<A> = Orbit<ModeOf<A>, STATES, ALL_POWERS>;

impl<A, R> Prepared<'_, f64, A, R>
where
    A: CoreScene<f64, STATES, ALL_POWERS> + Copy,
    R: Report<f64, Simulated<f64, A, RungeKutta4, STATES>> + Report<f64, Simulated<f64, A, TrBdf2, STATES>>,
{
    /// The steady state by shooting; the scene's own run where it has no stable orbit of one period.
    pub(super) fn steady_state(&self, start: &A::Start, typical: [f64; STATES]) -> Result<Outcome, Failure> {
        match self.setting.options.method {
            Method::Rk4 => self.steady(RungeKutta4, start, typical),
            _ => self.steady(TrBdf2, start, typical),
        }
    }

    /// The response of the orbit that `known` leads to, or the start.
    pub(super) fn response(
        &self,
        start: &A::Start,
        typical: [f64; STATES],
        known: &mut Option<OrbitOf<A>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        match self.setting.options.method {
            Method::Rk4 => self.followed(RungeKutta4, start, typical, known, spent),
            _ => self.followed(TrBdf2, start, typical, known, spent),
        }
    }

    fn forced<'a, I>(
        &'a self,
        simulation: &'a Simulated<f64, A, I, STATES>,
    ) -> ForcedSystem<'a, A, HostExcitation<'a, f64>, I> {
        ForcedSystem {
            harvester: simulation.scene(),
            excitation: &self.setting.excitation,
            frequency_hz: self.setting.scene.excitation.single_frequency().unwrap_or(f64::NAN),
            driver: simulation.driver(),
        }
    }

    fn steady<I: Integrator<f64>>(
        &self,
        integrator: I,
        start: &A::Start,
        typical: [f64; STATES],
    ) -> Result<Outcome, Failure>
    where
        R: Report<f64, Simulated<f64, A, I, STATES>>,
    {
        let simulation = self.simulation(integrator);
        let state: HybridState<f64, ModeOf<A>, STATES, ALL_POWERS> = self.start(&simulation, start)?;
        let run = self.run(&simulation);
        let mut outcome = sought(
            &self.forced(&simulation),
            state,
            &Search::new(typical),
            &self.setting.scene.run,
            |error| run.step_failure(&error, &state),
            |from, span| run.measured(from, span),
        )?;
        if outcome.is_of_an_orbit()
            && let Particular::ContactSeparation(motion) = &mut outcome.particular
        {
            // An orbit has no first impact.
            motion.first_impact_s = None;
        }
        Ok(outcome)
    }

    fn followed<I: Integrator<f64>>(
        &self,
        integrator: I,
        start: &A::Start,
        typical: [f64; STATES],
        known: &mut Option<OrbitOf<A>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure>
    where
        R: Report<f64, Simulated<f64, A, I, STATES>>,
    {
        let simulation = self.simulation(integrator);
        let state = self.start(&simulation, start)?;
        let found = self.forced(&simulation).followed(known, state, &Search::new(typical), spent);
        found.map_err(|error| self.run(&simulation).step_failure(&error, &state))
    }
}
