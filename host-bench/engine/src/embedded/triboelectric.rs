//! A run of a triboelectric scene, bare or behind a bridge: the method is chosen at run time.

use model_core::integrate::Cubic;
use model_core::integrate::{AnyStepControl, Method as Integrator, RungeKutta4, TrBdf2};
use model_core::observer::{ALL_POWERS, AcceptedStep, Motion, Outputs};
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::AnyStorage;
use model_core::scalar::Scalar;
use model_core::scene::rectified::{self, ElectricalPort, Rectified};
use model_core::scene::{Scene as CoreScene, Simulation};

use super::excitation::Setting;
use super::method_name;
use super::recorder::{dense, dense_voltage};
use super::run::{Report, Run, refuse_start, step_control};
use harvester_scene::method::{Failure, Method};
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{Draw, Load};

/// States of a bare triboelectric scene: position in m, velocity in m/s, charge in units of the scene.
pub(super) const STATES: usize = 3;

/// A scene of the core that is checked, with its excitation and the rule for the length of its steps.
pub(super) struct Prepared<'a, S: Scalar, A, R> {
    pub(super) setting: Setting<'a, S>,
    pub(super) core: &'a A,
    pub(super) report: &'a R,
    pub(super) control: AnyStepControl<S>,
}

/// The simulation of a scene of the core by the method `I`.
pub(super) type Simulated<S, A, I, const N: usize> = Simulation<A, I, AnyStepControl<S>, N, ALL_POWERS>;

impl<'a, S: Scalar, A: Copy, R> Prepared<'a, S, A, R> {
    /// The scene stepped by a method.
    pub(super) fn simulation<I, const N: usize>(&self, method: I) -> Simulated<S, A, I, N> {
        Simulation::with_all_powers(*self.core, method, self.control)
    }

    /// A run of the simulation.
    pub(super) fn run<'b, I, const N: usize>(
        &'b self,
        simulation: &'b Simulated<S, A, I, N>,
    ) -> Run<'b, S, Simulated<S, A, I, N>, R>
    where
        'a: 'b,
    {
        let Self { setting, report, .. } = *self;
        Run { setting, harvester: simulation, report, method: method_name(setting.options.method) }
    }

    /// Runs from `start` to the end of the scene by the method of the options.
    pub(super) fn to_end<const N: usize>(&self, start: &A::Start) -> Result<Outcome, Failure>
    where
        A: CoreScene<S, N, ALL_POWERS>,
        R: Report<S, Simulated<S, A, RungeKutta4, N>> + Report<S, Simulated<S, A, TrBdf2, N>>,
    {
        match self.setting.options.method {
            Method::Rk4 => self.with(RungeKutta4, start),
            _ => self.with(TrBdf2, start),
        }
    }

    fn with<I: Integrator<S>, const N: usize>(&self, method: I, start: &A::Start) -> Result<Outcome, Failure>
    where
        A: CoreScene<S, N, ALL_POWERS>,
        R: Report<S, Simulated<S, A, I, N>>,
    {
        let simulation = self.simulation(method);
        let state = self.start(&simulation, start)?;
        self.run(&simulation).measured(state, &self.setting.scene.run)
    }

    /// The state at the start of the scene.
    pub(super) fn start<I: Integrator<S>, const N: usize>(
        &self,
        simulation: &Simulated<S, A, I, N>,
        start: &A::Start,
    ) -> Result<model_core::hybrid::HybridState<S, A::Mode, N, ALL_POWERS>, Failure>
    where
        A: CoreScene<S, N, ALL_POWERS>,
    {
        use model_core::scene::Harvester;
        let Setting { scene, excitation, .. } = self.setting;
        simulation.start(start, &excitation).map_err(|error| refuse_start(scene, &error))
    }
}

/// The six columns of a trace: position, velocity, charge, voltage, base acceleration, stick.
pub(super) fn row<S: Scalar>(step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
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

/// A state in words; `coordinate` is the name of the first coordinate.
pub(super) fn describe<S: Scalar>(coordinate: &str, outputs: &Outputs<'_, S>) -> String {
    let motion = outputs.coordinate();
    format!(
        "{coordinate} {:e}, velocity {:e} m/s, charge {:e} C, mode {}",
        motion.value.to_f64(),
        motion.rate.to_f64(),
        outputs.charge.value.to_f64(),
        outputs.mode
    )
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

/// The outcome of a scene whose harvester is `inner`, behind `bridge`; `motion_s` is the step that the motion alone asks
/// of an explicit method.
pub(super) fn behind_bridge<S, H, R>(
    setting: Setting<'_, S>,
    (inner, report): (H, &R),
    start: &H::Start,
    bridge: FullBridge<S, AnyStorage<S>>,
    motion_s: f64,
) -> Result<Outcome, Failure>
where
    S: Scalar,
    H: ElectricalPort<S>,
    R: Report<S, Simulated<S, Rectified<S, H, AnyStorage<S>>, RungeKutta4, { rectified::STATES }>>
        + Report<S, Simulated<S, Rectified<S, H, AnyStorage<S>>, TrBdf2, { rectified::STATES }>>,
{
    let Setting { scene, options, .. } = setting;
    let core = Rectified::new(inner, bridge)
        .map_err(|error| Failure::Input(format!("{}: load.{error}", scene.file.display())))?;
    let control = step_control(scene, options, explicit_step(motion_s, scene.load))?;
    Prepared { setting, core: &core, report, control }.to_end(start)
}
