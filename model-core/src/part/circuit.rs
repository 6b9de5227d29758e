//! Steps a capacitance with a parallel load under a constant current, or under a current that is linear in time.
//!
//! `C v' = i − v/R` with a constant `i = Δq/h` has an exact solution. A step uses its mean voltage, which is linear
//! in the charge, `v̄ = e0 + e1 Δq`. It is passive at any step and any resistance: the work `v̄ Δq` is exactly the
//! energy stored and dissipated. A fast circuit is damped, while a trapezoidal rule would oscillate.

use super::load::Resistance;
use crate::scalar::{Mathematics, Scalar};

/// The coefficients for one step length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CircuitStep<S> {
    /// `e0/v`: weight of the start voltage in the mean.
    pub mean_by_voltage: S,
    /// `e1` in 1/F: mean voltage per charge brought in over the step.
    pub mean_by_charge: S,
    /// `(mean of v² − v̄²)/(Δv)²`: contribution of the change over the step to the mean square.
    pub square_by_change: S,
    /// `h/R` in s/Ω: charge through the load per mean voltage.
    pub charge_by_mean: S,
}

/// Ratio of step to time constant below which the closed forms cancel.
const SERIES_RATIO: f64 = 0.5;

impl<S: Scalar> CircuitStep<S> {
    /// For a capacitance in F above 0, a load, and a step in s above 0.
    pub(crate) fn new(capacitance: S, resistance: Resistance<S>, step: S) -> Self {
        match resistance {
            Resistance::Short => Self::default(),
            Resistance::Open => Self::of_ratio(S::ZERO, capacitance, S::ZERO),
            Resistance::Finite(resistance) => {
                let conductance = step / resistance;
                Self::of_ratio(conductance / capacitance, capacitance, conductance)
            }
        }
    }

    /// For a ratio `x = h/RC`.
    fn of_ratio(ratio: S, capacitance: S, charge_by_mean: S) -> Self {
        let (mean_by_voltage, rest, square_by_change) = if ratio < S::from_f64(SERIES_RATIO) {
            // (1 − w)/x = Σ (−x)ⁿ/(n+2)!, w = (1 − e⁻ˣ)/x.
            let (mut term, mut sum) = (S::from_f64(0.5), S::from_f64(0.5));
            for n in 3..20_u32 {
                term = -term * ratio / S::from_u32(n);
                sum += term;
            }
            // coth(x/2)/2x − 1/x².
            let square = ratio * ratio;
            let tail = S::from_f64(1.0 / 47_900_160.0) - S::from_f64(691.0 / 1_307_674_368_000.0) * square;
            let tail = S::from_f64(1.0 / 1_209_600.0) - square * tail;
            let tail = S::from_f64(1.0 / 30_240.0) - square * tail;
            let tail = S::from_f64(1.0 / 720.0) - square * tail;
            (S::ONE - ratio * sum, sum, S::from_f64(1.0 / 12.0) - square * tail)
        } else {
            let per_ratio = S::ONE / ratio;
            let decay = S::Build::exponential(-ratio);
            let mean = (S::ONE - decay) * per_ratio;
            let hyperbolic = (S::ONE + decay) / (S::ONE - decay);
            let square = (S::from_f64(0.5) * hyperbolic - per_ratio) * per_ratio;
            (mean, (S::ONE - mean) * per_ratio, square)
        };
        Self { mean_by_voltage, mean_by_charge: rest / capacitance, square_by_change, charge_by_mean }
    }
}

/// The coefficients for one step length under a current that is linear in time.
///
/// The current has the charge `m0 = Δq` and the first moment `m1 = ∫ P dq` with `P(c) = 2c − 1`, `c` from 0 to 1 over
/// the step. The projection of the voltage on linear functions, `V0 + V1 P`, is linear in the start voltage `v` and
/// in the moments:
///
/// ```text
/// V0 = w v + (r m0 − s m1)/C,   V1 = −x s v + (s m0 + t m1)/C,   x = h/RC
/// ```
///
/// The work `V0 m0 + V1 m1` is exactly the energy stored and dissipated. So a step is passive if the voltage acts back
/// as `V0 + V1 P` on the motion that moves the charge. The mean of `v²` is `V0² + V1²/3` and, for the rest of the
/// voltage, a multiple of `(v + v⁺ − 2 V0)²`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinearCircuitStep<S> {
    /// `V0` by `v`, and in 1/F by `m0` and `m1`.
    pub mean: [S; 3],
    /// `V1` by `v`, and in 1/F by `m0` and `m1`.
    pub tilt: [S; 3],
    /// Contribution of `(v + v⁺ − 2 V0)²` to the mean square.
    pub square_by_bend: S,
}

