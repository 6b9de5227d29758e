//! The periodic steady state of a contact-separation scene, and its resonance, by shooting.

use std::time::Instant as Stopwatch;

use model_core::hybrid::Driver;
use model_core::integrate::{AnyStepControl, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::scalar::Mathematics;
use model_core::scene::account;
use model_core::scene::contact_separation::{AnyParts, ContactSeparation as Harvester, Mode, STATES};

use super::{Run, State, prepared, step_failure};
use crate::embedded::excitation::HostExcitation;
use crate::method::{Failure, Method, Options};
use crate::outcome::{Outcome, Particular, SteadyState};
use crate::scene_file::{ContactSeparation, Excitation, RunSpan, Scene};
use crate::steady_state::{Orbit, Resonance, Response, Search, Shaken, Spent, Verdict, resonance};

/// The steady state by shooting; the scene's own run where it has no stable orbit of one period.
pub(in crate::embedded) fn steady_state<M: Mathematics<f64>>(
    scene: &Scene,
    model: &ContactSeparation,
    options: &Options,
) -> Result<Outcome, Failure> {
    prepared::<f64, M, _>(scene, model, options, |run, state| match options.method {
        Method::Rk4 => run.steady(RungeKutta4, state),
        Method::Auto | Method::TrBdf2 | Method::Reference => run.steady(TrBdf2, state),
    })
}

/// The resonance in a range of frequencies, and the simulated periods it took.
pub(in crate::embedded) fn resonance_peak<M: Mathematics<f64>>(
    scene: &Scene,
    model: &ContactSeparation,
    range: [f64; 2],
    points: usize,
    options: &Options,
) -> Result<(Option<Resonance>, f64), Failure> {
    let mut spent = Spent::default();
    let mut known = None;
    let found = resonance(range, points, |frequency_hz| {
        let mut scene = scene.clone();
        if let Excitation::Sine(tone) = &mut scene.excitation {
            tone.frequency_hz = frequency_hz;
        }
        prepared::<f64, M, _>(&scene, model, options, |run, state| match options.method {
            Method::Rk4 => run.response(RungeKutta4, state, &mut known, &mut spent),
            Method::Auto | Method::TrBdf2 | Method::Reference => {
                run.response(TrBdf2, state, &mut known, &mut spent)
            }
        })
    })?;
    Ok((found, spent.periods))
}

type KnownOrbit = Orbit<Mode, STATES, { account::WHOLE }>;

impl<M: Mathematics<f64>> Run<'_, f64, M> {
    fn shaken<'a, I>(
        &'a self,
        driver: &'a Driver<I, AnyStepControl<f64>>,
    ) -> Shaken<'a, Harvester<f64, AnyParts<M>>, HostExcitation<'a, f64, M>, I> {
        Shaken {
            harvester: self.harvester,
            excitation: self.excitation,
            frequency_hz: self.scene.excitation.single_frequency().unwrap_or(f64::NAN),
            driver,
        }
    }

    /// Gap, velocity and charge as large as they are in a motion that uses the whole gap.
    fn search(&self) -> Search<STATES> {
        let from = &self.model.parameters;
        let tribo_charge = from.charge_density_c_per_m2 * from.electrode_area_m2;
        Search::new([
            from.initial_gap_m,
            from.initial_gap_m * self.harvester.angular_frequency(),
            // A harvester without charge has no electrical motion; its unit is as good as any.
            if tribo_charge > 0.0 { tribo_charge / self.harvester.charge_unit() } else { 1.0 },
        ])
    }

    fn steady<I: Integrator<f64>>(&self, integrator: I, state: State<f64>) -> Result<Outcome, Failure> {
        let began = Stopwatch::now();
        let driver = Driver::new(integrator, self.control);
        let shaken = self.shaken(&driver);
        let mut spent = Spent::default();
        let verdict = shaken
            .steady_state(state, &self.search(), &mut spent)
            .map_err(|error| step_failure(&error, self.harvester, &state))?;
        let (start, span) = match &verdict {
            Verdict::StablePeriodOne(orbit) => {
                let settle_s = orbit.start.clock.seconds::<f64>();
                let duration_s = settle_s + 1.0 / shaken.frequency_hz;
                (orbit.start, RunSpan { duration_s, settle_s })
            }
            Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound => {
                (state, self.scene.run)
            }
        };
        let mut outcome = self.measured(&driver, start, &span)?;
        let from = start.clock.seconds::<f64>();
        outcome.steady_state = Some(SteadyState {
            steady_state: verdict.name(),
            largest_multiplier: verdict.orbit().map(Orbit::largest_multiplier),
            simulated_periods: spent.periods + (span.duration_s - from) * shaken.frequency_hz,
        });
        outcome.steps += spent.steps;
        outcome.rejected_steps += spent.rejected;
        outcome.newton_iterations += spent.iterations;
        outcome.events += spent.events;
        outcome.wall_s = began.elapsed().as_secs_f64();
        if let (Verdict::StablePeriodOne(_), Particular::ContactSeparation(motion)) =
            (&verdict, &mut outcome.particular)
        {
            motion.first_impact_s = None;
        }
        Ok(outcome)
    }

    /// The response of the stable orbit that `known` becomes here, or else of the steady state from the
    /// scene's start; the orbit is the known one from then on.
    fn response<I: Integrator<f64>>(
        &self,
        integrator: I,
        state: State<f64>,
        known: &mut Option<KnownOrbit>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        let driver = Driver::new(integrator, self.control);
        let shaken = self.shaken(&driver);
        let followed = known.as_ref().and_then(|orbit| shaken.continued(orbit, spent));
        let orbit = match followed.filter(Orbit::is_stable) {
            Some(orbit) => Some(orbit),
            None => match shaken
                .steady_state(state, &self.search(), spent)
                .map_err(|error| step_failure(&error, self.harvester, &state))?
            {
                Verdict::StablePeriodOne(orbit) => Some(orbit),
                Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound => None,
            },
        };
        let response = orbit.as_ref().and_then(|orbit| shaken.response(orbit, spent));
        *known = orbit;
        Ok(response)
    }
}
