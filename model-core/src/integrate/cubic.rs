//! Interpolates a step between its ends: the cubic Hermite interpolant of the values and slopes at both ends.
//!
//! Both slopes are known if the last stage of the method is its result. The interpolants of successive steps
//! join with a continuous first derivative. The extrema, which decide hidden crossings, grazes and peaks, are
//! the roots of a quadratic.

use crate::scalar::Scalar;

/// A cubic on θ ∈ [0, 1], given by its values and its slopes with respect to θ at the ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic<S> {
    start: S,
    start_slope: S,
    end: S,
    end_slope: S,
}

/// Newton iterations of a guess that is improved elsewhere.
const GUESS_ITERATIONS: usize = 3;
/// Most iterations of the bracketed root search. Bisection alone then resolves 2⁻⁴⁰.
const ROOT_ITERATIONS: usize = 40;

impl<S: Scalar> Cubic<S> {
    /// The cubic of the values and the time derivatives at both ends of a step of `step` seconds.
    #[must_use]
    #[inline]
    pub fn new(start: S, start_rate: S, end: S, end_rate: S, step: S) -> Self {
        Self { start, start_slope: start_rate * step, end, end_slope: end_rate * step }
    }

    /// The parabola of the values at both ends of a step and the mean over the step.
    #[must_use]
    #[inline]
    pub fn with_mean(start: S, end: S, mean: S) -> Self {
        // The second derivative: 6 (start + end) − 12 mean.
        let half_curvature = S::from_f64(3.0) * (start + end) - S::from_f64(6.0) * mean;
        let rise = end - start;
        Self { start, start_slope: rise - half_curvature, end, end_slope: rise + half_curvature }
    }

    /// The value at `theta`.
    #[must_use]
    pub fn value(&self, theta: S) -> S {
        let [linear, quadratic, cubic] = self.powers();
        self.start + theta * (linear + theta * (quadratic + theta * cubic))
    }

    /// The slope with respect to θ at `theta`.
    fn slope(&self, theta: S) -> S {
        let [linear, quadratic, cubic] = self.powers();
        linear + theta * (S::from_f64(2.0) * quadratic + theta * S::from_f64(3.0) * cubic)
    }

    /// Coefficients of θ, θ² and θ³.
    #[inline]
    fn powers(&self) -> [S; 3] {
        let rise = self.end - self.start;
        let cubic = self.start_slope + self.end_slope - S::from_f64(2.0) * rise;
        [self.start_slope, rise - self.start_slope - cubic, cubic]
    }

    /// The inner Bernstein coefficients: the cubic lies in the convex hull of these and the values at the ends.
    #[inline]
    fn inner_hull(&self) -> [S; 2] {
        let third = S::from_f64(1.0 / 3.0);
        [self.start + third * self.start_slope, self.end - third * self.end_slope]
    }

    /// The extrema inside the step, in the order of θ.
    fn extrema(&self) -> [Option<S>; 2] {
        let [linear, quadratic, cubic] = self.powers();
        // 3 c θ² + 2 b θ + a = 0, solved without cancellation.
        let discriminant = quadratic * quadratic - S::from_f64(3.0) * cubic * linear;
        if !(discriminant >= S::ZERO) {
            return [None, None];
        }
        let root = discriminant.sqrt();
        let q = -(quadratic + if quadratic < S::ZERO { -root } else { root });
        let inside = |theta: S| (theta > S::ZERO && theta < S::ONE).then_some(theta);
        let (first, second) = (inside(linear / q), inside(q / (S::from_f64(3.0) * cubic)));
        match (first, second) {
            (Some(a), Some(b)) if b < a => [Some(b), Some(a)],
            _ => [first, second],
        }
    }

    /// The θ of the minimum inside the step.
    fn minimum(&self) -> Option<S> {
        let [linear, quadratic, cubic] = self.powers();
        // The zero of the slope where the curvature is positive, without cancellation.
        let root = (quadratic * quadratic - S::from_f64(3.0) * cubic * linear).sqrt();
        let theta = if quadratic > S::ZERO {
            -linear / (root + quadratic)
        } else {
            (root - quadratic) / (S::from_f64(3.0) * cubic)
        };
        (theta > S::ZERO && theta < S::ONE).then_some(theta)
    }

    /// The largest value on the step.
    #[must_use]
    pub fn largest(&self) -> S {
        let ends = self.start.max(self.end);
        let [one, two] = self.inner_hull();
        if one <= ends && two <= ends {
            return ends;
        }
        self.extrema().into_iter().flatten().fold(ends, |largest, theta| largest.max(self.value(theta)))
    }

