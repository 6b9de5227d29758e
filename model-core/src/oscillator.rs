//! The exact motion of a damped linear oscillator over one step.
//!
//! ```text
//! x'' + d x' + w x = g(τ)          S(τ): the impulse response, S(0) = 0, S'(0) = 1
//! R_n(h) = ∫₀ʰ S(h − s) sⁿ/n! ds
//! ```
//!
//! From the equation of motion, `R_n'' + d R_n' + w R_n = hⁿ/n!` with `R_n' = R_{n−1}` (derived here):
//!
//! ```text
//! R_{n−2} = hⁿ/n! − d R_{n−1} − w R_n          R_{−1} = S          R_{−2} = S'
//! ```
//!
//! Downward the errors shrink: the highest two are the first terms of their power series. The responses to a cosine and a
//! sine are alternating sums of all `R_n`.

use crate::scalar::Scalar;

/// Largest product of the step and a rate of the oscillator, or of a sine, for which the series have full accuracy.
pub(crate) const LONGEST_RADIANS: f64 = 0.9;

/// A damped linear oscillator under a base acceleration `a` and a further force per mass `f`: `x'' = −w (x − x0) − d x' − κ a + f`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator<S> {
    /// `w`, the square of the angular frequency, in 1/s².
    pub stiffness: S,
    /// `d` in 1/s.
    pub damping: S,
    /// `x0`, the position without force, in m.
    pub rest: S,
    /// `κ`: acceleration against that of the base, relative to it.
    pub base_coupling: S,
}

impl<S: Scalar> Oscillator<S> {
    /// The longest step in s for which [`Kernel`] is accurate to rounding.
    #[inline]
    pub(crate) fn longest_step(&self, angular_frequency: S) -> S {
        S::from_f64(LONGEST_RADIANS) / angular_frequency.max(self.damping)
    }
}

/// The response of an oscillator over a step of `h` seconds, without units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel<S> {
    /// `h` in s.
    pub step: S,
    /// `w h²`.
    pub(crate) stiffness: S,
    /// `d h`.
    pub(crate) damping: S,
    /// `S/h`.
    pub(crate) impulse: S,
    /// `S' − 1`.
    pub(crate) impulse_rate: S,
    /// `R_n/h^(n+2)`: in single precision those up to 9, the others are zero.
    pub(crate) ramps: [S; 16],
}

/// The reciprocals of the factorials `k!`.
const RECIPROCAL_FACTORIALS: [f64; 18] = {
    let mut values = [1.0; 18];
    let mut k = 1;
    while k < values.len() {
        values[k] = values[k - 1] / k as f64;
        k += 1;
    }
    values
};

/// `1/k!`.
macro_rules! reciprocal_factorial {
    ($k:expr) => {
        S::from_f64(const { RECIPROCAL_FACTORIALS[$k] })
    };
}

/// Runs the body for each `n` of which a term is above a rounding, unrolled: a coefficient is then a constant. The numbers in
/// brackets are for double precision only.
macro_rules! downward {
    ($scalar:ty, $n:ident: [$($double:literal)+] $($single:literal)+ $body:block) => {
        if <$scalar>::IS_DOUBLE {
            $({ const $n: usize = $double; $body })+
        }
        $({ const $n: usize = $single; $body })+
    };
}

impl<S: Scalar> Kernel<S> {
    /// The response of `oscillator` over a step of `step` s.
    #[must_use]
    #[inline(always)]
    pub fn new(oscillator: &Oscillator<S>, step: S) -> Self {
        let stiffness = oscillator.stiffness * step * step;
        let damping = oscillator.damping * step;
        let mut ramps = [S::ZERO; 16];
        if S::IS_DOUBLE {
            (ramps[14], ramps[15]) = (reciprocal_factorial!(16), reciprocal_factorial!(17));
        } else {
            (ramps[8], ramps[9]) = (reciprocal_factorial!(10), reciprocal_factorial!(11));
        }
        downward!(S, N: [15 14 13 12 11 10] 9 8 7 6 5 4 3 2 {
            ramps[N - 2] = reciprocal_factorial!(N) - damping * ramps[N - 1] - stiffness * ramps[N];
        });
        let [zeroth, first, ..] = ramps;
        let impulse = S::ONE - damping * zeroth - stiffness * first;
        let impulse_rate = -damping * impulse - stiffness * zeroth;
        Self { step, stiffness, damping, impulse, impulse_rate, ramps }
    }

