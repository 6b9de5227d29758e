//! A run of a triboelectric scene, bare or behind a bridge: the method is chosen at run time.

use model_core::energy::{Integrals, Residual, RunMeter};
use model_core::hybrid::HybridState;
use model_core::integrate::{AnyStepControl, Cubic, Method as Integrator};
use model_core::observer::{ALL_POWERS, AcceptedStep, Motion, Outputs, PowerIndex};
use model_core::part::storage::AnyStorage;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::rectified::{ElectricalPort, Rectified};
use model_core::scene::{Harvester, Scene as CoreScene, Simulation};

use super::excitation::{Setting, bridge};
use super::limits::Gauge;
use super::report::{Report, RunSummary, dense, dense_voltage};
use super::run::{Run, refuse_start, step_control};
use harvester_scene::method::{Failure, Method};
use harvester_scene::outcome::{Outcome, Particular, with_store};
use harvester_scene::scene_file::{Draw, Load, Scene};

/// States of a bare triboelectric scene: position in m, velocity in m/s, charge in units of the scene.
pub(super) const STATES: usize = 3;

/// Parts of a step at whose ends a scene is compared with its limits.
pub(super) const PARTS: u32 = 4;

/// A triboelectric model of a scene file, for the core.
pub(super) trait Triboelectric {
    /// The core's harvester. It has no elementary functions as a type, so that one is compiled for all of them.
    type Core<S: Scalar>: ElectricalPort<S>
        + CoreScene<S, STATES, 0, Start = Self::Start<S>, Mode: Send + Sync>
        + CoreScene<S, STATES, ALL_POWERS, Start = Self::Start<S>, Mode: Send + Sync>;
    type Start<S: Scalar>;
    /// Columns of a trace without a storage: the second is the coordinate.
    const COLUMNS: [&'static str; 7];

    /// With the elementary functions `M`.
    fn core<S: Scalar, M: Mathematics<S>>(&self, scene: &Scene) -> Result<Self::Core<S>, Failure>;

    fn start<S: Scalar>(&self) -> Self::Start<S>;

    /// A step in s at which the explicit method is stable and accurate: see [`explicit_step_into`].
    fn explicit_step<S: Scalar>(&self, core: &Self::Core<S>, load: Load) -> f64;

    /// Position, velocity and charge as large as they are in a wide motion, in the units of the state.
    fn typical<S: Scalar>(&self, core: &Self::Core<S>) -> [f64; STATES];

    /// The relative residual of the energy ledger that holds for this scene.
    fn residual<S: Scalar>(&self, residual: &Residual<S>) -> Option<S>;

    /// What compares the steps of a run with the limits of the model.
    fn gauge<'a, S: Scalar>(&'a self, scene: &'a Scene) -> Gauge<'a, S>;

    /// The numbers that only this kind of scene has.
    fn particular<S: Scalar>(&self, harvester: &impl Harvester<S>, found: &RunSummary<'_, S>) -> Particular;
}

impl<S: Scalar, H: Harvester<S>, T: Triboelectric> Report<S, H> for T {
    fn columns(&self, with_storage: bool) -> &'static [&'static str] {
        let all = const { &with_store(T::COLUMNS) };
        if with_storage { all } else { &all[..T::COLUMNS.len()] }
    }

    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
        row(step, fraction, acceleration)
    }

    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        Triboelectric::residual(self, residual)
    }

    fn created_energy(&self, window: &RunMeter<S>) -> Option<S> {
        window.report().rms_voltage.map(|_| created_energy(window.integrals()))
    }

    fn gauge<'a>(&'a self, setting: Setting<'a, S>) -> Gauge<'a, S> {
        Triboelectric::gauge(self, setting.scene)
    }

    fn particular(&self, harvester: &H, found: &RunSummary<'_, S>, _end: &H::State) -> Particular {
        Triboelectric::particular(self, harvester, found)
    }

    fn describe(&self, outputs: &Outputs<'_, S>) -> String {
        let motion = outputs.coordinate();
        format!(
            "{} {:e}, velocity {:e} m/s, charge {:e} C, mode {}",
            T::COLUMNS[1],
            motion.value.to_f64(),
            motion.rate.to_f64(),
            outputs.charge.value.to_f64(),
            outputs.mode
        )
    }
}

