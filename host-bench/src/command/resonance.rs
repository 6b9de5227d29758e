//! `resonance`: the frequencies at which the steady state of a scene has its largest amplitude, voltage and power.

mod short_open;

use serde_json::json;

use super::storage_voltage::StorageVoltage;
use super::{NODE, SceneArguments, Unused, check_overrides, count, one_more, print, progress};
use crate::accuracy::{Statements, tell_warnings};
use crate::embedded::{Search, search as peaks};
use crate::method::{Failure, Options};
use crate::outcome::{Fields, fields, text};
use crate::scene_file::{self, Excitation, Load, Scene};
use crate::steady_state::{DEFAULT_POINTS, Peak, Resonance};

/// Keys that the search does not use.
const UNUSED: [Unused; 3] = [
    NODE,
    ("run", "the steady state does not depend on the length of a run"),
    ("excitation.frequency_hz", "--from and --to give the frequencies"),
];
/// Steady states that narrowing down the peaks takes, beside those of the scan: thrice a dozen.
const NARROWING: usize = 36;

#[derive(Debug, Clone, clap::Args)]
pub struct ResonanceArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Lowest frequency in Hz
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    from: f64,
    /// Highest frequency in Hz
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
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
pub fn run(arguments: &ResonanceArguments) -> Result<(), Failure> {
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
    let bar = progress(points + NARROWING);
    let range_hz = [from, to];
    let options = &arguments.scene.options;
    let found = if short_open {
        short_open::compared(&scene, range_hz, points, options, &bar)?
    } else {
        let search = Search { range_hz, points, with_power: true };
        let (found, periods) = peaks(&scene, &search, options, &mut || one_more(&bar))?;
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
        named
    };
    bar.finish_and_clear();
    tell_warnings(&found);
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

/// There is nothing to follow.
fn no_orbit([from, to]: [f64; 2]) -> Failure {
    Failure::Step(format!(
        "no stable orbit of one period from {from} to {to} Hz: `run --steady-state` at one frequency tells what shooting \
         leaves, and `sweep` without --steady-state gives the response of the runs"
    ))
}

/// Names and values of the peaks.
fn described(scene: &Scene, found: &Resonance, periods: f64) -> Fields {
    let without = found.responses.iter().filter(|(_, response)| response.is_none()).count();
    let mut named = fields(&json!({
        "scene": scene.name(),
        "peak_frequency_hz": found.amplitude.frequency_hz,
        "peak_amplitude_m": found.amplitude.value,
        "peak_within_hz": found.amplitude.within_hz,
        "peak_at_edge": found.amplitude.at_edge,
        "max_rms_voltage_frequency_hz": found.rms_voltage.frequency_hz,
        "max_rms_voltage_v": found.rms_voltage.value,
        "max_rms_voltage_within_hz": found.rms_voltage.within_hz,
        "max_rms_voltage_at_edge": found.rms_voltage.at_edge,
    }));
    if let Some(peak) = found.mean_power {
        named.extend(fields(&json!({
            "max_mean_power_frequency_hz": peak.frequency_hz,
            "max_mean_power_w": peak.value,
            "max_mean_power_within_hz": peak.within_hz,
            "max_mean_power_at_edge": peak.at_edge,
        })));
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
