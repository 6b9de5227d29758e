//! The error of linear interpolation between samples, and a filter of the samples that reduces it.
//!
//! With `x = w T/2`, samples of a sine of angular frequency `w` at the interval `T`, interpolated linearly, are this
//! sine times
//!
//! ```text
//! G(x) = (sin x / x)²
//! ```
//!
//! and images above half of the sampling rate. The samples `a − c (a₋ − 2 a + a₊)` of that sine are its samples times
//! `1 + 4 c sin² x`. With `c = (1/G − 1)/(4 sin² x)` at the resonance the two factors cancel there. `c` is near 1/12 at
//! every rate, so that they cancel to the order of `x⁴` elsewhere (derived here).
//!
//! Besides, the error of the mean power by the sensor: the steps of its converter, the jitter and the rate of its clock.

use super::response::Response;
use super::{Estimator, Settings};
use crate::scalar::{Scalar, arcsine, horner};
use crate::scene::Harvester;

/// The acceleration between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Interpolation {
    /// Linear between the samples: the mean power is too low, by 1.6 % with 20 samples in a resonance period and by 23 % with 5.
    Linear,
    /// Linear between samples that a filter of three samples corrects, exactly at the resonance of the harvester.
    #[default]
    DroopCompensated,
}

/// Samples per resonance period below which no figure for the sampling is stated.
const LEAST_SAMPLES_PER_PERIOD: u32 = 4;

/// The largest `x`, at [`LEAST_SAMPLES_PER_PERIOD`].
const LARGEST_HALF_TURN: f64 = core::f64::consts::PI / LEAST_SAMPLES_PER_PERIOD as f64;
/// Statement over the predicted error, for linear interpolation and with the filter. It covers what is not in the gain:
/// friction, which takes a constant power and so raises the gain of what is left. Fitted on some random inputs and
/// tested on others: docs/energy.md.
const COVERAGE: [f64; 2] = [6.0, 4.0];
/// Residual of the filter `4 δ u − 8/45 u²` with `u = sin² x`, by the series of `G`.
const RESIDUAL: f64 = 8.0 / 45.0;

/// The harvester's resonance in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Droop<S> {
    /// `c`.
    coefficient: S,
    /// `sin² x` at the resonance, at most that at the bound of `resolved`.
    sine_square: S,
    /// Samples in a period, at least 1.
    pub(super) samples: u32,
    /// Whether there are at least [`LEAST_SAMPLES_PER_PERIOD`].
    resolved: bool,
}

impl<S: Scalar> Droop<S> {
    /// Of a resonance in rad/s and a rate in samples per second.
    pub(super) fn new(angular_frequency: S, rate: S) -> Self {
        let half_turn = S::from_f64(0.5) * angular_frequency / rate;
        let largest = S::from_f64(LARGEST_HALF_TURN);
        let square = half_turn.min(largest) * half_turn.min(largest);
        // (1 − G)/x² by the series of sin²; the next term is below 10⁻⁶ of the sum.
        let series = [1.0 / 3.0, -2.0 / 45.0, 1.0 / 315.0, -2.0 / 14_175.0, 2.0 / 467_775.0].map(S::from_f64);
        let fall = horner(&series, square);
        let gain = S::ONE - square * fall;
        // A rounding above the bound is still at the bound.
        let resolved = half_turn <= largest * (S::ONE + S::from_f64(4.0) * S::EPSILON);
        let samples = (S::from_f64(core::f64::consts::PI) / half_turn + S::from_f64(0.5)).to_u32().max(1);
        let coefficient = fall / (S::from_f64(4.0) * gain * gain);
        Self { coefficient, sine_square: gain * square, samples, resolved }
    }

    /// The corrected sample, from the samples before and after it.
    #[inline]
    pub(super) fn compensate(&self, sample: S, bend: S) -> S {
        sample - self.coefficient * bend
    }
}

/// The figure for the error of the mean power by interpolation over `seconds`, relative: 0 at time zero and after whole
/// periods at rest. `None` if the rate is too low for one, and before the first period has ended.
pub(super) fn sampling_error<S: Scalar>(
    response: &Response<S>,
    droop: &Droop<S>,
    interpolation: Interpolation,
    seconds: S,
) -> Option<S> {
    let figure = response.frequencies().map_or(S::ZERO, |frequencies| {
        let [linear, filtered] = COVERAGE.map(S::from_f64);
        let of_amplitude = match interpolation {
            Interpolation::Linear => linear * weakened(frequencies[0]),
            Interpolation::DroopCompensated => filtered * residual(frequencies, droop.sine_square),
        };
        response.gain() * of_amplitude
    });
    let known = response.has_whole_period() || seconds == S::ZERO;
    (droop.resolved && known).then_some(figure)
}

/// Half of the relative loss of power by linear interpolation of a sine, `(1/G² − 1)/2`, from `sin² x`.
pub(super) fn weakened<S: Scalar>(sine_square: S) -> S {
    let sine = sine_square.sqrt();
    // Below this value the quotient is 1 + sin²/6.
    let small = S::from_f64(1e-2);
    let ratio =
        if sine > small { arcsine(sine) / sine } else { S::ONE + S::from_f64(1.0 / 6.0) * sine_square };
    let square = ratio * ratio;
    S::from_f64(0.5) * (square * square - S::ONE)
}

