//! Random places of a map, and the steady motions there by the full model.

use super::axes::{Axes, amplitude_of, level_of};
use super::column::BEYOND;
use crate::embedded::Held;
use crate::method::Failure;
use crate::stability::random::Source;

/// Ratio of an amplitude to the next on the way to the place, in levels: a quarter of an octave.
const STEP: f64 = 512.0;
/// How far below the place the rising way begins: two octaves. A motion from rest overshoots to twice its amplitude.
const BELOW: f64 = 2.0 * 2048.0;

/// A place of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub slice: usize,
    pub frequency_hz: f64,
    /// In m/s².
    pub amplitude: f64,
}

/// The steady motions at a place: what each yields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
}

/// Places with uniform detuning and logarithm of the amplitude.
pub(super) fn random(axes: &Axes, slices: usize, seed: u64, count: usize) -> Vec<Place> {
    (0..count)
        .map(|number| {
            let mut source = Source::new(seed, number as u64);
            let frequency_hz = axes.frequency(source.uniform(0.0, 1.0));
            let amplitude = source.logarithmic(axes.amplitudes[0], axes.amplitudes[1]);
            // As a node has them.
            let [frequency_hz, amplitude] = [frequency_hz, amplitude].map(|number| f64::from(number as f32));
            Place { slice: number % slices, frequency_hz, amplitude }
        })
        .collect()
}

/// The steady motions at a place: through rising amplitudes from rest, and through falling ones from `above`, a level at
/// which there is the upper motion only.
pub(super) fn truth(held: &mut dyn Held, place: &Place, above: f64) -> Result<Truth, Failure> {
    let at = level_of(place.amplitude);
    held.rest();
    let mut rising = None;
    let mut level = at - BELOW;
    while level < at + 0.5 * STEP {
        let amplitude = if (level - at).abs() < 1e-6 { place.amplitude } else { amplitude_of(level) };
        let motion = held.settle(amplitude)?;
        rising = Some(motion);
        level += STEP;
    }
    let mut top = above.max(at) + STEP;
    if rising.is_none_or(|motion| !motion.is_upper) {
        held.rest();
        let mut motion = held.settle(amplitude_of(top))?;
        if !motion.is_upper {
            top += BEYOND;
            motion = held.settle(amplitude_of(top))?;
        }
        let mut level = top;
        // Whole steps end at the place.
        while motion.is_upper && level > at + 1e-6 {
            let steps = ((level - at) / STEP).ceil();
            level -= (level - at) / steps;
            let amplitude = if level - at < 1e-6 { place.amplitude } else { amplitude_of(level) };
            motion = held.settle(amplitude)?;
        }
        return Ok(Truth {
            lower: rising.map(|motion| motion.value),
            upper: motion.is_upper.then_some(motion.value),
        });
    }
    Ok(Truth { lower: None, upper: rising.map(|motion| motion.value) })
}
