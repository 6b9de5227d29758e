//! What a meter sees of a run.

use crate::clock::Instant;
use crate::integrate::Point;
use crate::scalar::Scalar;

/// One accepted step.
#[derive(Debug, Clone, Copy)]
pub struct Span<'a, S, Mode, const N: usize, const P: usize> {
    /// The mode, the same over the whole step.
    pub mode: Mode,
    /// Time at the start of the step.
    pub from: Instant,
    /// Length in ticks.
    pub ticks: u32,
    /// Length in seconds.
    pub step: S,
    /// Where the step started.
    pub start: &'a Point<S, N, P>,
    /// Where it ended.
    pub end: &'a Point<S, N, P>,
    /// The integral of each power over the step.
    pub energies: &'a [S; P],
    /// Estimated local error of the first of them, with its sign: what the method's embedded formula would
    /// have added. 0 for a method without an estimate ([`crate::integrate::Method::ESTIMATES_ERROR`]).
    pub energy_error: S,
    /// Estimated local error of the state, as [`crate::integrate::System::error_norm`] measures it; 0 likewise.
    pub state_error: S,
}

/// One event.
#[derive(Debug, Clone, Copy)]
pub struct Event<'a, S, Mode, const N: usize, const P: usize> {
    /// Time of the event.
    pub at: Instant,
    /// The mode that ended.
    pub before: Mode,
    /// The guard that fell through zero.
    pub guard: usize,
    /// The point at which it did.
    pub reached: &'a Point<S, N, P>,
    /// The mode that begins.
    pub after: Mode,
    /// The point at which it begins.
    pub left: &'a Point<S, N, P>,
    /// Energy lost in the event, in joules.
    pub loss: S,
    /// The part of each power that passed in no time, in joules; most events have none.
    pub energies: &'a [S; P],
}

/// Sees every accepted step and every event of a run, in order of time.
pub trait Observer<S: Scalar, Mode, const N: usize, const P: usize> {
    /// A step was accepted.
    fn step(&mut self, span: &Span<'_, S, Mode, N, P>);

    /// An event happened.
    #[inline(always)]
    fn event(&mut self, _event: &Event<'_, S, Mode, N, P>) {}
}

/// Sees nothing.
impl<S: Scalar, Mode, const N: usize, const P: usize> Observer<S, Mode, N, P> for () {
    #[inline(always)]
    fn step(&mut self, _span: &Span<'_, S, Mode, N, P>) {}
}

/// An observer, or none.
impl<S: Scalar, Mode, const N: usize, const P: usize, A> Observer<S, Mode, N, P> for Option<&mut A>
where
    A: Observer<S, Mode, N, P>,
{
    #[inline(always)]
    fn step(&mut self, span: &Span<'_, S, Mode, N, P>) {
        if let Some(observer) = self {
            observer.step(span);
        }
    }

    #[inline(always)]
    fn event(&mut self, event: &Event<'_, S, Mode, N, P>) {
        if let Some(observer) = self {
            observer.event(event);
        }
    }
}

/// Two observers of the same run.
impl<S: Scalar, Mode, const N: usize, const P: usize, A, B> Observer<S, Mode, N, P> for (&mut A, &mut B)
where
    A: Observer<S, Mode, N, P>,
    B: Observer<S, Mode, N, P>,
{
    #[inline(always)]
    fn step(&mut self, span: &Span<'_, S, Mode, N, P>) {
        self.0.step(span);
        self.1.step(span);
    }

    #[inline(always)]
    fn event(&mut self, event: &Event<'_, S, Mode, N, P>) {
        self.0.event(event);
        self.1.event(event);
    }
}
