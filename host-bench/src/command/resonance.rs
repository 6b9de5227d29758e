//! `resonance`: the frequencies at which the steady state of a scene has its largest amplitude and voltage.

use serde_json::json;

use super::{NODE, SceneArguments, Unused, check_overrides, print};
use crate::embedded::resonance_peak;
use crate::method::Failure;
use crate::outcome::text;
use crate::scene_file;
use crate::steady_state::DEFAULT_POINTS;

/// Keys that the search does not use.
const UNUSED: [Unused; 3] = [
    NODE,
    ("run", "the steady state does not depend on the length of a run"),
    ("excitation.frequency_hz", "--from and --to give the frequencies"),
];
/// Most frequencies of a scan.
const MOST_POINTS: usize = 100_000;

#[derive(Debug, Clone, clap::Args)]
pub struct ResonanceArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Lowest frequency
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    from: f64,
    /// Highest frequency
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    to: f64,
    /// Frequencies of the scan from which the peaks are narrowed down
    #[arg(long, value_name = "COUNT", default_value_t = DEFAULT_POINTS)]
    points: usize,
}

/// Follows the steady state over the range and prints its peaks.
pub fn run(arguments: &ResonanceArguments) -> Result<(), Failure> {
    let ResonanceArguments { from, to, points, .. } = *arguments;
    let refuse = |text: String| Err(Failure::Input(text));
    for (name, value) in [("--from", from), ("--to", to)] {
        if !(value > 0.0 && value <= 1e6) {
            return refuse(format!("{name} {value}: must be a number above 0, to 1e6"));
        }
    }
    if !(from < to) {
        return refuse(format!("--from {from}: must be below --to {to}"));
    }
    if !(3..=MOST_POINTS).contains(&points) {
        return refuse(format!("--points {points}: must be from 3 to {MOST_POINTS}"));
    }
    let scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
    check_overrides(&arguments.scene.overrides, &UNUSED)?;
    let (found, periods) = resonance_peak(&scene, [from, to], points, &arguments.scene.options)?;
    let Some(found) = found else {
        return Err(Failure::Step(format!("no stable orbit of one period from {from} to {to} Hz")));
    };
    let without = found.responses.iter().filter(|(_, response)| response.is_none()).count();
    let fields = json!({
        "scene": scene.name(),
        "peak_frequency_hz": found.amplitude.frequency_hz,
        "peak_amplitude_m": found.amplitude.value,
        "peak_within_hz": found.amplitude.within_hz,
        "peak_at_edge": found.amplitude.at_edge,
        "max_rms_voltage_frequency_hz": found.rms_voltage.frequency_hz,
        "max_rms_voltage_v": found.rms_voltage.value,
        "max_rms_voltage_within_hz": found.rms_voltage.within_hz,
        "max_rms_voltage_at_edge": found.rms_voltage.at_edge,
        "frequencies": found.responses.len(),
        "frequencies_without_stable_orbit": without,
        "simulated_periods": periods,
    });
    print(&text(&fields, arguments.scene.format))
}
