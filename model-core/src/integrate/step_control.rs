//! Controls the length of the steps: fixed, or by a proportional–integral controller on the local error.
//!
//! After a step of length `h_n` whose local error is `r_n` times the allowed one, the controller proposes
//!
//! ```text
//! h_{n+1} = 0.97 h_n r_n^(−0.7/k) r_{n−1}^(0.4/k)
//! ```
//!
//! with `k` the order of `r` in the step (K. Gustafsson, ACM Trans. Math. Softw. 17, 1991). An attempt with `r > 1` is
//! rejected and repeated with `0.9 h r^(−1/k)`.

use super::control_memory::{ControlMemory, LEAST_REMEMBERED};
use crate::bounds::{Bounds, ParameterError};
use crate::clock::{LONGEST_STEP_S, seconds_of_ticks, ticks_of_seconds};
use crate::forward;
use crate::scalar::Scalar;

/// The errors of an attempted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepErrors<S> {
    /// Length of the step in ticks.
    pub(crate) ticks: u32,
    /// [`Method::ESTIMATE_ORDER`](super::Method::ESTIMATE_ORDER).
    pub(crate) order: i32,
    /// [`Method::LONGEST_RADIANS`](super::Method::LONGEST_RADIANS) in ticks.
    pub(crate) longest_ticks: u32,
    /// [`System::time_scale_ratio`](super::System::time_scale_ratio).
    pub(crate) time_scale_ratio: S,
    /// Estimated relative local error of the state.
    pub(crate) state: S,
    /// Estimated local error of the delivered energy in joules.
    pub(crate) energy: S,
    /// Energy delivered in the step in joules.
    pub(crate) delivered: S,
    /// Whether the errors come from increments that are rounded relative to themselves, not to the state.
    pub(crate) carried: bool,
}

/// The scales of a system's errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorScale<S> {
    /// Angular frequency of the slow motion in rad/s.
    pub angular_frequency: S,
    /// Rate in 1/s at which it decays: the damping ratio times the angular frequency; 0 if it is not known.
    pub decay_rate: S,
    /// Delivered energy per radian in joules below which no relative error is resolved.
    pub energy_floor: S,
}

impl<S: Scalar> ErrorScale<S> {
    /// The scales with the larger of the system's angular frequency and that of the excitation in rad/s.
    pub(crate) fn of_the_faster(self, excitation: S) -> Self {
        Self { angular_frequency: self.angular_frequency.max(excitation), ..self }
    }

    /// A number of radians in ticks.
    pub(crate) fn ticks_of_radians(&self, radians: f64) -> u32 {
        ticks_of_seconds(S::from_f64(radians) / self.angular_frequency)
    }
}

/// The judgement of an attempted step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The step is kept; [`ControlMemory::ticks`] is the length of the next step.
    Accept,
    /// The step is repeated with [`ControlMemory::ticks`].
    Reject,
}

/// A rule for the length of steps: [`FixedStep`], [`Adaptive`], or one of them as [`AnyStepControl`].
pub trait StepControl<S: Scalar> {
    /// Whether the control needs a method that estimates its error.
    const NEEDS_ESTIMATE: bool = false;

    /// The state before the first step.
    fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S>;

    /// The accuracy to which the implicit equations of a step of `ticks` are solved, in the norm
    /// [`System::error_norm`](super::System::error_norm): well below the error of the step.
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S;

    /// The longest step of a method with an exact motion over that at a tight tolerance, at least 1.
    #[inline]
    fn lengthening(&self) -> S {
        S::ONE
    }

    /// Judges an attempted step and proposes the length of the next one.
    ///
    /// `rounding` returns [`System::rounding_energy`](super::System::rounding_energy) in joules. It is called
    /// only where the attempt would be rejected.
    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> Verdict;

    /// Shortens the step to a quarter after an attempt that did not converge.
    #[inline]
    fn shorten(&self, memory: &mut ControlMemory<S>, ticks: u32) {
        memory.reject(ticks, f32::INFINITY, ticks / 4);
    }
}

/// Checks that a step length in s is above 0 and at most [`LONGEST_STEP_S`].
pub(crate) fn check_step<S: Scalar>(field: &'static str, seconds: S) -> Result<(), ParameterError<S>> {
    Bounds { lowest: S::TINY, highest: S::from_f64(LONGEST_STEP_S) }.check(field, seconds)
}

/// Steps of one length; [`ExponentialRadau`](super::ExponentialRadau) takes longer ones where no state changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FixedStep {
    ticks: u32,
}