/// Ratio of step to time constant below which the closed forms of [`LinearCircuitStep`] cancel, and number of terms of its series.
const LINEAR_SERIES_RATIO: f64 = 2.0;
const LINEAR_SERIES_TERMS: u32 = 26;

impl<S: Scalar> LinearCircuitStep<S> {
    /// For a capacitance in F above 0, a load, and a step in s above 0.
    pub(crate) fn new(capacitance: S, resistance: Resistance<S>, step: S) -> Self {
        match resistance {
            Resistance::Short => Self::default(),
            Resistance::Open => Self::of_ratio(S::ZERO, capacitance),
            Resistance::Finite(resistance) => Self::of_ratio(step / (resistance * capacitance), capacitance),
        }
    }

    fn of_ratio(ratio: S, capacitance: S) -> Self {
        let [mean, rest, lag, lead, square_by_bend] =
            if ratio < S::from_f64(LINEAR_SERIES_RATIO) { Self::series(ratio) } else { Self::closed(ratio) };
        let per = S::ONE / capacitance;
        Self {
            mean: [mean, rest * per, -lag * per],
            tilt: [-ratio * lag, lag * per, lead * per],
            square_by_bend,
        }
    }

    /// `w`, `r`, `s`, `t` and the contribution to the mean square. At a large ratio `w` is about `1/x`: the charge
    /// through the load is `x w C v`, so an error of `w` counts `x` times.
    fn closed(ratio: S) -> [S; 5] {
        let (two, three, six) = (S::from_f64(2.0), S::from_f64(3.0), S::from_f64(6.0));
        let per = S::ONE / ratio;
        let decay = S::Build::exponential(-ratio);
        // The projection `mean + tilt P` of e⁻ˣᶜ.
        let mean = (S::ONE - decay) * per;
        let tilt = three * per * (two * mean - (S::ONE + decay));
        let lead = per * (six * tilt * per + three * (S::ONE + tilt));
        let square = S::from_f64(0.5) * per * (S::ONE - decay * decay);
        let bend = S::ONE + decay - two * mean;
        let rest = square - mean * mean - tilt * tilt / three;
        [mean, (S::ONE - mean) * per, -tilt * per, lead, rest / (bend * bend)]
    }

    /// As [`Self::closed`], by series in the ratio.
    fn series(ratio: S) -> [S; 5] {
        let nine = S::from_f64(9.0);
        let (mut rest, mut lag, mut lead) = (S::ZERO, S::ZERO, S::ZERO);
        // (−x)ᵐ/(m + 2)!
        let mut term = S::from_f64(0.5);
        for m in 0..LINEAR_SERIES_TERMS {
            let [one, three, four] = [m + 1, m + 3, m + 4].map(S::from_u32);
            rest += term;
            // 3 (−x)ᵐ/(m! (m + 2)(m + 3)) and −9 m (−x)ᵐ/((m + 1)! (m + 2)(m + 4)).
            lag += S::from_f64(3.0) * term * one / three;
            lead -= nine * S::from_u32(m) * term / four;
            term = -term * ratio / three;
        }
        [S::ONE - ratio * rest, rest, lag, lead, Self::square_by_bend(S::from_f64(0.5) * ratio)]
    }