    /// The response to the acceleration `start + slope · τ`, in m/s² and m/s³.
    #[must_use]
    #[inline]
    pub fn to_line(&self, start: S, slope: S) -> Response<S> {
        let Self { step, impulse, ramps: [zeroth, first, ..], .. } = *self;
        let rise = step * slope;
        Response {
            displacement: step * step * (zeroth * start + first * rise),
            velocity: step * (impulse * start + zeroth * rise),
            start,
            end: start + rise,
        }
    }

    /// The response to the parabola through the accelerations at the start, the middle and the end, in m/s².
    #[must_use]
    #[inline]
    pub fn to_parabola(&self, [start, middle, end]: [S; 3]) -> Response<S> {
        let Self { step, impulse, ramps: [zeroth, first, second, ..], .. } = *self;
        let (rise, bow) = (end - start, middle - start);
        // `start + linear θ + half curvature θ²`.
        let linear = S::from_f64(4.0) * bow - rise;
        let curvature = S::from_f64(4.0) * (rise - bow - bow);
        Response {
            displacement: step * step * (zeroth * start + first * linear + second * curvature),
            velocity: step * (impulse * start + zeroth * linear + first * curvature),
            start,
            end,
        }
    }

    /// The response to the acceleration `Σ c_n θⁿ`, where `θ` goes from 0 to 1 over the step; `c_n` in m/s².
    #[must_use]
    #[inline]
    pub fn to_cubic(&self, [start, linear, square, cube]: [S; 4]) -> Response<S> {
        let Self { step, impulse, ramps: [zeroth, first, second, third, ..], .. } = *self;
        // `Rₙ` is the response to `τⁿ/n!`.
        let (square, cube) = (square + square, S::from_f64(6.0) * cube);
        Response {
            displacement: step * step * (zeroth * start + first * linear + second * square + third * cube),
            velocity: step * (impulse * start + zeroth * linear + first * square + second * cube),
            start,
            end: start + linear + S::from_f64(0.5) * square + S::from_f64(1.0 / 6.0) * cube,
        }
    }

    /// The response to the acceleration `start · cos Ωτ + rate · sin(Ωτ)/Ω` with `Ω` in rad/s, at any `Ω`, the resonance included.
    #[must_use]
    #[inline(always)]
    pub fn to_sine(&self, start: S, rate: S, angular_frequency: S) -> Response<S> {
        let Self { step, stiffness, damping, impulse, ramps, .. } = *self;
        let turn = angular_frequency * step;
        let square = turn * turn;
        // Those of even and of odd number.
        let [mut by_start, mut by_rate] = [S::ZERO; 2];
        downward!(S, N: [15 14 13 12 11 10] 9 8 7 6 5 4 3 2 1 0 {
            let sum = if N.is_multiple_of(2) { &mut by_start } else { &mut by_rate };
            *sum = ramps[N] - square * *sum;
        });
        let zeroth = ramps[0];
        let by_start_rate = impulse - square * by_rate;
        let rise = step * rate;
        let cosine = S::ONE + stiffness * (by_start - zeroth) - square * (by_start + damping * by_rate);
        let sine = by_start_rate + damping * by_start + stiffness * by_rate;
        Response {
            displacement: step * step * (by_start * start + by_rate * rise),
            velocity: step * (by_start_rate * start + by_start * rise),
            start,
            end: cosine * start + sine * rise,
        }
    }
}

/// The motion of an oscillator, at rest at the start of a step, under an acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response<S> {
    /// Displacement at the end in m.
    pub displacement: S,
    /// Velocity at the end in m/s.
    pub velocity: S,
    /// The acceleration at the start in m/s².
    pub start: S,
    /// The acceleration at the end in m/s².
    pub end: S,
}

impl<S: Scalar> Response<S> {
    /// The response to no acceleration.
    pub const NONE: Self = Self { displacement: S::ZERO, velocity: S::ZERO, start: S::ZERO, end: S::ZERO };

