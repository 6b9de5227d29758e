//! Choosing the step: fixed, or by a proportional–integral controller on the local error.

use crate::clock::{seconds_of_ticks, ticks_of_seconds};
use crate::scalar::Scalar;
use crate::snapshot::{Reader, Snapshot, SnapshotError, Writer};

/// What a controller remembers from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlMemory<S> {
    /// Length of the next step in ticks.
    pub ticks: u32,
    /// Binary logarithm of the last accepted error over the allowed one, in units of 2⁻²³.
    previous: i32,
    /// Attempts rejected since the last step that was kept: the next step must not grow.
    rejections: u8,
    /// Error over the allowed one of the last rejected attempt.
    rejected_ratio: f32,
    /// Length in ticks of the first of these attempts.
    rejected_ticks: u32,
    /// Energy delivered per radian, averaged over the last few periods: what the energy error is
    /// relative to.
    recent_energy: S,
}

impl<S: Scalar> ControlMemory<S> {
    /// The memory before a first step of `ticks`.
    const fn starting_with(ticks: u32) -> Self {
        Self {
            ticks,
            previous: 0,
            rejections: 0,
            rejected_ratio: 0.0,
            rejected_ticks: 0,
            recent_energy: S::ZERO,
        }
    }

    /// Takes back the proposal made after a step that was cut short from outside (an end of the
    /// run, a kink of the excitation): its small error says little about a whole step.
    #[inline(always)]
    pub(crate) fn keep_proposal(&mut self, before: &Self) {
        (self.ticks, self.previous, self.rejections) = (before.ticks, before.previous, before.rejections);
    }
}

impl<S: Scalar> Snapshot for ControlMemory<S> {
    const BYTES: usize = 4 * u32::BYTES + u8::BYTES + S::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.ticks.write(out);
        self.previous.write(out);
        self.rejections.write(out);
        // Infinite after an attempt that did not converge.
        self.rejected_ratio.to_bits().write(out);
        self.rejected_ticks.write(out);
        self.recent_energy.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let memory = Self {
            ticks: Snapshot::read(from)?,
            previous: Snapshot::read(from)?,
            rejections: Snapshot::read(from)?,
            rejected_ratio: f32::from_bits(Snapshot::read(from)?),
            rejected_ticks: Snapshot::read(from)?,
            recent_energy: Snapshot::read(from)?,
        };
        let sound = memory.ticks > 0
            && memory.rejected_ratio >= 0.0
            && (LEAST_REMEMBERED..=0).contains(&memory.previous);
        if sound { Ok(memory) } else { Err(SnapshotError::NoState) }
    }
}

/// The error of a step and what it is to be measured against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepErrors<S> {
    /// Length of the step in ticks.
    pub ticks: u32,
    /// Estimated relative local error of the state.
    pub state: S,
    /// Estimated local error of the delivered energy, in joules.
    pub energy: S,
    /// Energy delivered in the step, in joules.
    pub delivered: S,
}

/// The scales by which a system's errors are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorScale<S> {
    /// Angular frequency of the slow motion, in rad/s: its reciprocal is the unit of time.
    pub angular_frequency: S,
    /// Energy in joules below which the delivered energy of a radian is not resolved.
    pub energy_floor: S,
}

impl<S: Scalar> ErrorScale<S> {
    /// The same where the system is shaken at an angular frequency in rad/s: where that is faster than it
    /// moves by itself, the unit of time is the radian of the excitation.
    pub(crate) fn of_the_faster(self, excitation: S) -> Self {
        Self { angular_frequency: self.angular_frequency.max(excitation), ..self }
    }
}

/// Whether a step is to be kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Keep it; the memory holds the length of the next.
    Accept,
    /// Take it again with the length in the memory.
    Reject,
}

/// A rule for the length of steps.
pub trait StepControl<S: Scalar> {
    /// The memory before the first step.
    fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S>;

    /// How accurately the implicit equations of a step of `ticks` are to be solved, as
    /// [`crate::integrate::System::error_norm`] measures it: well below the step's own error.
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S;

