//! A bump-stop run on the embedded core.

mod shapes;

use std::time::Instant as Stopwatch;

use model_core::clock::{Instant, LONGEST_STEP_S};
use model_core::hybrid::StepError;
use model_core::integrate::cubic::Cubic;
use model_core::part::load::AnyLoad;
use model_core::part::monomorph::Layer;
use model_core::part::storage_step::StorageAccount;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::bump_stop::{
    AnyBridgedParts, AnyContact, AnyCoupling, AnyParts, BumpStop as Harvester, Circuit, ModalLedger,
    ModalMeter, ModalObserver, ModalSpan, Parameters, Parts, Restitution, Start, StateOf, Stepper, Stop,
};

pub use self::shapes::{DeflectedShape, deflected_shapes};
use super::bridge::{bridge, stored_energy};
use super::excitation::{HostExcitation, with_excitation};
use super::hybrid_run::{Total, ends_of, refuse_parameter, refuse_start};
use super::precision_name;
use crate::method::{Failure, Options};
use crate::outcome::{
    BUMP_STOP_COLUMNS, BumpStopOutcome, Outcome, Particular, Recording, StoreOutcome, with_store,
};
use crate::scene_file::{BumpStop, Contact, Coupling, Load, Scene};

/// Step near contact where none is given, in s.
const DEFAULT_SHORT_STEP_S: f64 = 1e-6;
/// Step in free flight where none is given, in s.
const DEFAULT_LONG_STEP_S: f64 = 2e-5;

/// Columns of a recording behind a bridge.
const STORE_COLUMNS: [&str; 8] = with_store(BUMP_STOP_COLUMNS);

/// Parts chosen at run time, the load aside.
pub(super) trait HostedParts<S: Scalar>:
    Parts<S, Coupling = AnyCoupling, Contact = AnyContact<S>>
{
}

impl<S: Scalar> HostedParts<S> for AnyParts {}
impl<S: Scalar> HostedParts<S> for AnyBridgedParts {}

/// The core's parameters of a scene whose load is a resistor; a bridge is taken as it is while it blocks.
#[must_use]
pub fn parameters<S: Scalar>(model: &BumpStop, load: Load) -> Parameters<S, AnyParts> {
    parameters_with(model, resistance(load))
}

fn resistance<S: Scalar>(load: Load) -> AnyLoad<S> {
    AnyLoad { ohms: S::from_f64(load.resistance_ohm()) }
}

/// The core's parameters of a scene with a load of the core.
fn parameters_with<S: Scalar, P: HostedParts<S>>(model: &BumpStop, load: P::Load) -> Parameters<S, P> {
    let from = &model.parameters;
    let number = S::from_f64;
    let absent = Stop {
        length: S::ONE,
        section: S::ONE,
        young_modulus: number(1e9),
        density: S::ONE,
        position: number(from.beam_length_m),
        gap: S::ZERO,
        contact_compliance: S::ZERO,
    };
    let stop = model.stop.as_ref().map_or(absent, |stop| Stop {
        length: number(stop.length_m),
        section: number(stop.width_m * stop.thickness_m),
        young_modulus: number(stop.young_modulus_pa),
        density: number(stop.density_kg_per_m3),
        position: number(stop.position_m),
        gap: number(stop.gap_m),
        contact_compliance: number(stop.contact_compliance_m_per_n),
    });
    let contact = model.stop.as_ref().map_or(AnyContact::NoStop, |stop| match stop.contact {
        Contact::ResidualFlexibility => AnyContact::ResidualFlexibility,
        Contact::DisplacementConstraint => AnyContact::DisplacementConstraint,
        Contact::Restitution => {
            AnyContact::Restitution(Restitution { coefficient: number(stop.restitution.unwrap_or(1.0)) })
        }
    });
    Parameters {
        beam_length: number(from.beam_length_m),
        beam_width: number(from.beam_width_m),
        substrate: Layer {
            thickness: number(from.substrate_thickness_m),
            young_modulus: number(from.substrate_young_modulus_pa),
            density: number(from.substrate_density_kg_per_m3),
        },
        piezo: Layer {
            thickness: number(from.piezo_thickness_m),
            young_modulus: number(from.piezo_young_modulus_pa),
            density: number(from.piezo_density_kg_per_m3),
        },
        piezo_d31: number(from.piezo_d31_m_per_v),
        piezo_permittivity: number(from.piezo_permittivity_f_per_m),
        damping_ratio: number(from.damping_ratio),
        stop,
        load,
        coupling: match from.coupling {
            Coupling::TwoWay => AnyCoupling::TwoWay,
            Coupling::OneWay => AnyCoupling::OneWay,
        },
        contact,
    }
}

