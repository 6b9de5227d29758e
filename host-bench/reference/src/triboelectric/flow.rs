//! Flow between events: diffsol's BDF, with the events located on its dense output.
//!
//! Local time starts at zero with each flow. The root finder of the crate is not used, because it takes a zero
//! at the start of a flow for an event. Instead each accepted step is cut where the velocity changes sign. The
//! position is then monotone in every piece, so a short hop or a graze inside one step is found too.

use diffsol::error::DiffsolError;
use diffsol::{
    NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquationsImplicit, OdeSolverMethod,
    OdeSolverProblem, OdeSolverStopReason,
};

use super::bridge::{Switch, SwitchSearch, earlier};
use super::harvester::{Dense, Guards, Harvester, Motion, Sample, Scales, SceneEvent};
use crate::ledger::{Effort, Integrals};
use harvester_scene::base_motion::LocalBase;
use harvester_scene::root::far_side;

/// Failures of the Newton iteration that one step may have.
const MOST_FAILURES: usize = 50;

/// Steps within which a flow must make progress.
const STALL: usize = 100_000;

/// Absolute tolerance over the relative tolerance of a quantity of its full size. The voltage between its
/// peaks, the speed of a small hop and a creeping motion need it small.
const ABSOLUTE: f64 = 1e-2;

/// One accepted step, or the part of it before an event.
pub(crate) struct Step<'a> {
    /// Local start in s.
    pub(crate) from: f64,
    /// Local end in s.
    pub(crate) to: f64,
    /// Local times between the ends at which the velocity changes sign.
    pub(crate) turns: Vec<f64>,
    /// Motion at a local time between the ends.
    pub(crate) motion: &'a Dense<'a, Motion>,
    /// Integrals since the start of the flow, at a local time between the ends.
    pub(crate) integrals: &'a Dense<'a, Integrals>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Event<E> {
    /// An event of the scene.
    Scene(E),
    /// The bridge or the draw switches.
    Switch(Switch),
}

/// The integrals over a flow and the event that ended it, if the time was not up.
pub(crate) type FlowEnd<H> = (Integrals, Option<Event<SceneEvent<H>>>);

#[derive(Debug)]
pub(crate) struct Reason(pub(crate) String);

impl From<DiffsolError> for Reason {
    /// The first line of the error; times in it are local.
    fn from(error: DiffsolError) -> Self {
        let text = error.to_string();
        Self(format!("integrator, in local time: {}", text.lines().next().unwrap_or("failed")))
    }
}

/// A flow from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flow<'a, H> {
    pub(crate) harvester: &'a H,
    pub(crate) base: &'a LocalBase,
    pub(crate) start: Motion,
    pub(crate) scales: &'a Scales,
    /// Relative tolerance of the integrator.
    pub(crate) tolerance: f64,
}