    /// Judges a finished attempt and proposes the next length. `rounding` tells how much of the error of
    /// the delivered energy may be the state's rounding ([`crate::integrate::System::rounding_energy`]); it
    /// is asked only where the attempt would be rejected.
    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> Verdict;

    /// Shortens the step after an attempt that did not converge.
    #[inline]
    fn shorten(&self, memory: &mut ControlMemory<S>, ticks: u32) {
        if memory.rejections == 0 {
            memory.rejected_ticks = ticks;
        }
        memory.ticks = ticks / 4;
        memory.rejections = memory.rejections.saturating_add(1);
        memory.rejected_ratio = f32::INFINITY;
    }
}

/// Steps of one length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FixedStep {
    ticks: u32,
}

impl FixedStep {
    /// Steps of the number of ticks nearest to `seconds`, at least 1 and at most 2³² − 1 (3.9 ms).
    #[must_use]
    pub fn of_seconds<S: Scalar>(seconds: S) -> Self {
        Self { ticks: ticks_of_seconds(seconds) }
    }
}

impl<S: Scalar> StepControl<S> for FixedStep {
    fn start(&self, _scale: &ErrorScale<S>) -> ControlMemory<S> {
        ControlMemory::starting_with(self.ticks)
    }

    #[inline(always)]
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S {
        // The local error is about 0.04 (ω h)³; the sum over all steps must stay of second order.
        let radians = seconds_of_ticks::<S>(ticks) * scale.angular_frequency;
        (S::from_f64(1e-4) * radians * radians * radians).max(S::EPSILON * S::from_f64(NEWTON_ROUNDINGS))
    }

    #[inline(always)]
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

/// Steps as long as the tolerance allows.
///
/// The allowed local error of the delivered energy is the tolerance *per radian of the slow motion*
/// (error per unit step), so that the global error is proportional to the tolerance whatever the
/// step; the energy's spikes at contact are far shorter than the motion. A lightly damped motion
/// remembers the errors of its state, so the state is allowed a twentieth of that. To both come a
/// few roundings per step, below which an estimate means nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adaptive<S> {
    tolerance: S,
}

/// Steps are at most this part of a radian of the slow motion: a sixteenth of a period.
const LONGEST_RADIANS: f64 = 0.4;
/// The first step, in radians: short enough to be accepted, and found anew within a few steps.
const FIRST_RADIANS: f64 = 1.0 / 128.0;
/// Roundings of the state's scale that a step may make beside its tolerance.
const ROUNDINGS: f64 = 4.0;
/// The same for the energy of a radian: where the circuit is stiff, a rounding of the charge is a
/// larger part of a step's current.
const ENERGY_ROUNDINGS: f64 = 32.0;
/// Radians for which a lightly damped motion is taken to remember an error made in its state:
/// errors of the state add up over these, errors of the delivered energy do not add to the motion.
pub(crate) const REMEMBERED_RADIANS: f64 = 20.0;
/// Roundings of the state's scale below which Newton's corrections are noise.
const NEWTON_ROUNDINGS: f64 = 16.0;
/// Part of the tolerance that may remain of the implicit equations.
const NEWTON_PART: f64 = 1.0 / REMEMBERED_RADIANS;
/// Radians over which the delivered energy is averaged: two and a half periods.
const MEMORY_RADIANS: f64 = 16.0;
/// The shortest step, in ticks, that is taken for the sake of the tolerance: 4 ns.
const SHORTEST_CONTROLLED_TICKS: u32 = 4096;
/// Relative error of a step that may be waived where shorter steps do not lessen it.
const WAIVED: f64 = 1e-3;
/// Rejections of one step after which it is asked whether they help.
const FUTILE_REJECTIONS: u8 = 3;
/// Exponents of the present and the previous error, in units of 2⁻⁸: 0.35 and 0.2. The error over the
/// allowed one is of second order in the step, hence halves of 0.7 and 0.4 (Gustafsson 1991).
const PRESENT_EXPONENT: i32 = 90;
const PREVIOUS_EXPONENT: i32 = 51;
/// log₂ of 0.97, in units of 2⁻²³: the controller settles at 0.8 of the allowed error.
const SAFETY: i32 = -368_600;
/// log₂ of 0.9, in units of 2⁻²³: the safety factor after a rejection.
const SAFETY_AFTER_REJECTION: i32 = -1_275_068;
/// log₂ of the largest and the smallest change of the step from one to the next: 4 and 1/5.
const LARGEST_CHANGE: i32 = 2 << 23;
const SMALLEST_CHANGE: i32 = -19_477_731;
/// log₂ of the smallest error ratio remembered, 1/16, in units of 2⁻²³.
const LEAST_REMEMBERED: i32 = -(4 << 23);

