//! `work-precision`: error against run time.

use std::path::PathBuf;

use comfy_table::presets;
use serde_json::json;

use super::files::{Outputs, make_folder, report_folder};
use super::{NODE, SHIPPED_SCENES, check_overrides, json_text, more, print, with_progress};
use crate::method::{Failure, Method, Options, Precision};
use crate::motion::{self, Series, View, Wanted};
use crate::name::Name;
use crate::needs::{REPEATS, Study, cheapest, host_time};
use crate::outcome::{Format, fields, folded};
use crate::report::setting::{setting, with_unit};
use crate::report::{report, short_chart, terminal};
use crate::rows::{Column, Digits, Rows};
use crate::run::run_scene;
use crate::scene_file::{self, Model, Override, Scene};
use crate::work_precision::triboelectric::method_name;
use crate::work_precision::{self, Comparison, Control, Extent, Row, Variant, table};

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: three minutes of one core for the shipped scenes")]
pub struct WorkPrecisionArguments {
    /// Scene files; without any, the shipped scenes at several loads
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of each scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    /// Beside peers: the core alone and general integrators of other crates, on these scenes of a fixed list, or on all;
    /// needs the feature peers
    #[arg(long, value_name = "NAME", num_args = 0.., conflicts_with_all = ["scenes", "overrides"])]
    peers: Option<Vec<String>>,
    /// With --peers: all rows as CSV
    #[arg(long, value_name = "FILE", requires = "peers")]
    csv: Option<PathBuf>,
    /// With --peers: error against cost
    #[arg(long, value_name = "FILE.svg", requires = "peers")]
    picture: Option<PathBuf>,
}

/// The shipped scenes that are compared: name, overrides, and whether the short comparison has it too.
///
/// * Contact-separation at two load resistances: a circuit as slow as the motion, and a stiff one.
/// * Sliding at the same resistances and at a stiffer one, over 60 periods from rest: the methods differ there as they do
///   in the long run to the steady motion.
/// * Bump-stop with the stop at the tip until after some contacts, where the trajectory is compared; and with the stop
///   at mid-span for a second, where the motion settles and statistics are compared.
const SHIPPED: [(&str, &str, bool); 9] = [
    ("contact-separation", "load.resistance_ohm=1e8", true),
    ("contact-separation", "load.resistance_ohm=1e6", true),
    ("sliding", "load.resistance_ohm=1e8 run.duration_periods=60 run.settle_periods=40", true),
    ("sliding", "load.resistance_ohm=1e6 run.duration_periods=60 run.settle_periods=40", true),
    ("sliding", "load.resistance_ohm=1e4 run.duration_periods=60 run.settle_periods=40", false),
    (
        "bump-stop",
        "parameters.beam_modes=6 stop.rod_modes=2 stop.gap_m=5e-6 run.duration_s=5.67e-3 run.settle_s=0",
        true,
    ),
    ("bump-stop", "stop.gap_m=5e-6 run.duration_s=5.67e-3 run.settle_s=0", false),
    (
        "bump-stop",
        "parameters.beam_modes=4 stop.rod_modes=1 stop.position_m=25e-3 run.duration_s=1.5 run.settle_s=0.5",
        false,
    ),
    ("bump-stop", "stop.rod_modes=3 stop.position_m=25e-3 run.duration_s=1.5 run.settle_s=0.5", false),
];

pub(super) fn run(arguments: &WorkPrecisionArguments) -> Result<(), Failure> {
    check_overrides(&arguments.overrides, &[NODE])?;
    if let Some(names) = &arguments.peers {
        return beside_peers(arguments, names);
    }
    let mut scenes = if arguments.scenes.is_empty() {
        shipped(&arguments.overrides, &Extent::WHOLE)?
    } else {
        let read = |file: &PathBuf| scene_file::read(file, &arguments.overrides);
        arguments.scenes.iter().map(read).collect::<Result<Vec<_>, _>>()?
    };
    // Tables with the same columns stand together.
    scenes.sort_by_key(|scene| matches!(scene.model, Model::BumpStop(_)));
    let comparisons = compare(&scenes, &Extent::WHOLE)?;
    print(&match arguments.format {
        Format::Table => table::text(&comparisons),
        Format::Csv => table::csv(&comparisons),
        Format::Json => json_text(&comparisons)?,
    })
}

