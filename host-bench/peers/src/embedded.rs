//! The embedded core alone: parts chosen at compile time, one power, double precision, as a firmware links it.

use harvester_engine::embedded::{bump_stop_parameters, contact_separation_parameters, sliding_parameters};
use harvester_scene::scene_file::{self, Draw, Excitation, ForceLaw, Load, Model, RectifiedStore, Scene};
use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::Advance;
use model_core::integrate::{Adaptive, ExponentialRadau, FixedStep, RungeKutta4, TrBdf2};
use model_core::part::draw::{Lockout, NoDraw, PowerDraw};
use model_core::part::load::{OpenCircuit, Resistor};
use model_core::part::rectifier::FullBridge;
use model_core::part::restitution::AnyRestitution;
use model_core::part::storage::{Capacitor, StorageCapacitor};
use model_core::scalar::Polynomial;
use model_core::scene::bump_stop::{self, ResidualFlexibility, Stepper, Stop as CoreStop};
use model_core::scene::rectified::Rectified;
use model_core::scene::{Harvester, Scene as CoreScene, Simulation, contact_separation, sliding};

use crate::method::Method;
use crate::{Meter, Stop};

/// Short steps in a long step of the bump-stop method, as by default.
const LONG_STEP: f64 = 20.0;

fn refuse<T>(reason: &str) -> Result<T, Stop> {
    Err(Stop::Refused(reason.to_owned()))
}

fn refused(error: impl std::fmt::Display) -> Stop {
    Stop::Refused(error.to_string())
}

pub(crate) fn run(scene: &Scene, method: Method, setting: f64) -> Result<Meter, Stop> {
    let run = Run { scene, method, setting };
    match &scene.model {
        Model::ContactSeparation(model) => run.contact_separation(model),
        Model::Sliding(model) => run.sliding(model),
        Model::BumpStop(model) => run.bump_stop(model),
    }
}

struct Run<'a> {
    scene: &'a Scene,
    method: Method,
    setting: f64,
}

/// The core's bridge with a storage and its draw.
fn bridge<D>(store: RectifiedStore, draw: D) -> FullBridge<f64, StorageCapacitor<f64, D>> {
    let capacitor = Capacitor { capacitance: store.capacitance_f, leakage_resistance: store.leakage_ohm };
    let storage = StorageCapacitor { capacitor, initial_voltage: store.initial_v, draw };
    FullBridge { diode_drop: store.diode_drop_v, storage }
}

/// Runs `$run` with the bridge of the load, whose draw is a type.
macro_rules! behind_bridge {
    ($store:expr, |$bridge:ident| $run:expr) => {
        match $store.draw {
            Draw::None => {
                let $bridge = bridge($store, NoDraw);
                $run
            }
            Draw::Power { power_w, lockout } => {
                let lockout = Lockout { turn_on: lockout.turn_on_v, turn_off: lockout.turn_off_v };
                let $bridge = bridge($store, PowerDraw { power: power_w, lockout });
                $run
            }
            _ => refuse("load.draw: must be \"none\" or \"power\" for this comparison"),
        }
    };
}

/// Runs a triboelectric scene of the parameters `$core` with the load `$load` that the scene file states.
macro_rules! by_load {
    ($run:ident, |$load:ident| $core:expr) => {
        match $run.scene.load {
            Load::Resistor { resistance_ohm } => {
                let $load = Resistor { resistance: resistance_ohm };
                $run.simulated($core.build().map_err(refused)?)
            }
            Load::RectifiedStore(store) => behind_bridge!(store, |bridge| {
                let $load = OpenCircuit;
                let core = $core.build().map_err(refused)?;
                $run.simulated(Rectified::new(core, bridge).map_err(refused)?)
            }),
            Load::DcBus { .. } => refuse("load: must be a resistor or a rectified store"),
        }
    };
}