impl<S: Scalar> Adaptive<S> {
    /// With a relative tolerance per radian, kept between a rounding and 0.1.
    #[must_use]
    pub fn new(tolerance: S) -> Self {
        Self { tolerance: tolerance.max(S::EPSILON).min(S::from_f64(0.1)) }
    }
}

/// Piecewise-linear binary logarithm in units of 2⁻²³: the bits of a float, taken as an integer.
/// Off by at most 0.09, which moves the step by a few per cent and is the same on every machine.
#[inline(always)]
fn log2(ratio: f32) -> i32 {
    ratio.to_bits().cast_signed().wrapping_sub(0x3f80_0000)
}

/// `ticks · 2^change`, with `change` in units of 2⁻²³ and the inverse of [`log2`].
#[inline(always)]
fn scaled(ticks: u32, change: i32) -> u32 {
    let factor = f32::from_bits(change.wrapping_add(0x3f80_0000).cast_unsigned());
    f32::to_u32(f32::from_u32(ticks) * factor).max(1)
}

impl<S: Scalar> StepControl<S> for Adaptive<S> {
    fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S> {
        ControlMemory::starting_with(ticks_of_seconds(S::from_f64(FIRST_RADIANS) / scale.angular_frequency))
    }

    #[inline(always)]
    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S {
        let radians = seconds_of_ticks::<S>(ticks) * scale.angular_frequency;
        (S::from_f64(NEWTON_PART) * self.tolerance * radians).max(S::EPSILON * S::from_f64(NEWTON_ROUNDINGS))
    }

