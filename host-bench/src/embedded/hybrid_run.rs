//! A run of any scene that advances by the core's hybrid driver: a position, a velocity, a charge, and behind a
//! bridge the voltage of a store.

use std::fmt::Display;
use std::time::Instant as Stopwatch;

use model_core::clock::{Instant, LONGEST_STEP_S};
use model_core::energy::{Ledger, Peak, Residual, RunMeter};
use model_core::hybrid::{Automaton, Driver, Event, HybridState, Observer, Span, StepError, Work};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::{Harvester, account};

use super::excitation::HostExcitation;
use super::recorder::Recorder;
use super::{DEFAULT_TOLERANCE, method_name, precision_name};
use crate::method::{Failure, Method, Options};
use crate::outcome::{Outcome, Particular, Recording, StoreOutcome};
use crate::scene_file::{RunSpan, Scene};

/// States of a scene without a store: position in m, velocity in m/s, charge in units of the scene.
pub(super) const STATES: usize = 3;
/// Entries of the account that a run integrates: all.
pub(super) const WHOLE: usize = account::WHOLE;

/// The modes of a hosted scene of `N` states.
pub(super) type ModeOf<S, H, const N: usize> =
    <<H as HostedScene<S, N>>::Core as Automaton<S, N, WHOLE>>::Mode;

/// A scene of the core, with what a report asks beside. The first three states are those of every such scene.
pub(super) trait HostedScene<S: Scalar, const N: usize> {
    /// The harvester of the core.
    type Core: Harvester<S, N, WHOLE>;

    /// The harvester.
    fn core(&self) -> &Self::Core;

    /// Columns of a trace: time, position, velocity, charge, voltage, base acceleration, held, and with a
    /// store its voltage.
    fn columns(&self, with_store: bool) -> &'static [&'static str];

    /// The charge in a state, in units of the scene.
    fn charge(&self, _mode: ModeOf<S, Self, N>, state: &[S; N]) -> S {
        state[2]
    }

    /// The store behind a bridge, if there is one.
    fn store(&self, _mode: ModeOf<S, Self, N>, _state: &[S; N]) -> Option<Store<S>> {
        None
    }

    /// The transferred charge in coulombs at a position and a charge.
    fn coulombs(&self, position: S, charge: S) -> S;

    /// How large position, velocity and charge of the state typically are.
    fn typical(&self) -> [f64; STATES];

    /// The relative residual of the energy ledger that holds for this scene.
    fn residual(&self, residual: &Residual<S>) -> Option<S>;

    /// The numbers that only this kind of scene has.
    fn particular(&self, found: &Found<S>) -> Particular;
}

/// What a store holds.
pub(super) struct Store<S> {
    /// Voltage in V.
    pub(super) voltage: S,
    /// Energy in J; `None` for a bus, which has no end.
    pub(super) energy: Option<S>,
}

/// What a run found, for the scene to make its own numbers of.
pub(super) struct Found<S> {
    /// Extremes of the position in the window, in m.
    pub(super) coordinate: Peak<S>,
    pub(super) impacts: u32,
    /// Largest impact speed in the window, in m/s.
    pub(super) fastest_impact: S,
    pub(super) sticks: u32,
    pub(super) stick_fraction: S,
    /// Time of the first impact of the whole run.
    pub(super) first_impact: Option<Instant>,
    /// Periods of the base in the window, where it moves in one sine.
    pub(super) periods: Option<f64>,
}

/// A tribo-charge in units of the state; one without charge has no electrical motion, and its unit is as
/// good as any.
pub(super) fn unit_of_charge(tribo_charge: f64, charge_unit: f64) -> f64 {
    if tribo_charge > 0.0 { tribo_charge / charge_unit } else { 1.0 }
}

/// The refusal of a parameter by the core.
pub(super) fn refuse_parameter(scene: &Scene, error: &dyn Display) -> Failure {
    Failure::Input(format!("{}: parameters.{error}", scene.file.display()))
}

/// The refusal of a start by the core.
pub(super) fn refuse_start(scene: &Scene, error: &dyn Display) -> Failure {
    Failure::Input(format!("{}: initial.{error}", scene.file.display()))
}

/// The instants from which a run is measured and at which it ends.
pub(super) fn ends_of(scene: &Scene, span: &RunSpan) -> Result<[Instant; 2], Failure> {
    let instant = |seconds: f64| {
        Instant::from_seconds(seconds).ok_or_else(|| {
            Failure::Input(format!("{}: run: {seconds} s, must be below 16777216", scene.file.display()))
        })
    };
    Ok([instant(span.settle_s)?, instant(span.duration_s)?])
}

/// The shortest step for which the explicit method is run without being told to.
const SHORTEST_EXPLICIT_STEP_S: f64 = 1e-7;

