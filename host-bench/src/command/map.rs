//! `map`: the income of a scene over amplitude and frequency, for a node to look up.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use serde_json::json;

use super::files::Outputs;
use super::{
    NODE, SceneArguments, Unused, check_overrides, count, one_more, print, set_option, with_progress,
};
use crate::accuracy::print_warnings;
use crate::input::STANDARD;
use crate::map::{self, Agreement, Detected, Map, Prediction, Request, Step};
use crate::method::Failure;
use crate::name::Name;
use crate::outcome::{self, Fields, text};
use crate::scene_file::{self, finite_number_in};

/// What a map should keep: the 90th percentile of the relative error at most, and at least the share of the places at which the bounds
/// hold, and that of the places far from a boundary at which its motions are those of the model. That of the median is `--error`.
const TARGETS: [f64; 3] = [0.08, 0.95, 0.99];
/// Keys that a map does not use.
const UNUSED: [Unused; 3] = [
    NODE,
    ("run", "a map has the steady motions, whatever the length of a run"),
    ("excitation", "--amplitude and --frequency give the excitation"),
];

/// A range: two positive numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range(pub(super) [f64; 2]);

impl Range {
    /// Reads `LO:HI` in a unit.
    pub(super) fn of(unit: &'static str) -> impl Fn(&str) -> Result<Self, String> + Clone {
        move |text| {
            let (low, high) = text.split_once(':').ok_or_else(|| format!("{text}: must be LO:HI"))?;
            let range = [finite_number_in(unit, "LO")(low)?, finite_number_in(unit, "HI")(high)?];
            let is_range = range[0] > 0.0 && range[0] < range[1];
            let wrong = || format!("{text}: must be two numbers above 0, the lower one first");
            is_range.then_some(Self(range)).ok_or_else(wrong)
        }
    }
}

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: a minute or two of one core")]
pub struct MapArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Lowest and highest amplitude in m/s²
    #[arg(long, value_name = "LO:HI", value_parser = Range::of("m/s²"))]
    amplitude: Range,
    /// Lowest and highest frequency in Hz
    #[arg(long, value_name = "LO:HI", value_parser = Range::of("Hz"))]
    frequency: Range,
    /// Voltage of the storage behind a bridge in V; several, rising, for a slice each
    #[arg(long, value_name = "V,…", value_delimiter = ',', value_parser = finite_number_in("V", "V"))]
    voltage: Vec<f64>,
    /// Median of the relative error above which a warning says so
    #[arg(long, value_name = "REL", default_value_t = 0.02, value_parser = finite_number_in("", "REL"))]
    error: f64,
    /// Random places of each slice, off the nodes, by which the bounds are measured, and as many others that check them
    #[arg(long, value_name = "COUNT", default_value_t = 300, value_parser = count::<usize>(30..=10_000))]
    places: usize,
    /// Seed of the random places
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u64,
    /// Random inputs (a line, two lines, noise) of which the bank of lines and the map are asked, against trajectories
    #[arg(long, value_name = "COUNT", default_value_t = 0, value_parser = count::<usize>(0..=100_000))]
    inputs: usize,
    /// Write the map into this file: .rs (or -) constants for firmware, .bin bytes; and a picture beside it
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write a picture of the first slice (.svg), or a page of all slices with zoom and the output power at the pointer (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
}

/// Counts the steps of a map on a bar.
pub(super) fn counted_on(bar: &ProgressBar) -> impl Fn(Step) + Sync {
    move |step| match step {
        Step::More(count) => bar.inc_length(count as u64),
        Step::Done => one_more(bar),
    }
}

