//! A bump-stop run on the embedded core.

mod observed;

use std::f64::consts::TAU;

use model_core::bounds::ParameterError;
use model_core::clock::{Instant, LONGEST_STEP_S};
use model_core::energy::Residual;
use model_core::observer::{AcceptedStep, Outputs, PowerIndex};
use model_core::part::load::AnyLoad;
use model_core::part::monomorph::Layer;
use model_core::scalar::Scalar;
use model_core::scene::Harvester as _;
use model_core::scene::bump_stop::{
    AnyChoices, AnyContact, BumpStop as Harvester, Choices, Circuit, ClampMeter, Parameters, Parts,
    Resistive, Restitution, Start, StateOf, Stepper, Stop, TipMass,
};

use super::excitation::{HostExcitation, Setting, bridge};
use super::limits::{Clamp, Gauge, MOST_MODES, limits};
use super::report::{Report, RunSummary, dense, dense_voltage};
use super::run::{Run, refuse_parameter, refuse_start};
use harvester_scene::method::{Failure, Method, Options};
use harvester_scene::outcome::{BUMP_STOP_COLUMNS, BumpStopOutcome, Outcome, Particular, with_store};
use harvester_scene::scene_file::{BumpStop, Contact, Coupling, Load, Scene};
pub use observed::{
    ContactInterval, DeflectedShape, ShapePoint, chattering_phases, contact_intervals, deflected_shapes,
};

/// Step near contact where none is given, in s, unless the excitation needs a shorter one.
pub const DEFAULT_SHORT_STEP_S: f64 = 1e-6;
/// Step in free flight where none is given, in s.
pub const DEFAULT_LONG_STEP_S: f64 = 2e-5;

/// Radians of the fastest sine in the step near contact where none is given. The core cuts longer ones than twice this length to
/// steps in which the voltage is constant, which halving does not change: their powers are up to 12 % off.
const RESOLVED_RAD: f64 = 0.45;

/// The method of the core, as the command line writes it.
pub(super) const METHOD: Method = Method::DiscreteGradient;

/// The core's parameters of a scene whose load is a resistor; a bridge is taken as it is while it blocks.
pub fn parameters<S: Scalar>(model: &BumpStop, load: Load) -> Parameters<S, AnyChoices<S>> {
    parameters_with(model, resistance(load))
}

pub(super) fn resistance<S: Scalar>(load: Load) -> Resistive<AnyLoad<S>> {
    Resistive(AnyLoad { resistance: S::from_f64(load.resistance_ohm()) })
}

/// The core's parameters of a scene with a load of the core.
fn parameters_with<S: Scalar, L>(model: &BumpStop, load: L) -> Parameters<S, AnyChoices<S, L>> {
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
        contact: AnyContact::NoStop,
    };
    let stop = model.stop.as_ref().map_or(absent, |stop| Stop {
        length: number(stop.length_m),
        section: number(stop.width_m * stop.thickness_m),
        young_modulus: number(stop.young_modulus_pa),
        density: number(stop.density_kg_per_m3),
        position: number(stop.position_m),
        gap: number(stop.gap_m),
        contact_compliance: number(stop.contact_compliance_m_per_n),
        contact: match stop.contact {
            Contact::ResidualFlexibility => AnyContact::ResidualFlexibility,
            Contact::DisplacementConstraint => AnyContact::DisplacementConstraint,
            Contact::Restitution => {
                AnyContact::Restitution(Restitution { coefficient: number(stop.restitution.unwrap_or(1.0)) })
            }
        },
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
        choices: Choices {
            load,
            stop,
            coupling: from.coupling,
            tip_mass: from.tip_mass.map(|body| {
                model_core::tip_mass_numbers!(harvester_scene::of_rows! { core body TipMass {} })
            }),
            transducer: from.transducer,
        },
    }
}