/// Energy in J that the force law created: what the field gained from the motion less what the motion lost to the force.
pub(super) fn created_energy<S: Scalar>(all: &Integrals<S>) -> S {
    all.integral(PowerIndex::FieldWork) - all.integral(PowerIndex::ElectrostaticWork)
}

/// `$then` with the simulation of a prepared scene by the method of its options.
macro_rules! by_method {
    ($prepared:ident, |$simulation:ident| $then:expr) => {
        match $prepared.setting.options.method {
            harvester_scene::method::Method::Rk4 => {
                let $simulation = $prepared.simulation(model_core::integrate::RungeKutta4);
                $then
            }
            harvester_scene::method::Method::TrBdf2 => {
                let $simulation = $prepared.simulation(model_core::integrate::TrBdf2);
                $then
            }
            _ => {
                let $simulation = $prepared.simulation(model_core::integrate::ExponentialRadau);
                $then
            }
        }
    };
}
pub(super) use by_method;

/// A scene of the core that is checked, with its excitation and the rule for the length of its steps.
pub(super) struct Prepared<'a, S: Scalar, A, T> {
    pub(super) setting: Setting<'a, S>,
    pub(super) core: A,
    pub(super) model: &'a T,
    pub(super) control: AnyStepControl<S>,
}

/// The simulation of a scene of the core by the method `I`.
pub(super) type Simulated<S, A, I, const N: usize> = Simulation<A, I, AnyStepControl<S>, N, ALL_POWERS>;

/// A scene of the core, not behind a bridge.
type Bare<'a, S, T> = Prepared<'a, S, <T as Triboelectric>::Core<S>, T>;

/// All that a run of a scene with a resistor needs.
pub(super) fn prepared<'a, S: Scalar, M: Mathematics<S>, T: Triboelectric>(
    setting: Setting<'a, S>,
    model: &'a T,
) -> Result<Bare<'a, S, T>, Failure> {
    let Setting { scene, options, .. } = setting;
    let core = model.core::<S, M>(scene)?;
    let control = step_control(scene, options, model.explicit_step(&core, scene.load))?;
    Ok(Prepared { setting, core, model, control })
}

/// A scene of the core behind a bridge.
type Bridged<'a, S, T> = Prepared<'a, S, Rectified<S, <T as Triboelectric>::Core<S>, AnyStorage<S>>, T>;

/// All that a run of a scene behind a bridge needs.
pub(super) fn behind_bridge<'a, S: Scalar, M: Mathematics<S>, T: Triboelectric>(
    setting: Setting<'a, S>,
    model: &'a T,
) -> Result<Bridged<'a, S, T>, Failure> {
    let Setting { scene, options, .. } = setting;
    let bridge = bridge(scene.load)
        .ok_or_else(|| Failure::of_file(scene, "load.kind: must be a bridge, is \"resistor\""))?;
    let inner = model.core::<S, M>(scene)?;
    let motion_s = model.explicit_step(&inner, scene.load);
    let core =
        Rectified::new(inner, bridge).map_err(|error| Failure::of_file(scene, format!("load.{error}")))?;
    let control = step_control(scene, options, explicit_step(motion_s, scene.load))?;
    Ok(Prepared { setting, core, model, control })
}

/// Runs the scene from its start to its end.
pub(super) fn run<S: Scalar, M: Mathematics<S>, T: Triboelectric>(
    setting: Setting<'_, S>,
    model: &T,
) -> Result<Outcome, Failure> {
    if matches!(setting.scene.load, Load::Resistor { .. }) {
        return prepared::<S, M, T>(setting, model)?.to_end::<STATES>(&model.start());
    }
    behind_bridge::<S, M, T>(setting, model)?.to_end(&model.start())
}

impl<'a, S: Scalar, A: Copy, T: Triboelectric> Prepared<'a, S, A, T> {
    /// The scene stepped by a method.
    pub(super) fn simulation<I, const N: usize>(&self, method: I) -> Simulated<S, A, I, N> {
        Simulation::with_all_powers(self.core, method, self.control)
    }

