//! Piezoelectric shunting, with which the first paper compares: findings 31 and 32.

use super::runs::{bump_stop, each, run, value};
use super::statistics::{largest, smallest};
use super::{Bound::*, Measured, check};
use crate::method::Failure;

/// Resistances in Ω.
const RESISTANCES: [&str; 7] = ["1", "3e3", "1e4", "3e4", "1e5", "1e6", "1e9"];
/// Frequencies in Hz from which the peak is narrowed down.
const FIRST_HZ: f64 = 237.0;
const EVERY_HZ: f64 = 1.5;
const COUNT: u32 = 8;
/// Half the width in Hz of the last parabola.
const CLOSE_HZ: f64 = 0.25;

/// Peak tip displacement in m of the beam without a stop, when its free motion has decayed to 10⁻⁸.
fn amplitude(resistance: &str, frequency_hz: f64) -> Result<f64, Failure> {
    let frequency = format!("{frequency_hz}");
    let outcome = run(
        "bump-stop-none",
        &[
            ("load.resistance_ohm", resistance),
            ("excitation.frequency_hz", frequency.as_str()),
            ("parameters.beam_modes", "6"),
            ("run.settle_s", "1.2"),
            ("run.duration_s", "1.25"),
        ],
    )?;
    Ok(value(bump_stop(&outcome)?.peak_tip_displacement_m))
}

/// Frequency in Hz of the largest amplitude, and the amplitude in m there; not-a-number if it is at the first or the last.
///
/// The inverse square of the amplitude of a resonance is a parabola in frequency but for terms of higher order: the top
/// of that through three points beside the largest, twice.
fn peak(resistance: &str) -> Result<[f64; 2], Failure> {
    let frequencies: Vec<f64> = (0..COUNT).map(|index| FIRST_HZ + EVERY_HZ * f64::from(index)).collect();
    let inverse =
        |frequency_hz: &f64| amplitude(resistance, *frequency_hz).map(|amplitude| amplitude.powi(-2));
    let values = each(&frequencies, inverse)?;
    let least = (0..values.len()).min_by(|one, other| values[*one].total_cmp(&values[*other]));
    let Some(least) = least.filter(|least| (1..values.len() - 1).contains(least)) else {
        return Ok([f64::NAN; 2]);
    };
    let near = top(frequencies[least], EVERY_HZ, [values[least - 1], values[least], values[least + 1]]);
    let around = each(&[near - CLOSE_HZ, near, near + CLOSE_HZ], inverse)?;
    let [before, here, after] = around[..] else { return Ok([f64::NAN; 2]) };
    let frequency_hz = top(near, CLOSE_HZ, [before, here, after]);
    Ok([frequency_hz, amplitude(resistance, frequency_hz)?])
}

/// Place of the lowest point of the parabola through three values at distances `every` around `middle`.
fn top(middle: f64, every: f64, [before, here, after]: [f64; 3]) -> f64 {
    middle + 0.5 * every * (before - after) / (before - 2.0 * here + after)
}

/// Findings 31 and 32.
pub(super) fn measure() -> Result<Measured, Failure> {
    let peaks = each(&RESISTANCES, |resistance| peak(resistance))?;
    let frequencies: Vec<f64> = peaks.iter().map(|[frequency, _]| *frequency).collect();
    let amplitudes: Vec<f64> = peaks.iter().map(|[_, amplitude]| 1e6 * amplitude).collect();
    let lowest = smallest(amplitudes.iter().copied());
    let ends = [amplitudes.first(), amplitudes.last()].map(|end| end.map_or(f64::NAN, |end| end / lowest));
    let shift = largest(frequencies.iter().copied()) - smallest(frequencies.iter().copied());
    Ok(vec![
        check("31", "resonance [Hz], 1 Ω to 1 GΩ", frequencies, Rises),
        check("31", "open less short circuit [Hz]", [shift], Above(5.0)),
        check("32", "amplitude at 1 Ω and at 1 GΩ / the smallest", ends, Above(1.5)),
        check("32", "amplitude [µm], 1 Ω to 1 GΩ", amplitudes, Reported),
    ])
}