/// `$with` for the numbers of modes of a model.
///
/// They are type parameters of the core. A mode beyond the scene's own stays at rest and leaves every bit as it is, so a few
/// capacities serve all scenes.
macro_rules! by_modes {
    ($model:expr, $with:ident::<$($of:ty),+>($($argument:expr),+)) => {
        match $model.modes() {
            [..=4, ..=2] => $with::<$($of,)+ 4, 2>($($argument),+),
            [..=10, ..=10] => $with::<$($of,)+ 10, 10>($($argument),+),
            _ => $with::<$($of,)+ 20, 20>($($argument),+),
        }
    };
}
pub(super) use by_modes;

/// Runs the scene from its start to its end.
pub(super) fn run<S: Scalar>(setting: Setting<'_, S>, model: &BumpStop) -> Result<Outcome, Failure> {
    match bridge(setting.scene.load) {
        Some(bridge) => by_modes!(model, run_with::<S, _>(setting, model, bridge)),
        None => by_modes!(model, run_with::<S, _>(setting, model, resistance(setting.scene.load))),
    }
}

/// The lengths of step near contact and in free flight that the options ask for.
fn steps(scene: &Scene, options: &Options) -> Result<[f64; 2], Failure> {
    if options.tolerance.is_some() {
        return Err(Failure::Input(
            "--tolerance: must not be given for a bump-stop scene, whose steps have no error estimate; \
             give --accuracy or --step"
                .to_owned(),
        ));
    }
    let resolved = RESOLVED_RAD / (TAU * scene.excitation.highest_hz());
    let short = options.step_s.unwrap_or(DEFAULT_SHORT_STEP_S.min(resolved));
    // A step that is given alone is that of the whole run.
    let long = options.long_step_s.or(options.step_s).unwrap_or(DEFAULT_LONG_STEP_S);
    for (name, step) in [("--step", short), ("--long-step", long)] {
        if step > LONGEST_STEP_S {
            return Err(Failure::Input(format!("{name} {step}: must be at most {LONGEST_STEP_S:.6} s")));
        }
    }
    if long < short {
        return Err(Failure::Input(format!(
            "--long-step {long}: must be at least {short} s, the step near contact (--step)"
        )));
    }
    Ok([short, long].map(|step| step * options.refinement()))
}

/// A harvester of the core, its initial values, and its lengths of step near contact and in free flight in s.
type Prepared<S, L, const B: usize, const R: usize> =
    (Harvester<S, AnyChoices<S, L>, B, R>, Start<S, B, R>, [S; 2]);

fn prepared<S: Scalar, L: Circuit<S>, const B: usize, const R: usize>(
    (scene, model, options): (&Scene, &BumpStop, &Options),
    load: L,
) -> Result<Prepared<S, L, B, R>, Failure> {
    let steps = steps(scene, options)?.map(S::from_f64);
    let [beam_modes, rod_modes] = model.modes();
    let harvester = parameters_with(model, load)
        .build_first::<B, R>(beam_modes, rod_modes)
        .map_err(|error| refuse_parameter(scene, &error))?;
    let initial = &model.initial;
    let mut start = Start { voltage: S::from_f64(initial.voltage_v), ..Start::default() };
    let put = |coordinates: &mut [[S; 2]], displacements: &[f64], velocities: &[f64]| {
        for ((coordinate, &displacement), &velocity) in
            coordinates.iter_mut().zip(displacements).zip(velocities)
        {
            *coordinate = [S::from_f64(displacement), S::from_f64(velocity)];
        }
    };
    put(&mut start.beam, &initial.modal_displacement, &initial.modal_velocity);
    put(&mut start.rod, &initial.rod_modal_displacement, &initial.rod_modal_velocity);
    Ok((harvester, start, steps))
}

/// A harvester with all powers, and its initial values.
pub(super) type Begun<S, L, const B: usize, const R: usize> =
    (Stepper<S, AnyChoices<S, L>, B, R, 1>, Start<S, B, R>);

pub(super) fn begun<S: Scalar, L: Circuit<S>, const B: usize, const R: usize>(
    of: (&Scene, &BumpStop, &Options),
    load: L,
) -> Result<Begun<S, L, B, R>, Failure> {
    let (scene, start, [short, long]) = prepared(of, load)?;
    Ok((Stepper::with_all_powers(scene, short, long).map_err(refuse_step)?, start))
}

