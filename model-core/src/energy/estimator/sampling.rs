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

use crate::scalar::{CompensatedSum, Scalar, arcsine, horner};
use crate::snapshot::snapshot_fields;

/// The acceleration between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Interpolation {
    /// Linear between the samples: the mean power is too low, by 1.6 % with 20 samples in a resonance period and by
    /// 23 % with 5.
    Linear,
    /// Linear between samples that a filter of three samples corrects, exactly at the resonance of the harvester.
    #[default]
    DroopCompensated,
}

/// Samples per resonance period below which no figure for the sampling is stated: [`Uncertainty::sampling`].
///
/// [`Uncertainty::sampling`]: super::Uncertainty::sampling
pub const LEAST_SAMPLES_PER_PERIOD: u32 = 4;

/// The largest `x`, at [`LEAST_SAMPLES_PER_PERIOD`].
const LARGEST_HALF_TURN: f64 = core::f64::consts::PI / LEAST_SAMPLES_PER_PERIOD as f64;
/// Figure over the excess of power at the resonance and at the mean frequency of the samples, for linear
/// interpolation. Calibrated, as the next one: docs/energy.md.
const OF_LINEAR: f64 = 2.3;
/// Figure over the square of the filter's largest change, with the filter.
const OF_COMPENSATED: f64 = 4.0;

/// The harvester's resonance in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Droop<S> {
    /// `G` at the resonance.
    gain: S,
    /// `c`.
    coefficient: S,
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
        Self { gain, coefficient: fall / (S::from_f64(4.0) * gain * gain), resolved }
    }

    /// The corrected sample, from the samples before and after it.
    #[inline(always)]
    pub(super) fn compensate(&self, sample: S, bend: S) -> S {
        sample - self.coefficient * bend
    }
}

/// Mean squares of the first and second differences of the samples: the frequencies that they contain, without bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Content<S> {
    slopes: CompensatedSum<S>,
    bends: CompensatedSum<S>,
}

impl<S: Scalar> Content<S> {
    /// Adds a first and a second difference in m/s².
    #[inline(always)]
    pub(super) fn add(&mut self, slope: S, bend: S) {
        self.slopes.add(slope * slope);
        self.bends.add(bend * bend);
    }

    /// The mean of `4 sin² x` over the samples, weighted by their squared slopes: 0 to 4.
    fn bend_per_slope(&self) -> S {
        let slopes = self.slopes.value();
        if slopes > S::ZERO { (self.bends.value() / slopes).min(S::from_f64(4.0)) } else { S::ZERO }
    }

    /// The figure for the error of the mean power by interpolation, relative; `None` if the rate is too low for one.
    pub(super) fn error(&self, droop: &Droop<S>, interpolation: Interpolation) -> Option<S> {
        let content = self.bend_per_slope();
        let figure = match interpolation {
            Interpolation::Linear => {
                let sine = (S::from_f64(0.25) * content).sqrt();
                let ratio = arcsine(sine) / sine.max(S::TINY);
                let of_content =
                    if sine > S::from_f64(1e-3) { ratio * ratio * ratio * ratio } else { S::ONE };
                let of_resonance = S::ONE / (droop.gain * droop.gain);
                S::from_f64(OF_LINEAR) * ((of_content - S::ONE) + (of_resonance - S::ONE))
            }
            Interpolation::DroopCompensated => {
                let change = droop.coefficient * content;
                S::from_f64(OF_COMPENSATED) * change * change
            }
        };
        droop.resolved.then_some(figure)
    }
}

snapshot_fields!(impl [S: Scalar] Content<S> { slopes, bends });

#[cfg(test)]
mod tests {
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
            assert!((droop.gain - gain(x)).abs() < 1e-7, "{samples_per_period}");
            let at = |x: f64| gain(x) * (1.0 + 4.0 * droop.coefficient * x.sin().powi(2));
            assert!((at(x) - 1.0).abs() < 1e-6, "{samples_per_period}: {}", at(x));
            assert!((at(0.5 * x) - 1.0).abs() < 0.1 * x.powi(4) + 1e-6);
            assert!((f64::from(small.coefficient) - droop.coefficient).abs() < 1e-7);
            assert!(droop.resolved && small.resolved);
        }
        assert!(!Droop::new(2.0 * PI, 3.9).resolved);
    }

    #[test]
    fn a_tone_is_found_in_the_samples_whatever_their_bias() {
        let samples_per_period = 11.1;
        let mut content = Content::default();
        let at = |n: u32| 9.81_f32 + (2.0 * PI * f64::from(n) / samples_per_period).sin() as f32;
        for n in 2..5000 {
            content.add(at(n) - at(n - 1), at(n - 2) - 2.0 * at(n - 1) + at(n));
        }
        let x = PI / samples_per_period;
        let expected = 4.0 * x.sin().powi(2);
        assert!((f64::from(content.bend_per_slope()) / expected - 1.0).abs() < 1e-3);
        let droop = Droop::new(2.0 * x as f32, 1.0);
        let figure = content.error(&droop, Interpolation::Linear).expect("resolved");
        let excess = gain(x).powi(-2) - 1.0;
        assert!((f64::from(figure) / (OF_LINEAR * 2.0 * excess) - 1.0).abs() < 1e-2, "{figure}");
        assert_eq!(Content::<f32>::default().bend_per_slope(), 0.0);
    }
}