/// Refuses the comparison with the peers, which this build does not have.
#[cfg(not(feature = "peers"))]
fn beside_peers(_: &WorkPrecisionArguments, _: &[String]) -> Result<(), Failure> {
    let text = "--peers: must be in a build with the feature peers: cargo run --release --package host-bench --features \
                peers -- work-precision --peers";
    Err(Failure::Input(text.to_owned()))
}

/// Runs the comparison with the peers, prints it and writes its files.
#[cfg(feature = "peers")]
fn beside_peers(arguments: &WorkPrecisionArguments, names: &[String]) -> Result<(), Failure> {
    use super::{one_more, print_line};
    use crate::work_precision::peers;

    let cases = peers::cases(names)?;
    let outputs = Outputs::of_shipped(SHIPPED_SCENES);
    for (option, file) in [("--csv", &arguments.csv), ("--picture", &arguments.picture)] {
        file.as_ref().map_or(Ok(()), |file| outputs.check(option, file))?;
    }
    let comparisons = with_progress("peers", cases.len(), |bar| {
        let compared = |case| {
            let comparison = peers::compare(case, &|line| bar.suspend(|| print_line(line)));
            one_more(bar);
            comparison
        };
        cases.into_iter().map(compared).collect::<Result<Vec<_>, Failure>>()
    })?;
    arguments.csv.iter().for_each(|file| outputs.keep(file, peers::csv(&comparisons)));
    if let Some(file) = &arguments.picture {
        outputs.keep(file, peers::draw(&comparisons)?);
    }
    print(&match arguments.format {
        Format::Table => peers::text(&comparisons),
        Format::Csv => peers::csv(&comparisons),
        Format::Json => {
            let rows: Vec<_> =
                comparisons.iter().flat_map(|comparison| comparison.methods.iter().flatten()).collect();
            json_text(&rows)?
        }
    })?;
    outputs.ended()
}

/// One run of the comparison with the peers, which valgrind counts.
#[cfg(feature = "peers")]
#[derive(Debug, Clone, clap::Args)]
pub struct RowArguments {
    scene: String,
    method: String,
    setting: f64,
    duration_s: f64,
}

#[cfg(feature = "peers")]
pub(super) fn run_row(arguments: &RowArguments) -> Result<(), Failure> {
    let RowArguments { scene, method, setting, duration_s } = arguments;
    work_precision::peers::run_one(scene, method, *setting, *duration_s)
}

pub(super) fn shipped(overrides: &[Override], extent: &Extent) -> Result<Vec<Scene>, Failure> {
    let cases = SHIPPED.iter().filter(|(_, _, is_short)| *is_short || extent.whole);
    let scenes = cases.map(|(name, own, _)| {
        let own = own.split(' ').filter_map(|pair| pair.split_once('='));
        let own = own.map(|(key, value)| Override::new(key, value));
        let all: Vec<Override> = own.chain(overrides.iter().cloned()).collect();
        let mut scene = scene_file::read(&scene_file::shipped(name), &all)?;
        // The name without the folder in which this crate was built.
        scene.file = PathBuf::from(name).with_extension("toml");
        Ok(scene)
    });
    scenes.collect()
}

/// Runs the comparison on each scene, with a progress bar.
pub(super) fn compare(scenes: &[Scene], extent: &Extent) -> Result<Vec<Comparison>, Failure> {
    let stage = match scenes {
        [scene] => Name::of_file(&scene.file).line(),
        all => format!("{} scenes", all.len()),
    };
    with_progress(
        stage,
        scenes.iter().map(|scene| work_precision::work(scene, extent)).sum::<u64>() as usize,
        |bar| {
            scenes
                .iter()
                .map(|scene| work_precision::compare(scene, extent, |work| more(bar, work)))
                .collect()
        },
    )
}

const PAGE: &str = "index.html";
/// The scene of the terminal, and the accuracy of its cut.
const FIRST: &str = "contact-separation-passive";
const ACCURACY: f64 = 1e-2;
/// Rows of the charts in the terminal.
const ROWS: [usize; 2] = [7, 15];
/// Columns of the table in the terminal.
const COLUMNS: [Column<'_>; 9] = [
    ("", "mark", Digits::Word),
    ("method", "method", Digits::Word),
    ("precision", "precision", Digits::Word),
    ("step, tolerance", "control", Digits::Word),
    ("error", "error", Digits::Exponent(1)),
    ("µs", "us_per_s", Digits::Fixed(1.0, 0)),
    ("spread", "time_spread", Digits::By(|spread| format!("{:.0} %", 100.0 * spread))),
    ("/ auto", "over_auto", Digits::Fixed(1.0, 2)),
    ("steps", "steps_per_s", Digits::Fixed(1.0, 0)),
];