    pub(super) fn run<'b, I, const N: usize>(
        &'b self,
        simulation: &'b Simulated<S, A, I, N>,
    ) -> Run<'b, S, Simulated<S, A, I, N>, T>
    where
        'a: 'b,
    {
        let Self { setting, model, .. } = *self;
        let method = match setting.options.method {
            Method::Auto => Method::ExponentialRadau,
            method => method,
        };
        Run { setting, harvester: simulation, report: model, method }
    }

    /// Runs from `start` to the end of the scene by the method of the options.
    fn to_end<const N: usize>(&self, start: &A::Start) -> Result<Outcome, Failure>
    where
        A: CoreScene<S, N, ALL_POWERS>,
    {
        by_method!(self, |simulation| {
            let mut state = self.start(&simulation, start)?;
            self.run(&simulation).measured(&mut state, &self.setting.scene.run)
        })
    }

    /// The state at the start of the scene.
    pub(super) fn start<I: Integrator<S>, const N: usize>(
        &self,
        simulation: &Simulated<S, A, I, N>,
        start: &A::Start,
    ) -> Result<HybridState<S, A::Mode, N, ALL_POWERS>, Failure>
    where
        A: CoreScene<S, N, ALL_POWERS>,
    {
        let Setting { scene, excitation, .. } = self.setting;
        simulation.start(start, &excitation).map_err(|error| refuse_start(scene, &error))
    }
}

/// The six columns of a trace: position, velocity, charge, voltage, base acceleration, stick.
fn row<S: Scalar>(step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
    let [start, end] = [step.start.coordinate(), step.end.coordinate()];
    [
        dense(start, end, step.step, fraction),
        dense_velocity(start, end, step.step, fraction),
        dense(step.start.charge, step.end.charge, step.step, fraction),
        dense_voltage(step, fraction),
        acceleration,
        if step.start.stick { S::ONE } else { S::ZERO },
    ]
}

/// Steps in s below which rounding makes the mean velocity of a step worse than a straight line between its ends.
const SHORT_STEP_S: f64 = 1e-5;

/// The velocity at a fraction of a step: a parabola of the mean, or a straight line over a short step.
fn dense_velocity<S: Scalar>(start: Motion<S>, end: Motion<S>, step: S, fraction: S) -> S {
    if step < S::from_f64(SHORT_STEP_S) {
        return start.rate + (end.rate - start.rate) * fraction;
    }
    Cubic::with_mean(start.rate, end.rate, (end.value - start.value) / step).value(fraction)
}

/// A tribo-charge in units of the state. Without charge there is no electrical motion, and any unit serves.
pub(super) fn unit_of_charge(tribo_charge: f64, charge_unit: f64) -> f64 {
    if tribo_charge > 0.0 { tribo_charge / charge_unit } else { 1.0 }
}

/// A step in s at which an explicit method is stable and accurate: an 800th of the natural period in s, and 2 over the
/// fastest rate of the circuit, 1/(R C), with `capacitance_f` in F.
pub(super) fn explicit_step_into(load: Load, period_s: f64, capacitance_f: f64) -> f64 {
    let resistance_ohm = load.resistance_ohm();
    let circuit = if resistance_ohm == 0.0 { f64::INFINITY } else { 2.0 * resistance_ohm * capacitance_f };
    (period_s / 800.0).min(circuit)
}

/// A step at which an explicit method is stable and accurate behind a bridge: the step of the motion, and 2 times the
/// time constant of what empties the storage.
fn explicit_step(motion_s: f64, load: Load) -> f64 {
    let Load::RectifiedStore(storage) = load else { return motion_s };
    let drawn = match storage.draw {
        Draw::Resistor { resistance_ohm, .. } => resistance_ohm,
        // Steepest where the draw is disconnected.
        Draw::Power { power_w, lockout } => lockout.turn_off_v.powi(2) / power_w,
        Draw::None | Draw::Current { .. } => f64::INFINITY,
    };
    motion_s.min(2.0 * storage.capacitance_f * storage.leakage_ohm.min(drawn))
}
