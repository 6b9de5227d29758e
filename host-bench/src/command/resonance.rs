//! `resonance`: the frequencies at which the steady state of a scene has its largest amplitude, voltage and power.

use indicatif::ProgressBar;
use serde_json::{Value, json};

use super::{
    NODE, SceneArguments, StorageVoltage, Unused, check_overrides, count, one_more, print, with_progress,
};
use crate::accuracy::{Statements, print_warnings};
use crate::closed_form::undamped_frequencies;
use crate::embedded::{Search, best_resistance, search, search as peaks};
use crate::method::{Failure, Options};
use crate::outcome::{Fields, fields, text};
use crate::scene_file::{self, Excitation, Load, Scene, finite_number_in};
use crate::steady_state::{BestLoad, DEFAULT_POINTS, Peak, Resonance};

/// Keys that the search does not use.
const UNUSED: [Unused; 3] = [
    NODE,
    ("run", "the steady state does not depend on the length of a run"),
    ("excitation.frequency_hz", "--from and --to give the frequencies"),
];
/// Steady states beside those of the scan: a dozen for each of three peaks, and two each decade of a load from 1 Ω to 10 TΩ.
const NARROWING: usize = 36;
const RESISTANCES: usize = 27;

#[derive(Debug, Clone, clap::Args)]
pub struct ResonanceArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Lowest frequency in Hz
    #[arg(long, value_name = "HZ", allow_hyphen_values = true, value_parser = finite_number_in("Hz", "HZ"))]
    from: f64,
    /// Highest frequency in Hz
    #[arg(long, value_name = "HZ", allow_hyphen_values = true, value_parser = finite_number_in("Hz", "HZ"))]
    to: f64,
    /// Frequencies of the scan from which the peaks are narrowed down
    #[arg(long, value_name = "COUNT", default_value_t = DEFAULT_POINTS, value_parser = count::<usize>(3..=100_000))]
    points: usize,
    /// Compare the resonances with short-circuited and open terminals: their frequencies, the coupling factor, and the
    /// largest power into a resistor at both; the load of the scene is not used
    #[arg(long, conflicts_with = "storage_voltage")]
    short_open: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
}

/// Follows the steady state over the range and prints its peaks.
pub(super) fn run(arguments: &ResonanceArguments) -> Result<(), Failure> {
    let ResonanceArguments { from, to, points, short_open, storage_voltage, .. } = *arguments;
    let refuse = |text: String| Err(Failure::Input(text));
    for (name, value) in [("--from", from), ("--to", to)] {
        if !(value > 0.0 && value <= 1e6) {
            return refuse(format!("{name} {value}: must be a number above 0, to 1e6"));
        }
    }
    if !(from < to) {
        return refuse(format!("--from {from}: must be below --to {to}"));
    }
    let mut scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    let load: Unused = ("load", "--short-open gives the loads");
    let unused = [&UNUSED[..], if short_open { std::slice::from_ref(&load) } else { &[] }].concat();
    check_overrides(&arguments.scene.overrides, &storage_voltage.unused(&unused))?;
    storage_voltage.hold(&mut scene)?;
    let range_hz = [from, to];
    let options = &arguments.scene.options;
    let runs = if short_open { 2 * (points + NARROWING + RESISTANCES) } else { points + NARROWING };
    let found = with_progress("frequencies", runs, |bar| {
        if short_open {
            return compared(&scene, range_hz, points, options, bar);
        }
        let search = Search { range_hz, points, with_power: true };
        let (found, periods) = peaks(&scene, &search, options, &mut || one_more(bar))?;
        let found = found.ok_or_else(|| no_orbit(range_hz))?;
        let peaks = [Some(found.amplitude), Some(found.rms_voltage), found.mean_power];
        let mut peaks: Vec<Peak> = peaks.into_iter().flatten().collect();
        let names = ["amplitude", "rms_voltage", "mean_power"].into_iter();
        let doubts: Vec<String> = names.zip(&peaks).filter_map(at_edge).collect();
        peaks.dedup_by(|one, other| one.frequency_hz == other.frequency_hz);
        let of = |peak: &Peak| {
            let there = found.responses.iter().find(|(frequency_hz, _)| *frequency_hz == peak.frequency_hz);
            let power_w = there.and_then(|(_, response)| Some(response.as_ref()?.mean_power_w));
            (&scene, peak.frequency_hz, power_w.filter(|power_w| *power_w > 0.0))
        };
        let mut named = described(&scene, &found, periods);
        named.extend(stated(&peaks.iter().rev().map(of).collect::<Vec<_>>(), &doubts, options)?);
        Ok(named)
    })?;
    print_warnings(&found);
    print(&text(&found, arguments.scene.format))
}