impl FixedStep {
    /// Steps of the number of ticks nearest to `seconds`, above 0 and at most [`LONGEST_STEP_S`] (15.6 ms).
    ///
    /// # Errors
    /// [`ParameterError`] with the field `step` if `seconds` is outside these bounds.
    pub fn of_seconds<S: Scalar>(seconds: S) -> Result<Self, ParameterError<S>> {
        check_step("step", seconds)?;
        Ok(Self { ticks: ticks_of_seconds(seconds) })
    }
}

impl<S: Scalar> StepControl<S> for FixedStep {
    fn start(&self, _scale: &ErrorScale<S>) -> ControlMemory<S> {
        ControlMemory::starting_with(self.ticks)
    }

    #[inline]
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S {
        // The local error is about 0.04 (ω h)³. The sum of the errors over all steps must stay of second order.
        let radians = seconds_of_ticks::<S>(ticks) * scale.angular_frequency;
        (S::from_f64(1e-4) * radians * radians * radians).max(S::EPSILON * S::from_f64(NEWTON_ROUNDINGS))
    }

    #[inline]
    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        _errors: &StepErrors<S>,
        _scale: &ErrorScale<S>,
        _rounding: impl FnOnce() -> S,
    ) -> Verdict {
        memory.ticks = self.ticks;
        Verdict::Accept
    }
}

/// Error control of the step length by a tolerance.
///
/// The allowed relative error of the delivered energy is the tolerance times the radians `ω h` of the step:
/// an error per unit step, so that the global error is proportional to the tolerance. The allowed error of
/// the state is a twentieth of that, because a lightly damped motion keeps the errors of its state for many
/// radians. A few roundings per step are added to both, since an estimate below rounding is meaningless.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adaptive<S> {
    /// Relative error per radian.
    tolerance: S,
}

/// First step in radians: short enough to be accepted.
const FIRST_RADIANS: f64 = 1.0 / 128.0;
/// Roundings of the state that a step is allowed beside its tolerance; a radian, where the rates are carried.
const ROUNDINGS: f64 = 4.0;
/// Roundings of the energy of a radian that a step is allowed beside its tolerance, or a radian. In a stiff circuit a
/// rounding of the charge is a larger part of the current of a step.
const ENERGY_ROUNDINGS: f64 = 32.0;
/// Radians of a step below which its roundings do not decrease: those of the excitation remain.
const LEAST_ROUNDED_RADIANS: f64 = 1.0 / 32.0;
/// Radians over which the errors of the state of a lightly damped motion are taken to add up.
pub(crate) const REMEMBERED_RADIANS: f64 = 20.0;
/// Roundings of the state below which Newton's corrections are noise.
const NEWTON_ROUNDINGS: f64 = 16.0;
/// Part of the tolerance to which implicit equations are solved.
const NEWTON_PART: f64 = 1.0 / REMEMBERED_RADIANS;
/// Radians over which the delivered energy is averaged: two and a half periods.
const MEMORY_RADIANS: f64 = 16.0;
/// Shortest step in ticks that the tolerance can demand: 4 ns.
const SHORTEST_CONTROLLED_TICKS: u32 = 1024;
/// Largest relative error of a step that is accepted if shorter steps do not reduce the error.
const WAIVED: f64 = 1e-3;
/// Number of rejections of one step after which a step with an unreduced error is accepted.
const FUTILE_REJECTIONS: u8 = 3;
/// Exponents of the present and the previous error, Gustafsson's 0.7 and 0.4, in units of 2⁻⁸. They are divided by the
/// order in the step of the error over the allowed one.
const PRESENT_EXPONENT: i32 = 180;
const PREVIOUS_EXPONENT: i32 = 102;
/// log₂ of the safety factor 0.97, in units of 2⁻²³: the controller settles at 0.8 of the allowed error.
const SAFETY: i32 = -368_600;
/// log₂ of the safety factor after a rejection, 0.9, in units of 2⁻²³.
const SAFETY_AFTER_REJECTION: i32 = -1_275_068;
/// log₂ of the largest ratio of two successive steps, 4, in units of 2⁻²³.
const LARGEST_CHANGE: i32 = 2 << 23;
/// log₂ of the smallest ratio of two successive steps, 1/5, in units of 2⁻²³.
const SMALLEST_CHANGE: i32 = -19_477_731;

/// The errors of a step relative to what is allowed.
#[derive(Clone, Copy)]
struct RelativeErrors<S> {
    /// The larger of the errors of state and energy over the allowed ones.
    ratio: f32,
    /// The larger of the relative errors of state and energy.
    largest: S,
    /// [`ControlMemory::recent_energy`] after the step.
    recent_energy: S,
}