    #[inline(always)]
    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> Verdict {
        let radians = seconds_of_ticks::<S>(errors.ticks) * scale.angular_frequency;
        let target = self.tolerance * radians;
        // A forgetting mean, over some periods, of the energy per radian: the power of a
        // vibro-impact harvester is a spike a period and must not be forgotten from one to the next.
        let part = S::from_f64(1.0 / MEMORY_RADIANS);
        let recent = memory.recent_energy + part * (errors.delivered.abs() - radians * memory.recent_energy);
        // In the beginning there is no sum yet: then the energy of a radian at the present power.
        let delivered = errors.delivered.abs() / radians;
        let per_radian = recent.max(delivered).max(scale.energy_floor);
        let energy_error = errors.energy / per_radian;
        let state_error = errors.state * S::from_f64(REMEMBERED_RADIANS);
        let state = state_error / (target + S::EPSILON * S::from_f64(ROUNDINGS * REMEMBERED_RADIANS));
        let allowed = target + S::EPSILON * S::from_f64(ENERGY_ROUNDINGS);
        let mut ratio = state.max(energy_error / allowed).to_f32();
        if !(ratio <= 1.0) {
            // What rounding the state makes of the energy, no shorter step can lessen: it divides the same
            // rounding by less time. A scene that has none of it compiles nothing of this.
            let rounding = rounding();
            if rounding > S::ZERO {
                let left = state.max((errors.energy - rounding) / per_radian / allowed).to_f32();
                ratio = if left <= 1.0 { left } else { ratio };
            }
        }
        let present = log2(Scalar::max(ratio, 1e-8));
        // An error that a shorter step does not lessen was not made by this step: the derivative at
        // its start is inherited from a longer one, or a boundary layer is being left behind. Such a
        // step is kept if the error by itself, not per radian, is small; and so is a step of nanoseconds,
        // with which an L-stable method passes the layer of a circuit that is faster still.
        let bearable = errors.state.max(energy_error) <= self.tolerance.max(S::from_f64(WAIVED));
        let futile = memory.rejections >= FUTILE_REJECTIONS && ratio > 0.5 * memory.rejected_ratio;
        let shortest = errors.ticks <= SHORTEST_CONTROLLED_TICKS && ratio < f32::INFINITY;
        let inherited = ratio > 1.0 && (bearable && futile || shortest);
        // Written so that not-a-number is rejected too.
        if !(ratio <= 1.0) && !inherited {
            // The error is of third order in the step, of second against the allowed one.
            let change = SAFETY_AFTER_REJECTION - present / 2;
            memory.ticks = scaled(errors.ticks, change.clamp(SMALLEST_CHANGE, LARGEST_CHANGE));
            if memory.rejections == 0 {
                memory.rejected_ticks = errors.ticks;
            }
            memory.rejections = memory.rejections.saturating_add(1);
            memory.rejected_ratio = ratio;
            return Verdict::Reject;
        }
        // 32 bits hold this: a logarithm is at most 2⁷ in units of 2⁻²³.
        let change = SAFETY + (memory.previous >> 8) * PREVIOUS_EXPONENT - (present >> 8) * PRESENT_EXPONENT;
        // No growth after a rejection.
        let largest = if memory.rejections > 0 { 0 } else { LARGEST_CHANGE };
        let longest = ticks_of_seconds(S::from_f64(LONGEST_RADIANS) / scale.angular_frequency);
        memory.ticks = if inherited {
            // The short step has washed the inherited error out; it says nothing about the next. Where
            // none was rejected before it, as after an event, the next is somewhat longer.
            let rejected = if memory.rejections > 0 { memory.rejected_ticks } else { 0 };
            rejected.max(errors.ticks.saturating_mul(4)).min(longest)
        } else {
            scaled(errors.ticks, change.clamp(SMALLEST_CHANGE, largest)).min(longest)
        };
        // One step without error must not make the next look like a sudden rise.
        memory.previous = present.clamp(LEAST_REMEMBERED, 0);
        memory.recent_energy = recent;
        memory.rejections = 0;
        Verdict::Accept
    }
}

/// A step control chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyStepControl<S> {
    /// Steps of one length.
    Fixed(FixedStep),
    /// Steps by error control.
    Adaptive(Adaptive<S>),
}

impl<S: Scalar> StepControl<S> for AnyStepControl<S> {
    fn start(&self, scale: &ErrorScale<S>) -> ControlMemory<S> {
        match self {
            Self::Fixed(control) => control.start(scale),
            Self::Adaptive(control) => control.start(scale),
        }
    }

    fn accuracy(&self, ticks: u32, scale: &ErrorScale<S>) -> S {
        match self {
            Self::Fixed(control) => control.accuracy(ticks, scale),
            Self::Adaptive(control) => control.accuracy(ticks, scale),
        }
    }