/// The rule for the length of steps that the options ask for; `explicit` is the step at which an
/// explicit method is stable and accurate, in s.
pub(super) fn step_control<S: Scalar>(
    scene: &Scene,
    options: &Options,
    explicit: f64,
) -> Result<AnyStepControl<S>, Failure> {
    let refuse = |text: String| Err(Failure::Input(text));
    match options.method {
        Method::DiscreteGradient => {
            return refuse("--method discrete-gradient: must be with a bump-stop scene".to_owned());
        }
        Method::Newmark => return refuse("--method newmark: must be with a bump-stop scene".to_owned()),
        Method::Auto | Method::TrBdf2 | Method::Rk4 | Method::Reference => {}
    }
    if options.long_step_s.is_some() {
        return refuse("--long-step: must be with a bump-stop scene".to_owned());
    }
    match (options.step_s, options.tolerance, options.method) {
        (Some(step), _, _) if step > LONGEST_STEP_S => {
            refuse(format!("--step {step}: must be at most {LONGEST_STEP_S:.6} s"))
        }
        (Some(step), _, _) => Ok(AnyStepControl::Fixed(FixedStep::of_seconds(S::from_f64(step)))),
        (None, Some(_), Method::Rk4) => refuse(
            "--tolerance: must not be given with rk4, which has no error estimate; give --step".to_owned(),
        ),
        (None, None, Method::Rk4) if explicit < SHORTEST_EXPLICIT_STEP_S => refuse(format!(
            "--method rk4: {} needs steps of {explicit:.1e} s to be stable, must be at least \
             {SHORTEST_EXPLICIT_STEP_S:e} s; use tr-bdf2",
            scene.file.display()
        )),
        (None, None, Method::Rk4) => {
            let step = explicit.min(LONGEST_STEP_S);
            Ok(AnyStepControl::Fixed(FixedStep::of_seconds(S::from_f64(step))))
        }
        (None, Some(tolerance), _) if S::from_f64(tolerance) < S::EPSILON => refuse(format!(
            "--tolerance {tolerance:e}: must be at least {:e} in {}",
            S::EPSILON.to_f64(),
            precision_name::<S>()
        )),
        (None, tolerance, _) => {
            Ok(AnyStepControl::Adaptive(Adaptive::new(S::from_f64(tolerance.unwrap_or(DEFAULT_TOLERANCE)))))
        }
    }
}

/// The time of the first impact.
struct FirstImpact<'a, H> {
    harvester: &'a H,
    at: Option<Instant>,
}

impl<S, H, const N: usize> Observer<S, H::Mode, N, WHOLE> for FirstImpact<'_, H>
where
    S: Scalar,
    H: Harvester<S, N, WHOLE>,
{
    fn step(&mut self, _span: &Span<'_, S, H::Mode, N, WHOLE>) {}

    fn event(&mut self, event: &Event<'_, S, H::Mode, N, WHOLE>) {
        if self.at.is_none() && self.harvester.is_impact(event.before, event.guard) {
            self.at = Some(event.at);
        }
    }
}

/// Attempts per call: the counts of a call fit in 32 bits.
const BUDGET: u32 = 1 << 24;

/// What a run of a scene of `N` states needs.
pub(super) struct Run<'a, S: Scalar, M, H, const N: usize> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a Options,
    pub(super) hosted: &'a H,
    pub(super) excitation: &'a HostExcitation<'a, S, M>,
    pub(super) control: AnyStepControl<S>,
}

