//! The coordinates of a map: its columns over frequency, its levels of amplitude.

use model_core::energy::response_map::{
    AMPLITUDE_OCTAVES, COLUMNS, FARTHEST, LEVELS_PER_OCTAVE, detuning, fixed, level,
};

use super::Request;
use crate::closed_form::estimate;
use crate::embedded::{damping_ratio, natural_frequency_hz};
use crate::method::{Failure, Precision};
use crate::scene_file::{Excitation, Scene, Tone};

/// Cells from the first to the last column.
const CELLS: u32 = COLUMNS as u32 - 1;
/// Most half-bandwidths from the resonance to an edge; a wider map has wider units.
const WIDEST: f64 = 63.0;
/// Frequencies at which the closed form is evaluated to find the resonance.
const SCAN: usize = 2001;

/// The coordinates of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Frequency of each column in Hz.
    pub frequencies: Vec<f64>,
    /// Lowest and highest amplitude in m/s².
    pub amplitudes: [f64; 2],
    /// The resonance in Hz, in the middle of the coordinate.
    pub centre_hz: f64,
    /// Unit of the detuning in Hz.
    pub half_bandwidth_hz: f64,
    pub(super) resonance: u32,
    pub(super) shift: i32,
    pub(super) slope: u32,
    pub(super) first: i32,
    pub(super) span: u32,
    /// Levels of the lowest and the highest amplitude.
    pub(super) levels: [i32; 2],
}

/// Level of an amplitude in m/s² as a real number.
pub(super) fn level_of(amplitude: f64) -> f64 {
    (amplitude.log2() + f64::from(AMPLITUDE_OCTAVES)) * f64::from(LEVELS_PER_OCTAVE)
}

/// Amplitude in m/s² of a level.
pub(super) fn amplitude_of(level: f64) -> f64 {
    (level / f64::from(LEVELS_PER_OCTAVE) - f64::from(AMPLITUDE_OCTAVES)).exp2()
}

impl Axes {
    /// Of a scene whose map is asked for.
    pub(super) fn new(scene: &Scene, request: &Request) -> Result<Self, Failure> {
        let [low, high] = request.frequencies;
        let (centre_hz, half_bandwidth_hz) = resonance(scene, request)?;
        let reach = (high - centre_hz).abs().max((centre_hz - low).abs());
        let half_bandwidth_hz = half_bandwidth_hz.max(reach / WIDEST);
        // A half-bandwidth of 2048 to 4096 units.
        let shift = (4095.0 / half_bandwidth_hz).log2().floor() as i32;
        let unit_hz = f64::from(-shift).exp2();
        let slope = (f64::from(1 << 24) * unit_hz / half_bandwidth_hz).round() as u32;
        let refuse = || Failure::Input(format!("--frequency {low}:{high}: must be narrower for a map"));
        let resonance = fixed(centre_hz as f32, shift).ok_or_else(refuse)?;
        let distance = |hertz: f64| {
            let units = fixed(hertz as f32, shift).ok_or_else(refuse)?;
            let distance = i64::from(units) - i64::from(resonance);
            i32::try_from(distance)
                .ok()
                .filter(|distance| distance.unsigned_abs() <= FARTHEST)
                .ok_or_else(refuse)
        };
        let [from, to] = [distance(low)?, distance(high)?];
        let first = detuning(from, slope);
        let span = (detuning(to, slope) - first).cast_unsigned();
        if span < 4 * CELLS {
            return Err(Failure::Input(format!(
                "--frequency {low}:{high}: must be wider, at least {:.3} half-bandwidths of {half_bandwidth_hz:.3} Hz",
                f64::from(4 * CELLS) / 4096.0
            )));
        }
        let frequencies = (0..=CELLS)
            .map(|column| {
                let target = first + (f64::from(span) * f64::from(column) / f64::from(CELLS)).round() as i32;
                f64::from(resonance.cast_signed() + inverse(target, slope)) * unit_hz
            })
            .collect();
        let levels = request.amplitudes.map(|amplitude| level(amplitude as f32).unwrap_or(0));
        Ok(Self {
            frequencies,
            amplitudes: request.amplitudes,
            centre_hz,
            half_bandwidth_hz,
            resonance,
            shift,
            slope,
            first,
            span,
            levels,
        })
    }

    /// The column below a frequency, and the part of the way to the next.
    pub(super) fn column(&self, frequency_hz: f64) -> (usize, f64) {
        let units = fixed(frequency_hz as f32, self.shift).unwrap_or(0).cast_signed();
        let from_first = (detuning(units - self.resonance.cast_signed(), self.slope) - self.first).max(0);
        let place = f64::from(from_first) / f64::from(self.span) * f64::from(CELLS);
        let below = (place.floor() as usize).min(COLUMNS - 2);
        (below, (place - below as f64).clamp(0.0, 1.0))
    }

    /// The frequency in Hz at a part, 0 to 1, of the way over the columns.
    pub(super) fn frequency(&self, part: f64) -> f64 {
        let target = self.first + (f64::from(self.span) * part) as i32;
        let units = self.resonance.cast_signed() + inverse(target, self.slope);
        f64::from(units) * f64::from(-self.shift).exp2()
    }
}

/// The smallest distance from the resonance whose detuning is not below `target`.
fn inverse(target: i32, slope: u32) -> i32 {
    let (mut low, mut high) = (-FARTHEST.cast_signed(), FARTHEST.cast_signed());
    while low < high {
        let middle = low + (high - low) / 2;
        if detuning(middle, slope) < target { low = middle + 1 } else { high = middle }
    }
    low
}

/// Resonance and half of its bandwidth in Hz: of the closed form at the lowest amplitude, over the frequencies of the map;
/// the natural frequency with its damping where that has no peak between them.
fn resonance(scene: &Scene, request: &Request) -> Result<(f64, f64), Failure> {
    let [low, high] = request.frequencies;
    let frequency = |index: usize| low + (high - low) * index as f64 / (SCAN - 1) as f64;
    let mut scene = scene.clone();
    let mut power = |frequency_hz: f64| {
        let amplitude_m_per_s2 = request.amplitudes[0];
        scene.excitation = Excitation::Sine(Tone { amplitude_m_per_s2, frequency_hz, phase_rad: 0.0 });
        estimate(&scene, Precision::F64).map_or(0.0, |found| found.mean_power_w)
    };
    let powers: Vec<f64> = (0..SCAN).map(|index| power(frequency(index))).collect();
    let best = (0..SCAN).max_by(|&one, &other| powers[one].total_cmp(&powers[other])).unwrap_or(0);
    let half = 0.5 * powers[best];
    let below = (0..best).rev().find(|&index| powers[index] < half);
    let above = (best..SCAN).find(|&index| powers[index] < half);
    if let (Some(below), Some(above)) = (below, above)
        && half > 0.0
    {
        return Ok((frequency(best), 0.5 * (frequency(above) - frequency(below))));
    }
    let natural = natural_frequency_hz(&scene)?;
    Ok((natural, natural * damping_ratio(&scene).max(1e-3)))
}
