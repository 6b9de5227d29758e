//! The memory of a step control between two steps.

use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// log₂ of the smallest previous error ratio that the controller uses, 1/16, in units of 2⁻²³.
pub(super) const LEAST_REMEMBERED: i32 = -(4 << 23);

/// The state of a step control between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct ControlMemory<S> {
    /// Length of the next step in ticks.
    pub(crate) ticks: u32,
    /// Binary logarithm of the last accepted error over the allowed one, in units of 2⁻²³, at most 0.
    pub(super) previous: i32,
    /// Number of attempts rejected since the last accepted step.
    pub(super) rejections: u8,
    /// Bits of [`ControlMemory::rejected_ratio`], which is infinite after an attempt that did not converge.
    rejected_ratio: u32,
    /// Length in ticks of the first attempt rejected since the last accepted step.
    pub(super) rejected_ticks: u32,
    /// Energy delivered per radian in joules, averaged over the last few periods: the scale of the energy error.
    pub(super) recent_energy: S,
}

impl<S: Scalar> ControlMemory<S> {
    /// The state before a first step of `ticks`.
    pub(super) const fn starting_with(ticks: u32) -> Self {
        Self {
            ticks,
            previous: 0,
            rejections: 0,
            rejected_ratio: 0,
            rejected_ticks: 0,
            recent_energy: S::ZERO,
        }
    }

    /// Restores the proposal from before a step that the end of the run or a kink of the excitation
    /// shortened: the small error of such a step does not predict that of a whole step.
    #[inline]
    pub(crate) fn keep_proposal(&mut self, before: &Self) {
        (self.ticks, self.previous, self.rejections) = (before.ticks, before.previous, before.rejections);
    }

    /// The longest step in ticks if an event is soon: an eighth longer if the last error was below half of the allowed one.
    #[inline]
    pub(crate) fn stretched(&self, ticks: u32) -> u32 {
        // A stretched step that is rejected is not stretched again.
        let has_margin = self.rejections == 0 && self.previous < -(1 << 23);
        if has_margin { ticks.saturating_add(ticks >> 3) } else { ticks }
    }

    /// Records an attempt of `ticks` with an error of `ratio` times the allowed one, and the length `next` of the next attempt.
    #[inline]
    pub(super) fn reject(&mut self, ticks: u32, ratio: f32, next: u32) {
        if self.rejections == 0 {
            self.rejected_ticks = ticks;
        }
        self.ticks = next;
        self.rejections = self.rejections.saturating_add(1);
        self.rejected_ratio = ratio.to_bits();
    }

    /// Error over the allowed one of the last rejected attempt.
    #[inline]
    pub(super) fn rejected_ratio(&self) -> f32 {
        f32::from_bits(self.rejected_ratio)
    }
}

snapshot_fields!(impl [S: Scalar] ControlMemory<S> {
    ticks, previous, rejections, rejected_ratio, rejected_ticks, recent_energy,
} if |memory| {
    memory.ticks > 0 && memory.rejected_ratio() >= 0.0 && (LEAST_REMEMBERED..=0).contains(&memory.previous)
});
