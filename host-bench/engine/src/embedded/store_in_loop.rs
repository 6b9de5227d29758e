//! A triboelectric harvester behind a bridge and its store, every step of the day, with a draw that changes from time to time.
//!
//! The draw is part of the scene's parameters and not of its state: a new one makes a new scene, which goes on
//! from the same state. The first stage of its first step is still that of the draw before, as the last stage of a
//! step is the first of the next; of an interval of a minute that is a hundred-thousandth.

use model_core::clock::Instant;
use model_core::energy::Ledger;
use model_core::hybrid::{Automaton, HybridState};
use model_core::integrate::{AnyStepControl, ExponentialRadau};
use model_core::observer::{ALL_POWERS, PowerIndex};
use model_core::part::draw::{Lockout, PowerDraw};
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{Capacitor, StorageCapacitor};
use model_core::scalar::Scalar;
use model_core::scene::rectified::{ElectricalPort, Mode, Rectified, STATES};
use model_core::scene::{Harvester, Simulation};

use super::excitation::{HostExcitation, with_setting};
use super::refuse_bump_stop;
use super::run::{BUDGET, refuse_start, step_control};
use super::triboelectric::Triboelectric;
use super::whole_day::Daily;
use harvester_scene::method::{Failure, Options, Precision};
use harvester_scene::scene_file::{HOURS, Scene, Storage};

/// What a stretch of time did, in joules.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stretch {
    /// What entered the store.
    pub delivered_j: f64,
    pub leaked_j: f64,
    /// What was drawn from it.
    pub drawn_j: f64,
    /// What the diodes took.
    pub diodes_j: f64,
    pub steps: u64,
}

/// A harvester with its store, at some time of its day.
pub trait StoreInLoop {
    /// Goes on to a second of the day, the node drawing so many watts from the store while it is connected.
    fn advance(&mut self, until_s: u32, draw_w: f64) -> Result<Stretch, Failure>;

    /// Voltage of the store in V.
    fn voltage(&self) -> f64;

    fn is_connected(&self) -> bool;
}

/// The caller's function, behind a reference: the run is compiled in this crate and not in the caller's.
type With<'a> = &'a mut dyn FnMut(&mut dyn StoreInLoop) -> Result<(), Failure>;

/// A triboelectric scene at midnight.
#[derive(Debug)]
pub struct Midnight<'a> {
    pub scene: &'a Scene,
    pub diode_drop_v: f64,
    /// The store, but for its voltage and whether the node is connected.
    pub storage: &'a Storage,
    /// Voltage of the store in V.
    pub initial_v: f64,
    pub is_connected: bool,
    /// Factor of the excitation in each hour of the day.
    pub hours: &'a [f64; HOURS],
    pub options: &'a Options,
}

impl Midnight<'_> {
    /// Calls `with` with the harvester and its store.
    pub fn with_store_in_loop<R>(
        &self,
        with: impl FnOnce(&mut dyn StoreInLoop) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        self.options.check()?;
        self.options.check_scene(self.scene)?;
        let (mut with, mut found) = (Some(with), None);
        let mut call = |looped: &mut dyn StoreInLoop| {
            found = with.take().map(|with| with(looped));
            Ok(())
        };
        match self.options.precision {
            Some(Precision::F32) => self.with_precision::<f32>(&mut call)?,
            _ => self.with_precision::<f64>(&mut call)?,
        }
        found.unwrap_or_else(|| unreachable!("a run that began calls once"))
    }

    fn with_precision<S: Scalar>(&self, with: With<'_>) -> Result<(), Failure> {
        by_harvester!(self.scene,
            triboelectric(model) => self.with_model::<S, _>(model, with),
            bump_stop(_) => Err(refuse_bump_stop(self.scene, "with --exact")))
    }

    fn with_model<S: Scalar, T: Triboelectric>(&self, model: &T, with: With<'_>) -> Result<(), Failure> {
        let Self { scene, storage, .. } = self;
        let number = S::from_f64;
        let lockout = Lockout { turn_on: number(storage.turn_on_v), turn_off: number(storage.turn_off_v) };
        let bridge = FullBridge {
            diode_drop: number(self.diode_drop_v),
            storage: StorageCapacitor {
                capacitor: Capacitor {
                    capacitance: number(storage.capacitance_f),
                    leakage_resistance: number(storage.leakage_ohm),
                },
                initial_voltage: number(self.initial_v),
                draw: PowerDraw { power: S::ZERO, lockout },
            },
        };
        let core = connected(scene, model.core::<S, S::Build>(scene)?, bridge)?;
        // Only an explicit method asks how fast the circuit is.
        let control = step_control(scene, self.options, f64::INFINITY)?;
        with_setting::<S, S::Build, _>(scene, self.options, |setting| {
            let daily = Daily { base: setting.excitation, factors: self.hours.map(S::from_f64) };
            let mut state =
                core.start(&model.start(), &daily, &control).map_err(|error| refuse_start(scene, &error))?;
            // Between the thresholds the voltage alone does not determine the state of the switch.
            state.mode.connected = self.is_connected;
            with(&mut Loop { scene, core, daily, control, state })
        })
    }
}

/// A harvester of the core behind a bridge into a store that a node draws constant power from.
type Core<S, H> = Rectified<S, H, StorageCapacitor<S, PowerDraw<S>>>;

fn connected<S: Scalar, H: ElectricalPort<S>>(
    scene: &Scene,
    harvester: H,
    bridge: FullBridge<S, StorageCapacitor<S, PowerDraw<S>>>,
) -> Result<Core<S, H>, Failure> {
    Rectified::new(harvester, bridge).map_err(|error| Failure::of_file(scene, format!("node.{error}")))
}

struct Loop<'a, S: Scalar, H: ElectricalPort<S>> {
    scene: &'a Scene,
    core: Core<S, H>,
    daily: Daily<S, HostExcitation<'a, S>>,
    control: AnyStepControl<S>,
    state: HybridState<S, Mode<H::Mode>, STATES, ALL_POWERS>,
}

impl<S: Scalar, H: ElectricalPort<S>> StoreInLoop for Loop<'_, S, H> {
    fn advance(&mut self, until_s: u32, draw_w: f64) -> Result<Stretch, Failure> {
        let mut bridge = *self.core.bridge();
        bridge.storage.draw.power = S::from_f64(draw_w);
        self.core = connected(self.scene, *self.core.harvester(), bridge)?;
        let simulation = Simulation::with_all_powers(self.core, ExponentialRadau, self.control);
        let until = Instant::from_whole_seconds(until_s);
        let mut ledger = Ledger::open(&simulation.outputs(&self.state));
        let mut steps = 0;
        while self.state.clock < until {
            let advance = simulation
                .advance(&mut self.state, &self.daily, until, BUDGET, &mut ledger)
                .map_err(|error| Failure::Step(format!("{error}: {:?}", self.state)))?;
            steps += u64::from(advance.work.steps);
        }
        let integral = |power| ledger.integrals().integral(power).to_f64();
        Ok(Stretch {
            delivered_j: integral(PowerIndex::Load),
            leaked_j: integral(PowerIndex::Leakage),
            drawn_j: integral(PowerIndex::Draw),
            diodes_j: integral(PowerIndex::Diodes),
            steps,
        })
    }

    fn voltage(&self) -> f64 {
        // With what rounding took from it: a large store gains less than a rounding in a step.
        let storage = self.core.outputs(self.state.mode, &self.state.point).storage;
        storage.map_or(0.0, |storage| storage.voltage.to_f64() + storage.remainder.to_f64())
    }

    fn is_connected(&self) -> bool {
        self.state.mode.connected
    }
}
