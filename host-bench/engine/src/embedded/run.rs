//! A run of any harvester of the core, measured and recorded: one path for every scene.

use std::fmt::Display;

use cpu_time::ThreadTime;
use model_core::clock::{Instant, LONGEST_STEP_S};
use model_core::energy::{Ledger, Residual, RunMeter};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep};
use model_core::observer::{PowerIndex, StorageOutput};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;

use super::excitation::Setting;
use super::limits::{Clamp, Compared};
use super::report::{Blocks, Recorder, Report, RunSummary};
use super::{DEFAULT_TOLERANCE, auto, precision_name};
use crate::steady_state::{Total, given_up};
use harvester_scene::method::{Failure, Method, Options, refuse_first};
use harvester_scene::outcome::{CreatedEnergy, EnergyFlow, Margins, Outcome, Recording, StoreOutcome, name};
use harvester_scene::progress;
use harvester_scene::scene_file::{Load, Random, RunSpan, Scene};

pub(super) fn refuse_parameter(scene: &Scene, error: &dyn Display) -> Failure {
    Failure::of_file(scene, format!("parameters.{error}"))
}

pub(super) fn refuse_start(scene: &Scene, error: &dyn Display) -> Failure {
    Failure::of_file(scene, format!("initial.{error}"))
}

pub(super) fn ends_of(scene: &Scene, span: &RunSpan) -> Result<[Instant; 2], Failure> {
    Ok([instant(scene, span.settle_s)?, instant(scene, span.duration_s)?])
}

/// An instant of the run of a scene, in s.
pub(super) fn instant(scene: &Scene, seconds: f64) -> Result<Instant, Failure> {
    let refused = || Failure::of_file(scene, format!("run: {seconds} s, must be below 16777216"));
    Instant::from_seconds(seconds).ok_or_else(refused)
}

/// The shortest step for which the explicit method is run without an option that asks for it.
const SHORTEST_EXPLICIT_STEP_S: f64 = 1e-7;

/// Steps of one length in s, for the option `name`.
fn fixed<S: Scalar>(name: &str, seconds: f64) -> Result<AnyStepControl<S>, Failure> {
    FixedStep::of_seconds(S::from_f64(seconds))
        .map(AnyStepControl::Fixed)
        .map_err(|error| Failure::Input(format!("{name}: {error}")))
}

/// The rule for the length of steps that the options ask for; `explicit` is the step at which an
/// explicit method is stable and accurate, in s.
pub(super) fn step_control<S: Scalar>(
    scene: &Scene,
    options: &Options,
    explicit: f64,
) -> Result<AnyStepControl<S>, Failure> {
    refuse_first(&[
        (
            options.method == Method::DiscreteGradient,
            "--method discrete-gradient: must be with a bump-stop scene",
        ),
        (options.method == Method::Newmark, "--method newmark: must be with a bump-stop scene"),
        (options.long_step_s.is_some(), "--long-step: must be with a bump-stop scene"),
    ])?;
    let refuse = |text: String| Err(Failure::Input(text));
    let finer = options.refinement();
    match (options.step_s, options.tolerance, options.method) {
        (Some(step), _, _) if step > LONGEST_STEP_S => {
            refuse(format!("--step {step}: must be at most {LONGEST_STEP_S:.6} s"))
        }
        (Some(step), _, _) => fixed("--step", step * finer),
        (None, Some(_), Method::Rk4) => refuse(
            "--tolerance: must not be given with rk4, which has no error estimate; give --step".to_owned(),
        ),
        (None, None, Method::Rk4) if explicit < SHORTEST_EXPLICIT_STEP_S => refuse(format!(
            "--method rk4: {} needs steps of {explicit:.1e} s to be stable, must be at least \
             {SHORTEST_EXPLICIT_STEP_S:e} s; use exponential-radau",
            scene.file.display()
        )),
        (None, None, Method::Rk4) => fixed("--method rk4", explicit.min(LONGEST_STEP_S) * finer),
        (None, Some(tolerance), _) if S::from_f64(tolerance) < S::EPSILON => refuse(format!(
            "--tolerance {tolerance:e}: must be at least {:e} in {}",
            S::EPSILON.to_f64(),
            precision_name::<S>()
        )),
        (None, tolerance, method) => {
            let tolerance = tolerance.unwrap_or_else(|| match method {
                Method::TrBdf2 => DEFAULT_TOLERANCE,
                _ => {
                    let by_default = auto::default_accuracy(scene, options.chosen_precision());
                    auto::tolerance(scene, options.accuracy.unwrap_or(by_default))
                }
            });
            Adaptive::new(S::from_f64(tolerance * finer))
                .map(AnyStepControl::Adaptive)
                .map_err(|error| Failure::Input(format!("--tolerance: {error}")))
        }
    }
}

