//! A one-sided spectral density, straight between points in logarithmic axes.

use super::ExcitationError;
use crate::bounds::Bounds;
use crate::scalar::{Mathematics, Scalar, logarithm};

/// Frequencies of a spectral density in Hz.
pub const DENSITY_FREQUENCY: Bounds<f64> = Bounds { lowest: 1e-3, highest: 1e5 };
/// Values of a spectral density in (m/s²)²/Hz.
const SPECTRAL_DENSITY: Bounds<f64> = Bounds { lowest: 1e-12, highest: 1e8 };

/// Least quotient of the frequencies of two neighbouring points.
const LEAST_QUOTIENT: f64 = 1.001;

/// A one-sided spectral density of acceleration, `S(f)` in (m/s²)²/Hz, as vibration standards give it.
///
/// Between two points `ln S` is linear in `ln f`: a constant number of decibels for each octave. Below the first and
/// above the last point the density is 0. The mean square of the acceleration is `∫ S df`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralDensity<'a, S> {
    points: &'a [[S; 2]],
}

impl<'a, S: Scalar> SpectralDensity<'a, S> {
    /// The density through `points`, each a frequency in Hz and a density in (m/s²)²/Hz.
    ///
    /// # Errors
    /// Fewer than two points, a frequency that is not above that of the point before by at least a thousandth, or a number out
    /// of [`DENSITY_FREQUENCY`] or a density out of 10⁻¹² to 10⁸; the error has the index of the point.
    pub fn new(points: &'a [[S; 2]]) -> Result<Self, ExcitationError> {
        if points.len() < 2 {
            return Err(ExcitationError::TooFewPoints);
        }
        let within = |value: S, bounds: Bounds<f64>| {
            value >= S::from_f64(bounds.lowest) && value <= S::from_f64(bounds.highest)
        };
        let mut last = S::ZERO;
        for (index, &[frequency, density]) in (0..points.len()).zip(points) {
            let valid = within(frequency, DENSITY_FREQUENCY) && within(density, SPECTRAL_DENSITY);
            // In a narrower band rounding moves the lines.
            if !(valid && frequency >= last * S::from_f64(LEAST_QUOTIENT)) {
                return Err(ExcitationError::Point { index });
            }
            last = frequency;
        }
        Ok(Self { points })
    }

    /// The lowest and the highest frequency in Hz.
    #[must_use]
    pub fn band(&self) -> [S; 2] {
        let frequency = |point: Option<&[S; 2]>| point.map_or(S::ONE, |&[frequency, _]| frequency);
        [frequency(self.points.first()), frequency(self.points.last())]
    }

    /// The pairs of neighbouring points.
    fn segments(&self) -> impl Iterator<Item = [[S; 2]; 2]> {
        let from = self.points.iter().copied();
        from.zip(self.points.iter().copied().skip(1)).map(|(from, to)| [from, to])
    }

    /// The density in (m/s²)²/Hz at a frequency in Hz; 0 outside the band.
    #[must_use]
    pub fn at(&self, frequency: S) -> S {
        let mut segments = self.segments();
        let around = segments.find(|[[low, _], [high, _]]| frequency >= *low && frequency <= *high);
        around.map_or(S::ZERO, |[[low, left], [high, right]]| {
            let slope = logarithm(right / left) / logarithm(high / low);
            left * S::Build::exponential(slope * logarithm(frequency / low))
        })
    }

    /// The mean square of the acceleration in (m/s²)², `∫ S df`.
    ///
    /// With `L = ln(f₂/f₁)` and `z = L + ln(S₂/S₁)` a segment has `f₁ S₁ L (eᶻ − 1)/z`, at every slope; −1 has `z = 0`.
    #[must_use]
    pub fn mean_square(&self) -> S {
        self.segments().fold(S::ZERO, |sum, [[low, left], [high, right]]| {
            let length = logarithm(high / low);
            sum + low * left * length * mean_exponential(length + logarithm(right / left))
        })
    }
}

