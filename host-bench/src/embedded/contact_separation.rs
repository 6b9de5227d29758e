//! A contact-separation run on the embedded core.

use std::marker::PhantomData;
use std::time::Instant as Stopwatch;

use model_core::clock::{Instant, LONGEST_STEP_S};
use model_core::energy::{Ledger, RunMeter};
use model_core::hybrid::{Driver, Event, HybridState, Observer, Span, StepError, Work};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::part::load::AnyLoad;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution, VelocityDependentRestitution};
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::account;
use model_core::scene::contact_separation::{
    AnyForceLaw, AnyParts, AnyStickCharge, ContactSeparation as Harvester, Mode, Parameters, STATES, Start,
};

use super::excitation::{HostExcitation, with_excitation};
use super::recorder::Recorder;
use super::{DEFAULT_TOLERANCE, method_name, precision_name};
use crate::method::{Failure, Method, Options};
use crate::outcome::{CONTACT_SEPARATION_COLUMNS, ContactSeparationOutcome, Outcome, Particular, Recording};
use crate::scene_file::{ContactSeparation, ForceLaw, Load, Restitution, RunSpan, Scene, StickCharge};

mod shooting;

pub(super) use shooting::{resonance_peak, steady_state};

type State<S> = HybridState<S, Mode, STATES, { account::WHOLE }>;

/// The core's parameters of a scene.
#[must_use]
pub fn parameters<S: Scalar, M: Mathematics<S>>(
    model: &ContactSeparation,
    load: Load,
) -> Parameters<S, AnyParts<M>> {
    let from = &model.parameters;
    let number = S::literal;
    let Load::Resistor { resistance_ohm } = load;
    Parameters {
        mass: number(from.mass_kg),
        stiffness: number(from.stiffness_n_per_m),
        damping_ratio: number(from.damping_ratio),
        initial_gap: number(from.initial_gap_m),
        electrode_area: number(from.electrode_area_m2),
        dielectric_thickness: number(from.dielectric_thickness_m),
        relative_permittivity: number(from.relative_permittivity),
        charge_density: number(from.charge_density_c_per_m2),
        parasitic: ParasiticCapacitance { farads: number(from.parasitic_capacitance_f) },
        load: AnyLoad { ohms: number(resistance_ohm) },
        force_law: match from.force_law {
            ForceLaw::TransferredCharge => AnyForceLaw::TransferredCharge,
            ForceLaw::GapField => AnyForceLaw::GapField,
        },
        restitution: match from.restitution {
            Restitution::Constant { coefficient } => {
                AnyRestitution::Constant(ConstantRestitution { coefficient: number(coefficient) })
            }
            Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
                AnyRestitution::VelocityDependent(VelocityDependentRestitution {
                    at_rest: number(at_rest),
                    at_speed: number(at_speed),
                    reference_speed: number(reference_speed_m_per_s),
                    mathematics: PhantomData,
                })
            }
        },
        sticking: match from.stick_charge {
            StickCharge::Frozen => AnyStickCharge::Frozen,
            StickCharge::Relaxing => AnyStickCharge::Relaxing,
        },
    }
}

/// Runs the scene from its start to its end.
pub(super) fn run<S: Scalar, M: Mathematics<S>>(
    scene: &Scene,
    model: &ContactSeparation,
    options: &Options,
) -> Result<Outcome, Failure> {
    prepared::<S, M, _>(scene, model, options, |run, state| match options.method {
        Method::Rk4 => run.with(RungeKutta4, state),
        Method::Auto | Method::TrBdf2 | Method::Reference => run.with(TrBdf2, state),
    })
}