/// Runs the scene from its start to its end.
///
/// The mode counts are type parameters of the core. A mode beyond the scene's own stays at rest and
/// leaves every bit as it is, so a few capacities serve all scenes.
pub(super) fn run<S: Scalar, M: Mathematics<S>>(
    scene: &Scene,
    model: &BumpStop,
    options: &Options,
) -> Result<Outcome, Failure> {
    match bridge(scene.load) {
        Some(bridge) => with_load::<S, M, AnyBridgedParts>(scene, model, options, bridge),
        None => with_load::<S, M, AnyParts>(scene, model, options, resistance(scene.load)),
    }
}

fn with_load<S: Scalar, M: Mathematics<S>, P: HostedParts<S>>(
    scene: &Scene,
    model: &BumpStop,
    options: &Options,
    load: P::Load,
) -> Result<Outcome, Failure> {
    let what = (scene, model, options);
    match (model.parameters.beam_modes, model.stop.as_ref().map_or(0, |stop| stop.rod_modes)) {
        (..=4, ..=2) => prepared::<S, M, P, 4, 2, _>(what, load, |run, state| run.to_end(state)),
        (..=10, ..=10) => prepared::<S, M, P, 10, 10, _>(what, load, |run, state| run.to_end(state)),
        _ => prepared::<S, M, P, 20, 20, _>(what, load, |run, state| run.to_end(state)),
    }
}

/// The lengths of step near contact and in free flight that the options ask for.
fn steps(options: &Options) -> Result<[f64; 2], Failure> {
    if options.tolerance.is_some() {
        return Err(Failure::Input(
            "--tolerance: must not be given for a bump-stop scene, whose steps have no error estimate; \
             give --step"
                .to_owned(),
        ));
    }
    let short = options.step_s.unwrap_or(DEFAULT_SHORT_STEP_S);
    // A step that is given alone is that of the whole run.
    let long = options.long_step_s.or(options.step_s).unwrap_or(DEFAULT_LONG_STEP_S);
    for (name, step) in [("--step", short), ("--long-step", long)] {
        if step > LONGEST_STEP_S {
            return Err(Failure::Input(format!("{name} {step}: must be at most {LONGEST_STEP_S:.6} s")));
        }
    }
    Ok([short, long])
}

/// Calls `with` with all that a run of the scene with a load of the core needs, and the state it starts in.
fn prepared<S: Scalar, M: Mathematics<S>, P: HostedParts<S>, const B: usize, const R: usize, T>(
    (scene, model, options): (&Scene, &BumpStop, &Options),
    load: P::Load,
    with: impl FnOnce(&Run<'_, S, M, P, B, R>, StateOf<S, P, B, R>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let [short, long] = steps(options)?;
    let (beam_modes, rod_modes) =
        (model.parameters.beam_modes, model.stop.as_ref().map_or(0, |stop| stop.rod_modes));
    let harvester = parameters_with::<S, P>(model, load)
        .build_first::<B, R>(beam_modes, rod_modes)
        .map_err(|error| refuse_parameter(scene, &error))?;
    let mut start = Start { voltage: S::from_f64(model.initial.voltage_v), ..Start::default() };
    let initial = &model.initial;
    let put = |coordinates: &mut [[S; 2]], displacements: &[f64], velocities: &[f64]| {
        for ((coordinate, &displacement), &velocity) in
            coordinates.iter_mut().zip(displacements).zip(velocities)
        {
            *coordinate = [S::from_f64(displacement), S::from_f64(velocity)];
        }
    };
    put(&mut start.beam, &initial.modal_displacement, &initial.modal_velocity);
    put(&mut start.rod, &initial.rod_modal_displacement, &initial.rod_modal_velocity);
    let stepper = Stepper::new(harvester, S::from_f64(short), S::from_f64(long));
    with_excitation::<S, M, _>(scene, |excitation| {
        let state = stepper.scene().start(&start, excitation).map_err(|error| refuse_start(scene, &error))?;
        with(&Run { scene, model, options, stepper: &stepper, excitation }, state)
    })
}

/// Attempts per call: the counts of a call fit in 32 bits.
const BUDGET: u32 = 1 << 24;

/// What a run needs.
struct Run<'a, S: Scalar, M, P: Parts<S>, const B: usize, const R: usize> {
    scene: &'a Scene,
    model: &'a BumpStop,
    options: &'a Options,
    stepper: &'a Stepper<S, P, B, R>,
    excitation: &'a HostExcitation<'a, S, M>,
}