fn run_with<S: Scalar, L: Circuit<S>, const B: usize, const R: usize>(
    setting: Setting<'_, S>,
    model: &BumpStop,
    load: L,
) -> Result<Outcome, Failure> {
    let of = (setting.scene, model, setting.options);
    if setting.options.bare {
        let (scene, start, [short, long]) = prepared::<S, L, B, R>(of, load)?;
        to_end(setting, model, &Stepper::new(scene, short, long).map_err(refuse_step)?, &start)
    } else {
        let (stepper, start) = begun::<S, L, B, R>(of, load)?;
        to_end(setting, model, &stepper, &start)
    }
}

/// The refusal of a length of step by the core.
fn refuse_step<S: Scalar>(error: ParameterError<S>) -> Failure {
    Failure::Input(format!("--step, --long-step: {error}"))
}

fn to_end<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize>(
    setting: Setting<'_, S>,
    model: &BumpStop,
    harvester: &Stepper<S, P, B, R, ALL>,
    start: &Start<S, B, R>,
) -> Result<Outcome, Failure> {
    let Setting { scene, excitation, .. } = setting;
    let mut state = harvester.start(start, &excitation).map_err(|error| refuse_start(scene, &error))?;
    Run { setting, harvester, report: model, method: METHOD }.measured(&mut state, &scene.run)
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize>
    Report<S, Stepper<S, P, B, R, ALL>> for BumpStop
{
    fn columns(&self, with_storage: bool) -> &'static [&'static str] {
        const ALL_COLUMNS: [&str; 8] = with_store(BUMP_STOP_COLUMNS);
        if with_storage { &ALL_COLUMNS } else { &BUMP_STOP_COLUMNS }
    }

    /// Tip, stop point, rod face, voltage, contact force, base acceleration.
    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
        let place =
            |index: usize| dense(step.start.motions[index], step.end.motions[index], step.step, fraction);
        // Without a stop there is no stop point, no rod and no force.
        let of_stop = |value: S| if self.stop.is_some() { value } else { S::from_f64(f64::NAN) };
        let voltage = dense_voltage(step, fraction);
        [place(0), of_stop(place(1)), of_stop(place(2)), voltage, of_stop(step.contact.force), acceleration]
    }

    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        match self.parameters.coupling {
            Coupling::TwoWay => residual.total(),
            Coupling::OneWay => residual.largest(),
        }
    }

    fn particular(
        &self,
        harvester: &Stepper<S, P, B, R, ALL>,
        found: &RunSummary<'_, S>,
        end: &StateOf<S, P, B, R>,
    ) -> Particular {
        let window = found.window;
        let number = |value: S| Some(value.to_f64());
        let with_stop = |value: S| self.stop.as_ref().map(|_| value.to_f64());
        let contacts = u64::from(window.report().contacts);
        let modes = self.modes();
        let [beam_natural_frequencies_hz, rod_natural_frequencies_hz] =
            natural_frequencies_hz(harvester.scene(), modes);
        Particular::BumpStop(BumpStopOutcome {
            beam_natural_frequencies_hz,
            rod_natural_frequencies_hz,
            peak_tip_displacement_m: number(window.report().coordinate.magnitude()),
            peak_stop_point_displacement_m: with_stop(window.report().stop_point.magnitude()),
            contacts,
            contacts_per_period: found.periods.map(|periods| contacts as f64 / periods),
            contact_fraction: number(window.report().contact_fraction),
            first_contact_s: found.first_contact.map(Instant::seconds),
            peak_force_n: with_stop(window.report().peak_force),
            mean_force_n: with_stop(window.integrals().mean(PowerIndex::ContactForce)),
            clamp: found.clamp.map(Clamp::outcome),
            end_state: scaled(harvester.scene(), end, modes),
        })
    }

    fn clamp<'a>(&self, excitation: HostExcitation<'a, S>) -> Option<Clamp<'a, S>> {
        let [beam, rod] = self.modes();
        // The circuit has no part in the bending.
        let open = Load::Resistor { resistance_ohm: f64::INFINITY };
        let bending = parameters::<S>(self, open).clamp_bending::<MOST_MODES, MOST_MODES>(beam, rod).ok()?;
        Some(Clamp::new(ClampMeter::new(bending, excitation)))
    }

    /// At the ends of steps, the strain at the extremes of the curvature within them.
    fn gauge<'a>(&'a self, setting: Setting<'a, S>) -> Gauge<'a, S> {
        let from = &self.parameters;
        let [_, in_series] = from.layers();
        let [strain, piezo_strain, piezo_field, slope, speed] = limits(setting.scene);
        let mut clamp = Report::<S, Stepper<S, P, B, R, ALL>>::clamp(self, setting.excitation);
        let core = parameters::<f64>(self, setting.scene.load);
        let modes = (1..).take(from.beam_modes);
        let slopes = modes.map(|number| core.beam_mode(number).shape(1.0).slope / from.beam_length_m);
        let slopes: Vec<f64> = slopes.collect();
        let has_stop = self.stop.is_some();
        let at = move |step: &AcceptedStep<'_, S>, fraction: S| {
            let begins = fraction == S::ZERO;
            let outputs = if begins { &step.start } else { &step.end };
            let state = outputs.state.iter().step_by(2);
            let tilt: f64 = slopes.iter().zip(state).map(|(slope, at)| slope * at.to_f64()).sum();
            // A step counts once.
            let strains = clamp.as_mut().map_or([0.0; 2], |clamp| clamp.strains((!begins).then_some(step)));
            let meets = has_stop && step.start.penetration <= S::ZERO && step.end.penetration > S::ZERO;
            let [_, beam, rod] = step.start.motions;
            let closing = if meets { (beam.rate - rod.rate).to_f64().abs() } else { 0.0 };
            [
                [strains[0], strain],
                [strains[1], piezo_strain],
                [outputs.voltage.to_f64().abs() / (in_series * from.piezo_thickness_m), piezo_field],
                [tilt.abs(), slope],
                [closing, speed],
            ]
        };
        (Box::new(at), 1)
    }

    fn describe(&self, outputs: &Outputs<'_, S>) -> String {
        format!(
            "tip {:e} m, gap {:e} m, voltage {:e} V",
            outputs.coordinate().value.to_f64(),
            outputs.penetration.to_f64(),
            outputs.voltage.to_f64()
        )
    }
}