    /// The response to the sum of two accelerations.
    #[must_use]
    #[inline]
    pub fn and(self, other: Self) -> Self {
        Self {
            displacement: self.displacement + other.displacement,
            velocity: self.velocity + other.velocity,
            start: self.start + other.start,
            end: self.end + other.end,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Steps of RK4 for the response over a step.
    const STEPS: u32 = 4_000;

    /// Position and velocity after `time` from rest under `acceleration`, by steps of RK4.
    pub(crate) fn by_small_steps(
        oscillator: &Oscillator<f64>,
        time: f64,
        steps: u32,
        acceleration: impl Fn(f64) -> f64,
    ) -> [f64; 2] {
        let h = time / f64::from(steps);
        let rate = |t: f64, [x, v]: [f64; 2]| {
            [v, acceleration(t) - oscillator.damping * v - oscillator.stiffness * x]
        };
        let along = |y: [f64; 2], h: f64, k: [f64; 2]| [y[0] + h * k[0], y[1] + h * k[1]];
        let mut y = [0.0; 2];
        for n in 0..steps {
            let t = f64::from(n) * h;
            let k1 = rate(t, y);
            let k2 = rate(t + 0.5 * h, along(y, 0.5 * h, k1));
            let k3 = rate(t + 0.5 * h, along(y, 0.5 * h, k2));
            let k4 = rate(t + h, along(y, h, k3));
            y = core::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        y
    }

    fn assert_close<S: Scalar>(found: Response<S>, expected: [f64; 2], end: f64, tolerance: f64) {
        for (found, expected) in
            [(found.displacement, expected[0]), (found.velocity, expected[1]), (found.end, end)]
        {
            assert!((found.to_f64() - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
        }
    }

    /// Light and heavy damping.
    fn oscillators() -> [Oscillator<f64>; 3] {
        [0.01, 1.0, 3.0].map(|ratio: f64| Oscillator {
            stiffness: 126.0 * 126.0,
            damping: 2.0 * ratio * 126.0,
            rest: 0.0,
            base_coupling: 1.0,
        })
    }

    fn single(oscillator: &Oscillator<f64>) -> Oscillator<f32> {
        Oscillator {
            stiffness: oscillator.stiffness as f32,
            damping: oscillator.damping as f32,
            rest: 0.0,
            base_coupling: 1.0,
        }
    }

    #[test]
    fn lines_parabolas_and_sines_are_followed_exactly() {
        for oscillator in oscillators() {
            let h = oscillator.longest_step(126.0);
            let kernel = Kernel::new(&oscillator, h);
            let small = Kernel::new(&single(&oscillator), h as f32);
            let line = |t: f64| 2.0 - 300.0 * t;
            let expected = by_small_steps(&oscillator, h, STEPS, line);
            assert_close(kernel.to_line(2.0, -300.0), expected, line(h), 2e-14);
            assert_close(small.to_line(2.0, -300.0), expected, line(h), 1e-6);
            let parabola = |t: f64| 1.0 + 200.0 * t + 3e4 * t * t;
            let expected = by_small_steps(&oscillator, h, STEPS, parabola);
            let samples = [parabola(0.0), parabola(0.5 * h), parabola(h)];
            assert_close(kernel.to_parabola(samples), expected, parabola(h), 2e-14);
            let cubic = |t: f64| parabola(t) - 4e6 * t * t * t;
            let expected = by_small_steps(&oscillator, h, STEPS, cubic);
            let coefficients = [1.0, 200.0 * h, 3e4 * h * h, -4e6 * h * h * h];
            assert_close(kernel.to_cubic(coefficients), expected, cubic(h), 2e-14);
            let found = small.to_cubic(coefficients.map(|coefficient| coefficient as f32));
            assert_close(found, expected, cubic(h), 2e-6);
            for frequency in [1e-3, 50.0, 125.99, 126.0, 200.0] {
                let sine = |t: f64| 2.0 * (frequency * t).cos() + 0.7 * (frequency * t).sin();
                // A sine limits the step too.
                let h = oscillator.longest_step(frequency.max(126.0));
                let kernel = Kernel::new(&oscillator, h);
                let small = Kernel::new(&single(&oscillator), h as f32);
                let expected = by_small_steps(&oscillator, h, STEPS, sine);
                let rate = 0.7 * frequency;
                assert_close(kernel.to_sine(2.0, rate, frequency), expected, sine(h), 2e-13);
                let found = small.to_sine(2.0, rate as f32, frequency as f32);
                assert_close(found, expected, sine(h), 2e-6);
                // The longest step of `StepControl::lengthening`.
                let h = 1.5 * h;
                let expected = by_small_steps(&oscillator, h, STEPS, sine);
                let found = Kernel::new(&oscillator, h).to_sine(2.0, rate, frequency);
                assert_close(found, expected, sine(h), 1e-11);
            }
        }
    }

    #[test]
    fn the_free_motion_is_that_of_the_closed_form() {
        let [light, ..] = oscillators();
        let h = 3e-3;
        let kernel = Kernel::new(&light, h);
        let decay = 0.5 * light.damping;
        let damped = (light.stiffness - decay * decay).sqrt();
        let impulse = (-decay * h).exp() * (damped * h).sin() / damped;
        let impulse_rate = (-decay * h).exp() * (damped * h).cos() - decay * impulse;
        assert!((h * kernel.impulse / impulse - 1.0).abs() < 1e-15);
        assert!((1.0 + kernel.impulse_rate - impulse_rate).abs() < 1e-15);
    }
}