/// Shows one scene, error against run time on it, and what it does not need; then writes the report of all scenes.
pub(super) fn run_default() -> Result<(), Failure> {
    let (outputs, folder) = (Outputs::of_shipped(SHIPPED_SCENES), report_folder());
    outputs.check_in("", &folder, &[PAGE])?;
    let mut scene = scene_file::read(&scene_file::shipped(FIRST), &[])?;
    scene.file = PathBuf::from(FIRST).with_extension("toml");
    print(
        "Simulates vibration energy harvesters by the library that runs on the microcontroller of a node,\n\
         and compares its results and run times with an independent reference and with other methods.\n\n",
    )?;
    print(&motion_of(&scene)?)?;
    print(&cut(&scene)?)?;
    let found = compare(std::slice::from_ref(&scene), &Extent::FIRST)?;
    found.iter().try_for_each(|comparison| print(&errors(comparison)))?;
    print(&folded(
        "All scenes, methods and precisions follow in report/index.html. More: work-precision (every method), stability \
         (extreme scenes), run SCENE.toml (one scene), --help (all commands).",
        0,
    ))?;
    print("\n")?;
    let comparisons = compare(&shipped(&[], &Extent::SHORT)?, &Extent::SHORT)?;
    let page = report(&comparisons)?;
    make_folder(&folder)?;
    let file = folder.join(PAGE);
    outputs.write(&file, &page)?;
    outputs.ended()
}

/// A scene in a line, and its last periods.
fn motion_of(scene: &Scene) -> Result<String, Failure> {
    let span_s = motion::span_s(scene);
    let every_s = motion::every_s(scene, span_s);
    let outcome = run_scene(scene, &Options { trace_every_s: Some(every_s), ..Options::default() })?;
    let series = Series::of("run", scene, &outcome);
    let usual = motion::usual(scene, "", &series, every_s);
    let quantities = ["gap_m", "voltage_v"].map(str::to_owned).to_vec();
    let wanted = Wanted { views: &[View::History], quantities, ..usual };
    let picture = motion::picture(&wanted, &[series])?;
    let power = outcome.mean_power_w.map_or_else(String::new, |power| with_unit(power, "W"));
    let charts: String = picture.charts.iter().map(|chart| terminal(chart, ROWS[0])).collect();
    Ok(format!(
        "{}: a charged dielectric and a sprung mass that hits it\n{}; mean power {power}\n\n{charts}\n",
        scene.file.display(),
        setting(scene, &[])
    ))
}

/// What a scene does not need, and what leaving it out saves.
fn cut(scene: &Scene) -> Result<String, Failure> {
    let study = Study::with_corners(scene, &[], ACCURACY)?;
    let needs = study.needs(|_| ())?;
    let numerics = cheapest(&study, (&needs.cut_scene, false), |_| ());
    let Some(cheapest) = numerics.iter().find(|found| found.setting.precision == Precision::F32) else {
        return Ok(String::new());
    };
    let auto = Options { precision: Some(Precision::F64), ..Options::default() };
    let time = |(host_s_per_s, spread): (f64, Option<f64>)| {
        format!("{:.0} µs (spread {:.0} %)", 1e6 * host_s_per_s, 100.0 * spread.unwrap_or(f64::NAN))
    };
    let [whole, whole_auto] =
        [cheapest.setting.options(), auto].map(|options| time(host_time(scene, &options)));
    let parts: Vec<String> = needs.cut.iter().map(|part| part.name()).collect();
    let text = format!(
        "Left out of it at an accuracy of {} %: {}. The mean power changes by {:.2} %, and a simulated second takes {} \
         of this processor in f32 with the longest steps that hold this accuracy, {whole} with all parts, and \
         {whole_auto} with all parts as auto runs it in f64, each the least of {REPEATS} runs. The command needs says this of \
         any scene.",
        100.0 * ACCURACY,
        if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") },
        100.0 * cheapest.change.mean_power.unwrap_or(f64::NAN).abs(),
        time((cheapest.host_s_per_s, cheapest.host_spread)),
    );
    Ok(folded(&text, 0) + "\n\n")
}

