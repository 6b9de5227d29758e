//! The periodic steady state of a scene, and its resonance, by shooting.
//!
//! Triboelectric scenes, bare or behind a bridge into a bus of constant voltage, and bump-stop are one [`Kind`] each.

mod beam;
mod triboelectric;

use std::any::Any;
use std::sync::Arc;

use cpu_time::ThreadTime;
use model_core::scalar::Mathematics;

use self::beam::beam;
use self::triboelectric::{bare, bridged};
use super::Search;
use super::excitation::{HostExcitation, Setting, with_setting};
use super::report::Report;
use super::run::Run;
use crate::steady_state::{
    BestLoad, Coordinates, ForcedSystem, MOST_ATTEMPTS, Orbit, Resonance, Response, Spent, Verdict,
    best_load, resonance,
};
use harvester_scene::method::{Failure, Options};
use harvester_scene::outcome::{Outcome, Particular, SteadyState};
use harvester_scene::scene_file::{Excitation, Load, RunSpan, Scene};

/// One kind of scene, with the orbit that it has found last.
trait Kind {
    /// The outcome of one period of the stable orbit that continues a remembered one. Where there is none: that of the stable
    /// orbit to which the motion goes from the remembered one, without one from the scene's start; of the whole run where there
    /// is none.
    fn resume(
        &self,
        setting: Setting<'_, f64>,
        memory: Option<&Memory>,
    ) -> Result<(Outcome, Memory), Failure>;

    /// The response of the stable orbit that continues the last one, or else of the one from the scene's start.
    fn follow(&mut self, setting: Setting<'_, f64>, spent: &mut Spent) -> Result<Option<Response>, Failure>;
}

fn kind<'a, M: Mathematics<f64> + 'a>(scene: &'a Scene) -> Box<dyn Kind + 'a> {
    let resistive = matches!(scene.load, Load::Resistor { .. });
    by_harvester!(scene,
        triboelectric(model) => match resistive {
            true => bare::<M, _>(model),
            false => bridged::<M, _>(model),
        },
        bump_stop(model) => beam(scene, model))
}

/// [`Kind::resume`] of a scene.
pub(super) fn resume<M: Mathematics<f64>>(
    scene: &Scene,
    options: &Options,
    memory: Option<&Memory>,
) -> Result<(Outcome, Memory), Failure> {
    with_setting::<f64, M, _>(scene, options, |setting| kind::<M>(setting.scene).resume(setting, memory))
}

/// The peaks over the frequencies of a search, and the simulated periods that they took; calls `done` after each frequency.
pub(super) fn peaks<M: Mathematics<f64>>(
    scene: &Scene,
    search: &Search,
    options: &Options,
    done: &mut dyn FnMut(),
) -> Result<(Option<Resonance>, f64), Failure> {
    let (mut kind, mut spent) = (kind::<M>(scene), Spent::default());
    let mut scene = scene.clone();
    let found = resonance(search.range_hz, search.points, search.with_power, |frequency_hz| {
        if let Excitation::Sine(tone) = &mut scene.excitation {
            tone.frequency_hz = frequency_hz;
        }
        done();
        with_setting::<f64, M, _>(&scene, options, |setting| kind.follow(setting, &mut spent))
    })?;
    Ok((found, spent.periods))
}

/// The resistance that takes the most power at the frequency of the scene, and the simulated periods that it took; calls
/// `done` after each resistance.
pub(super) fn best_resistance<M: Mathematics<f64>>(
    scene: &Scene,
    options: &Options,
    done: &mut dyn FnMut(),
) -> Result<(Option<BestLoad>, f64), Failure> {
    let mut scene = Scene { load: Load::Resistor { resistance_ohm: 1.0 }, ..scene.clone() };
    let like = scene.clone();
    let (mut kind, mut spent) = (kind::<M>(&like), Spent::default());
    let found = best_load(|resistance_ohm| {
        scene.load = Load::Resistor { resistance_ohm };
        done();
        with_setting::<f64, M, _>(&scene, options, |setting| kind.follow(setting, &mut spent))
    })?;
    Ok((found, spent.periods))
}

/// A motion of any harvester under one sine: its orbit, or a state at the end of a run where it has none.
#[derive(Clone)]
pub struct Memory {
    motion: Arc<dyn Any + Send + Sync>,
    is_orbit: bool,
}

impl Memory {
    /// Whether the motion has a stable orbit of one period.
    pub fn is_orbit(&self) -> bool {
        self.is_orbit
    }
}

/// What a [`Memory`] holds of a harvester with the state `T`.
enum Known<T> {
    Orbit(Orbit<T>),
    /// A state at a phase, in periods from the beginning of one.
    State(T, f64),
}

impl std::fmt::Debug for Memory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Memory")
    }
}