    /// The values at the start, at the extrema inside in their order, and at the end.
    #[must_use]
    pub(crate) fn turns(&self) -> [S; 4] {
        let mut turns = [self.start, self.end, self.end, self.end];
        let inside = self.extrema().into_iter().flatten();
        turns.iter_mut().skip(1).zip(inside).for_each(|(turn, theta)| *turn = self.value(theta));
        turns
    }

    /// The smallest value on the step.
    #[must_use]
    pub fn smallest(&self) -> S {
        let Self { start, start_slope, end, end_slope } = *self;
        -Self { start: -start, start_slope: -start_slope, end: -end, end_slope: -end_slope }.largest()
    }

    /// The smallest θ at which the cubic falls to zero, or touches zero. 0 for a cubic that starts below
    /// zero, or at zero without rising.
    ///
    /// `None`, the common case, costs four multiplications: a cubic with positive Bernstein coefficients has no zero.
    #[inline]
    pub(crate) fn first_fall(&self) -> Option<S> {
        let [one, two] = self.inner_hull();
        if self.start >= S::ZERO && one > S::ZERO && two > S::ZERO && self.end > S::ZERO {
            None
        } else {
            self.search_fall()
        }
    }

    /// A guess of the θ at which a cubic that starts above zero falls through zero, or the θ of a minimum at or below `margin`.
    #[cold]
    pub(crate) fn approximate_fall(&self, margin: S) -> Option<S> {
        if self.end > S::ZERO {
            return self.minimum().filter(|&theta| self.value(theta) <= margin);
        }
        let half = S::from_f64(0.5);
        let mut theta = if self.start_slope > S::ZERO {
            self.return_to_start()
        } else if self.start > S::ZERO {
            self.start / (self.start - self.end)
        } else {
            half
        };
        for _ in 0..GUESS_ITERATIONS {
            let next = theta - self.value(theta) / self.slope(theta);
            theta = if next > S::ZERO && next <= S::ONE { next } else { half * theta };
        }
        Some(theta)
    }

    /// The θ at which a cubic that rises at its start returns to the value there; 1 if it does not. A cubic that starts near
    /// zero falls there, after its maximum.
    fn return_to_start(&self) -> S {
        let [linear, quadratic, cubic] = self.powers();
        let root = (quadratic * quadratic - S::from_f64(4.0) * cubic * linear).sqrt();
        // Without cancellation.
        let theta = (linear + linear) / (root - quadratic);
        if theta > S::ZERO && theta <= S::ONE { theta } else { S::ONE }
    }

    #[cold]
    fn search_fall(&self) -> Option<S> {
        let mut left = S::ZERO;
        // A start at zero counts as positive only if the cubic rises there.
        if self.start < S::ZERO || self.start == S::ZERO && !(self.start_slope > S::ZERO) {
            return Some(S::ZERO);
        }
        let [first, second] = self.extrema();
        for right in [first, second, Some(S::ONE)].into_iter().flatten() {
            let value = if right == S::ONE { self.end } else { self.value(right) };
            if value <= S::ZERO {
                return Some(self.root_between(left, right));
            }
            left = right;
        }
        None
    }

    /// The zero between `above`, where the cubic is positive, and `below`, where the cubic is at or below zero.
    fn root_between(&self, mut above: S, mut below: S) -> S {
        let half = S::from_f64(0.5);
        // Start away from θ = 0, which is also a root if the cubic starts at zero.
        let mut theta =
            if above == S::ZERO && self.start == S::ZERO { half * below } else { half * (above + below) };
        for _ in 0..ROOT_ITERATIONS {
            let value = self.value(theta);
            if value > S::ZERO {
                above = theta;
            } else {
                below = theta;
            }
            let newton = theta - value / self.slope(theta);
            let next = if newton > above && newton < below { newton } else { half * (above + below) };
            if (next - theta).abs() <= S::EPSILON * theta {
                return next;
            }
            theta = next;
        }
        below
    }
}

/// The smallest and the largest value of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak<S> {
    /// Smallest value; infinite before the first step.
    pub lowest: S,
    /// Largest value; minus infinity before the first step.
    pub highest: S,
}

impl<S: Scalar> Peak<S> {
    pub(crate) fn new() -> Self {
        Self { lowest: S::INFINITY, highest: -S::INFINITY }
    }

    /// Includes a step with the extrema inside it, of a magnitude of at most `most`.
    #[inline]
    pub(crate) fn include(&mut self, cubic: &Cubic<S>, most: S) {
        self.lowest = cubic.smallest().max(-most).min(self.lowest);
        self.highest = cubic.largest().min(most).max(self.highest);
    }

