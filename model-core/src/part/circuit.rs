//! Steps a capacitance with a parallel load under a constant current.
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

#[cfg(test)]
mod tests {
    use super::*;

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