/// A harvester under the sine of a scene.
fn forced<'a, H>(
    harvester: &'a H,
    setting: &'a Setting<'_, f64>,
) -> ForcedSystem<'a, H, HostExcitation<'a, f64>> {
    ForcedSystem {
        harvester,
        excitation: &setting.excitation,
        frequency_hz: setting.scene.excitation.single_frequency().unwrap_or(f64::NAN),
        most_attempts: setting.options.most_attempts.unwrap_or(MOST_ATTEMPTS),
    }
}

/// An outcome, and the motion that it is of.
type Reached<T> = (Outcome, Known<T>);

/// The outcome of the motion that a run from `start` of a harvester whose coordinates are of the size `typical` reaches.
fn reached<H: Coordinates, R: Report<f64, H>>(
    run: &Run<'_, f64, H, R>,
    start: H::State,
    typical: &[f64],
) -> Result<Reached<H::State>, Failure> {
    let forced = forced(run.harvester, &run.setting);
    let began = ThreadTime::now();
    let mut spent = Spent::default();
    let verdict = forced
        .steady_state(start, typical, &mut spent)
        .map_err(|failure| with_message(run, failure, &start))?;
    let (mut outcome, end) = described(run, start, &verdict, &spent)?;
    outcome.processor_s = began.elapsed().as_secs_f64();
    let motion = match verdict {
        Verdict::StablePeriodOne(orbit) => Known::Orbit(orbit),
        Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound(_) => {
            let periods = run.harvester.clock(&end).seconds::<f64>() * forced.frequency_hz;
            Known::State(end, periods.fract())
        }
    };
    Ok((outcome, motion))
}

/// [`Kind::resume`] for a harvester with a start, and coordinates of the size `typical`.
fn remembered<H, R>(
    run: &Run<'_, f64, H, R>,
    start: H::State,
    typical: &[f64],
    memory: Option<&Memory>,
) -> Result<(Outcome, Memory), Failure>
where
    H: Coordinates,
    H::State: Send + Sync + 'static,
    R: Report<f64, H>,
{
    let keep = |motion: Known<H::State>| Memory {
        is_orbit: matches!(motion, Known::Orbit(_)),
        motion: Arc::new(motion),
    };
    let known = memory.and_then(|memory| memory.motion.downcast_ref::<Known<H::State>>());
    let forced = forced(run.harvester, &run.setting);
    let mut spent = Spent::default();
    let orbit = if let Some(Known::Orbit(orbit)) = known { Some(orbit) } else { None };
    let continued = orbit.and_then(|orbit| forced.continued(orbit, &mut spent)).filter(Orbit::is_stable);
    if let Some(orbit) = continued {
        let verdict = Verdict::StablePeriodOne(orbit.clone());
        let (outcome, _) = described(run, start, &verdict, &spent)?;
        return Ok((outcome, keep(Known::Orbit(orbit))));
    }
    let from = match known {
        Some(Known::Orbit(orbit)) => forced.resumed(&orbit.start, orbit.phase()),
        Some(Known::State(state, phase)) => forced.resumed(state, *phase),
        None => None,
    };
    let (outcome, motion) = reached(run, from.unwrap_or(start), typical)?;
    Ok((outcome, keep(motion)))
}