/// The larger remainder in J of the mechanical and the electrical ledger.
pub(super) fn remainder<S: Scalar>(ledger: &Ledger<S>) -> f64 {
    let Residual { mechanical, electrical, .. } = ledger.residual();
    mechanical.abs().max(electrical.abs()).to_f64()
}

/// Where the energy of a run went.
fn energy_flow<S: Scalar>(ledger: &Ledger<S>) -> EnergyFlow {
    let spent = |power| ledger.integrals().integral(power).to_f64();
    EnergyFlow {
        base_j: spent(PowerIndex::Base),
        dissipated_j: spent(PowerIndex::Dissipation),
        contact_j: ledger.lost_in_contact().to_f64(),
        delivered_j: spent(PowerIndex::Load),
        diodes_j: spent(PowerIndex::Diodes),
        created_j: spent(PowerIndex::FieldWork) - spent(PowerIndex::ElectrostaticWork),
    }
}

/// Attempts per call, a few hundredths of a second: the progress is reported after each.
pub(super) const BUDGET: u32 = 1 << 16;
/// Most attempted steps of a run, where the options have no limit: an hour or more of one core.
const MOST_ATTEMPTS: u64 = 10_000_000_000;

/// Attempted steps, and radians of the motion that as many must pass: a storage of picofarads in `f32`, whose voltage is
/// below the roundings of the harvester's, may take steps without end.
const STUCK: (u64, f64) = (1 << 19, 8.0);

/// The least length in s, and in distances of the ends of steps, of the first step where those are given.
const FIRST_S: f64 = 1e-9;
const FIRST: f64 = 1e-3;

/// A harvester of the core with all that a run of its scene needs.
pub(super) struct Run<'a, S: Scalar, H, R> {
    pub(super) setting: Setting<'a, S>,
    pub(super) harvester: &'a H,
    pub(super) report: &'a R,
    pub(super) method: Method,
}

/// The meters of a run. A bare run has the window alone.
struct Meters<'a, S: Scalar> {
    whole: Option<(Ledger<S>, RunMeter<S>)>,
    window: RunMeter<S>,
    margins: Option<Compared<'a, S>>,
    blocks: Option<Blocks>,
    clamp: Option<Clamp<'a, S>>,
}

