//! A run of a peer.

use std::cell::Cell;

use differential_equations::methods::ExplicitRungeKutta;
use diffsol::NalgebraLU;
use harvester_scene::scene_file::{Draw, Excitation, Load, Model, RectifiedStore, Scene, StickCharge};

use super::scene::{Base, Harvester, System};
use super::solver::{Explicit, Implicit, problem, stop};
use crate::load::{Transducer, WithBridge, WithResistor};
use crate::march::March;
use crate::method::Method;
use crate::scene::bump_stop::BumpStop;
use crate::scene::contact_separation::ContactSeparation;
use crate::scene::sliding::Sliding;
use crate::{Meter, Stop};

/// Steps after which a run is given up.
const MOST_STEPS: f64 = 3e6;

/// What the tolerances of a kind of method mean: of the values tried, on contact-separation at 100 MΩ and 1 MΩ and sliding
/// at 100 MΩ, those with the least run time at errors of 1e-2, 1e-3 and 1e-5.
struct Tuning {
    /// Absolute tolerance over relative tolerance and size of the states of the motion.
    motion: f64,
    /// The same of the voltages.
    voltage: f64,
    /// The same of the energy.
    energy: f64,
    /// First step after an event over the last one before it.
    restart: f64,
}

const EXPLICIT: Tuning = Tuning { motion: 1.0, voltage: 100.0, energy: 1.0, restart: 1.0 };
const IMPLICIT: Tuning = Tuning { motion: 0.01, voltage: 100.0, energy: 1000.0, restart: 0.1 };

impl Tuning {
    /// The absolute tolerances at a relative one.
    fn absolute<H: Harvester<N>, const N: usize>(&self, relative: f64, harvester: &H) -> [f64; N] {
        let mut sizes = harvester.sizes();
        let (motion, rest) = sizes.split_at_mut(harvester.motion_states());
        motion.iter_mut().for_each(|size| *size *= self.motion * relative);
        if let Some((energy, voltages)) = rest.split_last_mut() {
            voltages.iter_mut().for_each(|size| *size *= self.voltage * relative);
            *energy *= self.energy * relative;
        }
        sizes
    }
}

/// Modes of beam and rod of the bump-stop scene.
const MODES: usize = 5;

fn refuse<T>(reason: &str) -> Result<T, Stop> {
    Err(Stop::Refused(reason.to_owned()))
}

pub(crate) fn run(scene: &Scene, method: Method, tolerance: f64) -> Result<Meter, Stop> {
    let Excitation::Sine(tone) = &scene.excitation else {
        return refuse("excitation.kind: must be \"sine\" for the peers");
    };
    let base = Base {
        amplitude: tone.amplitude_m_per_s2,
        angular_frequency: std::f64::consts::TAU * tone.frequency_hz,
        phase: tone.phase_rad,
    };
    let run = Run { scene, method, tolerance };
    match &scene.model {
        Model::ContactSeparation(model) => {
            frozen(model.parameters.stick_charge)?;
            at_rest(model.initial == Default::default())?;
            run.with::<_, 4, 5>(ContactSeparation::new(&model.parameters, base))
        }
        Model::Sliding(model) => {
            frozen(model.parameters.stick_charge)?;
            at_rest(model.initial == Default::default())?;
            if model.parameters.lateral_force {
                return refuse("parameters.lateral_force: must be false for the peers");
            }
            if matches!(scene.load, Load::RectifiedStore(RectifiedStore { draw, .. }) if draw != Draw::None) {
                return refuse("load.draw: must be \"none\" in sliding for the peers");
            }
            run.with::<_, 4, 5>(Sliding::new(&model.parameters, base))
        }
        Model::BumpStop(model) => match BumpStop::<MODES>::new(model, base) {
            Some(transducer) => run.with::<_, { 2 * MODES + 2 }, { 2 * MODES + 3 }>(transducer),
            None => refuse("parameters.beam_modes: must be 5 with stop.rod_modes for the peers"),
        },
    }
}

fn frozen(charge: StickCharge) -> Result<(), Stop> {
    match charge {
        StickCharge::Frozen => Ok(()),
        StickCharge::Relaxing => refuse("parameters.stick_charge: must be \"frozen\" for the peers"),
    }
}

fn at_rest(is_default: bool) -> Result<(), Stop> {
    if is_default { Ok(()) } else { refuse("initial: must not be given for the peers") }
}

/// What a run needs besides the equations.
struct Run<'a> {
    scene: &'a Scene,
    method: Method,
    tolerance: f64,
}

impl Run<'_> {
    /// Runs the motion with its load: with `R` states with a resistor, with `B` states behind a bridge.
    fn with<T: Transducer, const R: usize, const B: usize>(&self, transducer: T) -> Result<Meter, Stop> {
        match self.scene.load {
            Load::Resistor { resistance_ohm } if resistance_ohm > 0.0 => {
                self.march::<_, R>(WithResistor { transducer, conductance: resistance_ohm.recip() })
            }
            Load::RectifiedStore(store) => match store.draw {
                Draw::None | Draw::Power { .. } => self.march::<_, B>(WithBridge { transducer, store }),
                _ => refuse("load.draw: must be \"none\" or \"power\" for the peers"),
            },
            _ => refuse("load: must be a resistor above 0 ohm or a rectified store for the peers"),
        }
    }

    fn march<H: Harvester<N>, const N: usize>(&self, harvester: H) -> Result<Meter, Stop> {
        let span = [self.scene.run.settle_s, self.scene.run.duration_s];
        let (mode, state) = harvester.start();
        let relative = self.tolerance;
        let is_explicit = matches!(self.method, Method::Dopri5 | Method::Dop853);
        let tuning = if is_explicit { EXPLICIT } else { IMPLICIT };
        let absolute = tuning.absolute(relative, &harvester);
        let system = System { harvester, mode: Cell::new(mode) };
        macro_rules! march {
            ($solver:expr) => {
                March::new(&system, $solver, state, [tuning.restart, MOST_STEPS]).run(span)
            };
        }
        macro_rules! explicit {
            ($method:ident) => {{
                let method = ExplicitRungeKutta::$method().max_steps(usize::MAX);
                march!(Explicit { system: &system, method: method.rtol(relative).atol(absolute) })
            }};
        }
        macro_rules! implicit {
            ($method:ident) => {{
                let mut problem = problem(&system, state, relative, absolute).map_err(stop)?;
                // The crate counts the failures of a whole run.
                problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
                let method = problem.$method::<NalgebraLU<f64>>().map_err(stop)?;
                march!(Implicit::new(&system, method))
            }};
        }
        match self.method {
            Method::Dopri5 => explicit!(dopri5),
            Method::Dop853 => explicit!(dop853),
            Method::DiffsolTrBdf2 => implicit!(tr_bdf2),
            Method::DiffsolEsdirk34 => implicit!(esdirk34),
            _ => implicit!(bdf),
        }
    }
}