/// Calls `with` with all that a run of the scene needs, and the state it starts in.
fn prepared<S: Scalar, M: Mathematics<S>, R>(
    scene: &Scene,
    model: &ContactSeparation,
    options: &Options,
    with: impl FnOnce(&Run<'_, S, M>, State<S>) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let refuse = |error: &dyn std::fmt::Display| {
        Failure::Input(format!("{}: parameters.{error}", scene.file.display()))
    };
    let harvester = parameters::<S, M>(model, scene.load).build().map_err(|error| refuse(&error))?;
    let start = Start {
        gap: model.initial.gap_m.map(S::literal),
        velocity: model.initial.velocity_m_per_s.map(S::literal),
        charge: model.initial.charge_c.map(S::literal),
    };
    let control = step_control(scene, model, options)?;
    with_excitation::<S, M, _>(scene, |excitation| {
        let state = harvester
            .start(&start, excitation, &control)
            .map_err(|error| Failure::Input(format!("{}: initial.{error}", scene.file.display())))?;
        let run = Run { scene, model, options, harvester: &harvester, excitation, control };
        with(&run, state)
    })
}

/// The rule for the length of steps that the options ask for.
fn step_control<S: Scalar>(
    scene: &Scene,
    model: &ContactSeparation,
    options: &Options,
) -> Result<AnyStepControl<S>, Failure> {
    let refuse = |text: String| Err(Failure::Input(text));
    match (options.step_s, options.tolerance, options.method) {
        (Some(step), _, _) if step > LONGEST_STEP_S => {
            refuse(format!("--step {step}: must be at most {LONGEST_STEP_S:.6} s"))
        }
        (Some(step), _, _) => Ok(AnyStepControl::Fixed(FixedStep::of_seconds(S::literal(step)))),
        (None, Some(_), Method::Rk4) => refuse(
            "--tolerance: must not be given with rk4, which has no error estimate; give --step".to_owned(),
        ),
        (None, None, Method::Rk4) => {
            let step = explicit_step(model, scene.load);
            if step < SHORTEST_EXPLICIT_STEP_S {
                return refuse(format!(
                    "--method rk4: needs steps of {step:.1e} s to be stable, must be at least \
                     {SHORTEST_EXPLICIT_STEP_S:e} s; use tr-bdf2"
                ));
            }
            Ok(AnyStepControl::Fixed(FixedStep::of_seconds(S::literal(step))))
        }
        (None, Some(tolerance), _) if S::literal(tolerance) < S::EPSILON => refuse(format!(
            "--tolerance {tolerance:e}: must be at least {:e} in {}",
            S::EPSILON.to_f64(),
            precision_name::<S>()
        )),
        (None, tolerance, _) => {
            Ok(AnyStepControl::Adaptive(Adaptive::new(S::literal(tolerance.unwrap_or(DEFAULT_TOLERANCE)))))
        }
    }
}

/// The shortest step for which the explicit method is run without being told to.
const SHORTEST_EXPLICIT_STEP_S: f64 = 1e-7;

/// A step at which the explicit method is stable and accurate: an 800th of the natural period, and
/// 2 over the fastest rate of the circuit, 1/(R (C + C_p)) with C at three times the initial gap.
fn explicit_step(model: &ContactSeparation, load: Load) -> f64 {
    const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;
    let from = &model.parameters;
    let Load::Resistor { resistance_ohm } = load;
    let period = std::f64::consts::TAU * (from.mass_kg / from.stiffness_n_per_m).sqrt();
    let distance = 3.0 * from.initial_gap_m + from.dielectric_thickness_m / from.relative_permittivity;
    let capacitance = VACUUM_PERMITTIVITY * from.electrode_area_m2 / distance + from.parasitic_capacitance_f;
    let circuit = if resistance_ohm == 0.0 { f64::INFINITY } else { 2.0 * resistance_ohm * capacitance };
    (period / 800.0).min(circuit)
}

/// The time of the first impact.
#[derive(Default)]
struct FirstImpact(Option<Instant>);

impl<S: Scalar> Observer<S, Mode, STATES, { account::WHOLE }> for FirstImpact {
    fn step(&mut self, _span: &Span<'_, S, Mode, STATES, { account::WHOLE }>) {}

    fn event(&mut self, event: &Event<'_, S, Mode, STATES, { account::WHOLE }>) {
        if event.before == Mode::Free && self.0.is_none() {
            self.0 = Some(event.at);
        }
    }
}

/// Attempts per call: the counts of a call fit in 32 bits.
const BUDGET: u32 = 1 << 24;

/// What a run needs.
struct Run<'a, S: Scalar, M: Mathematics<S>> {
    scene: &'a Scene,
    model: &'a ContactSeparation,
    options: &'a Options,
    harvester: &'a Harvester<S, AnyParts<M>>,
    excitation: &'a HostExcitation<'a, S, M>,
    control: AnyStepControl<S>,
}