impl<H: Harvester> Flow<'_, H> {
    /// Flows for `span` seconds or until an event, and shows each step to `watch`. Gives the integrals over the
    /// flow and the event; `last` is the motion at the end, or the last good one.
    pub(crate) fn run(
        &self,
        span: f64,
        effort: &mut Effort,
        last: &mut Sample,
        watch: &mut dyn FnMut(&Step<'_>) -> Result<(), DiffsolError>,
    ) -> Result<FlowEnd<H>, Reason> {
        let problem = problem(self.harvester, self.base, self.start, self.tolerance, self.sizes())?;
        let mut solver = problem.bdf::<NalgebraLU<f64>>()?;
        // The first step after an impact on a tiny load is tiny.
        solver.config_mut().minimum_timestep = 1e-30;
        solver.set_stop_time(span)?;
        let mut search = Search::new(self);
        let mut checked = (0, 0.0);
        loop {
            // The crate counts the failures of a whole flow; the limit is meant for one step.
            let failures = solver.get_statistics().number_of_nonlinear_solver_fails;
            solver.config_mut().maximum_newton_fails = failures + MOST_FAILURES;
            let finished = matches!(solver.step()?, OdeSolverStopReason::TstopReached);
            let motion = |t: f64| Ok(self.start.with(solver.interpolate(t)?.batch_as_slice(0)));
            let integrals = |t: f64| Ok(integrals_of(solver.interpolate_out(t)?.batch_as_slice(0)));
            let (from, to) = (last.0, solver.state().t);
            let mut step = Step { from, to, turns: Vec::new(), motion: &motion, integrals: &integrals };
            let event = search.cut(&mut step)?;
            watch(&step)?;
            *last = (step.to, motion(step.to)?);
            let (elapsed, motion) = *last;
            if !self.harvester.is_in_range(&motion) {
                return Err(Reason("the motion left the model".to_owned()));
            }
            let statistics = solver.get_statistics();
            if statistics.number_of_steps > checked.0 + STALL {
                if elapsed - checked.1 < H::LEAST_PROGRESS * self.scales.time {
                    return Err(Reason(format!("stalled: {STALL} steps without progress")));
                }
                checked = (statistics.number_of_steps, elapsed);
            }
            if event.is_some() || finished {
                effort.add(statistics);
                return Ok((integrals(step.to)?, event));
            }
        }
    }

    /// Sizes of the states and of the integrals.
    fn sizes(&self) -> (Vec<f64>, Vec<f64>) {
        let Scales { position, velocity, voltage, time, energy, surface_energy, charge } = *self.scales;
        let mut states = vec![position, velocity, voltage];
        let mut integrals =
            vec![voltage * voltage * time, voltage * time, energy, energy, surface_energy, surface_energy];
        if let Some(storage) = &self.harvester.load().storage {
            let (gain, energies) = storage.scales(charge, energy);
            states.push(gain);
            integrals.extend(energies);
        }
        (states, integrals)
    }
}

/// The equations of a harvester behind a reference, so that the integrator is compiled once for all harvesters.
trait Equations {
    fn rates(&self, motion: &Motion, base: f64) -> [f64; Motion::STATES];

    fn rates_along(&self, motion: &Motion, change: &Motion) -> [f64; Motion::STATES];

    fn integrands(&self, motion: &Motion, base: f64) -> Integrals;
}

impl<H: Harvester> Equations for H {
    fn rates(&self, motion: &Motion, base: f64) -> [f64; Motion::STATES] {
        Harvester::rates(self, motion, base)
    }

    fn rates_along(&self, motion: &Motion, change: &Motion) -> [f64; Motion::STATES] {
        Harvester::rates_along(self, motion, change)
    }

    fn integrands(&self, motion: &Motion, base: f64) -> Integrals {
        Harvester::integrands(self, motion, base)
    }
}

/// The equations of motion and the integrands for the integrator; `sizes` are those of the states and of the integrals.
fn problem<'a>(
    harvester: &'a dyn Equations,
    base: &'a LocalBase,
    start: Motion,
    tolerance: f64,
    (states, integrals): (Vec<f64>, Vec<f64>),
) -> Result<
    OdeSolverProblem<
        impl OdeEquationsImplicit<M = NalgebraMat<f64>, V = NalgebraVec<f64>, T = f64, C = NalgebraContext> + 'a,
    >,
    DiffsolError,