/// `(eᶻ − 1)/z`: the mean of `e^x` from 0 to `z`.
fn mean_exponential<S: Scalar>(z: S) -> S {
    if z.abs() > S::from_f64(0.5) {
        return (S::Build::exponential(z) - S::ONE) / z;
    }
    // `1 + z/2! + z²/3! + …`: the difference would cancel.
    (2..=14_u32).rev().fold(S::ONE, |sum, n| S::ONE + z / S::from_u32(n) * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ S df` by Simpson's rule in `ln f`.
    fn by_quadrature(density: &SpectralDensity<'_, f64>) -> f64 {
        density.segments().fold(0.0, |sum, [[low, _], [high, _]]| {
            const PARTS: u32 = 2000;
            let length = (high / low).ln() / f64::from(PARTS);
            let value = |k: u32| {
                let frequency = (low * (f64::from(k) * length).exp()).clamp(low, high);
                frequency * density.at(frequency)
            };
            let simpson = |k: u32| match k {
                0 | PARTS => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            sum + (0..=PARTS).map(|k| simpson(k) * value(k)).sum::<f64>() * length / 3.0
        })
    }

    #[test]
    fn the_mean_square_is_the_integral_at_any_slope() {
        // Flat, slopes of −1, 3, −12 and nearly −1, in both precisions.
        let slopes: [&[[f64; 2]]; 6] = [
            &[[20.0, 0.3], [50.0, 0.3]],
            &[[20.0, 1.0], [200.0, 0.1]],
            &[[10.0, 1e-3], [20.0, 8e-3]],
            &[[1.0, 1e8], [1e3, 1e-12]],
            &[[20.0, 1.0], [200.0, 0.1001]],
            &[[10.0, 0.015], [40.0, 0.015], [500.0, 0.000_15]],
        ];
        for points in slopes {
            let density = SpectralDensity::new(points).expect("valid");
            let exact = by_quadrature(&density);
            assert!((density.mean_square() / exact - 1.0).abs() < 1e-8, "{points:?}: {exact}");
            let single: Vec<[f32; 2]> = points.iter().map(|point| point.map(|value| value as f32)).collect();
            let single = SpectralDensity::new(&single).expect("valid");
            assert!((f64::from(single.mean_square()) / exact - 1.0).abs() < 1e-5, "{points:?}");
        }
        let flat = SpectralDensity::new(slopes[0]).expect("valid");
        assert!((flat.mean_square() - 9.0).abs() < 1e-14);
        // A slope of −1: `f₁ S₁ ln(f₂/f₁)`.
        let pink = SpectralDensity::new(slopes[1]).expect("valid");
        assert!((pink.mean_square() - 20.0 * 10f64.ln()).abs() < 1e-13);
        // The curve for road transport in MIL-STD-810, vertical, has 1.04 g root mean square.
        let truck = SpectralDensity::new(slopes[5]).expect("valid");
        assert!((truck.mean_square().sqrt() - 1.04).abs() < 0.005);
    }

    #[test]
    fn the_density_is_straight_in_logarithms_and_zero_outside() {
        let points = [[10.0_f64, 0.015], [40.0, 0.015], [500.0, 0.000_15]];
        let density = SpectralDensity::new(&points).expect("valid");
        assert_eq!([density.at(9.999), density.at(500.1)], [0.0, 0.0]);
        assert!((density.at(20.0) - 0.015).abs() < 1e-16);
        let middle = (40.0_f64 * 500.0).sqrt();
        assert!((density.at(middle) / (0.015_f64 * 0.000_15).sqrt() - 1.0).abs() < 1e-14);
        assert_eq!(density.band(), [10.0, 500.0]);
    }

    #[test]
    fn bad_densities_are_refused_with_their_point() {
        let refuse = |points: &[[f32; 2]]| SpectralDensity::new(points).err();
        assert_eq!(refuse(&[[10.0, 1.0]]), Some(ExcitationError::TooFewPoints));
        for bad in [
            [10.0, 1.0],
            [9.0, 1.0],
            [20.0, 0.0],
            [20.0, -1.0],
            [20.0, f32::NAN],
            [f32::NAN, 1.0],
            [2e5, 1.0],
        ] {
            assert_eq!(refuse(&[[10.0, 1.0], bad, [30.0, 1.0]]), Some(ExcitationError::Point { index: 1 }));
        }
    }
}