    fn judge(
        &self,
        memory: &mut ControlMemory<S>,
        errors: &StepErrors<S>,
        scale: &ErrorScale<S>,
        rounding: impl FnOnce() -> S,
    ) -> Verdict {
        match self {
            Self::Fixed(control) => control.judge(memory, errors, scale, rounding),
            Self::Adaptive(control) => control.judge(memory, errors, scale, rounding),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_and_its_inverse_agree() {
        for ratio in [1e-6_f32, 0.3, 1.0, 7.5, 1e4] {
            let exact = ratio.log2();
            assert!((log2(ratio) as f32 / 8_388_608.0 - exact).abs() < 0.09, "{ratio}");
            let change = log2(ratio).clamp(SMALLEST_CHANGE, LARGEST_CHANGE);
            let expected = ratio.clamp(0.2, 4.0) * 1e6;
            assert!((scaled(1_000_000, change) as f32 / expected - 1.0).abs() < 0.06, "{ratio}");
        }
        assert_eq!(scaled(u32::MAX, LARGEST_CHANGE), u32::MAX);
        assert_eq!(scaled(1, SMALLEST_CHANGE), 1);
    }

    #[test]
    fn settles_where_the_error_meets_the_tolerance() {
        let scale = ErrorScale { angular_frequency: 100.0_f64, energy_floor: 1e-12 };
        let control = Adaptive::new(1e-4);
        let mut memory = control.start(&scale);
        // A model error of 0.04 (ω h)³ per step: the allowed 1e-4 ω h / 20 gives ω h = 0.0112.
        let mut radians = 0.0;
        let mut rejections = 0;
        for _ in 0..60 {
            radians = seconds_of_ticks::<f64>(memory.ticks) * 100.0;
            let errors = StepErrors {
                ticks: memory.ticks,
                state: 0.04 * radians.powi(3),
                energy: 0.0,
                delivered: 0.0,
            };
            rejections += u32::from(control.judge(&mut memory, &errors, &scale, || 0.0) == Verdict::Reject);
        }
        assert!((0.0094..0.0112).contains(&radians), "{radians}");
        assert!(rejections <= 2, "{rejections}");
    }

    #[test]
    fn a_rejected_step_shrinks_and_the_next_does_not_grow() {
        let scale = ErrorScale { angular_frequency: 100.0_f32, energy_floor: 1e-12 };
        let control = Adaptive::new(1e-4);
        let mut memory = control.start(&scale);
        let before = memory.ticks;
        let bad = StepErrors { ticks: before, state: 1.0, energy: 0.0, delivered: 0.0 };
        assert_eq!(control.judge(&mut memory, &bad, &scale, || 0.0), Verdict::Reject);
        assert!(memory.ticks < before);
        let retried = memory.ticks;
        let good = StepErrors { ticks: retried, state: 0.0, energy: 0.0, delivered: 0.0 };
        assert_eq!(control.judge(&mut memory, &good, &scale, || 0.0), Verdict::Accept);
        assert!(memory.ticks <= retried);
    }

    #[test]
    fn an_error_of_the_energy_that_is_rounding_is_no_reason_to_reject() {
        let scale = ErrorScale { angular_frequency: 100.0_f32, energy_floor: 1e-12 };
        let control = Adaptive::new(1e-4);
        let start = control.start(&scale);
        let noisy = StepErrors { ticks: start.ticks, state: 0.0, energy: 2e-9, delivered: 1e-8 };
        let judge = |errors: &StepErrors<f32>, rounding: f32| {
            control.judge(&mut { start }, errors, &scale, || rounding)
        };
        assert_eq!(judge(&noisy, 0.0), Verdict::Reject);
        assert_eq!(judge(&noisy, 1e-9), Verdict::Reject);
        assert_eq!(judge(&noisy, 2e-9), Verdict::Accept);
        // The error of the state is not excused by it.
        assert_eq!(judge(&StepErrors { state: 1.0, ..noisy }, 2e-9), Verdict::Reject);
    }

    #[test]
    fn the_unit_of_time_is_that_of_the_faster_motion_at_any_frequency() {
        use crate::excitation::{Excitation, Silence, Sine};
        let scale = ErrorScale { angular_frequency: 126.0_f64, energy_floor: 1e-12 };
        let at = |hertz: f64| {
            let sine = Sine::<f64>::new(1.0, hertz, 0.0).expect("valid");
            scale.of_the_faster(sine.angular_frequency()).angular_frequency
        };
        assert_eq!(at(20.0), 126.0);
        for hertz in [20.1, 31.999, 32.001, 1e4] {
            assert_eq!(at(hertz), core::f64::consts::TAU * hertz);
        }
        assert_eq!(scale.of_the_faster(Excitation::<f64>::angular_frequency(&Silence)), scale);
    }
}
