//! What the checks of a bump-stop run by steps of half the length have shown, and the statement that follows from it.
//!
//! Each check gives the energy `e` that the steps of the run delivered in it, and the difference `d` of that by steps of
//! half the length from the same state. The checks are a sample of the run:
//!
//! ```text
//! error of the mean power / mean power ≈ 2 (|Σ d| + (2 + 4/n) √(Σ d²)) / Σ |e|
//! ```
//!
//! `Σ d/Σ e` is the bias of the method, with its sign: errors that cancel in the run cancel in it. `√(Σ d²)` is the
//! standard error of `Σ d`, as if the `n` checks were independent, and twice that, more of few, covers what the sample does not show. With a
//! method of first order the error is twice the difference, of second order 4/3 of it. The measured order is 2 to 3,
//! the error 1.1 differences in the median, but contact that the longer steps do not resolve has no order: the first 2 assumes
//! the least.

use crate::scalar::Scalar;
use crate::scene::StepDoublingError;
use crate::snapshot::snapshot_fields;

/// The error of a step over its difference from two of half the length, in a method of first order.
const ERROR_PER_CHANGE: f64 = 2.0;
/// Standard errors of the sum of differences that are stated: with `n` checks the first number, and the second one over `n`.
const STANDARD_ERRORS: [f64; 2] = [2.0, 4.0];
/// Inverse of the share of checks in which two motions come apart above which the whole run is irregular. Fitted with the two
/// factors above and the bounds below: docs/energy.md.
const DIVERGING: f64 = 4.0;
/// Energy of the difference of both motions over the stored energy, above which they have come apart.
const APART: f64 = 0.04;
/// Growth of that energy in the second half of a check, above which two motions come apart in the end. An error that adds up
/// evenly grows to four times, and 16 times if all of it comes at once in the second half.
const GROWTH: f64 = 36.0;
/// Number of checks at which all sums are halved: older ones weigh less.
const MOST: u32 = 256;
/// Largest energy in J of a check that an image may have, as in the estimator.
const LARGEST_SUM: f64 = 1e12;

/// Sums over the checks of a run; of more than 256 checks the older ones weigh less.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Checks<S> {
    count: u32,
    /// Number of checks in which the motion in finer steps has come apart from that of the run.
    diverging: u32,
    /// Number of periods of all checks.
    periods: u32,
    /// `Σ |e|` in J.
    energy: S,
    /// `Σ d` in J.
    change: S,
    /// `Σ d²` in J².
    squares: S,
}

/// One check: a window of the run, from one state in the steps of the run and in steps of half the length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Check<S> {
    /// Energy delivered in the window, in J, and what half the step changes of it.
    pub(super) energy: S,
    pub(super) change: S,
    /// Its periods of the first mode.
    pub(super) periods: u32,
    /// Whether both motions come apart.
    pub(super) diverges: bool,
}

/// Whether two motions have come apart, by the energy of their difference and the stored energy, in J.
pub(super) fn is_apart<S: Scalar>(distance: S, stored: S) -> bool {
    distance > S::from_f64(APART) * stored
}

/// Whether two motions come apart in the end, by the energies of their difference in J: the largest one in the first half of a
/// check, and that at its end.
pub(super) fn comes_apart<S: Scalar>(first: S, end: S) -> bool {
    end > S::from_f64(GROWTH) * first
}

impl<S: Scalar> Checks<S> {
    /// Number of checks with a weight, at most 256.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The statement; `None` before the first check.
    pub(super) fn error(&self, angular_frequency: S) -> Option<StepDoublingError<S>> {
        if self.count == 0 {
            return None;
        }
        let count = S::from_u32(self.count);
        let [of_many, of_few] = STANDARD_ERRORS.map(S::from_f64);
        let spread = (of_many + of_few / count) * self.squares.sqrt();
        let relative =
            S::from_f64(ERROR_PER_CHANGE) * (self.change.abs() + spread) / self.energy.max(S::TINY);
        let share = S::from_u32(self.diverging) / count;
        let irregular = (S::from_f64(DIVERGING) * share).min(S::ONE);
        let radians = S::from_f64(core::f64::consts::TAU) * S::from_u32(self.periods.max(1));
        Some(StepDoublingError { relative, irregular, power: self.energy * angular_frequency / radians })
    }

    pub(super) fn add(&mut self, check: &Check<S>) {
        if self.count >= MOST {
            let half = S::from_f64(0.5);
            (self.count, self.diverging, self.periods) =
                (self.count / 2, self.diverging / 2, self.periods / 2);
            (self.energy, self.change) = (half * self.energy, half * self.change);
            self.squares = half * self.squares;
        }
        self.count = self.count.wrapping_add(1);
        self.periods = self.periods.wrapping_add(check.periods);
        self.diverging = self.diverging.wrapping_add(check.diverges.into());
        self.energy += check.energy.abs();
        self.change += check.change;
        self.squares += check.change * check.change;
    }
}

snapshot_fields!(impl [S: Scalar] Checks<S> { count, diverging, periods, energy, change, squares } if |checks| {
    let largest = S::from_f64(LARGEST_SUM);
    let energies = checks.energy >= S::ZERO && checks.energy.max(checks.change.abs()) <= largest;
    energies && checks.squares >= S::ZERO && checks.diverging <= checks.count && checks.count <= MOST
        && checks.periods <= MOST << 8
});
