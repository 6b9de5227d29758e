//! The error of the mean power by the sensor: the steps of its converter, the jitter and the rate of its clock.
//!
//! The step `q` and the jitter `j`, in intervals, are noise of the samples, of the variance `n² = q²/12 + j² ⟨Δa²⟩` with the
//! change `Δa` from sample to sample. At the interval `T` it moves a resonator of the decay rate `d` by `⟨v²⟩ = n² T/(4 d)`.
//! A converter that cuts off takes up to `q/2` from a signal besides, and jitter weakens a sine by `6 j²` of what linear
//! interpolation does. A rate that is off by the part `t` shifts the input by `t w` against the resonance `w`
//! ([`largest_change`]; derived here).

use super::sampling::weakened;
use super::{Estimator, Settings};
use crate::scalar::Scalar;
use crate::scene::Harvester;

/// Statement over the predicted change of the amplitude by what is proportional to the signal, and by noise. Fitted on
/// some random inputs and tested on others: docs/energy.md.
const COVERAGE: [f64; 2] = [3.0, 2.0];
/// Fundamental of a square wave of the height 1/2 over the root mean square of a sine of the amplitude 1: `√2/π`.
const OF_CUT: f64 = 0.45;
/// Loss of amplitude by jitter over that by linear interpolation, per square of the jitter.
const OF_JITTER: f64 = 6.0;

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// The figures for the error of the mean power over `seconds` by the noise of the samples and by the rate, relative.
    pub(super) fn sensor_errors(&self, seconds: S) -> [S; 2] {
        let Settings { format, jitter, .. } = self.settings;
        let response = &self.state.response;
        // The decay rate, or that of the integrated time if that is faster.
        let decay = self.harvester.decay_rate().max(S::ONE / seconds.max(S::TINY));
        let of_rate = largest_change(self.state.rate_tolerance * self.harvester.angular_frequency() / decay);
        let (step_square, jitter_square) = (format.resolution * format.resolution, jitter * jitter);
        let Some([velocity, sample, rise]) = response.mean_squares(self.droop.samples_per_period()) else {
            return [S::ZERO, response.gain() * of_rate];
        };
        let sine_squares = response.frequencies().map_or(S::ZERO, |found| found.sine_squares);
        let of_signal = S::from_f64(OF_CUT) * (step_square / sample.max(S::TINY)).sqrt()
            + S::from_f64(OF_JITTER) * jitter_square * weakened(sine_squares);
        let variance = S::from_f64(1.0 / 12.0) * step_square + jitter_square * rise;
        // Energy of the noise over that of the motion, and the mean of their product.
        let of_noise = variance / (S::from_f64(4.0) * self.rate() * decay * velocity).max(S::TINY);
        let of_both = (of_noise / (decay * seconds).max(S::ONE)).sqrt();
        let [for_signal, for_noise] = COVERAGE.map(S::from_f64);
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