/// Largest mean residual of the filter, relative to the amplitude: `8/45 · |u (u_r − u)|` for a sine. For a spectrum,
/// by the inequality of Cauchy and Schwarz, in which nothing cancels.
fn residual<S: Scalar>([sine_squares, sine_fourths]: [S; 2], resonance: S) -> S {
    let off_resonance = sine_fourths - (resonance + resonance) * sine_squares + resonance * resonance;
    S::from_f64(RESIDUAL) * (sine_fourths * off_resonance.max(S::ZERO)).sqrt()
}

/// Statement over the predicted change of the amplitude by what is proportional to the signal, and by noise. Fitted on
/// some random inputs and tested on others: docs/energy.md.
const SENSOR_COVERAGE: [f64; 2] = [3.0, 2.0];
/// Fundamental of a square wave of the height 1/2 over the root mean square of a sine of the amplitude 1: `√2/π`.
const OF_CUT: f64 = 0.45;
/// Loss of amplitude by jitter over that by linear interpolation, per square of the jitter.
const OF_JITTER: f64 = 6.0;

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// The figures for the error of the mean power over `seconds` by the noise of the samples and by the rate, relative.
    ///
    /// The step `q` and the jitter `j`, in intervals, are noise of the samples, of the variance `n² = q²/12 + j² ⟨Δa²⟩` with the
    /// change `Δa` from sample to sample. At the interval `T` it moves a resonator of the decay rate `d` by `⟨v²⟩ = n² T/(4 d)`.
    /// A converter that cuts off takes up to `q/2` from a signal besides, and jitter weakens a sine by `6 j²` of what linear
    /// interpolation does. A rate that is off by the part `t` shifts the input by `t w` against the resonance `w`
    /// ([`largest_change`]; derived here).
    pub(super) fn sensor_errors(&self, seconds: S) -> [S; 2] {
        let Settings { format, jitter, .. } = self.settings;
        let response = &self.state.response;
        // The decay rate, or that of the integrated time if that is faster.
        let decay = self.harvester.decay_rate().max(S::ONE / seconds.max(S::TINY));
        let of_rate = largest_change(self.state.rate_tolerance * self.harvester.angular_frequency() / decay);
        let (step_square, jitter_square) = (format.resolution * format.resolution, jitter * jitter);
        let Some([velocity, sample, rise]) = response.mean_squares(self.droop.samples) else {
            return [S::ZERO, response.gain() * of_rate];
        };
        let sine_squares = response.frequencies().map_or(S::ZERO, |[sine_squares, _]| sine_squares);
        let of_signal = S::from_f64(OF_CUT) * (step_square / sample.max(S::TINY)).sqrt()
            + S::from_f64(OF_JITTER) * jitter_square * weakened(sine_squares);
        let variance = S::from_f64(1.0 / 12.0) * step_square + jitter_square * rise;
        // Energy of the noise over that of the motion, and the mean of their product.
        let of_noise = variance / (S::from_f64(4.0) * self.rate() * decay * velocity).max(S::TINY);
        let of_both = (of_noise / (decay * seconds).max(S::ONE)).sqrt();
        let [for_signal, for_noise] = SENSOR_COVERAGE.map(S::from_f64);
        [for_signal * of_signal + for_noise * (of_both + of_noise), of_rate]
            .map(|part| response.gain() * part)
    }
}

