//! The shipped scene at another charge density and load, and its resonance.

use crate::embedded::resonance_peak;
use crate::method::{Failure, Options};
use crate::scene_file::{Load, Scene};
use crate::steady_state::Resonance;

use super::TOLERANCE;

/// Range of frequencies in Hz that contains all peaks, and number of frequencies of the scan. The range goes from 30 mHz
/// below the lowest peak to 20 mHz above the natural frequency of the shipped beam.
const AROUND_PEAKS: ([f64; 2], usize) = ([18.31, 18.40], 10);

/// The values that differ from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Case {
    /// Tribo-charge density in µC/m².
    pub charge_density: f64,
    /// Load resistance in Ω; 0 is a short circuit.
    pub resistance: f64,
}

/// The peak of the steady state over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Peak {
    pub case: Case,
    /// Frequency in Hz at which the amplitude is largest.
    pub frequency_hz: f64,
    /// That amplitude in m, half the distance of the extremes.
    pub amplitude_m: f64,
    /// Largest RMS voltage over frequency, in V.
    pub rms_voltage_v: f64,
}

impl Case {
    /// The steady states over `points` frequencies between two in Hz, and the peaks.
    pub(crate) fn resonance(
        &self,
        base: &Scene,
        range: [f64; 2],
        points: usize,
    ) -> Result<Resonance, Failure> {
        let load = Load::Resistor { resistance_ohm: self.resistance };
        let mut scene = Scene { load, ..base.clone() };
        scene.sliding_mut()?.parameters.charge_density_c_per_m2 = self.charge_density * 1e-6;
        let options = Options { tolerance: Some(TOLERANCE), ..Options::default() };
        let at = format!("{} uC/m^2, {} ohm", self.charge_density, self.resistance);
        let (found, _) =
            resonance_peak(&scene, range, points, &options).map_err(|failure| failure.of_case(&at))?;
        found.ok_or_else(|| {
            Failure::Step(format!("{at}: no stable orbit of one period from {} to {} Hz", range[0], range[1]))
        })
    }

    /// The peak of the steady state over frequency.
    pub(crate) fn peak(&self, base: &Scene) -> Result<Peak, Failure> {
        let (range, points) = AROUND_PEAKS;
        let found = self.resonance(base, range, points)?;
        // Without a voltage the place of the largest voltage has no meaning.
        let silent = found.rms_voltage.value == 0.0;
        if found.amplitude.at_edge || (found.rms_voltage.at_edge && !silent) {
            return Err(Failure::Step(format!(
                "{} uC/m^2, {} ohm: the peak is not between {} and {} Hz",
                self.charge_density, self.resistance, range[0], range[1]
            )));
        }
        Ok(Peak {
            case: *self,
            frequency_hz: found.amplitude.frequency_hz,
            amplitude_m: found.amplitude.value,
            rms_voltage_v: found.rms_voltage.value,
        })
    }
}
