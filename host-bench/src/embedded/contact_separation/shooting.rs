//! The periodic steady state of a contact-separation scene, and its resonance, by shooting.

use model_core::hybrid::Driver;
use model_core::integrate::{AnyStepControl, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::scalar::Mathematics;
use model_core::scene::account;
use model_core::scene::contact_separation::{AnyParts, ContactSeparation as Harvester, Mode, STATES};

use super::{Run, State, prepared, step_failure};
use crate::embedded::excitation::HostExcitation;
use crate::embedded::steady_state::sought;
use crate::method::{Failure, Method, Options};
use crate::outcome::{Outcome, Particular};
use crate::scene_file::{ContactSeparation, Excitation, Scene};
use crate::steady_state::{Orbit, Resonance, Response, Search, Shaken, Spent, resonance};

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

    fn steady<I: Integrator<f64>>(&self, integrator: I, start: State<f64>) -> Result<Outcome, Failure> {
        let driver = Driver::new(integrator, self.control);
        let mut outcome = sought(
            &self.shaken(&driver),
            start,
            &self.search(),
            &self.scene.run,
            |error| step_failure(&error, self.harvester, &start),
            |from, span| self.measured(&driver, from, span),
        )?;
        if outcome.is_of_an_orbit() {
            let Particular::ContactSeparation(motion) = &mut outcome.particular;
            motion.first_impact_s = None;
        }
        Ok(outcome)
    }

    fn response<I: Integrator<f64>>(
        &self,
        integrator: I,
        start: State<f64>,
        known: &mut Option<KnownOrbit>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        let driver = Driver::new(integrator, self.control);
        let found = self.shaken(&driver).followed(known, start, &self.search(), spent);
        found.map_err(|error| step_failure(&error, self.harvester, &start))
    }
}