impl<S: Scalar, M: Mathematics<S>, H: HostedScene<S, N>, const N: usize> Run<'_, S, M, H, N> {
    /// Runs from `state` to the end of the scene by the method of the options.
    pub(super) fn to_end(
        &self,
        state: HybridState<S, ModeOf<S, H, N>, N, WHOLE>,
    ) -> Result<Outcome, Failure> {
        match self.options.method {
            Method::Rk4 => self.with(RungeKutta4, state),
            Method::Auto
            | Method::TrBdf2
            | Method::DiscreteGradient
            | Method::Newmark
            | Method::Reference => self.with(TrBdf2, state),
        }
    }

    fn with<I: Integrator<S>>(
        &self,
        integrator: I,
        state: HybridState<S, ModeOf<S, H, N>, N, WHOLE>,
    ) -> Result<Outcome, Failure> {
        self.measured(&Driver::new(integrator, self.control), state, &self.scene.run)
    }

    /// The outcome of a run from `state` to the end of `span`.
    pub(super) fn measured<I: Integrator<S>>(
        &self,
        driver: &Driver<I, AnyStepControl<S>>,
        mut state: HybridState<S, ModeOf<S, H, N>, N, WHOLE>,
        span: &RunSpan,
    ) -> Result<Outcome, Failure> {
        let Self { scene, options, hosted, excitation, .. } = self;
        let harvester = hosted.core();
        let [settled, end] = ends_of(scene, span)?;
        let mut ledger = Ledger::open(harvester, &state);
        let mut first_impact = FirstImpact { harvester, at: None };
        let mut meter = RunMeter::new(harvester);
        let every = options.trace_every_s.unwrap_or(f64::INFINITY);
        let mut recorder = Recorder { hosted: *hosted, excitation, every, rows: Vec::new() };
        let mut total = Total::default();
        let began = Stopwatch::now();
        // One pass over each stretch; the recorder joins in only if a trace was asked for.
        for (until, measured) in [(settled, false), (end, true)] {
            let mut whole = (&mut ledger, &mut first_impact);
            let mut recording = options.trace_every_s.map(|_| &mut recorder);
            let mut measuring = measured.then_some(&mut meter);
            let mut others = (&mut recording, &mut measuring);
            let mut observer = (&mut whole, &mut others);
            while state.clock < until {
                let left =
                    options.most_attempts.map_or(u64::MAX, |most| most.saturating_sub(total.attempts()));
                if left == 0 {
                    return Err(self.given_up(&state));
                }
                let budget = u32::try_from(left).unwrap_or(BUDGET).min(BUDGET);
                let advance = driver
                    .advance(harvester, &mut state, *excitation, until, budget, &mut observer)
                    .map_err(|error| self.step_failure(&error, &state))?;
                total.add(&advance.work);
            }
        }
        let wall_s = began.elapsed().as_secs_f64();
        let number = |value: S| Some(value.to_f64());
        let whole = |entry| number(ledger.integrals().integral(entry));
        let store = hosted.store(state.mode, &state.point.state);
        let found = Found {
            coordinate: meter.coordinate(),
            impacts: meter.impacts(),
            fastest_impact: meter.fastest_impact(),
            sticks: meter.sticks(),
            stick_fraction: meter.stick_fraction(),
            first_impact: first_impact.at,
            periods: scene.excitation.single_frequency().map(|frequency| frequency * span.window_s()),
        };
        Ok(Outcome {
            scene: scene.name(),
            method: method_name(options.method).to_owned(),
            precision: precision_name::<S>(),
            math: M::NAME,
            duration_s: span.duration_s,
            settle_s: span.settle_s,
            mean_power_w: number(meter.mean_power()),
            rms_voltage_v: number(meter.rms_voltage()),
            peak_voltage_v: number(meter.voltage().magnitude()),
            mean_voltage_v: number(meter.mean_voltage()),
            delivered_energy_j: number(meter.delivered_energy()),
            energy_residual: hosted.residual(&ledger.residual()).map(S::to_f64),
            steps: total.steps,
            rejected_steps: total.rejected,
            newton_iterations: total.iterations,
            events: total.events,
            wall_s,
            particular: hosted.particular(&found),
            store: store.as_ref().map(|store| StoreOutcome {
                store_voltage_v: number(store.voltage),
                stored_energy_j: store.energy.and_then(number),
                diode_loss_j: whole(account::DIODES),
                leaked_energy_j: whole(account::LEAKED),
                drawn_energy_j: whole(account::DRAWN),
            }),
            steady_state: None,
            trace: options.trace_every_s.map(|_| Recording {
                columns: hosted.columns(store.is_some()),
                rows: std::mem::take(&mut recorder.rows),
            }),
        })
    }

    /// The end of a run that has taken the most attempts it may.
    fn given_up(&self, state: &HybridState<S, ModeOf<S, H, N>, N, WHOLE>) -> Failure {
        let (most, at) = (self.options.most_attempts.unwrap_or(0), state.clock.seconds::<f64>());
        Failure::StepLimitExceeded(format!("given up after {most} attempted steps at {at} s"))
    }

    pub(super) fn step_failure(
        &self,
        error: &StepError<S>,
        state: &HybridState<S, ModeOf<S, H, N>, N, WHOLE>,
    ) -> Failure {
        let [position, velocity] = [state.point.state[0], state.point.state[1]];
        let charge = self.hosted.charge(state.mode, &state.point.state);
        Failure::Step(format!(
            "{error}: {} {:e}, velocity {:e} m/s, charge {:e} C, {:?}",
            self.hosted.columns(false)[1],
            position.to_f64(),
            velocity.to_f64(),
            self.hosted.coulombs(position, charge).to_f64(),
            state.mode
        ))
    }
}

/// Work of a whole run: a long one has more steps than fit in 32 bits.
#[derive(Default)]
pub(super) struct Total {
    pub(super) steps: u64,
    pub(super) rejected: u64,
    pub(super) locating: u64,
    pub(super) iterations: u64,
    pub(super) events: u64,
}

impl Total {
    /// Steps kept, rejected, and taken to locate events.
    fn attempts(&self) -> u64 {
        self.steps + self.rejected + self.locating
    }

    pub(super) fn add(&mut self, work: &Work) {
        self.steps += u64::from(work.steps);
        self.rejected += u64::from(work.rejected);
        self.locating += u64::from(work.locating);
        self.iterations += u64::from(work.iterations);
        self.events += u64::from(work.events);
    }
}