    /// With the modified spherical Bessel functions, `e^(y (1 − 2c)) = Σ ±(2j + 1) i_j(y) P_j`, so the contribution is
    /// `Σ (2j + 1) i_j²` over `j ≥ 2`, divided by `(2 Σ (2j + 1) i_j)²` over even `j ≥ 2`. The sums end where a term is
    /// below a rounding.
    fn square_by_bend(y: S) -> S {
        let half_square = S::from_f64(0.5) * y * y;
        let (mut squares, mut bend) = (S::ZERO, S::ZERO);
        // yʲ⁻²/(2j + 1)!!
        let mut leading = S::from_f64(1.0 / 15.0);
        for j in 2..LINEAR_SERIES_TERMS {
            let (mut term, mut sum) = (leading, leading);
            for k in 1..LINEAR_SERIES_TERMS {
                term = term * half_square / S::from_u32(k * (2 * j + 2 * k + 1));
                let longer = sum + term;
                if longer == sum {
                    break;
                }
                sum = longer;
            }
            let weighted = S::from_u32(2 * j + 1) * sum;
            squares += weighted * sum;
            if j % 2 == 0 {
                let longer = bend + weighted + weighted;
                if longer == bend {
                    break;
                }
                bend = longer;
            }
            leading = leading * y / S::from_u32(2 * j + 3);
        }
        squares / (bend * bend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_current_has_the_projection_and_the_mean_square_of_the_exact_solution() {
        let (capacitance, step, start) = (16e-9, 1e-6, 0.3);
        for (charge, moment) in [(2e-9, 1e-9), (-1e-9, 6e-9), (0.0, 0.0)] {
            for ratio in [1e-6_f64, 1e-3, 0.1, 1.9, 2.1, 30.0] {
                let resistance = step / (ratio * capacitance);
                let circuit = LinearCircuitStep::new(capacitance, Resistance::Finite(resistance), step);
                let given = [start, charge, moment];
                let of = |row: [f64; 3]| row.iter().zip(given).map(|(a, b)| a * b).sum::<f64>();
                let (mean, tilt) = (of(circuit.mean), of(circuit.tilt));
                let end = start + (charge - step / resistance * mean) / capacitance;
                // v' = (m0 + 3 m1 P)/C − x v has a linear solution, and one that decays.
                let by_slope = 6.0 * moment / capacitance / ratio;
                let settled = |c: f64| {
                    let current = (charge + 3.0 * moment * (2.0 * c - 1.0)) / capacitance;
                    (current - by_slope) / ratio
                };
                let value = |c: f64| settled(c) + (start - settled(0.0)) * (-ratio * c).exp();
                let count = 200_000;
                let (mut first, mut second, mut square) = (0.0, 0.0, 0.0);
                for k in 0..count {
                    let c = (f64::from(k) + 0.5) / f64::from(count);
                    let voltage = value(c);
                    first += voltage / f64::from(count);
                    second += 3.0 * voltage * (2.0 * c - 1.0) / f64::from(count);
                    square += voltage * voltage / f64::from(count);
                }
                let size = start + (charge.abs() + moment.abs()) / capacitance;
                // The exact solution cancels at a small ratio.
                let tolerance = 1e-9 + 1e-15 / (ratio * ratio);
                if tolerance > 1e-2 {
                    continue;
                }
                let close = |a: f64, b: f64| {
                    assert!((a - b).abs() < tolerance * size.max(size * size), "{ratio} {a} {b}");
                };
                close(mean, first);
                close(tilt, second);
                close(end, value(1.0));
                let bend = start + end - 2.0 * mean;
                close(mean * mean + tilt * tilt / 3.0 + circuit.square_by_bend * bend * bend, square);
                // The work is stored and dissipated.
                let work = mean * charge + tilt * moment;
                let found = mean * mean + tilt * tilt / 3.0 + circuit.square_by_bend * bend * bend;
                let stored = 0.5 * capacitance * (end * end - start * start);
                let out = stored + found * step / resistance;
                assert!((work - out).abs() < 1e-12 * capacitance * size * size, "{ratio}: {work} {out}");
            }
        }
    }

    #[test]
    fn single_precision_keeps_the_coefficients_of_a_linear_current() {
        for resistance in
            [Resistance::Open, Resistance::Finite(1e6), Resistance::Finite(40.0), Resistance::Finite(10.0)]
        {
            let fine = LinearCircuitStep::<f64>::new(16e-9, resistance, 1e-6);
            let single = match resistance {
                Resistance::Finite(ohms) => Resistance::Finite(ohms as f32),
                _ => Resistance::Open,
            };
            let coarse = LinearCircuitStep::<f32>::new(16e-9, single, 1e-6);
            for (fine, coarse) in [(fine.mean, coarse.mean), (fine.tilt, coarse.tilt)] {
                for (a, b) in fine.iter().zip(coarse) {
                    assert!((a - f64::from(b)).abs() <= 1e-5 * a.abs() + 1e-7, "{a} {b}");
                }
            }
            assert!((f64::from(coarse.square_by_bend) / fine.square_by_bend - 1.0).abs() < 1e-4);
        }
        let open = LinearCircuitStep::<f64>::new(1.0, Resistance::Open, 1.0);
        assert_eq!(
            open,
            LinearCircuitStep {
                mean: [1.0, 0.5, -0.5],
                tilt: [0.0, 0.5, 0.0],
                square_by_bend: open.square_by_bend
            }
        );
        assert!((open.square_by_bend - 0.05).abs() < 1e-15);
    }

    #[test]
    fn a_small_resistance_discharges_within_a_step_in_single_precision() {
        let capacitance = 16e-9_f32;
        for exponent in 3..=13 {
            for digit in [1.0, 1.7, 3.3, 7.9] {
                let step = 180e-6_f32;
                let load = Resistance::Finite(step / (digit * 10f32.powi(exponent) * capacitance));
                let circuit = LinearCircuitStep::new(capacitance, load, step);
                let conductance = CircuitStep::new(capacitance, load, step).charge_by_mean;
                let ([mean, ..], [tilt, ..]) = (circuit.mean, circuit.tilt);
                let end = 1.0 - conductance * mean / capacitance;
                assert!(end.abs() < 1e-6, "{digit}e{exponent}: {end}");
                let bend = 1.0 + end - 2.0 * mean;
                let square = mean * mean + tilt * tilt / 3.0 + circuit.square_by_bend * bend * bend;
                let delivered = conductance * square / (0.5 * capacitance);
                assert!((delivered - 1.0).abs() < 1e-6, "{digit}e{exponent}: {delivered}");
            }
        }
    }

    #[test]
    fn mean_and_mean_square_are_those_of_the_exact_solution() {
        let capacitance = 16e-9;
        for ratio in [1e-6_f64, 1e-3, 0.1, 0.49, 0.51, 2.0, 30.0, 500.0] {
            let (step, charge, start) = (1e-6, 2e-9, 0.3);
            let resistance = step / (ratio * capacitance);
            let circuit = CircuitStep::new(capacitance, Resistance::Finite(resistance), step);
            let mean = circuit.mean_by_voltage * start + circuit.mean_by_charge * charge;
            let end = start + (charge - circuit.charge_by_mean * mean) / capacitance;
            // v(t) = v∞ + (v0 − v∞) e^(−xt/h), sampled finely at the middles of intervals.
            let (settled, count) = (resistance * charge / step, 2_000_000);
            let value = |t: f64| settled + (start - settled) * (-ratio * t).exp();
            let (mut first, mut second) = (0.0, 0.0);
            for k in 0..count {
                let voltage = value((f64::from(k) + 0.5) / f64::from(count));
                first += voltage / f64::from(count);
                second += voltage * voltage / f64::from(count);
            }
            let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{ratio} {a} {b}");
            close(mean, first);
            close(end, value(1.0));
            close(mean * mean + circuit.square_by_change * (end - start).powi(2), second);
        }
    }

    #[test]
    fn open_and_short_are_the_limits() {
        let open = CircuitStep::<f32>::new(1e-8, Resistance::Open, 1e-6);
        assert_eq!((open.mean_by_voltage, open.charge_by_mean), (1.0, 0.0));
        assert!((open.mean_by_charge * 1e-8 - 0.5).abs() < 1e-6);
        let short = CircuitStep::<f32>::new(1e-8, Resistance::Short, 1e-6);
        assert_eq!((short.mean_by_voltage, short.mean_by_charge), (0.0, 0.0));
        let nearly = CircuitStep::<f32>::new(1e-8, Resistance::Finite(1e30), 1e-6);
        assert_eq!(nearly.mean_by_charge, open.mean_by_charge);
    }
}