impl<S: Scalar, M: Mathematics<S>> Run<'_, S, M> {
    fn with<I: Integrator<S>>(&self, integrator: I, state: State<S>) -> Result<Outcome, Failure> {
        self.measured(&Driver::new(integrator, self.control), state, &self.scene.run)
    }

    /// The outcome of a run from `state` to the end of `span`.
    fn measured<I: Integrator<S>>(
        &self,
        driver: &Driver<I, AnyStepControl<S>>,
        mut state: State<S>,
        span: &RunSpan,
    ) -> Result<Outcome, Failure> {
        let Self { scene, model, options, harvester, excitation, .. } = self;
        let instant = |seconds: f64| {
            Instant::from_seconds(seconds).ok_or_else(|| {
                Failure::Input(format!("{}: run: {seconds} s, must be below 16777216", scene.file.display()))
            })
        };
        let (settled, end) = (instant(span.settle_s)?, instant(span.duration_s)?);
        let mut ledger = Ledger::open(*harvester, &state);
        let mut first_impact = FirstImpact::default();
        let mut meter = RunMeter::new(*harvester);
        let mut recorder = Recorder {
            harvester,
            excitation,
            every: options.trace_every_s.unwrap_or(f64::INFINITY),
            rows: Vec::new(),
        };
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
                let advance = driver
                    .advance(*harvester, &mut state, *excitation, until, BUDGET, &mut observer)
                    .map_err(|error| step_failure(&error, harvester, &state))?;
                total.add(&advance.work);
            }
        }
        let wall_s = began.elapsed().as_secs_f64();
        let residual = ledger.residual();
        let residual = match model.parameters.force_law {
            ForceLaw::GapField => residual.total(),
            ForceLaw::TransferredCharge => residual.larger(),
        };
        let number = |value: S| Some(value.to_f64());
        let impacts = u64::from(meter.impacts());
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * span.window_s());
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
            energy_residual: residual.map(S::to_f64),
            steps: total.steps,
            rejected_steps: total.rejected,
            newton_iterations: total.iterations,
            events: total.events,
            wall_s,
            particular: Particular::ContactSeparation(ContactSeparationOutcome {
                peak_gap_m: number(meter.coordinate().highest),
                // A step that ends in an impact ends up to a tick beyond contact.
                min_gap_m: number(meter.coordinate().lowest.larger(S::ZERO)),
                impacts,
                impacts_per_period: periods.map(|periods| impacts as f64 / periods),
                max_impact_speed_m_per_s: (impacts > 0).then(|| meter.fastest_impact().to_f64()),
                first_impact_s: first_impact.0.map(Instant::seconds),
                stuck_fraction: number(meter.held_fraction()),
            }),
            steady_state: None,
            trace: options.trace_every_s.map(|_| Recording {
                columns: &CONTACT_SEPARATION_COLUMNS,
                rows: std::mem::take(&mut recorder.rows),
            }),
        })
    }
}

/// Work of a whole run: a long one has more steps than fit in 32 bits.
#[derive(Default)]
struct Total {
    steps: u64,
    rejected: u64,
    iterations: u64,
    events: u64,
}

impl Total {
    fn add(&mut self, work: &Work) {
        self.steps += u64::from(work.steps);
        self.rejected += u64::from(work.rejected);
        self.iterations += u64::from(work.iterations);
        self.events += u64::from(work.events);
    }
}

fn step_failure<S: Scalar, M: Mathematics<S>>(
    error: &StepError<S>,
    harvester: &Harvester<S, AnyParts<M>>,
    state: &State<S>,
) -> Failure {
    let [gap, velocity, charge] = state.point.state;
    let charge = harvester.transferred_charge(gap, charge);
    Failure::Step(format!(
        "{error}: gap {:e} m, velocity {:e} m/s, charge {:e} C, {:?}",
        gap.to_f64(),
        velocity.to_f64(),
        charge.to_f64(),
        state.mode
    ))
}
