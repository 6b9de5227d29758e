//! The coordinates of a map: its columns over frequency, its levels of amplitude.

use model_core::energy::response_map::{
    AMPLITUDE_OCTAVES, COLUMNS, FARTHEST, LEVELS_PER_OCTAVE, detuning, fixed, level,
};

use super::Request;
use crate::embedded::{Search, natural_frequency_hz, search};
use crate::method::{Failure, Options};
use crate::scene_file::{Excitation, Scene, Tone};

/// Cells from the first to the last column.
const CELLS: u32 = COLUMNS as u32 - 1;
/// Most half-bandwidths from the resonance to an edge; a wider map has wider units.
const WIDEST: f64 = 63.0;
/// Frequencies from which the resonance is narrowed down.
const SCAN: usize = 81;

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
    pub(super) fn new(scene: &Scene, request: &Request, options: &Options) -> Result<Self, Failure> {
        let [low, high] = request.frequencies;
        let (centre_hz, half_bandwidth_hz) = resonance(scene, request, options)?;
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

/// Resonance and half of its bandwidth in Hz: of the power of the steady motion at the lowest amplitude, over the
/// frequencies of the map; the natural frequency with its damping where that has no peak between them.
fn resonance(scene: &Scene, request: &Request, options: &Options) -> Result<(f64, f64), Failure> {
    let mut scene = scene.clone();
    let ([amplitude_m_per_s2, _], [frequency_hz, _]) = (request.amplitudes, request.frequencies);
    scene.excitation = Excitation::Sine(Tone { amplitude_m_per_s2, frequency_hz, phase_rad: 0.0 });
    let over = Search { range_hz: request.frequencies, points: SCAN, with_power: true };
    let (found, _) = search(&scene, &over, options, &mut || {})?;
    if let Some((peak, responses)) = found.and_then(|found| Some((found.mean_power?, found.responses)))
        && !peak.at_edge
    {
        // Of the response nearest to half of the power on either side: `P = P₀/(1 + (Δf/b)²)`.
        let beside = |is_side: fn(f64) -> bool| {
            let widths = responses.iter().filter_map(|(frequency_hz, response)| {
                let distance = frequency_hz - peak.frequency_hz;
                let ratio = peak.value / response.as_ref()?.mean_power_w;
                (is_side(distance) && ratio > 1.0 && ratio.is_finite())
                    .then(|| (ratio, distance.abs() / (ratio - 1.0).sqrt()))
            });
            let off_half = |ratio: f64| (ratio / 2.0).ln().abs();
            widths.min_by(|one, other| off_half(one.0).total_cmp(&off_half(other.0))).map(|(_, width)| width)
        };
        if let (Some(below), Some(above)) =
            (beside(|distance| distance < 0.0), beside(|distance| distance > 0.0))
        {
            return Ok((peak.frequency_hz, 0.5 * (below + above)));
        }
    }
    let natural = natural_frequency_hz(&scene)?;
    Ok((natural, natural * scene.model.summary().damping_ratio.max(1e-3)))
}