> {
    let (states_count, integrals_count) = (states.len(), integrals.len());
    let absolute =
        |sizes: Vec<f64>| -> Vec<f64> { sizes.into_iter().map(|size| ABSOLUTE * tolerance * size).collect() };
    OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance)
        .atol(absolute(states))
        .out_rtol(tolerance)
        .out_atol(absolute(integrals))
        .rhs_implicit(
            move |x: &[f64], _: &[f64], t: f64, rates: &mut [f64]| {
                let all = harvester.rates(&start.with(x), base.at(t));
                rates.copy_from_slice(&all[..states_count]);
            },
            move |x: &[f64], _: &[f64], _: f64, change: &[f64], rates: &mut [f64]| {
                let all = harvester.rates_along(&start.with(x), &start.with(change));
                rates.copy_from_slice(&all[..states_count]);
            },
        )
        .init(
            move |_: &[f64], _: f64, x: &mut [f64]| x.copy_from_slice(&start.states()[..states_count]),
            states_count,
        )
        .out_implicit(
            move |x: &[f64], _: &[f64], t: f64, powers: &mut [f64]| {
                let all = harvester.integrands(&start.with(x), base.at(t));
                powers.copy_from_slice(&all[..integrals_count]);
            },
            // Only sensitivities need the derivative of the integrands.
            |_: &[f64], _: &[f64], _: f64, _: &[f64], change: &mut [f64]| change.fill(0.0),
            integrals_count,
        )
        .integrate_out(true)
        .build()
}

/// The integrals of which the first are given; those of a bridge are zero without one.
fn integrals_of(values: &[f64]) -> Integrals {
    let mut integrals = Integrals::default();
    integrals[..values.len()].copy_from_slice(values);
    integrals
}

/// The search for events along a flow.
struct Search<'a, H: Harvester> {
    flow: &'a Flow<'a, H>,
    guards: H::Guards,
    bridge: Option<SwitchSearch<'a>>,
}

impl<'a, H: Harvester> Search<'a, H> {
    fn new(flow: &'a Flow<'a, H>) -> Self {
        let Motion { voltage, bridge, .. } = flow.start;
        let storage = flow.harvester.load().storage.as_ref();
        Self {
            flow,
            guards: flow.harvester.guards(&flow.start),
            bridge: storage.map(|storage| SwitchSearch::new(storage, bridge, voltage)),
        }
    }

    /// The first event of the scene in a step, and the turns before it.
    fn scene_event(&mut self, step: &mut Step<'_>) -> Result<Option<(f64, SceneEvent<H>)>, DiffsolError> {
        let (Flow { harvester, base, .. }, motion) = (self.flow, step.motion);
        let acceleration = |t: f64| Ok(harvester.acceleration(&motion(t)?, base.at(t)));
        let mut begin = (step.from, motion(step.from)?);
        for cut in self.guards.cuts(&acceleration, step.from, step.to)? {
            let end = (cut, motion(cut)?);
            if begin.1.velocity != 0.0 && (begin.1.velocity > 0.0) != (end.1.velocity > 0.0) {
                let turn = far_side(|t| Ok::<_, DiffsolError>(motion(t)?.velocity), begin.0, cut)?;
                let end = (turn, motion(turn)?);
                if let Some(event) = self.guards.event(motion, begin, end)? {
                    return Ok(Some(event));
                }
                step.turns.push(turn);
                begin = end;
            }
            if let Some(event) = self.guards.event(motion, begin, end)? {
                return Ok(Some(event));
            }
            begin = end;
        }
        Ok(None)
    }

    /// Cuts a step at its first event, if there is one, and finds the turns before it.
    fn cut(&mut self, step: &mut Step<'_>) -> Result<Option<Event<SceneEvent<H>>>, DiffsolError> {
        let (from, to, motion) = (step.from, step.to, step.motion);
        let harvester = self.flow.harvester;
        let mut event = self.scene_event(step)?.map(|(at, event)| (at, Event::Scene(event)));
        if let Some(bridge) = &mut self.bridge {
            let at = |t: f64| motion(t).map(|motion| (harvester.port(&motion), motion.bridge));
            let until = event.map_or(to, |(at, _)| at);
            let switch = bridge.first(from, until, &step.turns, &at)?;
            event = earlier(event, switch.map(|(at, switch)| (at, Event::Switch(switch))), to - from);
        }
        step.to = event.map_or(to, |(at, _)| at);
        step.turns.retain(|turn| *turn < step.to);
        Ok(event.map(|(_, event)| event))
    }
}