    /// Largest magnitude; 0 before the first step.
    #[must_use]
    pub fn magnitude(&self) -> S {
        self.highest.max(-self.lowest).max(S::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_function(f: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> Cubic<f64> {
        Cubic::new(f(0.0), slope(0.0), f(1.0), slope(1.0), 1.0)
    }

    #[test]
    fn reproduces_a_cubic() {
        let (f, slope) =
            (|t: f64| 1.0 - 2.0 * t + 0.5 * t * t + 3.0 * t * t * t, |t: f64| -2.0 + t + 9.0 * t * t);
        let cubic = from_function(f, slope);
        for k in 0..=10 {
            let theta = f64::from(k) / 10.0;
            assert!((cubic.value(theta) - f(theta)).abs() < 1e-14);
            assert!((cubic.slope(theta) - slope(theta)).abs() < 1e-14);
        }
    }

    #[test]
    fn finds_the_first_of_two_hidden_crossings() {
        // (θ − 0.4)(θ − 0.6) is positive at both ends.
        let cubic = from_function(|t| (t - 0.4) * (t - 0.6), |t| 2.0 * t - 1.0);
        assert!((cubic.first_fall().expect("hidden") - 0.4).abs() < 1e-15);
        // Lifted so that it does not touch, there is nothing to find.
        let lifted = from_function(|t| (t - 0.4) * (t - 0.6) + 0.0101, |t| 2.0 * t - 1.0);
        assert_eq!(lifted.first_fall(), None);
    }

    #[test]
    fn a_start_at_zero_is_not_a_fall_while_it_rises() {
        let rises = from_function(|t| t * (1.3 - t), |t| 1.3 - 2.0 * t);
        assert_eq!(rises.first_fall(), None);
        let returns = from_function(|t| t * (0.7 - t), |t| 0.7 - 2.0 * t);
        assert!((returns.first_fall().expect("falls") - 0.7).abs() < 1e-15);
        let sinks = from_function(|t| -t, |_| -1.0);
        assert_eq!(sinks.first_fall(), Some(0.0));
    }

    #[test]
    fn a_rise_from_near_zero_is_not_taken_for_a_fall() {
        for start in [0.0, 1e-16, 1e-3] {
            let returns = from_function(|t| start + t * (0.7 - t), |t| 0.7 - 2.0 * t);
            let found = returns.approximate_fall(0.0).expect("falls");
            assert!((found - 0.7).abs() < 0.02, "{found}");
        }
        // However soon it falls.
        let soon = from_function(|t| t * (1e-9 - t), |t| 1e-9 - 2.0 * t);
        let found = soon.approximate_fall(0.0).expect("falls");
        assert!((found - 1e-9).abs() < 1e-15, "{found}");
    }

    #[test]
    fn roots_are_at_rounding_level_in_single_precision() {
        for k in 1..100 {
            let root = k as f32 / 100.0;
            // Steep and curved: (root − θ)(1 + 30 θ²).
            let f = |t: f64| (f64::from(root) - t) * (1.0 + 30.0 * t * t);
            let slope = |t: f64| -(1.0 + 30.0 * t * t) + (f64::from(root) - t) * 60.0 * t;
            let cubic = Cubic::new(f(0.0) as f32, slope(0.0) as f32, f(1.0) as f32, slope(1.0) as f32, 1.0);
            let found = cubic.first_fall().expect("falls");
            assert!((found - root).abs() < 2e-5, "{found} {root}");
        }
    }

    #[test]
    fn a_parabola_is_recovered_from_its_mean() {
        // 1 + 4 θ (1 − θ): mean 5/3, largest value 2 at the middle.
        let parabola = Cubic::with_mean(1.0_f64, 1.0, 5.0 / 3.0);
        assert!((parabola.largest() - 2.0).abs() < 1e-15 && parabola.smallest() == 1.0);
        assert!((parabola.value(0.25) - 1.75).abs() < 1e-15);
    }

    #[test]
    fn extremes_inside_the_step_are_found() {
        let cubic = from_function(|t| 4.0 * t * (1.0 - t), |t| 4.0 - 8.0 * t);
        assert!((cubic.largest() - 1.0).abs() < 1e-15);
        assert_eq!(cubic.smallest(), 0.0);
        let flat = from_function(|_| 2.0, |_| 0.0);
        assert_eq!((flat.largest(), flat.smallest()), (2.0, 2.0));
    }
}
