//! The reading of an accelerometer: a value, a lower bound of its magnitude, or no value.

use crate::bounds::{Bounds, ParameterError};
use crate::excitation::is_acceleration;
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// One sample of the acceleration of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Sample<S> {
    /// The acceleration in m/s².
    Good(S),
    /// The end of the sensor's range in m/s²: the magnitude of the acceleration is at least that of the end.
    Saturated(S),
    /// The sample was lost.
    Missing,
}

/// The conversion of an accelerometer's readings to accelerations, and the limits of its range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SampleFormat<S> {
    /// Acceleration per count in m/s², 10⁻⁹ to 10⁶ in magnitude; a negative value reverses the axis.
    pub scale: S,
    /// Acceleration at a count of zero in m/s², at most 10⁶ in magnitude: minus the reading at rest, which is
    /// the bias of the sensor and gravity.
    pub offset: S,
    /// Step of the converter in m/s², 0 to 10⁶: 0 if it does not matter.
    pub resolution: S,
    /// Magnitude of a raw count from which the sensor is saturated, 1 to 32 768.
    pub count_limit: u16,
    /// Magnitude of an acceleration in m/s² from which the sensor is saturated, 10⁻⁹ to infinity.
    pub range: S,
}

impl<S: Scalar> SampleFormat<S> {
    /// Readings in m/s² in steps of `resolution` in m/s², 0 if that does not matter, of a sensor that is saturated from
    /// `range` in m/s²; infinite for a sensor without limit.
    #[must_use]
    pub fn accelerations(range: S, resolution: S) -> Self {
        Self { scale: S::ONE, offset: S::ZERO, resolution, count_limit: 1 << 15, range }
    }

    /// Raw counts of `scale` in m/s² with zero at rest, saturated from `count_limit`. A sensor of fewer bits whose count is
    /// a multiple has a larger [`SampleFormat::resolution`].
    #[must_use]
    pub fn counts(scale: S, count_limit: u16) -> Self {
        Self { scale, offset: S::ZERO, resolution: scale.abs(), count_limit, range: S::INFINITY }
    }

    /// The sample of a raw count.
    #[inline]
    pub(crate) fn of_count(&self, count: i16) -> Sample<S> {
        let (count, limit) = (i32::from(count), i32::from(self.count_limit));
        let clipped = count.max(-limit).min(limit);
        let saturated = count.unsigned_abs() >= u32::from(self.count_limit);
        match self.of_acceleration(self.scale * S::from_i32(clipped) + self.offset) {
            Sample::Good(acceleration) if saturated => Sample::Saturated(acceleration),
            sample => sample,
        }
    }

    /// The sample of a reading in m/s²; a reading that is not finite or beyond 10⁶ is missing.
    #[inline]
    pub(crate) fn of_acceleration(&self, acceleration: S) -> Sample<S> {
        if !is_acceleration(acceleration) {
            Sample::Missing
        } else if acceleration.abs() < self.range {
            Sample::Good(acceleration)
        } else {
            Sample::Saturated(acceleration.max(-self.range).min(self.range))
        }
    }

    pub(super) fn check(&self) -> Result<(), ParameterError<S>> {
        Bounds::new(1e-9, 1e6).check("magnitude of scale", self.scale.abs())?;
        Bounds::new(-1e6, 1e6).check("offset", self.offset)?;
        Bounds::new(0.0, 1e6).check("resolution", self.resolution)?;
        Bounds::new(1.0, 32_768.0).check("count_limit", S::from_u32(self.count_limit.into()))?;
        Bounds { lowest: S::from_f64(1e-9), highest: S::INFINITY }.check("range", self.range)
    }

    pub(super) fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.numbers(&[self.scale, self.offset, self.resolution, self.range]);
        fingerprint.count(self.count_limit.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_the_range_is_saturated_on_both_sides() {
        let format = SampleFormat { offset: 0.5_f32, ..SampleFormat::counts(0.01, 1000) };
        assert_eq!(format.of_count(100), Sample::Good(1.5));
        assert_eq!(format.of_count(999), Sample::Good(10.49));
        assert_eq!(format.of_count(1000), Sample::Saturated(10.5));
        assert_eq!(format.of_count(i16::MAX), Sample::Saturated(10.5));
        assert_eq!(format.of_count(i16::MIN), Sample::Saturated(-9.5));
        let whole = SampleFormat::counts(1.0_f64, 1 << 15);
        assert_eq!(whole.of_count(i16::MAX), Sample::Good(32_767.0));
        assert_eq!(whole.of_count(i16::MIN), Sample::Saturated(-32_768.0));
        let format = SampleFormat::accelerations(20.0_f32, 0.0);
        assert_eq!(format.of_acceleration(-19.9), Sample::Good(-19.9));
        assert_eq!(format.of_acceleration(25.0), Sample::Saturated(20.0));
        assert_eq!(format.of_acceleration(-20.0), Sample::Saturated(-20.0));
        assert_eq!(format.of_acceleration(f32::NAN), Sample::Missing);
        assert_eq!(format.of_acceleration(f32::INFINITY), Sample::Missing);
        let format = SampleFormat::accelerations(f32::INFINITY, 0.0);
        assert_eq!(format.of_acceleration(-1e6), Sample::Good(-1e6));
        assert_eq!(format.of_acceleration(1e30), Sample::Missing);
    }

    #[test]
    fn formats_out_of_bounds_are_named() {
        let refused = |change: fn(&mut SampleFormat<f64>)| {
            let mut format = SampleFormat::counts(1e-3, 2048);
            change(&mut format);
            format.check().err().map(|error| error.field)
        };
        assert_eq!(refused(|_| ()), None);
        assert_eq!(refused(|f| f.scale = 0.0), Some("magnitude of scale"));
        assert_eq!(refused(|f| f.scale = -1.0), None);
        assert_eq!(refused(|f| f.offset = f64::NAN), Some("offset"));
        assert_eq!(refused(|f| f.count_limit = 0), Some("count_limit"));
        assert_eq!(refused(|f| f.range = -1.0), Some("range"));
    }
}