/// The largest relative change of the power of a linear resonator by a shift of the input in decay rates, `e`: `e r` with
/// `r = (e + √(e² + 4))/2`, between frequencies at `r` and `1/r` decay rates from the resonance.
fn largest_change<S: Scalar>(shift: S) -> S {
    S::from_f64(0.5) * shift * (shift + (shift * shift + S::from_f64(4.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::accumulator::EnergyAccumulator;
    use super::*;
    use core::f64::consts::PI;

    /// `sin² x/x²`.
    fn gain(x: f64) -> f64 {
        (x.sin() / x).powi(2)
    }

    #[test]
    fn the_filter_undoes_the_droop_at_the_resonance_and_nearly_so_elsewhere() {
        for samples_per_period in [4.0, 5.0, 11.1, 20.0, 100.0, 1000.0] {
            let x = PI / samples_per_period;
            let droop = Droop::new(2.0 * x, 1.0);
            let small = Droop::new(2.0 * x as f32, 1.0);
            assert!((droop.sine_square - x.sin().powi(2)).abs() < 1e-7, "{samples_per_period}");
            assert_eq!(droop.samples, (samples_per_period + 0.5) as u32);
            let at = |x: f64| gain(x) * (1.0 + 4.0 * droop.coefficient * x.sin().powi(2));
            assert!((at(x) - 1.0).abs() < 1e-6, "{samples_per_period}: {}", at(x));
            assert!((at(0.5 * x) - 1.0).abs() < 0.1 * x.powi(4) + 1e-6);
            assert!((f64::from(small.coefficient) - droop.coefficient).abs() < 1e-7);
            assert!(droop.resolved && small.resolved);
        }
        assert!(!Droop::new(2.0 * PI, 3.9).resolved);
    }

    #[test]
    fn the_error_of_a_linear_harvester_under_one_sine_is_predicted() {
        // A velocity whose amplitude rises evenly from period to period, and a power that is its square.
        for samples_per_period in [5.0_f32, 11.1, 40.0] {
            let x = PI / f64::from(samples_per_period);
            let droop = Droop::new(2.0 * x as f32, 1.0);
            let at = |n: u32| (1.0 + 1e-4 * f64::from(n)) * (2.0 * x * f64::from(n)).sin();
            let (mut response, mut accumulator) = (Response::default(), EnergyAccumulator::default());
            for n in 0..5000 {
                accumulator.add(1e-6 * at(n).powi(2) as f32, 1);
                response.add(at(n) as f32, [0.0; 2], (droop.samples, false), &mut accumulator);
            }
            let gain = response.gain();
            assert!((gain - 2.0).abs() < 1e-2, "{gain}");
            let error = |interpolation| {
                f64::from(sampling_error(&response, &droop, interpolation, 1.0).expect("resolved"))
            };
            let figure = error(Interpolation::Linear) / COVERAGE[0];
            let excess = super::tests::gain(x).powi(-2) - 1.0;
            assert!((figure / excess - 1.0).abs() < 2e-2, "{samples_per_period}: {figure} {excess}");
            // At the resonance the filter leaves nothing; the statement, far less than without the filter.
            let left = error(Interpolation::DroopCompensated) / COVERAGE[1];
            assert!(left < 0.05 * excess, "{samples_per_period}: {left} {excess}");
        }
    }

    #[test]
    fn the_residual_of_the_filter_is_that_of_a_sine_beside_the_resonance() {
        let droop = Droop::new(2.0 * PI / 12.0, 1.0);
        for samples_per_period in [8.0, 10.0, 15.0, 30.0] {
            let x: f64 = PI / samples_per_period;
            let u = x.sin().powi(2);
            let exact = (gain(x) * (1.0 + 4.0 * droop.coefficient * u) - 1.0).abs();
            let found = residual([u, u * u], droop.sine_square);
            assert!((found / exact - 1.0).abs() < 0.1, "{samples_per_period}: {found} {exact}");
        }
    }

    #[test]
    fn the_gain_is_the_exponent_of_the_power() {
        let droop = Droop::new(2.0 * PI / 20.0, 1.0);
        let (mut response, mut accumulator) = (Response::default(), EnergyAccumulator::default());
        for n in 0..4000 {
            let amplitude = 1.0 + 0.05 * (1e-3 * f64::from(n)).sin();
            let velocity = amplitude * (2.0 * PI / 20.0 * f64::from(n)).sin();
            // The fourth power of the amplitude.
            accumulator.add(amplitude.powi(2) * velocity.powi(2), 1);
            response.add(velocity, [0.0; 2], (droop.samples, false), &mut accumulator);
        }
        assert!((response.gain() - 4.0).abs() < 0.1, "{}", response.gain());
        assert_eq!(response.irregularity(None), 0.0);
        // Unknown before three periods, and the least of all motions without motion.
        assert_eq!(Response::<f32>::default().gain(), 20.0);
    }

    #[test]
    fn the_error_is_unknown_until_a_period_has_ended_and_zero_after_periods_at_rest() {
        let droop = Droop::new(2.0 * PI / 20.0, 1.0);
        for interpolation in [Interpolation::Linear, Interpolation::DroopCompensated] {
            for (velocity, rests) in [(0.0, true), (1.0, false)] {
                let (mut response, mut accumulator) = (Response::default(), EnergyAccumulator::default());
                let error = |response: &Response<f64>, seconds| {
                    sampling_error(response, &droop, interpolation, seconds)
                };
                assert_eq!(error(&response, 0.0), Some(0.0));
                for n in 1..=20 {
                    assert_eq!(error(&response, f64::from(n)), None, "{n}");
                    response.add(velocity, [0.0; 2], (droop.samples, false), &mut accumulator);
                }
                assert_eq!(error(&response, 20.0).map(|error| error == 0.0), Some(rests));
                response.clear(false);
                assert_eq!((error(&response, 0.0), error(&response, 1.0)), (Some(0.0), None));
            }
        }
    }
}

#[cfg(test)]
mod tests_of_sensor {
    use super::*;

    #[test]
    fn the_largest_change_is_that_of_all_pairs_of_frequencies() {
        for shift in [1e-2, 0.3, 10.0] {
            let power = |off: f64| 1.0 / (off * off + 1.0);
            let offs = (-20_000..20_000).map(|n| 1e-3 * f64::from(n));
            let largest = offs.map(|off| power(off) / power(off + shift) - 1.0).fold(0.0, f64::max);
            assert!((largest_change(shift) / largest - 1.0).abs() < 1e-3, "{shift}: {largest}");
        }
    }
}