/// Makes the map, writes it, and prints how well it agrees with the model.
pub(super) fn run(arguments: &MapArguments) -> Result<(), Failure> {
    let request = request(arguments)?;
    let overrides = &arguments.scene.overrides;
    let scene = scene_file::read(&arguments.scene.scene, overrides)?;
    check_overrides(overrides, &UNUSED)?;
    let files = arguments.output.as_deref().map(files).transpose()?;
    let outputs = Outputs::of(&arguments.scene.scene, overrides)?;
    for file in files.iter().flatten() {
        outputs.check("--output", file)?;
    }
    if let Some([_, own]) = files.as_deref().filter(|files| arguments.picture.as_ref() == files.get(1)) {
        let reason = "--output writes this picture: leave --picture out";
        return Err(Failure::Input(format!("--picture {}: {reason}", own.display())));
    }
    outputs.check_picture("--picture", &arguments.picture)?;
    let options = &arguments.scene.options;
    let found = with_progress("map", 0, |bar| map::map(&scene, &request, options, &counted_on(bar)))?;
    let name = Name::of_file(&arguments.scene.scene).line();
    let drawn = || map::picture(&found, &name);
    if let Some([map_file, pictures @ ..]) = files.as_deref() {
        match map_file.extension() == Some(OsStr::new("bin")) {
            true => outputs.keep(map_file, map::bytes(&found)),
            false => outputs.keep(map_file, map::module(&found, &name, &command(arguments))),
        }
        pictures.iter().try_for_each(|picture| drawn()?.svg().map(|svg| outputs.keep(picture, svg)))?;
    }
    if let Some(file) = &arguments.picture {
        outputs.keep(file, drawn()?.of_file(file)?);
    }
    let warnings: Vec<String> = missed(&found.agreement, request.error)
        .chain(beside(found.axes.centre_hz, request.frequencies))
        .collect();
    let stated = found.statements.fields(&warnings);
    print_warnings(&stated);
    let mut numbers = fields(&found, scene.name());
    if let Some((slice, frequency, amplitude, income)) = map::best(&found)? {
        let name = if request.voltages.is_empty() { "largest_income_w" } else { "largest_income_a" };
        numbers.extend(outcome::fields(&json!({
            name: income,
            "largest_at_frequency_hz": frequency,
            "largest_at_amplitude_m_per_s2": amplitude,
            "largest_in_slice": slice,
        })));
    }
    if arguments.inputs > 0 {
        let detected = with_progress("inputs", arguments.inputs, |bar| {
            map::detected(&scene, &found, arguments.inputs, request.seed, options, &|| one_more(bar))
        });
        numbers.extend(inputs(&detected?));
    }
    numbers.extend(stated);
    print(&text(&numbers, arguments.scene.format))?;
    outputs.ended()
}

/// The targets of a map that it misses, as warnings; `median` is that of the relative error.
fn missed(agreement: &Agreement, median: f64) -> impl Iterator<Item = String> {
    let [largest, bounds, regime] = TARGETS;
    let errors =
        [("the median", agreement.median, median), ("the 90th percentile", agreement.percentile_90, largest)];
    let shares = [
        (
            "the bounds hold",
            agreement.bounds_hold,
            bounds,
            "an output power outside them is more likely than they say",
        ),
        (
            "far from the boundaries the motions of the map are right",
            agreement.regime_right,
            regime,
            "a node may count on a motion that is not there",
        ),
    ];
    let errors = errors.into_iter().filter(|(_, found, target)| found > target).map(|(name, found, target)| {
        // Without what the factor rounds.
        let (found, target) = (100.0 * found, (1e6 * target).round() / 1e4);
        format!("{name} of the relative error is {found:.2} %, the target is {target} %: the bounds in the map allow for it")
    });
    let shares = shares.into_iter().filter(|(_, found, target, _)| found < target);
    errors.chain(shares.map(|(what, found, target, then)| {
        let [found, target] = [found, target].map(|value| 100.0 * value);
        format!("{what} at {found:.1} % of the places, the target is {target:.0} %: {then}")
    }))
}

/// A remark on a map whose frequencies do not have the resonance.
fn beside(resonance_hz: f64, [from, to]: [f64; 2]) -> Option<String> {
    (!(from..=to).contains(&resonance_hz)).then(|| {
        format!(
            "the resonance of {resonance_hz:.4} Hz is outside --frequency {from}:{to}: the map has no place at which the \
             harvester resonates"
        )
    })
}

/// How what a node says of random inputs agrees with the trajectories, for each kind.
fn inputs(detected: &[Detected]) -> Fields {
    let mut all = Fields::default();
    for (kind, name) in map::KINDS.into_iter().zip(["line", "two_lines", "noise"]) {
        let of_kind = detected.iter().filter(|detected| detected.kind == kind && detected.truth > 0.0);
        let (mut errors, mut either, mut holds, mut flagged, mut silent) = (Vec::new(), 0, 0_u32, 0, 0);
        for Detected { truth, prediction, .. } in of_kind {
            match *prediction {
                Prediction::Known { value, low, high } => {
                    holds += u32::from((low..=high).contains(truth));
                    errors.push((value / truth - 1.0).abs());
                }
                Prediction::Either { low, high } => {
                    holds += u32::from((low..=high).contains(truth));
                    either += 1;
                }
                Prediction::Beyond => flagged += 1,
                Prediction::Nothing => silent += 1,
            }
        }
        errors.sort_by(f64::total_cmp);
        let at = |part: f64| errors.get((errors.len() as f64 * part) as usize).copied();
        let bounded = errors.len() + either;
        let numbers = json!({
            "estimates": errors.len(),
            "either_motion": either,
            "flagged": flagged,
            "silent": silent,
            "median_error": at(0.5),
            "error_90_percent": at(0.9),
            "bounds_hold": (bounded > 0).then(|| f64::from(holds) / bounded as f64),
        });
        let named = outcome::fields(&numbers);
        all.extend(named.into_iter().map(|(key, value)| (format!("{name}_{key}"), value)));
    }
    all
}