impl<S> RelativeErrors<S> {
    /// The logarithm of the ratio in units of 2⁻²³.
    #[inline]
    fn logarithm(&self) -> i32 {
        log2(Scalar::max(self.ratio, 1e-8))
    }
}

impl<S: Scalar> Adaptive<S> {
    /// With a relative tolerance per radian, from one rounding ([`Scalar::EPSILON`]) to 0.1.
    ///
    /// # Errors
    /// [`ParameterError`] with the field `tolerance` if it is outside these bounds.
    pub fn new(tolerance: S) -> Result<Self, ParameterError<S>> {
        Bounds { lowest: S::EPSILON, highest: S::from_f64(0.1) }.check("tolerance", tolerance)?;
        Ok(Self { tolerance })
    }

    #[inline(always)]
    fn relative(
        &self,
        recent_energy: S,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> RelativeErrors<S> {
        let radians = seconds_of_ticks::<S>(errors.ticks) * scale.angular_frequency;
        let target = self.tolerance * radians;
        // A vibro-impact harvester delivers one spike a period, so the mean spans several periods.
        let part = S::from_f64(1.0 / MEMORY_RADIANS);
        let recent = recent_energy + part * (errors.delivered.abs() - radians * recent_energy);
        // At the start of a run the mean is still zero: use the power of this step.
        let delivered = errors.delivered.abs() / radians;
        let per_radian = recent.max(delivered).max(scale.energy_floor);
        let energy_error = errors.energy / per_radian;
        let state_error = errors.state * S::from_f64(REMEMBERED_RADIANS);
        let share = if errors.carried { radians.max(S::from_f64(LEAST_ROUNDED_RADIANS)) } else { S::ONE };
        let rounding_of = S::EPSILON * share;
        let state = state_error / (target + rounding_of * S::from_f64(ROUNDINGS * REMEMBERED_RADIANS));
        let allowed = target + rounding_of * S::from_f64(ENERGY_ROUNDINGS);
        let mut ratio = state.max(energy_error / allowed).to_f32();
        if !(ratio <= 1.0) {
            // A shorter step does not reduce the energy error that the rounding of the state causes.
            let rounding = rounding();
            // The compiler removes this branch if the system returns the constant 0.
            if rounding > S::ZERO {
                let left = state.max((errors.energy - rounding) / per_radian / allowed).to_f32();
                ratio = if left <= 1.0 { left } else { ratio };
            }
        }
        RelativeErrors { ratio, largest: errors.state.max(energy_error), recent_energy: recent }
    }

    /// Whether a step with too large an error is accepted because a shorter step has no smaller error.
    ///
    /// The derivative at the start of the step then comes from a longer step, or the step leaves a boundary layer.
    /// Such a step is accepted if its relative error, not per radian, is small. A step of a few nanoseconds is always
    /// accepted: with such steps an L-stable method passes the boundary layer of a faster circuit.
    #[inline(always)]
    fn is_inherited(&self, memory: &ControlMemory<S>, ticks: u32, relative: &RelativeErrors<S>) -> bool {
        let ratio = relative.ratio;
        let small = relative.largest <= self.tolerance.max(S::from_f64(WAIVED));
        let futile = memory.rejections >= FUTILE_REJECTIONS && ratio > 0.5 * memory.rejected_ratio();
        let shortest = ticks <= SHORTEST_CONTROLLED_TICKS && ratio < f32::INFINITY;
        ratio > 1.0 && (small && futile || shortest)
    }

    /// The length of the next step after an attempt beyond the tolerance that is accepted, or the memory after its
    /// rejection.
    ///
    /// Outlined, with values as arguments: the memory of the accepted step then need not be at an address.
    #[cold]
    #[inline(never)]
    fn beyond_tolerance(
        &self,
        mut memory: ControlMemory<S>,
        ticks: u32,
        order: i32,
        relative: &RelativeErrors<S>,
    ) -> Result<u32, ControlMemory<S>> {
        if self.is_inherited(&memory, ticks, relative) {
            // An inherited error does not predict the next error: return to the length first rejected.
            // Without a rejection, as after an event, take a longer step.
            let rejected = if memory.rejections > 0 { memory.rejected_ticks } else { 0 };
            return Ok(rejected.max(ticks.saturating_mul(4)));
        }
        let change =
            SAFETY_AFTER_REJECTION.wrapping_sub(relative.logarithm().checked_div(order).unwrap_or(0));
        memory.reject(ticks, relative.ratio, scaled(ticks, change.clamp(SMALLEST_CHANGE, LARGEST_CHANGE)));
        Err(memory)
    }
}

/// Piecewise-linear binary logarithm in units of 2⁻²³: the bits of a float as an integer. Its error is at
/// most 0.09, a few per cent of the step.
#[inline]
fn log2(ratio: f32) -> i32 {
    ratio.to_bits().cast_signed().wrapping_sub(0x3f80_0000)
}

/// log₂ of the change of the step with a ratio of two successive time scales, in units of 2⁻²³.
///
/// A shorter time scale shortens the step by its power 3/4, a longer one lengthens it by its power 1/2. With the
/// contact-separation scene these powers take the fewest steps; without them every step before an impact is rejected.
#[inline]
fn change_with<S: Scalar>(time_scale_ratio: S) -> i32 {
    let ratio = log2(time_scale_ratio.to_f32());
    if ratio > 0 { ratio >> 1 } else { (ratio >> 2) * 3 }
}

/// `ticks · 2^change` by the inverse of [`log2`], with `change` in units of 2⁻²³.
#[inline]
fn scaled(ticks: u32, change: i32) -> u32 {
    let factor = f32::from_bits(change.wrapping_add(0x3f80_0000).cast_unsigned());
    f32::to_u32(f32::from_u32(ticks) * factor).max(1)
}

impl<S: Scalar> StepControl<S> for Adaptive<S> {
    const NEEDS_ESTIMATE: bool = true;

    fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S> {
        ControlMemory::starting_with(ticks_of_seconds(S::from_f64(FIRST_RADIANS) / scale.angular_frequency))
    }

    #[inline]
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S {
        let radians = seconds_of_ticks::<S>(ticks) * scale.angular_frequency;
        (S::from_f64(NEWTON_PART) * self.tolerance * radians).max(S::EPSILON * S::from_f64(NEWTON_ROUNDINGS))
    }

    /// Up to 1.5 at tolerances from 1/15 to 0.1, in double precision: the series of the motion are then off by 10⁻¹², in single
    /// precision by 10⁻⁶.
    #[inline]
    fn lengthening(&self) -> S {
        if S::IS_DOUBLE { (S::from_f64(15.0) * self.tolerance).max(S::ONE) } else { S::ONE }
    }

    #[inline(always)]
    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> Verdict {
        let relative = self.relative(memory.recent_energy, errors, scale, rounding);
        let present = relative.logarithm();
        // `!(ratio <= 1.0)` also rejects not-a-number.
        let next = if !(relative.ratio <= 1.0) {
            match self.beyond_tolerance(*memory, errors.ticks, errors.order, &{ relative }) {
                Ok(next) => next,
                Err(rejected) => {
                    *memory = rejected;
                    return Verdict::Reject;
                }
            }
        } else {
            // No overflow: a logarithm is at most 2⁷ in units of 2⁻²³.
            let change = SAFETY
                .wrapping_add(change_with(errors.time_scale_ratio))
                .wrapping_add((memory.previous >> 8).wrapping_mul(PREVIOUS_EXPONENT / errors.order))
                .wrapping_sub((present >> 8).wrapping_mul(PRESENT_EXPONENT / errors.order));
            // No growth after a rejection.
            let largest = if memory.rejections > 0 { 0 } else { LARGEST_CHANGE };
            scaled(errors.ticks, change.clamp(SMALLEST_CHANGE, largest))
        };
        memory.ticks = next.min(errors.longest_ticks);
        // Bounded below: after a step without error, the next error would otherwise look like a sudden rise.
        memory.previous = present.clamp(LEAST_REMEMBERED, 0);
        memory.recent_energy = relative.recent_energy;
        memory.rejections = 0;
        Verdict::Accept
    }
}

/// A step control chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyStepControl<S> {
    /// Steps of one length; [`ExponentialRadau`](super::ExponentialRadau) takes longer ones where no state changes.
    Fixed(FixedStep),
    /// Steps by error control.
    Adaptive(Adaptive<S>),
}

impl<S: Scalar> StepControl<S> for AnyStepControl<S> {
    forward! {
        match { Self::Fixed(control) => control, Self::Adaptive(control) => control }
        fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S>;
        fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S;
        fn lengthening(&self) -> S;
        fn judge(
            &self,
            memory: &mut ControlMemory<S>,
            errors: &StepErrors<S>,
            scale: &ErrorScale<S>,
            rounding: impl FnOnce() -> S,
        ) -> Verdict;
    }
}

#[cfg(test)]
mod tests;
