//! The resonances of a scene with short-circuited and open terminals, and what a resistor takes at both.
//!
//! The voltage of a piezoelectric beam stiffens it: its resonance rises from the short circuit to the open one, and the
//! power into the best resistor has a peak at both. The field of a triboelectric harvester pulls: its frequencies depend on
//! the amplitude.

use indicatif::ProgressBar;
use serde_json::json;

use super::{at_edge, no_orbit, stated};
use crate::closed_form::undamped_frequencies;
use crate::command::one_more;
use crate::embedded::{Search, best_resistance, search};
use crate::method::{Failure, Options};
use crate::outcome::{Fields, fields};
use crate::scene_file::{Excitation, Load, Scene};
use crate::steady_state::{BestLoad, Peak};

/// One of the two ends of the load.
struct End {
    amplitude: Peak,
    rms_voltage_v: f64,
    /// The resistor that takes most at this resonance.
    best: Option<BestLoad>,
    periods: f64,
}

/// Names and values of the comparison.
pub(super) fn compared(
    scene: &Scene,
    range_hz: [f64; 2],
    points: usize,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Fields, Failure> {
    let end = |resistance_ohm| end(scene, resistance_ohm, (range_hz, points), options, bar);
    let [short, open] = [end(0.0)?, end(f64::INFINITY)?];
    let mut named = fields(&json!({ "scene": scene.name() }));
    for (name, end) in [("short_circuit", &short), ("open_circuit", &open)] {
        named.extend([
            (format!("{name}_frequency_hz"), end.amplitude.frequency_hz.into()),
            (format!("{name}_amplitude_m"), end.amplitude.value.into()),
            (format!("{name}_within_hz"), end.amplitude.within_hz.into()),
            (format!("{name}_at_edge"), end.amplitude.at_edge.into()),
        ]);
    }
    let frequencies = [&short, &open].map(|end| end.amplitude.frequency_hz);
    named.extend(fields(&json!({
        "open_circuit_rms_voltage_v": open.rms_voltage_v,
        "frequency_shift_hz": frequencies[1] - frequencies[0],
        "coupling_factor_squared": coupling_factor_squared(frequencies),
    })));
    if let Some(undamped) = undamped_frequencies(scene)? {
        named.extend(fields(&json!({
            "undamped_short_circuit_frequency_hz": undamped[0],
            "undamped_open_circuit_frequency_hz": undamped[1],
            "undamped_coupling_factor_squared": coupling_factor_squared(undamped),
        })));
    }
    for (name, end) in [("short_circuit", &short), ("open_circuit", &open)] {
        named.extend([
            (format!("{name}_best_resistance_ohm"), end.best.map(|best| best.resistance_ohm).into()),
            (format!("{name}_peak_power_w"), end.best.map(|best| best.mean_power_w).into()),
        ]);
    }
    let loaded = [0.0, f64::INFINITY]
        .map(|resistance_ohm| Scene { load: Load::Resistor { resistance_ohm }, ..scene.clone() });
    let peaks: Vec<_> = loaded.iter().zip(frequencies).map(|(scene, peak)| (scene, peak, None)).collect();
    let ends =
        [("amplitude (short circuit)", &short.amplitude), ("amplitude (open circuit)", &open.amplitude)];
    let doubts: Vec<String> = ends.into_iter().filter_map(at_edge).collect();
    named.extend(stated(&peaks, &doubts, options)?);
    named.extend([("simulated_periods".to_owned(), (short.periods + open.periods).into())]);
    Ok(named)
}

/// `k² = (f_oc² − f_sc²)/f_oc²`; below 0 where the open circuit is the softer one.
fn coupling_factor_squared([short, open]: [f64; 2]) -> f64 {
    1.0 - (short / open).powi(2)
}

fn end(
    scene: &Scene,
    resistance_ohm: f64,
    (range_hz, points): ([f64; 2], usize),
    options: &Options,
    bar: &ProgressBar,
) -> Result<End, Failure> {
    let mut scene = Scene { load: Load::Resistor { resistance_ohm }, ..scene.clone() };
    let range = Search { range_hz, points, with_power: false };
    let (found, periods) = search(&scene, &range, options, &mut || one_more(bar))?;
    let found = found.ok_or_else(|| no_orbit(range_hz))?;
    let amplitude = found.amplitude;
    let there = found.responses.iter().find(|(frequency, _)| *frequency == amplitude.frequency_hz);
    let rms_voltage_v =
        there.and_then(|(_, response)| *response).map_or(f64::NAN, |found| found.rms_voltage_v);
    if let Excitation::Sine(tone) = &mut scene.excitation {
        tone.frequency_hz = amplitude.frequency_hz;
    }
    let (best, further) = best_resistance(&scene, options, &mut || one_more(bar))?;
    Ok(End { amplitude, rms_voltage_v, best, periods: periods + further })
}