fn request(arguments: &MapArguments) -> Result<Request, Failure> {
    let (Range(amplitudes), Range(frequencies)) = (arguments.amplitude, arguments.frequency);
    let MapArguments { voltage, error, places, seed, .. } = arguments;
    let voltages = voltage.clone();
    let request = Request { amplitudes, frequencies, voltages, error: *error, places: *places, seed: *seed };
    match request.check() {
        Err(Failure::Input(text)) => Err(Failure::Input(format!("--{text}"))),
        checked => checked.map(|()| request),
    }
}

/// The file of the map and that of its picture, which standard output has not.
fn files(map: &Path) -> Result<Vec<PathBuf>, Failure> {
    match map.extension().and_then(OsStr::to_str) {
        Some("rs" | "bin") => Ok(vec![map.to_owned(), map.with_extension("svg")]),
        _ if map == Path::new(STANDARD) => Ok(vec![map.to_owned()]),
        _ => Err(Failure::Input(format!("--output {}: must end in .rs or .bin", map.display()))),
    }
}

/// The command that makes the map again.
fn command(arguments: &MapArguments) -> String {
    let MapArguments { scene, amplitude: Range([low, high]), frequency: Range([from, to]), .. } = arguments;
    let mut text = format!(
        "host-bench map {} --amplitude {low}:{high} --frequency {from}:{to}",
        Name::of_file(&scene.scene).shell()
    );
    if !arguments.voltage.is_empty() {
        let voltages: Vec<String> = arguments.voltage.iter().map(f64::to_string).collect();
        text += &format!(" --voltage {}", voltages.join(","));
    }
    text += &format!(" --error {} --places {} --seed {}", arguments.error, arguments.places, arguments.seed);
    let numerics = [
        ("--accuracy", scene.options.accuracy),
        ("--tolerance", scene.options.tolerance),
        ("--step", scene.options.step_s),
        ("--long-step", scene.options.long_step_s),
    ];
    for (option, value) in numerics {
        if let Some(value) = value {
            text += &format!(" {option} {value:e}");
        }
    }
    text.extend(scene.overrides.iter().map(set_option));
    text
}

fn fields(found: &Map, scene: &str) -> Fields {
    let Map { image, axes, agreement, .. } = found;
    let columns = found.slices.iter().flatten();
    let with_both =
        columns.clone().filter(|column| column.found && column.rising > column.falling * 1.0001).count();
    outcome::fields(&json!({
        "scene": scene,
        "fingerprint": format!("{:#010x}", image.fingerprint),
        "bytes": image.bytes(),
        "slices": found.slices.len(),
        "columns": axes.frequencies.len(),
        "resonance_hz": axes.centre_hz,
        "half_bandwidth_hz": axes.half_bandwidth_hz,
        "columns_with_boundary": columns.filter(|column| column.found).count(),
        "columns_with_two_motions": with_both,
        "margin": found.margin,
        "places": agreement.places,
        "median_error": agreement.median,
        "error_90_percent": agreement.percentile_90,
        "largest_error": agreement.largest,
        "far_places": agreement.far_places,
        "regime_right": agreement.regime_right,
        "bounds_hold": agreement.bounds_hold,
        "power_over_density_w_s3_per_m2": found.broadband.map(|[factor, _]| factor),
        "largest_density_m2_per_s3": found.broadband.map(|[_, largest]| largest),
        "median_bounds_ratio": agreement.median_bounds_ratio,
        "simulated_periods": found.periods,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_missed_target_warns_and_no_met_one() {
        let met = Agreement {
            places: 300,
            median: 0.02,
            percentile_90: 0.08,
            largest: 30.0,
            bounds_hold: 0.95,
            regime_right: 0.99,
            far_places: 200,
            median_bounds_ratio: 1.5,
        };
        assert_eq!(missed(&met, 0.02).count(), 0);
        for (missing, words) in [
            (
                Agreement { median: 0.021, ..met },
                "the median of the relative error is 2.10 %, the target is 2 %",
            ),
            (
                Agreement { percentile_90: 0.87, ..met },
                "the 90th percentile of the relative error is 87.00 %",
            ),
            (
                Agreement { bounds_hold: 0.924, ..met },
                "the bounds hold at 92.4 % of the places, the target is 95 %",
            ),
            (
                Agreement { regime_right: 0.98, ..met },
                "are right at 98.0 % of the places, the target is 99 %",
            ),
        ] {
            let texts: Vec<String> = missed(&missing, 0.02).collect();
            assert!(texts.len() == 1 && texts[0].contains(words), "{texts:?}");
        }
    }

    #[test]
    fn a_map_beside_the_resonance_is_remarked() {
        assert_eq!(beside(20.1, [17.0, 24.0]), None);
        assert!(
            beside(20.1, [21.0, 24.0])
                .is_some_and(|text| text.contains("20.1000 Hz is outside --frequency 21:24"))
        );
    }
}
