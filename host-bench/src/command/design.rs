//! `report`: one page on a design, of the charts and tables of other commands.

use std::path::{Path, PathBuf};

use comfy_table::presets;

use super::files::{Outputs, make_folder, report_folder};
use super::sweep::points::PointArguments;
use super::sweep::{Axis, drawn};
use super::tolerance::{Varied, sampled};
use super::{FileArguments, SceneArguments, Watch, print, run, warn};
use crate::accuracy::run_with_accuracy;
use crate::attractors::add_branches;
use crate::budget::{picture, short_day};
use crate::input::{MOST_OF_DATA, text as text_of};
use crate::method::{Failure, Options};
use crate::motion;
use crate::name::Name;
use crate::outcome::{Fields, Format, Outcome, fields, flattened, shown, text};
use crate::report::Picture;
use crate::report::page::{Page, escaped};
use crate::report::setting::{margin, named, setting};
use crate::resolution::natural_frequency_hz;
use crate::rows::Rows;
use crate::scene_file::{self, Override, Scene, number_at};

const FREQUENCY: &str = "excitation.frequency_hz";
const RESISTANCE: &str = "load.resistance_ohm";
/// Points of a curve.
const POINTS: usize = 41;
/// What varies where nothing else is asked for.
const VARIED: [(&str, &str); 2] = [(FREQUENCY, "±1%"), (RESISTANCE, "±5%")];

#[derive(Debug, Clone, clap::Args)]
pub struct ReportArguments {
    #[command(flatten)]
    scene: FileArguments,
    #[command(flatten)]
    options: Options,
    /// A key that varies from part to part, as in tolerance; repeat it [default: the frequency by 1 %, the load resistance by 5 %]
    #[arg(long = "vary", value_name = "KEY=±BOUND[%][:normal]")]
    varied: Vec<Varied>,
    /// Samples of the tolerance
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = super::count::<usize>(20..=100_000))]
    samples: usize,
    /// Write the page to this file [default: report/design.html]
    #[arg(long, value_name = "FILE.html")]
    output: Option<PathBuf>,
}

/// Runs the scene, its curves, its tolerance, and the day of its node if it has one, and writes the page.
pub(super) fn run(arguments: &ReportArguments) -> Result<(), Failure> {
    let FileArguments { scene: file, overrides } = &arguments.scene;
    arguments.options.check()?;
    let scene = scene_file::read(file, overrides)?;
    let written = scene_text(file, overrides)?;
    let outputs = Outputs::of(file, overrides)?;
    let target = arguments.output.clone().unwrap_or_else(|| report_folder().join("design.html"));
    match arguments.output {
        Some(_) => outputs.check_ending("--output", &target, &["html"])?,
        None => outputs.check_in("", &report_folder(), &["design.html"])?,
    }
    let points = PointArguments::of_single_runs(SceneArguments {
        scene: file.clone(),
        options: arguments.options,
        format: Format::Table,
        overrides: overrides.clone(),
    });
    // Before the other runs, so that a bad key is refused at once.
    let tolerance = tolerance(arguments, &points)?;
    let every_s = motion::every_s(&scene, motion::span_s(&scene));
    let options = Options { trace_every_s: Some(every_s), ..arguments.options };
    let watch = Watch::new();
    let mut outcome = run_with_accuracy(&scene, &options)?;
    add_branches(&scene, &options, &mut outcome);
    let [numbers, stress] = parts(&outcome);
    let motion = run::picture(file, &scene, (&options, every_s), &outcome);
    drop(watch);
    outcome.warnings.iter().for_each(|warning| warn(warning));
    let day = match scene_file::read_with_node(file, overrides) {
        Err(_) => left_out("the scene has no [node]"),
        Ok(_) => short_day(file, overrides).map(|(day, source)| picture::picture(&day, &source)),
    };
    let limits = Rows::of(&outcome.margins.limits);
    let table = limits.table(presets::NOTHING, &limits.plain(), 1);
    let sections = [
        ("Resonance", curve(&points, FREQUENCY, |driven| frequencies(&scene, &outcome, driven), false)),
        ("Load curve", curve(&points, RESISTANCE, |load| [0.03 * load, 30.0 * load], true)),
        ("Motion", motion.map(|motion| Picture { text: text(&numbers, Format::Table), ..motion })),
        ("Margins to physical limits", words_if(!limits.0.is_empty(), table, "this method keeps no margins")),
        (
            "Stress and life",
            words_if(!stress.is_empty(), text(&stress, Format::Table), "the model has no stress at a clamp"),
        ),
        ("Tolerance", tolerance),
        ("Day of the node", day),
        ("Scene", Ok(words(written))),
    ];
    let title = motion::title(file, &outcome.method, &setting(&scene, &[]));
    let [power, voltage, error] =
        ["mean_power_w", "rms_voltage_v", "accuracy_total"].map(|name| shown(&numbers[name]));
    let margin = margin(named(&outcome.margins));
    let short =
        format!("Mean power {power} W (stated relative error {error}), RMS voltage {voltage} V{margin}.");
    let page = page(&title, &short, sections)?;
    if arguments.output.is_none() {
        make_folder(&report_folder())?;
    }
    outputs.write(&target, page.html())?;
    print(&format!("{}\n", Name::new(target.display().to_string()).line()))
}

