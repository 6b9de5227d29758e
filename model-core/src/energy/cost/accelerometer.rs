//! Current, start-up and FIFO of an accelerometer.

use super::Evidence::Confirmed;
use super::Figure;
use crate::scalar::Scalar;

/// A supply current at a sample rate.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RatedCurrent<S> {
    /// Sample rate in Hz.
    pub rate: S,
    /// Supply current in A.
    pub current: Figure<S>,
}

/// An accelerometer as data.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Accelerometer<S> {
    /// Name of the part.
    pub name: &'static str,
    /// Supply voltage in V.
    pub supply: S,
    /// The current at the lowest known rate.
    pub slow: RatedCurrent<S>,
    /// The current at the highest known rate; equal to `slow` where one rate is known.
    pub fast: RatedCurrent<S>,
    /// Samples from switching on to the first valid one.
    pub start_up_samples: u32,
    /// Samples of all stored axes that the FIFO holds.
    pub fifo_samples: u32,
    /// Bits to transfer for each sample of all stored axes.
    pub bits_per_sample: u32,
}

impl<S: Scalar> Accelerometer<S> {
    /// Power at a sample rate in Hz, in W: the known currents, linear between their rates, the lower below.
    ///
    /// `None` for a rate that is not positive or above the highest known one.
    #[must_use]
    pub fn power(&self, rate: S) -> Option<S> {
        let (slow, fast) = (&self.slow, &self.fast);
        if !(rate > S::ZERO && rate <= fast.rate) {
            return None;
        }
        let current = if rate <= slow.rate {
            slow.current.value
        } else {
            let part = (rate - slow.rate) / (fast.rate - slow.rate);
            slow.current.value + part * (fast.current.value - slow.current.value)
        };
        Some(current * self.supply)
    }

    /// All accelerometers.
    #[must_use]
    pub fn all() -> [Self; 6] {
        [
            Self::adxl362(),
            Self::adxl367(),
            Self::bma400(),
            Self::lis2dw12(),
            Self::lis2dh12(),
            Self::iis3dwb(),
        ]
    }

    /// Analog Devices ADXL362. Its FIFO stores all three axes.
    #[must_use]
    pub fn adxl362() -> Self {
        let sheet = "ADXL362 data sheet";
        Self {
            name: "ADXL362",
            supply: S::from_f64(2.0),
            slow: rated(100.0, 1.8e-6, sheet),
            fast: rated(400.0, 3.0e-6, sheet),
            start_up_samples: 4,
            fifo_samples: 170,
            bits_per_sample: 48,
        }
    }

    /// Analog Devices ADXL367. Its FIFO stores one axis.
    #[must_use]
    pub fn adxl367() -> Self {
        let only = rated(100.0, 0.89e-6, "ADXL367 data sheet");
        Self {
            name: "ADXL367",
            supply: S::from_f64(2.0),
            slow: only,
            fast: only,
            start_up_samples: 4,
            fifo_samples: 512,
            bits_per_sample: 16,
        }
    }

    /// Bosch BMA400, low-power mode at 25 Hz and normal mode at 800 Hz.
    #[must_use]
    pub fn bma400() -> Self {
        let sheet = "BMA400 data sheet";
        Self {
            name: "BMA400",
            supply: S::from_f64(1.8),
            slow: rated(25.0, 0.85e-6, sheet),
            fast: rated(800.0, 14.5e-6, sheet),
            start_up_samples: 2,
            fifo_samples: 146,
            bits_per_sample: 56,
        }
    }

    /// ST LIS2DW12, low-power mode at 12.5 Hz and high-resolution mode at 1600 Hz.
    #[must_use]
    pub fn lis2dw12() -> Self {
        let sheet = "LIS2DW12 data sheet";
        Self {
            name: "LIS2DW12",
            supply: S::from_f64(1.8),
            slow: rated(12.5, 1.0e-6, sheet),
            fast: rated(1600.0, 90e-6, sheet),
            start_up_samples: 2,
            fifo_samples: 32,
            bits_per_sample: 48,
        }
    }

    /// ST LIS2DH12.
    #[must_use]
    pub fn lis2dh12() -> Self {
        let sheet = "LIS2DH12 data sheet";
        Self {
            name: "LIS2DH12",
            supply: S::from_f64(2.5),
            slow: rated(100.0, 10e-6, sheet),
            fast: rated(400.0, 36e-6, sheet),
            start_up_samples: 2,
            fifo_samples: 32,
            bits_per_sample: 48,
        }
    }

    /// ST IIS3DWB, a vibration sensor of 26.7 kHz.
    #[must_use]
    pub fn iis3dwb() -> Self {
        let only = RatedCurrent {
            rate: S::from_f64(26_700.0),
            current: Figure::new(1.1e-3, Confirmed, "IIS3DWB data sheet"),
        };
        Self {
            name: "IIS3DWB",
            supply: S::from_f64(3.0),
            slow: only,
            fast: only,
            start_up_samples: 270,
            fifo_samples: 438,
            bits_per_sample: 56,
        }
    }
}

/// `current` in A at `rate` in Hz by the maker's data sheet. The lengths of FIFO and start-up beside it are unconfirmed.
#[inline(always)] // the compiler converts the figures, not firmware in double precision
fn rated<S: Scalar>(rate: f64, current: f64, sheet: &'static str) -> RatedCurrent<S> {
    RatedCurrent { rate: S::from_f64(rate), current: Figure::new(current, Confirmed, sheet) }
}
