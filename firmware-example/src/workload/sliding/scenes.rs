//! The workloads of each binary. The host calls these very functions.
//!
//! The bench runs the classical Runge–Kutta method with a fixed step: nothing here is stiff at 100 MΩ,
//! the corners of the motion are events, and at equal error it is several times cheaper than TR-BDF2.

use model_core::integrate::{Adaptive, FixedStep, RungeKutta4, TrBdf2};
use model_core::part::load::{OpenCircuit, ShortCircuit};
use model_core::scene::sliding::{Choices, Frictionless, NeverSticks, Parameters, Parts};

use super::building::Building;
use super::parts::{self, FRICTION, LOAD, choices};
use crate::workload::Workload;
use crate::workload::hybrid_run::{HybridRun, Plan};

/// The workload of most binaries.
type ExplicitRun<P> = HybridRun<Parameters<f32, P>, RungeKutta4, FixedStep>;

/// 0.36 g at 18.373 Hz, the natural frequency: the slider lets go in the first period and slides from
/// then on. Three seconds.
pub const SLIDING: Plan =
    Plan { name: "sliding", amplitude: 3.5316, frequency: 18.373, velocity: 0.0, quarters: 1, samples: 12 };
/// 0.30 g at 6 Hz: the slider sticks twice a period, for half of the time.
pub const STICK_SLIP: Plan = Plan { name: "stick-slip", amplitude: 2.943, frequency: 6.0, ..SLIDING };
/// 0.1 g: without friction 0.36 g would part the discs.
pub const GENTLE: Plan = Plan { name: "gentle", amplitude: 0.981, ..SLIDING };
/// 0.8 g at 16 Hz: the force of the field presses a slider at the centre on so that 0.36 g cannot move it.
pub const STRONG: Plan = Plan { name: "strong", amplitude: 7.848, frequency: 16.0, ..SLIDING };
/// In motion from the start, for a slider that cannot be held.
pub const MOVING: Plan = Plan { name: "moving", velocity: -0.8, ..SLIDING };
/// Fifteen seconds at resonance, of which the last five are settled.
pub const SETTLING: Plan = Plan { name: "settling", quarters: 20, samples: 3, ..SLIDING };
/// The same a little below and a little above: on the flanks an error of the frequency shows.
pub const BELOW: Plan = Plan { name: "below", frequency: 18.303, ..SETTLING };
/// See [`BELOW`].
pub const ABOVE: Plan = Plan { name: "above", frequency: 18.443, ..SETTLING };

/// Step of the bench in seconds: some 27 in a period.
pub const STEP: f32 = 2e-3;
/// Relative tolerance per radian of TR-BDF2 beside it.
pub const TOLERANCE: f32 = 5e-3;
/// Fixed step of TR-BDF2 beside it, in seconds.
pub const IMPLICIT_STEP: f32 = 5e-4;

/// The default scene, as `sliding` runs it.
#[must_use]
pub fn bench() -> Option<impl Workload> {
    explicit(parts::whole())
}

/// The default scene without friction, shaken by [`GENTLE`].
#[must_use]
pub fn without_friction() -> Option<impl Workload> {
    explicit_of(GENTLE, parts::parameters(choices(LOAD, Frictionless)))
}

/// The default scene without sticking, from the start of [`MOVING`].
#[must_use]
pub fn without_sticking() -> Option<impl Workload> {
    explicit_of(MOVING, parts::parameters(choices(LOAD, FRICTION).sticking(NeverSticks)))
}

/// The default scene with the load open.
#[must_use]
pub fn open() -> Option<impl Workload> {
    explicit(parts::parameters(choices(OpenCircuit, FRICTION)))
}

/// The default scene with the load shorted.
#[must_use]
pub fn shorted() -> Option<impl Workload> {
    explicit(parts::parameters(choices(ShortCircuit, FRICTION)))
}