/// The page of the sections by their headings. Where one failed, it says why.
fn page(title: &str, short: &str, sections: [(&str, Result<Picture, Failure>); 8]) -> Result<Page, Failure> {
    let mut page = Page::new(title);
    page.add(&format!("<p>{}</p>\n", escaped(short)));
    page.note(
        "The motion has an accuracy statement. Points of curves and samples of the tolerance are single runs without one.",
    );
    for (heading, found) in sections {
        page.add(&format!("<h2>{}</h2>\n", escaped(heading)));
        match found {
            Ok(mut picture) => {
                // Charts of one section alone are zoomed together.
                let grouped = picture.charts.iter_mut().filter(|chart| !chart.group.is_empty());
                grouped.for_each(|chart| chart.group.insert_str(0, heading));
                picture.add_to(&mut page)?;
            }
            Err(reason) => page.note(&format!("Left out: {reason}.")),
        }
    }
    Ok(page)
}

/// The positive number of a scene at a key.
fn value(scene: &SceneArguments, key: &str) -> Option<f64> {
    let found = number_at(&scene.scene, &scene.overrides, key).ok().flatten();
    found.filter(|value| value.is_normal() && *value > 0.0)
}

/// What the samples of the keys give; of keys that nobody asked for, what they lack is no error.
fn tolerance(
    arguments: &ReportArguments,
    points: &PointArguments,
) -> Result<Result<Picture, Failure>, Failure> {
    if !arguments.varied.is_empty() {
        return sampled(points, arguments.varied.clone(), arguments.samples).map(Ok);
    }
    let usual = VARIED.iter().filter(|(key, _)| value(&points.scene, key).is_some());
    let usual: Vec<Varied> = usual.filter_map(|(key, bound)| format!("{key}={bound}").parse().ok()).collect();
    Ok(match usual.is_empty() {
        true => left_out(
            "the scene has neither one frequency nor a load resistance to vary; --vary names other keys",
        ),
        false => sampled(points, usual, arguments.samples),
    })
}

/// Power and voltage over a key, between ends that follow from its value in the scene.
fn curve(
    points: &PointArguments,
    key: &str,
    ends: impl Fn(f64) -> [f64; 2],
    is_logarithmic: bool,
) -> Result<Picture, Failure> {
    let Some(value) = value(&points.scene, key) else {
        return left_out(&format!("{key} is no positive number in the scene"));
    };
    drawn(points, Axis::new(key, ends(value), POINTS, is_logarithmic))
}

fn left_out(reason: &str) -> Result<Picture, Failure> {
    Err(Failure::Input(reason.to_owned()))
}

fn words(text: String) -> Picture {
    Picture { text, ..Picture::default() }
}

fn words_if(is_there: bool, text: String, reason: &str) -> Result<Picture, Failure> {
    if is_there { Ok(words(text)) } else { left_out(reason) }
}

/// The scene file, with the values that replace its own.
fn scene_text(file: &Path, overrides: &[Override]) -> Result<String, Failure> {
    let text = text_of(file, MOST_OF_DATA)
        .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", file.display())))?;
    let changes = overrides.iter().map(|change| format!("# --set {}={}\n", change.key(), change.value()));
    Ok(changes.chain([text]).collect())
}

/// The numbers of a run without those of stress and margins, and those of stress.
fn parts(outcome: &Outcome) -> [Fields; 2] {
    let numbers = flattened(fields(outcome)).into_iter().filter(|(name, _)| !name.starts_with("limits_"));
    let (stress, motion) = numbers.partition(|(name, _)| name.contains("clamp_"));
    [motion, stress]
}

/// First and last frequency of the resonance curve in Hz: about that of the excitation, and about the lowest natural one where
/// that is within a factor of 3.
fn frequencies(scene: &Scene, outcome: &Outcome, driven: f64) -> [f64; 2] {
    let is_near = |natural: &f64| (driven / 3.0..3.0 * driven).contains(natural);
    let natural = natural_frequency_hz(scene, outcome).filter(is_near).unwrap_or(driven);
    [0.9 * driven.min(natural), 1.1 * driven.max(natural)]
}