/// The state with half the sum of its squares the energy in J of motion and charge.
fn scaled<S: Scalar, P: Parts<S>, const B: usize, const R: usize>(
    scene: &Harvester<S, P, B, R>,
    state: &StateOf<S, P, B, R>,
    [beam_modes, rod_modes]: [usize; 2],
) -> Vec<f64> {
    let beam = state.beam.iter().enumerate().take(beam_modes);
    let beam = beam.filter_map(|(i, motion)| Some((scene.beam_angular_frequency(i)?, motion)));
    let rod = state.rod.iter().enumerate().take(rod_modes);
    let rod = rod.filter_map(|(j, motion)| Some((scene.rod_angular_frequency(j)?, motion)));
    let charge = scene.capacitance().to_f64().sqrt() * scene.voltage(state).to_f64();
    beam.chain(rod)
        .flat_map(|(omega, [at, rate])| [omega.to_f64() * at.to_f64(), rate.to_f64()])
        .chain([charge])
        .collect()
}

/// Of the modes that the scene keeps of the beam, and of the rod.
fn natural_frequencies_hz<S: Scalar, P: Parts<S>, const B: usize, const R: usize>(
    scene: &Harvester<S, P, B, R>,
    [beam_modes, rod_modes]: [usize; 2],
) -> [Vec<f64>; 2] {
    let hertz = |omega: S| omega.to_f64() / TAU;
    let beam = (0..beam_modes).filter_map(|i| scene.beam_angular_frequency(i));
    let rod = (0..rod_modes).filter_map(|j| scene.rod_angular_frequency(j));
    [beam.map(hertz).collect(), rod.map(hertz).collect()]
}