impl<S: Scalar, M: Mathematics<S>, P: Parts<S>, const B: usize, const R: usize> Run<'_, S, M, P, B, R> {
    fn to_end(&self, mut state: StateOf<S, P, B, R>) -> Result<Outcome, Failure> {
        let Self { scene, model, options, stepper, excitation } = self;
        let harvester = stepper.scene();
        let [settled, end] = ends_of(scene, &scene.run)?;
        let mut ledger = (!options.bare).then(|| ModalLedger::open(harvester, &state));
        let mut whole_run = ModalMeter::new(harvester);
        let mut window = ModalMeter::new(harvester);
        let every = options.trace_every_s.unwrap_or(f64::INFINITY);
        let has_stop = model.stop.is_some();
        let mut recorder = Recorder { harvester, has_stop, every, rows: Vec::new() };
        let mut total = Total::default();
        let began = Stopwatch::now();
        for (until, measured) in [(settled, false), (end, true)] {
            let mut of_run = ledger.as_mut().map(|ledger| (ledger, &mut whole_run));
            let mut whole = of_run.as_mut();
            let mut recording = options.trace_every_s.map(|_| &mut recorder);
            if measured {
                window = ModalMeter::from(harvester, &state);
            }
            let mut measuring = measured.then_some(&mut window);
            let mut others = (&mut recording, &mut measuring);
            let mut observer = (&mut whole, &mut others);
            while state.clock < until {
                let advance = stepper
                    .advance(&mut state, *excitation, until, BUDGET, &mut observer)
                    .map_err(|error| step_failure(&error, harvester, &state))?;
                total.add(&advance.work);
            }
        }
        let wall_s = began.elapsed().as_secs_f64();
        let residual = ledger.and_then(|ledger| match model.parameters.coupling {
            Coupling::TwoWay => ledger.residual().total(),
            Coupling::OneWay => ledger.residual().largest(),
        });
        let number = |value: S| Some(value.to_f64());
        let periods = scene.excitation.single_frequency().map(|frequency| frequency * scene.run.window_s());
        let with_stop = |value: S| model.stop.as_ref().map(|_| value.to_f64());
        let contacts = u64::from(window.contacts());
        Ok(Outcome {
            scene: scene.name(),
            method: "discrete-gradient".to_owned(),
            precision: precision_name::<S>(),
            math: M::NAME,
            duration_s: scene.run.duration_s,
            settle_s: scene.run.settle_s,
            mean_power_w: number(window.mean_power()),
            rms_voltage_v: number(window.rms_voltage()),
            peak_voltage_v: number(window.voltage().magnitude()),
            mean_voltage_v: number(window.mean_voltage()),
            delivered_energy_j: number(window.delivered_energy()),
            energy_residual: residual.map(S::to_f64),
            steps: total.steps,
            rejected_steps: total.rejected,
            newton_iterations: total.iterations,
            events: total.events,
            wall_s,
            particular: Particular::BumpStop(BumpStopOutcome {
                natural_frequencies_hz: self.natural_frequencies_hz(),
                peak_tip_displacement_m: number(window.tip().magnitude()),
                peak_stop_point_displacement_m: with_stop(window.stop_point().magnitude()),
                contacts,
                contacts_per_period: periods.map(|periods| contacts as f64 / periods),
                contact_fraction: number(window.contact_fraction()),
                first_contact_s: whole_run.first_contact().map(Instant::seconds),
                peak_force_n: with_stop(window.peak_force()),
                mean_force_n: with_stop(window.mean_force()),
                end_state: self.scaled(&state),
            }),
            store: self.store(&state, &whole_run),
            steady_state: None,
            trace: options
                .trace_every_s
                .map(|_| Recording { columns: recorder.columns(), rows: std::mem::take(&mut recorder.rows) }),
        })
    }

    /// What the store holds at the end, and what the whole run spent; a `bare` run has no account.
    fn store(
        &self,
        state: &StateOf<S, P, B, R>,
        whole_run: &ModalMeter<'_, S, P, B, R>,
    ) -> Option<StoreOutcome> {
        let store = self.stepper.scene().storage(state)?;
        let volts = store.voltage.to_f64();
        let account = (!self.options.bare).then(|| whole_run.storage_account());
        let spent = |of: fn(&StorageAccount<S>) -> S| account.as_ref().map(|account| of(account).to_f64());
        Some(StoreOutcome {
            store_voltage_v: Some(volts),
            stored_energy_j: stored_energy(self.scene.load, volts),
            diode_loss_j: spent(|account| account.diodes),
            leaked_energy_j: spent(|account| account.leaked),
            drawn_energy_j: spent(|account| account.drawn),
        })
    }

    /// The state with half the sum of its squares the energy in J of motion and charge.
    fn scaled(&self, state: &StateOf<S, P, B, R>) -> Vec<f64> {
        let harvester = self.stepper.scene();
        let rod_modes = self.model.stop.as_ref().map_or(0, |stop| stop.rod_modes);
        let beam = state.beam.iter().enumerate().take(self.model.parameters.beam_modes);
        let beam = beam.filter_map(|(i, motion)| Some((harvester.beam_angular_frequency(i)?, motion)));
        let rod = state.rod.iter().enumerate().take(rod_modes);
        let rod = rod.filter_map(|(j, motion)| Some((harvester.rod_angular_frequency(j)?, motion)));
        let charge = harvester.capacitance().to_f64().sqrt() * harvester.voltage(state).to_f64();
        beam.chain(rod)
            .flat_map(|(omega, [at, rate])| [omega.to_f64() * at.to_f64(), rate.to_f64()])
            .chain([charge])
            .collect()
    }

    /// Of the modes that the scene keeps, the beam's first.
    fn natural_frequencies_hz(&self) -> Vec<f64> {
        let harvester = self.stepper.scene();
        let beam = (0..self.model.parameters.beam_modes).filter_map(|i| harvester.beam_angular_frequency(i));
        let rod_modes = self.model.stop.as_ref().map_or(0, |stop| stop.rod_modes);
        let rod = (0..rod_modes).filter_map(|j| harvester.rod_angular_frequency(j));
        beam.chain(rod).map(|omega| omega.to_f64() / std::f64::consts::TAU).collect()
    }
}

