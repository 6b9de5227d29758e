//! What a meter sees of a run by modal steps.

use super::State;
use super::circuit::Memory;
use crate::clock::Instant;
use crate::scalar::Scalar;

/// One step.
#[derive(Debug, Clone, Copy)]
pub struct ModalSpan<'a, S, const B: usize, const R: usize, C: Memory = ()> {
    /// Length in ticks.
    pub ticks: u32,
    /// Length in seconds.
    pub step: S,
    /// Where the step started.
    pub start: &'a State<S, B, R, C>,
    /// Where it ended.
    pub end: &'a State<S, B, R, C>,
    /// Contact force, constant over the step, in N.
    pub force: S,
    /// Mean terminal voltage in V.
    pub mean_voltage: S,
    /// Mean of the square of the terminal voltage in V².
    pub mean_square_voltage: S,
    /// Energy delivered to the load in J; behind a bridge, what enters the storage.
    pub delivered: S,
    /// What else the load accounts for.
    pub account: C::Account,
}

impl<S: Scalar, const B: usize, const R: usize, C: Memory> ModalSpan<'_, S, B, R, C> {
    /// Base acceleration in m/s² at both ends; linear between them.
    #[must_use]
    pub fn accelerations(&self) -> [S; 2] {
        [self.start.acceleration, self.end.acceleration]
    }
}

/// One impact under [`super::Restitution`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModalImpact<S> {
    /// When.
    pub at: Instant,
    /// Closing speed in m/s, above zero.
    pub speed: S,
    /// Impulse between beam and rod in N·s.
    pub impulse: S,
    /// Energy lost in J.
    pub loss: S,
}

/// Sees every step and every impact of a run, in order of time.
pub trait ModalObserver<S: Scalar, const B: usize, const R: usize, C: Memory = ()> {
    /// A step was taken.
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, C>);

    /// Beam and rod collided.
    #[inline(always)]
    fn impact(&mut self, _impact: &ModalImpact<S>) {}
}

/// Sees nothing.
impl<S: Scalar, const B: usize, const R: usize, C: Memory> ModalObserver<S, B, R, C> for () {
    #[inline(always)]
    fn step(&mut self, _span: &ModalSpan<'_, S, B, R, C>) {}
}

/// An observer, or none.
impl<S, O, const B: usize, const R: usize, C> ModalObserver<S, B, R, C> for Option<&mut O>
where
    S: Scalar,
    C: Memory,
    O: ModalObserver<S, B, R, C>,
{
    #[inline(always)]
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, C>) {
        if let Some(observer) = self {
            observer.step(span);
        }
    }

    #[inline(always)]
    fn impact(&mut self, impact: &ModalImpact<S>) {
        if let Some(observer) = self {
            observer.impact(impact);
        }
    }
}

/// Two observers of the same run.
impl<S, O, Q, const B: usize, const R: usize, C> ModalObserver<S, B, R, C> for (&mut O, &mut Q)
where
    S: Scalar,
    C: Memory,
    O: ModalObserver<S, B, R, C>,
    Q: ModalObserver<S, B, R, C>,
{
    #[inline(always)]
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, C>) {
        self.0.step(span);
        self.1.step(span);
    }

    #[inline(always)]
    fn impact(&mut self, impact: &ModalImpact<S>) {
        self.0.impact(impact);
        self.1.impact(impact);
    }
}