impl Run<'_> {
    fn contact_separation(&self, model: &scene_file::ContactSeparation) -> Result<Meter, Stop> {
        let any = contact_separation_parameters::<f64, Polynomial>(model, self.scene.load);
        let (AnyRestitution::VelocityDependent(restitution), ForceLaw::TransferredCharge) =
            (any.choices.restitution, model.parameters.force_law)
        else {
            return refuse("parameters: restitution and force_law must be those of the shipped scene");
        };
        by_load!(self, |load| any.with_choices(
            contact_separation::Choices::new(load, restitution)
                .force_law(contact_separation::TransferredCharge)
                .parasitic(any.choices.parasitic),
        ))
    }

    fn sliding(&self, model: &scene_file::Sliding) -> Result<Meter, Stop> {
        if model.parameters.force_law != ForceLaw::TransferredCharge || model.parameters.lateral_force {
            return refuse("parameters: force_law and lateral_force must be those of the shipped scene");
        }
        let any = sliding_parameters::<f64>(model, self.scene.load);
        by_load!(self, |load| any.with_choices(
            sliding::Choices::new(load, any.choices.friction).force_law(sliding::TransferredCharge),
        ))
    }

    fn bump_stop(&self, model: &scene_file::BumpStop) -> Result<Meter, Stop> {
        let any = bump_stop_parameters::<f64>(model, self.scene.load);
        let stop = CoreStop {
            length: any.choices.stop.length,
            section: any.choices.stop.section,
            young_modulus: any.choices.stop.young_modulus,
            density: any.choices.stop.density,
            position: any.choices.stop.position,
            gap: any.choices.stop.gap,
            contact_compliance: any.choices.stop.contact_compliance,
            contact: ResidualFlexibility,
        };
        let Load::RectifiedStore(store) = self.scene.load else {
            return refuse("load: must be a rectified store");
        };
        let short = self.period() / self.setting;
        behind_bridge!(store, |bridge| {
            let parameters = bump_stop::Parameters {
                beam_length: any.beam_length,
                beam_width: any.beam_width,
                substrate: any.substrate,
                piezo: any.piezo,
                piezo_d31: any.piezo_d31,
                piezo_permittivity: any.piezo_permittivity,
                damping_ratio: any.damping_ratio,
                choices: bump_stop::Choices::behind(bridge)
                    .stop(stop)
                    .tip_mass(any.choices.tip_mass)
                    .transducer(any.choices.transducer),
            };
            let core = parameters.build::<4, 1>().map_err(refused)?;
            self.measured(&Stepper::new(core, short, LONG_STEP * short).map_err(refused)?)
        })
    }

    /// The period of the base in s.
    fn period(&self) -> f64 {
        self.scene.excitation.single_frequency().map_or(f64::NAN, f64::recip)
    }

    /// Runs a triboelectric scene by the method.
    fn simulated<A, const N: usize>(&self, core: A) -> Result<Meter, Stop>
    where
        A: CoreScene<f64, N, 1>,
    {
        let adaptive = || Adaptive::new(self.setting).map_err(refused);
        let fixed = || FixedStep::of_seconds(self.period() / self.setting).map_err(refused);
        match self.method {
            Method::ExponentialRadau => self.measured(&Simulation::new(core, ExponentialRadau, adaptive()?)),
            Method::TrBdf2 => self.measured(&Simulation::new(core, TrBdf2, adaptive()?)),
            Method::Rk4 => self.measured(&Simulation::new(core, RungeKutta4, fixed()?)),
            _ => refuse("the method must be a triboelectric one"),
        }
    }

    /// Runs a harvester of the core.
    fn measured<H: Harvester<f64>>(&self, harvester: &H) -> Result<Meter, Stop> {
        let Excitation::Sine(tone) = &self.scene.excitation else {
            return refuse("excitation.kind: must be \"sine\" for this comparison");
        };
        let sine: Sine<f64, Polynomial> =
            Sine::new(tone.amplitude_m_per_s2, tone.frequency_hz, tone.phase_rad).map_err(refused)?;
        let whole = Meter::begin();
        let mut state = harvester.start(&H::Start::default(), &sine).map_err(refused)?;
        let mut steps = 0.0;
        let mut to = |seconds: f64, steps: &mut f64| {
            let until = Instant::from_seconds(seconds).ok_or_else(|| refused("run: too long"))?;
            let mut meter = PowerMeter::new();
            loop {
                let Advance { work, .. } = harvester
                    .advance(&mut state, &sine, until, 1 << 24, &mut meter)
                    .map_err(|error| Stop::Integrator(error.to_string()))?;
                *steps += f64::from(work.steps);
                if harvester.clock(&state) >= until {
                    return Ok(meter.delivered_energy());
                }
            }
        };
        to(self.scene.run.settle_s, &mut steps)?;
        let delivered = to(self.scene.run.duration_s, &mut steps)?;
        Ok(whole.close(delivered, steps))
    }
}