/// The warning of a peak that is at an edge of the range.
fn at_edge((name, peak): (&str, &Peak)) -> Option<String> {
    let hz = peak.frequency_hz;
    peak.at_edge
        .then(|| format!("range: the largest {name} is at its edge, {hz} Hz: a larger one may be beyond"))
}

/// What the steady motions of scenes at some frequencies in Hz and with a mean power in W, if it is known, state.
fn stated(
    peaks: &[(&Scene, f64, Option<f64>)],
    doubts: &[String],
    options: &Options,
) -> Result<Fields, Failure> {
    let amplitude = |scene: &Scene| match &scene.excitation {
        Excitation::Sine(tone) => tone.amplitude_m_per_s2,
        _ => 0.0,
    };
    let place = |&(scene, hz, power_w): &(_, f64, _)| (scene, [amplitude(scene), hz], power_w);
    let places: Vec<_> = peaks.iter().map(place).collect();
    Statements::of_orbits(&places, options).map(|statements| statements.fields(doubts))
}

fn no_orbit([from, to]: [f64; 2]) -> Failure {
    Failure::Step(format!(
        "no stable orbit of one period from {from} to {to} Hz: `run --steady-state` at one frequency prints what shooting \
         leaves, and `sweep` without --steady-state gives the response of the runs"
    ))
}

/// The numbers of a peak, each behind its name; `value` is the rest of the name of its value.
fn of_peak(name: &str, value: &str, peak: &Peak) -> impl Iterator<Item = (String, Value)> {
    let numbers: [(&str, Value); 4] = [
        ("frequency_hz", peak.frequency_hz.into()),
        (value, peak.value.into()),
        ("within_hz", peak.within_hz.into()),
        ("at_edge", peak.at_edge.into()),
    ];
    numbers.map(|(number, value)| (format!("{name}_{number}"), value)).into_iter()
}

fn described(scene: &Scene, found: &Resonance, periods: f64) -> Fields {
    let without = found.responses.iter().filter(|(_, response)| response.is_none()).count();
    let mut named = fields(&json!({ "scene": scene.name() }));
    named.extend(of_peak("peak", "amplitude_m", &found.amplitude));
    named.extend(of_peak("max_rms_voltage", "v", &found.rms_voltage));
    if let Some(peak) = found.mean_power {
        named.extend(of_peak("max_mean_power", "w", &peak));
        if !matches!(scene.load, Load::Resistor { .. }) {
            let there = found.responses.iter().find(|(frequency, _)| *frequency == peak.frequency_hz);
            let current = there.and_then(|(_, response)| Some(response.as_ref()?.mean_current_a));
            named.extend(fields(&json!({ "max_mean_power_current_a": current })));
        }
    }
    named.extend(fields(&json!({
        "frequencies": found.responses.len(),
        "frequencies_without_stable_orbit": without,
        "simulated_periods": periods,
    })));
    named
}

// The resonances of a scene with short-circuited and open terminals, and what a resistor takes at both.
//
// The voltage of a piezoelectric beam stiffens it: its resonance rises from the short circuit to the open one, and the power into the
// best resistor has a peak at both. The field of a triboelectric harvester pulls: its frequencies depend on the amplitude.

/// One of the two ends of the load.
struct End {
    amplitude: Peak,
    rms_voltage_v: f64,
    /// The resistor that takes most at this resonance.
    best: Option<BestLoad>,
    periods: f64,
}

fn compared(
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
        named.extend(of_peak(name, "amplitude_m", &end.amplitude));
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
