//! The difference of two runs of the same scene.

use crate::outcome::{BLOCKS, Outcome};

/// Least mean number of steps in a part of the window.
const STEPS_PER_PART: u64 = 64;

/// Whether a run delivers power.
pub(super) fn delivers(outcome: &Outcome) -> bool {
    outcome.delivered_energy_j.is_some_and(|energy| energy != 0.0)
}

/// How two runs differ, relative to the smaller energy of the two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Difference {
    /// Of the energies delivered; where none is, the larger of the relative differences of the largest motion and of the RMS
    /// voltage.
    pub(super) whole: f64,
    /// The root of the sum of the squares of the differences in the parts of the window.
    pub(super) parts: f64,
}

/// The difference of two runs; `None` if one of the two alone delivers nothing.
pub(super) fn difference(one: &Outcome, two: &Outcome) -> Option<Difference> {
    let (energy, other) = (one.delivered_energy_j?, two.delivered_energy_j?);
    if energy == 0.0 && other == 0.0 {
        let [motion, voltage] = [0, 1].map(|index| relative(motions(one)[index], motions(two)[index]));
        let whole = motion?.max(voltage?);
        return Some(Difference { whole, parts: whole });
    }
    // Where a part has few steps, the energy of the step across its border is a part of it.
    let parts = (one.steps.min(two.steps) / STEPS_PER_PART).clamp(1, BLOCKS as u64);
    let blocks_of_part = BLOCKS >> parts.ilog2();
    let blocks = one.block_energies_j.iter().zip(&two.block_energies_j);
    let apart: Vec<f64> = blocks.map(|(one, two)| one - two).collect();
    let squares = apart.chunks(blocks_of_part).map(|part| part.iter().sum::<f64>().powi(2)).sum::<f64>();
    let over = |apart_j: f64| if apart_j == 0.0 { 0.0 } else { apart_j / energy.abs().min(other.abs()) };
    let found = Difference { whole: over((energy - other).abs()), parts: over(squares.sqrt()) };
    (found.whole.is_finite() && found.parts.is_finite()).then_some(found)
}

/// The largest gap, displacement of the slider or displacement of the tip in m, and the RMS voltage in V; 0 where
/// there is none.
pub(super) fn motions(outcome: &Outcome) -> [f64; 2] {
    [outcome.largest_motion_m(), outcome.rms_voltage_v].map(|value| value.unwrap_or(0.0))
}

/// The difference of two values over the smaller magnitude; `None` if one of the two alone is 0.
fn relative(one: f64, other: f64) -> Option<f64> {
    let apart = (one - other).abs() / one.abs().min(other.abs());
    if one == other { Some(0.0) } else { apart.is_finite().then_some(apart) }
}