/// The default scene with the force of the field, shaken by [`STRONG`].
#[must_use]
pub fn gap_field() -> Option<impl Workload> {
    explicit_of(STRONG, parts::parameters(Choices::new(LOAD, FRICTION)))
}

/// The default scene by TR-BDF2 with a fixed step.
#[must_use]
pub fn implicit() -> Option<impl Workload> {
    HybridRun::new(SLIDING, parts::whole(), TrBdf2, FixedStep::of_seconds(IMPLICIT_STEP).ok()?)
}

/// The default scene by TR-BDF2 with error control.
#[must_use]
pub fn with_error_control() -> Option<impl Workload> {
    HybridRun::new(SLIDING, parts::whole(), TrBdf2, Adaptive::new(TOLERANCE).ok()?)
}

fn explicit<P: Parts<f32>>(parameters: Parameters<f32, P>) -> Option<ExplicitRun<P>> {
    explicit_of(SLIDING, parameters)
}

fn explicit_of<P: Parts<f32>>(plan: Plan, parameters: Parameters<f32, P>) -> Option<ExplicitRun<P>> {
    HybridRun::new(plan, parameters, RungeKutta4, FixedStep::of_seconds(STEP).ok()?)
}

/// Gives `work` what the bench leaves out, to compare its bits: [`STICK_SLIP`] as the bench runs it,
/// [`SLIDING`] and [`STICK_SLIP`] by TR-BDF2 with [`TOLERANCE`], and the making of the coefficients;
/// `None` if one is refused.
pub fn with_others<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let Ok(step) = FixedStep::of_seconds(STEP) else { return work(None) };
    let explicit = HybridRun::new(STICK_SLIP, parts::whole(), RungeKutta4, step);
    let adaptive = [SLIDING, STICK_SLIP]
        .map(|plan| HybridRun::new(plan, parts::whole(), TrBdf2, Adaptive::new(TOLERANCE).ok()?));
    let (Some(mut a), [Some(mut b), Some(mut c)]) = (explicit, adaptive) else {
        return work(None);
    };
    work(Some(&mut [&mut a, &mut b, &mut c, &mut Building::default()]))
}

/// Tolerances of [`with_precision`].
pub const TOLERANCES: [f32; 4] = [5e-2, 2e-2, 1e-2, 5e-3];
/// Fixed steps of [`with_precision`] for TR-BDF2, in seconds.
pub const STEPS: [f32; 2] = [1e-3, 5e-4];
/// Fixed steps of [`with_precision`] for the classical Runge–Kutta method, in seconds.
pub const EXPLICIT_STEPS: [f32; 4] = [3.8e-3, 2.5e-3, 2e-3, 1e-3];

/// Gives `work` the scene at resonance with [`TOLERANCES`], [`STEPS`] and [`EXPLICIT_STEPS`], in this
/// order; `None` if one is refused.
pub fn with_precision<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    with_precision_of(SETTLING, work)
}

/// The same for any plan.
pub fn with_precision_of<R>(plan: Plan, work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let adaptive = TOLERANCES
        .map(|tolerance| HybridRun::new(plan, parts::whole(), TrBdf2, Adaptive::new(tolerance).ok()?));
    let implicit =
        STEPS.map(|step| HybridRun::new(plan, parts::whole(), TrBdf2, FixedStep::of_seconds(step).ok()?));
    let explicit = EXPLICIT_STEPS
        .map(|step| HybridRun::new(plan, parts::whole(), RungeKutta4, FixedStep::of_seconds(step).ok()?));
    let (
        [Some(mut a), Some(mut b), Some(mut c), Some(mut d)],
        [Some(mut e), Some(mut f)],
        [Some(mut g), Some(mut h), Some(mut i), Some(mut j)],
    ) = (adaptive, implicit, explicit)
    else {
        return work(None);
    };
    work(Some(&mut [&mut a, &mut b, &mut c, &mut d, &mut e, &mut f, &mut g, &mut h, &mut i, &mut j]))
}