impl<S: Scalar, H: Harvester<S>, R: Report<S, H>> Run<'_, S, H, R> {
    /// The outcome of a run from `state` to the end of `span`, at which the state is then.
    pub(super) fn measured(&self, state: &mut H::State, span: &RunSpan) -> Result<Outcome, Failure> {
        let Self { setting: Setting { scene, options, excitation, .. }, harvester, .. } = *self;
        let outputs = harvester.outputs(state);
        let mut meters = Meters {
            whole: (!options.bare).then(|| (Ledger::open(&outputs), RunMeter::new())),
            window: RunMeter::new(),
            margins: (!options.bare).then(|| Compared::new(scene, self.report.gauge(self.setting))),
            blocks: None,
            clamp: None,
        };
        let every = options.trace_every_s.unwrap_or(f64::INFINITY);
        let mut recorder = Recorder::new(self.report, excitation, every);
        let mut total = Total::default();
        progress::begin();
        let [settled, end] = ends_of(scene, span)?;
        let began = ThreadTime::now();
        // One pass over each stretch; the recorder joins in only if a trace was asked for.
        for (until, measured) in [(settled, false), (end, true)] {
            if measured {
                meters.window = RunMeter::starting_at(&harvester.outputs(state));
                meters.blocks = options.blocks.then(|| Blocks::new(settled, end));
                // Runs that are compared have blocks.
                meters.clamp =
                    (options.blocks || !options.bare).then(|| self.report.clamp(excitation)).flatten();
            }
            let mut pair = meters.whole.as_mut().map(|(ledger, meter)| (ledger, meter));
            let mut margins = meters.margins.as_mut();
            let mut whole = (&mut pair.as_mut(), &mut margins);
            let mut recording = options.trace_every_s.map(|_| &mut recorder);
            let mut window = measured.then_some(&mut meters.window);
            let mut blocks = meters.blocks.as_mut();
            let mut clamp = meters.clamp.as_mut();
            let mut parts = (&mut blocks, &mut clamp);
            let mut measuring = (&mut window, &mut parts);
            let mut others = (&mut recording, &mut measuring);
            if let Some(every) = options.ends_every_s {
                let next = |row: f64| Instant::from_seconds(row * every).filter(|row| *row < until);
                let at = harvester.clock(state).seconds::<f64>() / every;
                // A charge that is gone within nanoseconds acts on the motion throughout the first step: that is a short one.
                let first = (FIRST_S / every).clamp(FIRST, 1.0);
                let mut row = if at == 0.0 { first } else { at.floor() + 1.0 };
                while let Some(stop) = next(row) {
                    self.advance(state, stop, &mut total, &mut (&mut whole, &mut others))?;
                    row = row.floor() + 1.0;
                }
            }
            self.advance(state, until, &mut total, &mut (&mut whole, &mut others))?;
        }
        let processor_s = began.elapsed().as_secs_f64();
        let Recorder { rows, impacts_s, .. } = recorder;
        let columns = self.report.columns(harvester.outputs(state).storage.is_some());
        let trace = options.trace_every_s.map(|_| Recording { columns, rows, impacts_s });
        Ok(Outcome { trace, ..self.outcome(state, span, &meters, (&total, processor_s)) })
    }

    /// Advances to `until`, within the attempts that the options allow.
    fn advance(
        &self,
        state: &mut H::State,
        until: Instant,
        total: &mut Total,
        observer: &mut impl model_core::observer::Observer<S>,
    ) -> Result<(), Failure> {
        let Self { setting: Setting { scene, options, excitation, .. }, harvester, .. } = *self;
        let frequency = harvester.angular_frequency().max(excitation.angular_frequency()).to_f64();
        let may_be_stuck = H::ESTIMATES_ERROR
            && options.step_s.is_none()
            && matches!(scene.load, Load::RectifiedStore(_))
            && precision_name::<S>() == "f32";
        let mut mark = (total.attempts(), harvester.clock(state).seconds::<f64>());
        while harvester.clock(state) < until {
            let most = options.most_attempts.unwrap_or(MOST_ATTEMPTS);
            let left = most.saturating_sub(total.attempts());
            if left == 0 {
                return Err(given_up(most, harvester.clock(state)));
            }
            let budget = u32::try_from(left).unwrap_or(BUDGET).min(BUDGET);
            let advance = harvester
                .advance(state, &excitation, until, budget, observer)
                .map_err(|error| self.step_failure(error, state))?;
            total.add(&advance.work);
            let at = harvester.clock(state).seconds::<f64>();
            progress::report(at / scene.run.duration_s, [total.attempts(), total.events]);
            if may_be_stuck && total.attempts() >= mark.0 + STUCK.0 {
                if frequency * (at - mark.1) < STUCK.1 && harvester.clock(state) < until {
                    let described = self.report.describe(&harvester.outputs(state));
                    return Err(stuck(at, total.attempts() - mark.0, at - mark.1, &described));
                }
                mark = (total.attempts(), at);
            }
        }
        Ok(())
    }

    /// The outcome of a run that ended in `state`.
    fn outcome(
        &self,
        state: &H::State,
        span: &RunSpan,
        meters: &Meters<'_, S>,
        (total, processor_s): (&Total, f64),
    ) -> Outcome {
        let Self { setting, harvester, report, method } = *self;
        let window = &meters.window;
        let ledger = meters.whole.as_ref().map(|(ledger, _)| ledger);
        let found = RunSummary {
            window,
            first_contact: meters.whole.as_ref().and_then(|(_, meter)| meter.report().first_contact),
            periods: setting.scene.excitation.single_frequency().map(|frequency| frequency * span.window_s()),
            clamp: meters.clamp.as_ref(),
        };
        let created = report.created_energy(window).zip(ledger).map(|(created, ledger)| {
            let delivered = window.delivered_energy().to_f64();
            CreatedEnergy::new(created.to_f64(), delivered, remainder(ledger))
        });
        let own = Outcome {
            method: name(&method),
            created,
            energy_residual: ledger.and_then(|ledger| report.residual(&ledger.residual())).map(S::to_f64),
            particular: report.particular(harvester, &found, state),
            store: harvester.outputs(state).storage.map(|storage| meters.store(&storage)),
            processor_s,
            ..Outcome::default()
        };
        meters.outcome(setting, span, total, own)
    }

    /// The end of a run in a step that cannot be taken, with the state.
    pub(super) fn step_failure(&self, error: impl Display, state: &H::State) -> Failure {
        Failure::Step(format!("{error}: {}", self.report.describe(&self.harvester.outputs(state))))
    }
}

