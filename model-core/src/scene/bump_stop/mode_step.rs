//! The exact step of a mode, and of all modes of a beam or rod.

use crate::integrate::modal::ModalStep;
use crate::scalar::Scalar;

/// The linear map of a step for one mode, `[displacement, velocity]`. The map gives increments, which a short step in
/// `f32` does not round away. The coefficients are those of [`ModalStep`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeStep<S> {
    by_displacement: [S; 2],
    by_velocity: [S; 2],
    /// Displacement per modal force that is constant over the step; the velocity is that by velocity of the displacement.
    by_force: S,
    /// Per modal force that rises from −1 to 1.
    by_tilt: [S; 2],
    /// First moment of the rates of gap and strain charge by displacement and velocity at the start.
    gap_moment: [S; 2],
    charge_moment: [S; 2],
}

/// Sums over the modes at the end of a step without forces.
#[derive(Clone, Copy)]
pub(super) struct Sums<S> {
    /// Gap in m.
    pub(super) gap: S,
    /// Strain charge in C.
    pub(super) charge: S,
    /// First moment `∫ (2t/h − 1) ġ dt` of the gap's rate in m, and the same of the strain charge in C.
    pub(super) gap_moment: S,
    pub(super) charge_moment: S,
}

impl<S: Scalar> ModeStep<S> {
    /// For a mode with gap and strain charge `[contact, voltage]` per displacement.
    pub(super) fn new(modal: &ModalStep<S>, angular_frequency: S, [contact, voltage]: [S; 2]) -> Self {
        let [by_tilt @ .., _] = modal.tilt;
        let moment = modal.moment(angular_frequency);
        Self {
            by_displacement: [modal.displacement_by_displacement, modal.velocity_by_displacement],
            by_velocity: [modal.displacement_by_velocity, modal.velocity_by_velocity],
            by_force: modal.response,
            by_tilt,
            gap_moment: moment.map(|of_rate| contact * of_rate),
            charge_moment: moment.map(|of_rate| voltage * of_rate),
        }
    }
}

/// Advances all modes of a beam or rod from `start` to `end` without forces. `weights` are gap and strain charge per
/// displacement of a mode.
#[inline(always)]
pub(super) fn advance<S: Scalar, C>(
    (modes, coefficients): (&[ModeStep<S>], &[C]),
    start: &[[S; 2]],
    end: &mut [[S; 2]],
    weights: impl Fn(&C) -> [S; 2],
) -> Sums<S> {
    let mut sums = Sums { gap: S::ZERO, charge: S::ZERO, gap_moment: S::ZERO, charge_moment: S::ZERO };
    for (((mode, coefficients), start), end) in modes.iter().zip(coefficients).zip(start).zip(end) {
        let [contact, voltage] = weights(coefficients);
        let [displacement, velocity] = *start;
        let increment =
            |row: usize| mode.by_displacement[row] * displacement + mode.by_velocity[row] * velocity;
        sums.gap_moment += mode.gap_moment[0] * displacement;
        sums.gap_moment += mode.gap_moment[1] * velocity;
        sums.charge_moment += mode.charge_moment[0] * displacement;
        sums.charge_moment += mode.charge_moment[1] * velocity;
        *end = [displacement + increment(0), velocity + increment(1)];
        sums.gap += contact * end[0];
        sums.charge += voltage * end[0];
    }
    sums
}

/// Adds the effect of negative modal forces, `[mean, half the rise over the step]`.
#[inline]
pub(super) fn push<S: Scalar, C>(
    (modes, coefficients): (&[ModeStep<S>], &[C]),
    end: &mut [[S; 2]],
    forces: impl Fn(&C) -> [S; 2],
) {
    for ((mode, coefficients), end) in modes.iter().zip(coefficients).zip(end) {
        let [mean, tilt] = forces(coefficients);
        end[0] = end[0] - mode.by_force * mean - mode.by_tilt[0] * tilt;
        end[1] = end[1] - mode.by_velocity[0] * mean - mode.by_tilt[1] * tilt;
    }
}