fn step_failure<S: Scalar, P: Parts<S>, const B: usize, const R: usize>(
    error: &StepError<S>,
    harvester: &Harvester<S, P, B, R>,
    state: &StateOf<S, P, B, R>,
) -> Failure {
    Failure::Step(format!(
        "{error}: tip {:e} m, gap {:e} m, voltage {:e} V",
        harvester.tip(state)[0].to_f64(),
        state.gap().to_f64(),
        harvester.voltage(state).to_f64()
    ))
}

/// Rows of a trace at equal distances in time: the columns of [`BUMP_STOP_COLUMNS`], and behind a bridge of
/// [`STORE_COLUMNS`].
struct Recorder<'a, S: Scalar, P: Parts<S>, const B: usize, const R: usize> {
    harvester: &'a Harvester<S, P, B, R>,
    /// Without one there is no stop point, no rod and no force.
    has_stop: bool,
    every: f64,
    rows: Vec<Vec<f64>>,
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> Recorder<'_, S, P, B, R> {
    fn columns(&self) -> &'static [&'static str] {
        if P::Load::SWITCHES { &STORE_COLUMNS } else { &BUMP_STOP_COLUMNS }
    }
}

/// What a load of the parts `P` remembers.
type MemoryOf<S, P> = <<P as Parts<S>>::Load as Circuit<S>>::State;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> ModalObserver<S, B, R, MemoryOf<S, P>>
    for Recorder<'_, S, P, B, R>
{
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, MemoryOf<S, P>>) {
        let (from, end) = (span.start.clock.seconds::<f64>(), span.end.clock.seconds::<f64>());
        loop {
            let time = self.rows.len() as f64 * self.every;
            if Instant::from_seconds(time).is_none_or(|row| row > span.end.clock) {
                return;
            }
            let theta = S::from_f64(((time - from) / (end - from)).clamp(0.0, 1.0));
            type Of<S, P, const B: usize, const R: usize> =
                fn(&Harvester<S, P, B, R>, &StateOf<S, P, B, R>) -> [S; 2];
            let dense = |of: Of<S, P, B, R>| {
                let [start, end] = [span.start, span.end].map(|state| of(self.harvester, state));
                Cubic::new(start[0], start[1], end[0], end[1], span.step).value(theta).to_f64()
            };
            let voltages = [span.start, span.end].map(|state| self.harvester.voltage(state));
            let voltage = Cubic::with_mean(voltages[0], voltages[1], span.mean_voltage).value(theta);
            let of_stop = |value: f64| if self.has_stop { value } else { f64::NAN };
            let [before, after] = span.accelerations().map(S::to_f64);
            let stores = [span.start, span.end].map(|state| self.harvester.storage(state));
            let [from_store, to_store] = stores.map(|store| store.map(|store| store.voltage));
            let store = from_store.zip(to_store).map(|(from, to)| (from + (to - from) * theta).to_f64());
            let mut row = vec![
                time,
                dense(Harvester::tip),
                of_stop(dense(Harvester::stop_point)),
                of_stop(dense(Harvester::rod_tip)),
                voltage.to_f64(),
                of_stop(span.force.to_f64()),
                before + (after - before) * theta.to_f64(),
            ];
            row.extend(store);
            self.rows.push(row);
        }
    }
}