/// The end of a run that attempted so many steps for so little of its time, in s.
fn stuck(at: f64, steps: u64, advanced_s: f64, described: &str) -> Failure {
    Failure::Step(format!(
        "steps without end at {at} s: {steps} attempts advanced {advanced_s:.1e} s; a voltage may be within its \
         roundings in f32: {described}"
    ))
}

/// What is the same for every harvester, compiled once for each precision.
impl<S: Scalar> Meters<'_, S> {
    /// An outcome with what the meters of any harvester know, from the part that depends on the harvester.
    fn outcome(&self, setting: Setting<'_, S>, span: &RunSpan, total: &Total, own: Outcome) -> Outcome {
        let Setting { scene, math, .. } = setting;
        let number = |value: S| Some(value.to_f64());
        let window = &self.window;
        let ledger = self.whole.as_ref().map(|(ledger, _)| ledger);
        Outcome {
            scene: scene.name(),
            precision: precision_name::<S>(),
            math,
            duration_s: span.duration_s,
            settle_s: span.settle_s,
            mean_power_w: number(window.mean_power()),
            rms_voltage_v: window.report().rms_voltage.and_then(number),
            peak_voltage_v: number(window.report().voltage.magnitude()),
            mean_voltage_v: ledger.and_then(|_| number(window.integrals().mean(PowerIndex::Voltage))),
            delivered_energy_j: number(window.delivered_energy()),
            base_rms_m_per_s2: scene.excitation.random().map(Random::rms_m_per_s2),
            steps: total.steps,
            rejected_steps: total.rejected,
            newton_iterations: total.iterations,
            events: total.events,
            flow: ledger.map(energy_flow),
            margins: self.margins.as_ref().map_or_else(Margins::default, Compared::margins),
            block_energies_j: self.blocks.as_ref().map_or_else(Vec::new, |blocks| blocks.energies_j.to_vec()),
            ..own
        }
    }

    /// What the storage behind a bridge holds at the end, and what it lost.
    fn store(&self, storage: &StorageOutput<S>) -> StoreOutcome {
        let ledger = self.whole.as_ref().map(|(ledger, _)| ledger);
        let spent = |power| ledger.map(|ledger| ledger.integrals().integral(power).to_f64());
        let current = self.window.integrals().mean(PowerIndex::CurrentMagnitude);
        StoreOutcome {
            store_voltage_v: Some(storage.voltage.to_f64()),
            mean_store_current_a: ledger.map(|_| current.to_f64()),
            stored_energy_j: storage.capacitance.is_finite().then(|| storage.energy().to_f64()),
            diode_loss_j: spent(PowerIndex::Diodes),
            leaked_energy_j: spent(PowerIndex::Leakage),
            drawn_energy_j: spent(PowerIndex::Draw),
            cycles: self.blocks.as_ref().and_then(Blocks::cycles),
        }
    }
}
