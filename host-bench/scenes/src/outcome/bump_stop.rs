//! The numbers of a bump-stop run only.

use serde::Serialize;

use crate::rainflow::Rainflow;

/// Bending of the beam at its clamp over the window.
///
/// Stress and strain are of bending alone, in the outer fibre of each layer: without the stress of the electric field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClampOutcome {
    /// Largest magnitude of the curvature in 1/m.
    pub clamp_curvature_peak_per_m: f64,
    /// Root mean square of the curvature in 1/m.
    pub clamp_curvature_rms_per_m: f64,
    /// Largest magnitude of the strain of the substrate.
    pub clamp_strain_peak: f64,
    /// Largest magnitude of the stress of the substrate in Pa.
    pub clamp_stress_peak_pa: f64,
    /// Root mean square of the stress of the substrate in Pa.
    pub clamp_stress_rms_pa: f64,
    /// Largest range of the stress of the substrate in Pa, from a turning point to another.
    pub clamp_stress_largest_range_pa: f64,
    /// Rainflow cycles of the stress (ASTM E1049) of at least a tenth of the largest range.
    pub clamp_stress_cycles: f64,
    /// Range in Pa of the stress of the substrate whose cycles, one per second, do the same damage as the rainflow cycles
    /// by Miner's rule with an S–N curve of the exponent 5.
    pub clamp_stress_equivalent_range_pa: f64,
    /// Largest magnitude of the strain of the piezoelectric layer.
    pub piezo_clamp_strain_peak: f64,
    /// Largest magnitude of the stress of the piezoelectric layer in Pa.
    pub piezo_clamp_stress_peak_pa: f64,
    /// Root mean square of the stress of the piezoelectric layer in Pa.
    pub piezo_clamp_stress_rms_pa: f64,
}

/// Part of the largest range from which a cycle is counted.
const COUNTED: f64 = 0.1;
/// Exponent of the S–N curve of the equivalent range; 3 is usual of welds, 5 and more of smooth steel.
const EXPONENT: f64 = 5.0;

impl ClampOutcome {
    /// Of the largest magnitude and the RMS of the curvature in 1/m, its rainflow count over so many `seconds`, and of the function of each
    /// outer fibre, the substrate's first, from a curvature to the strain and the stress in Pa.
    pub fn new(
        [peak, rms]: [f64; 2],
        (curvature, seconds): (&Rainflow, f64),
        [substrate, piezo]: [impl Fn(f64) -> [f64; 2]; 2],
    ) -> Self {
        let [strain, stress] = substrate(peak);
        let [piezo_strain, piezo_stress] = piezo(peak);
        let [_, rms_stress] = substrate(rms);
        let [_, piezo_rms_stress] = piezo(rms);
        let [_, largest_range] = substrate(curvature.largest_range());
        let [_, equivalent_range] = substrate(curvature.equivalent_range(EXPONENT, seconds));
        Self {
            clamp_curvature_peak_per_m: peak,
            clamp_curvature_rms_per_m: rms,
            clamp_strain_peak: strain,
            clamp_stress_peak_pa: stress,
            clamp_stress_rms_pa: rms_stress,
            clamp_stress_largest_range_pa: largest_range,
            clamp_stress_cycles: curvature.cycles(COUNTED),
            clamp_stress_equivalent_range_pa: equivalent_range,
            piezo_clamp_strain_peak: piezo_strain,
            piezo_clamp_stress_peak_pa: piezo_stress,
            piezo_clamp_stress_rms_pa: piezo_rms_stress,
        }
    }
}

/// The numbers of a bump-stop run only.
///
/// Without a stop there are no contacts, and the numbers of the stop are `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BumpStopOutcome {
    /// Natural frequencies in Hz of the modes kept of the beam with its tip mass, short-circuit and undamped, rising.
    pub beam_natural_frequencies_hz: Vec<f64>,
    /// Natural frequencies in Hz of the modes kept of the rod, undamped, rising; empty without a stop.
    pub rod_natural_frequencies_hz: Vec<f64>,
    /// Largest magnitude in the window of the displacement of the beam's tip relative to the base, in m.
    pub peak_tip_displacement_m: Option<f64>,
    /// Largest magnitude in the window of the displacement in m of the beam at the stop; `None` without a stop.
    pub peak_stop_point_displacement_m: Option<f64>,
    /// Contacts that begin in the window: intervals with a force, and rigid impacts.
    pub contacts: u64,
    /// Contacts over periods in the window; `None` unless the base moves in one sine.
    pub contacts_per_period: Option<f64>,
    /// Part of the window during which beam and stop are in contact.
    pub contact_fraction: Option<f64>,
    /// Time of the first contact of the run in s; `None` without contacts.
    pub first_contact_s: Option<f64>,
    /// Largest contact force in the window in N, without rigid impacts, which have none; `None` without a stop.
    pub peak_force_n: Option<f64>,
    /// Mean contact force over the window in N, the momentum of impacts included; `None` without a stop.
    pub mean_force_n: Option<f64>,
    /// Bending at the clamp; `None` by TR-BDF2, the Runge-Kutta method and Newmark's.
    #[serde(flatten)]
    pub clamp: Option<ClampOutcome>,
    /// State at the end of the run, scaled so that half the sum of squares is the energy in J of motion and
    /// charge: `ω r` and `r'` of each mode, the beam's first, and `√C v`. Not part of the JSON object.
    #[serde(skip)]
    pub end_state: Vec<f64>,
}

/// Columns of a recording of a bump-stop run. Without a stop the two columns of the stop are not-a-number.
pub const BUMP_STOP_COLUMNS: [&str; 7] = [
    "time_s",
    "tip_displacement_m",
    "stop_point_displacement_m",
    "rod_tip_displacement_m",
    "voltage_v",
    "contact_force_n",
    "base_acceleration_m_per_s2",
];