/// The outcome of a verdict: of one period of its orbit, or of the run from `start`; and the state at its end.
fn described<H: Coordinates, R: Report<f64, H>>(
    run: &Run<'_, f64, H, R>,
    start: H::State,
    verdict: &Verdict<H::State>,
    spent: &Spent,
) -> Result<(Outcome, H::State), Failure> {
    let forced = forced(run.harvester, &run.setting);
    let began = ThreadTime::now();
    let (from, span) = match verdict {
        Verdict::StablePeriodOne(orbit) => {
            let settle_s = run.harvester.clock(&orbit.start).seconds::<f64>();
            (orbit.start, RunSpan { duration_s: settle_s + 1.0 / forced.frequency_hz, settle_s })
        }
        Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound(_) => {
            (start, run.setting.scene.run)
        }
    };
    let mut end = from;
    let mut outcome = run.measured(&mut end, &span)?;
    let simulated_s = span.duration_s - run.harvester.clock(&from).seconds::<f64>();
    outcome.steady_state = Some(SteadyState {
        steady_state: verdict.name(),
        largest_multiplier: verdict.orbit().map(Orbit::largest_multiplier),
        steady_state_residual: verdict.residual(),
        simulated_periods: spent.periods + simulated_s * forced.frequency_hz,
    });
    outcome.warnings.extend(warning(verdict));
    outcome.steps += spent.work.steps;
    outcome.rejected_steps += spent.work.rejected;
    outcome.newton_iterations += spent.work.iterations;
    outcome.events += spent.work.events;
    outcome.processor_s = began.elapsed().as_secs_f64();
    if outcome.is_of_an_orbit() {
        // Each period is like the others: parts of one, from another phase in another run, are no samples.
        let parts = outcome.block_energies_j.len() as f64;
        outcome.block_energies_j.fill(outcome.delivered_energy_j.unwrap_or(0.0) / parts);
        // An orbit has no first impact or contact.
        match &mut outcome.particular {
            Particular::ContactSeparation(motion) => motion.first_impact_s = None,
            Particular::BumpStop(motion) => motion.first_contact_s = None,
            Particular::Sliding(_) => {}
        }
    }
    Ok((outcome, end))
}

/// The failure of a search; of a step that cannot be taken, with the state at the start.
fn with_message<H: Coordinates, R: Report<f64, H>>(
    run: &Run<'_, f64, H, R>,
    failure: Failure,
    start: &H::State,
) -> Failure {
    match failure {
        Failure::Step(error) => run.step_failure(error, start),
        other => other,
    }
}

/// What to know where the numbers are not those of an orbit.
fn warning<T>(verdict: &Verdict<T>) -> Option<String> {
    let why = match verdict {
        Verdict::StablePeriodOne(_) => return None,
        Verdict::NotReached(_) => "the transient has not come to the stable orbit of one period".to_owned(),
        Verdict::UnstablePeriodOne(_) => "the orbit of one period is unstable".to_owned(),
        Verdict::NotFound(left) if left.residual.is_finite() => format!(
            "shooting found no orbit of one period: the state still changes by {:.1e} of its half range over a period",
            left.residual
        ),
        Verdict::NotFound(_) => "shooting found no orbit of one period: the period map fails".to_owned(),
    };
    Some(format!("steady state: {why}; the numbers are those of the run, transient included up to settle_s"))
}

/// [`Kind::follow`] for a harvester with a start, and coordinates of the size `typical`.
fn follow<H: Coordinates, R: Report<f64, H>>(
    run: &Run<'_, f64, H, R>,
    start: H::State,
    typical: &[f64],
    known: &mut Option<Orbit<H::State>>,
    spent: &mut Spent,
) -> Result<Option<Response>, Failure> {
    let found = forced(run.harvester, &run.setting).followed(known, start, typical, spent);
    found.map_err(|failure| with_message(run, failure, &start))
}
