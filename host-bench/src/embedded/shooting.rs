//! The periodic steady state of a scene on the hybrid driver, and its resonance, by shooting.

use model_core::hybrid::{Driver, HybridState};
use model_core::integrate::{AnyStepControl, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::scalar::Mathematics;

use super::excitation::HostExcitation;
use super::hybrid_run::{HostedScene, ModeOf, Run, STATES, WHOLE};
use super::steady_state::sought;
use crate::method::{Failure, Method};
use crate::outcome::{Outcome, Particular};
use crate::steady_state::{ForcedSystem, Orbit, Response, Search, Spent};

/// A state of a hosted scene.
type State<H> = HybridState<f64, ModeOf<f64, H, STATES>, STATES, WHOLE>;

impl<M: Mathematics<f64>, H: HostedScene<f64, STATES>> Run<'_, f64, M, H, STATES> {
    /// The steady state by shooting; the scene's own run where it has no stable orbit of one period.
    pub(super) fn steady_state(&self, start: State<H>) -> Result<Outcome, Failure> {
        match self.options.method {
            Method::Rk4 => self.steady(RungeKutta4, start),
            Method::Auto
            | Method::TrBdf2
            | Method::DiscreteGradient
            | Method::Newmark
            | Method::Reference => self.steady(TrBdf2, start),
        }
    }

    /// The response of the orbit that `known` leads to, or the start.
    pub(super) fn response(
        &self,
        start: State<H>,
        known: &mut Option<Orbit<ModeOf<f64, H, STATES>, STATES, WHOLE>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        match self.options.method {
            Method::Rk4 => self.followed(RungeKutta4, start, known, spent),
            Method::Auto
            | Method::TrBdf2
            | Method::DiscreteGradient
            | Method::Newmark
            | Method::Reference => self.followed(TrBdf2, start, known, spent),
        }
    }

    fn shaken<'a, I>(
        &'a self,
        driver: &'a Driver<I, AnyStepControl<f64>>,
    ) -> ForcedSystem<'a, H::Core, HostExcitation<'a, f64, M>, I> {
        ForcedSystem {
            harvester: self.hosted.core(),
            excitation: self.excitation,
            frequency_hz: self.scene.excitation.single_frequency().unwrap_or(f64::NAN),
            driver,
        }
    }

    fn steady<I: Integrator<f64>>(&self, integrator: I, start: State<H>) -> Result<Outcome, Failure> {
        let driver = Driver::new(integrator, self.control);
        let mut outcome = sought(
            &self.shaken(&driver),
            start,
            &Search::new(self.hosted.typical()),
            &self.scene.run,
            |error| self.step_failure(&error, &start),
            |from, span| self.measured(&driver, from, span),
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
        start: State<H>,
        known: &mut Option<Orbit<ModeOf<f64, H, STATES>, STATES, WHOLE>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        let driver = Driver::new(integrator, self.control);
        let search = Search::new(self.hosted.typical());
        let found = self.shaken(&driver).followed(known, start, &search, spent);
        found.map_err(|error| self.step_failure(&error, &start))
    }
}