/// Why a row has no result, in a sentence.
fn without_result(Row { variant, failure, .. }: &Row) -> Option<String> {
    let reason = table::reason(failure.as_ref()?);
    Some(format!(" No result of {}, {}: {reason}.", method_name(variant), control_of(variant)))
}

fn control_of(variant: &Variant) -> String {
    match variant.control {
        Control::PerPeriod { steps, .. } => format!("{steps} a period"),
        Control::Default => String::new(),
        other => other.to_string(),
    }
}

/// Error against run time on one scene: a chart, a table and the meaning of its columns.
fn errors(comparison: &Comparison) -> String {
    let auto = |row: &&Row| row.variant.method == Method::Auto;
    let is_shown = |row: &&Row| {
        let Variant { method, precision, control, .. } = row.variant;
        let is_double = precision == Precision::F64
            && (method == Method::Rk4 || !matches!(control, Control::PerPeriod { .. }));
        auto(row) || is_double
    };
    let time = |row: &Row| row.found.as_ref().map_or(f64::INFINITY, |found| found.ns_per_s);
    let of_auto = comparison.rows.iter().find(auto).map_or(f64::NAN, time);
    let mut shown: Vec<&Row> = comparison.rows.iter().filter(is_shown).collect();
    shown.sort_by(|one, other| time(one).total_cmp(&time(other)));
    let row = |row: &&Row| {
        let Variant { method, precision, control, .. } = row.variant;
        let is_reference = method == Method::Reference && control == Control::Default;
        let is_off = !is_reference && !comparison.reaches_target(row);
        let mark = match (auto(row), is_off) {
            (true, false) => "->",
            (true, true) => "-> x",
            (false, false) => "",
            (false, true) => "x",
        };
        let found = row.found.as_ref();
        fields(&json!({
            "mark": mark,
            "method": method_name(&row.variant),
            "precision": precision.name(),
            "control": control_of(&row.variant),
            "error": comparison.shown_error(row),
            "us_per_s": found.map(|found| found.ns_per_s / 1e3),
            "time_spread": found.and_then(|found| found.time_spread),
            "over_auto": found.map(|found| found.ns_per_s / of_auto),
            "steps_per_s": found.map(|found| found.steps_per_s),
        }))
    };
    let rows = Rows(shown.iter().map(row).collect());
    let failed: String = shown.iter().filter_map(|row| without_result(row)).collect();
    let notes = folded(
        &format!(
            "->: recommended, what auto takes. x: an error above the asked {:.0e}, or no result. step, tolerance: steps in \
             a period of the excitation, or the relative tolerance of an adaptive step. error: of the mean power, relative to \
             the reference. µs: time of this processor for a simulated second, the least of up to {} runs; spread: the largest \
             over it, less 1; / auto: it over that of auto in f64. steps: taken and rejected in a simulated second.{failed}",
            comparison.target_error(),
            Extent::FIRST.runs
        ),
        0,
    );
    format!(
        "Error against run time, in f64; lower and further left is better\n{}\n{}\n{notes}\n\n",
        terminal(&short_chart(comparison), ROWS[1]),
        rows.table(presets::ASCII_MARKDOWN, &COLUMNS, 4)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_time_of_the_first_table_has_its_spread_and_the_table_fits_a_terminal() {
        let run = Override::new("run", "{duration_periods=4,settle_periods=2}");
        let scene = scene_file::read(&scene_file::shipped(FIRST), &[run]).expect("the shipped scene");
        let comparison = compare(&[scene], &Extent::FIRST).expect("the reference runs").remove(0);
        let text = errors(&comparison);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        let rows: Vec<Vec<&str>> = text
            .lines()
            .filter(|line| line.starts_with('|'))
            .map(|line| line.split('|').map(str::trim).collect())
            .collect();
        assert!((10..=25).contains(&rows.len()), "{text}");
        let place = |heading: &str| rows[0].iter().position(|cell| *cell == heading).expect("a column");
        let [method, time, spread] = ["method", "µs", "spread"].map(place);
        let timed = rows[2..].iter().filter(|row| row[time] != "-" && row[method] != "reference");
        let spreads: Vec<Option<f64>> =
            timed.map(|row| row[spread].strip_suffix(" %").and_then(|part| part.parse().ok())).collect();
        assert!(
            spreads.len() > 8 && spreads.iter().all(|part| part.is_some_and(|part| part >= 0.0)),
            "{text}"
        );
    }
}
