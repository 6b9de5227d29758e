//! The workloads of each binary. The host calls these very functions.

use model_core::integrate::{Adaptive, FixedStep, RungeKutta4, TrBdf2};
use model_core::scene::contact_separation::NeverSticks;

use super::parts::{self, CONSTANT, LAW_OF_SPEED, LOAD, PARASITIC};
use crate::workload::Workload;
use crate::workload::hybrid_run::{HybridRun, Plan};

/// 0.2 g at 20 Hz, just below the natural frequency: impacts from 0.43 s on. Three seconds.
pub const IMPACTING: Plan = Plan {
    name: "contact-separation",
    amplitude: 1.962,
    frequency: 20.0,
    velocity: 0.0,
    quarters: 1,
    samples: 12,
};
/// The same for fifteen seconds, of which the last five are settled.
pub const SETTLING: Plan = Plan { name: "settling", quarters: 20, samples: 3, ..IMPACTING };
/// 0.2 g at 22 Hz, above the natural frequency: the mass never reaches the dielectric.
pub const SMOOTH: Plan = Plan { name: "smooth", frequency: 22.0, quarters: 12, samples: 1, ..IMPACTING };

/// Relative tolerance per radian of `bench` and of what is compared with it.
pub const TOLERANCE: f32 = 5e-2;
/// Step of what is compared with `bench` and has no error control, in seconds: as many steps.
pub const FIXED_STEP: f32 = 1.25e-3;

/// The default scene, as `bench` runs it.
#[must_use]
pub fn bench() -> Option<impl Workload> {
    HybridRun::new(IMPACTING, parts::whole(), TrBdf2, Adaptive::new(TOLERANCE).ok()?)
}

/// The default scene without its parasitic capacitance.
#[must_use]
pub fn without_parasitic() -> Option<impl Workload> {
    let parameters = parts::parameters(parts::without_parasitic(LOAD, LAW_OF_SPEED));
    HybridRun::new(IMPACTING, parameters, TrBdf2, Adaptive::new(TOLERANCE).ok()?)
}

/// The default scene without sticking.
#[must_use]
pub fn without_sticking() -> Option<impl Workload> {
    let choices = parts::without_parasitic(LOAD, LAW_OF_SPEED).parasitic(PARASITIC).sticking(NeverSticks);
    let parameters = parts::parameters(choices);
    HybridRun::new(IMPACTING, parameters, TrBdf2, Adaptive::new(TOLERANCE).ok()?)
}

/// The default scene with one coefficient of restitution for all speeds.
#[must_use]
pub fn without_law_of_speed() -> Option<impl Workload> {
    let parameters = parts::parameters(parts::without_parasitic(LOAD, CONSTANT).parasitic(PARASITIC));
    HybridRun::new(IMPACTING, parameters, TrBdf2, Adaptive::new(TOLERANCE).ok()?)
}

/// The default scene without error control.
#[must_use]
pub fn without_error_control() -> Option<impl Workload> {
    let control = FixedStep::of_seconds(FIXED_STEP).ok()?;
    HybridRun::new(IMPACTING, parts::whole(), TrBdf2, control)
}

/// The default scene without all of these.
#[must_use]
pub fn without_any() -> Option<impl Workload> {
    let parameters = parts::parameters(parts::without_parasitic(LOAD, CONSTANT).sticking(NeverSticks));
    HybridRun::new(IMPACTING, parameters, TrBdf2, FixedStep::of_seconds(FIXED_STEP).ok()?)
}

/// Tolerances of [`with_precision`].
pub const TOLERANCES: [f32; 4] = [1e-1, 5e-2, 2e-2, 1e-2];
/// Fixed steps of [`with_precision`] for TR-BDF2, in seconds.
pub const STEPS: [f32; 2] = [1e-3, 5e-4];
/// Fixed steps of [`with_precision`] for the classical Runge–Kutta method, in seconds.
pub const EXPLICIT_STEPS: [f32; 2] = [5e-4, 2.5e-4];

/// Gives `work` the settling scene with [`TOLERANCES`], [`STEPS`] and [`EXPLICIT_STEPS`], in this
/// order; `None` if one is refused.
pub fn with_precision<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let adaptive = TOLERANCES
        .map(|tolerance| HybridRun::new(SETTLING, parts::whole(), TrBdf2, Adaptive::new(tolerance).ok()?));
    let fixed =
        STEPS.map(|step| HybridRun::new(SETTLING, parts::whole(), TrBdf2, FixedStep::of_seconds(step).ok()?));
    let explicit = EXPLICIT_STEPS
        .map(|step| HybridRun::new(SETTLING, parts::whole(), RungeKutta4, FixedStep::of_seconds(step).ok()?));
    let (
        [Some(mut a), Some(mut b), Some(mut c), Some(mut d)],
        [Some(mut e), Some(mut f)],
        [Some(mut g), Some(mut h)],
    ) = (adaptive, fixed, explicit)
    else {
        return work(None);
    };
    work(Some(&mut [&mut a, &mut b, &mut c, &mut d, &mut e, &mut f, &mut g, &mut h]))
}

/// Tolerances of [`with_smooth`].
pub const SMOOTH_TOLERANCES: [f32; 3] = [1e-1, 1e-2, 1e-3];
/// Its fixed step for the classical Runge–Kutta method, in seconds.
pub const SMOOTH_STEP: f32 = 2.5e-4;
/// Tolerances of numeris beside it.
pub const PEER_TOLERANCES: [f32; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

/// Gives `work` the smooth scene with [`SMOOTH_TOLERANCES`] and [`SMOOTH_STEP`], in this order;
/// `None` if one is refused.
pub fn with_smooth<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let adaptive = SMOOTH_TOLERANCES
        .map(|tolerance| HybridRun::new(SMOOTH, parts::whole(), TrBdf2, Adaptive::new(tolerance).ok()?));
    let Ok(step) = FixedStep::of_seconds(SMOOTH_STEP) else { return work(None) };
    let explicit = HybridRun::new(SMOOTH, parts::whole(), RungeKutta4, step);
    let ([Some(mut a), Some(mut b), Some(mut c)], Some(mut d)) = (adaptive, explicit) else {
        return work(None);
    };
    work(Some(&mut [&mut a, &mut b, &mut c, &mut d]))
}
