//! `work-precision`: error against run time.

pub(super) mod bump_stop;

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use super::{print, progress};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file::{self, Model, Override, Scene};
use crate::work_precision::bump_stop::{BumpStopComparison, table as bump_stop_table};
use crate::work_precision::{self, Comparison, Extent, table};

/// Arguments of `work-precision`.
#[derive(Debug, Clone, clap::Args)]
pub struct WorkPrecisionArguments {
    /// Scene files; without any, the shipped scenes at several loads
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of each scene, such as run.duration_s=5; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
}

/// The shipped scenes, with the load resistances in Ω at which each is compared: one at which the circuit
/// is as slow as the motion, one at which it is stiff, and for the sliding one a stiffer.
const SHIPPED: [(&str, &[&str]); 2] =
    [("contact-separation.toml", &["1e8", "1e6"]), ("sliding.toml", &["1e8", "1e6", "1e4"])];
/// Instead of the long run of the sliding scene to its steady motion: from rest to most of it, through all
/// that the methods differ in.
const SLIDING_SPAN: [(&str, &str); 2] = [("run.duration_periods", "60"), ("run.settle_periods", "40")];

/// Runs the comparison and prints it.
///
/// # Errors
/// A scene that is refused, or that the reference cannot run.
pub fn run(arguments: &WorkPrecisionArguments) -> Result<(), Failure> {
    let scenes = if arguments.scenes.is_empty() {
        let mut scenes = shipped(&arguments.overrides, usize::MAX)?;
        scenes.extend(bump_stop::shipped(&arguments.overrides, usize::MAX)?);
        scenes
    } else {
        let read = |file: &PathBuf| scene_file::read(file, &arguments.overrides).map_err(Failure::from);
        arguments.scenes.iter().map(read).collect::<Result<Vec<_>, _>>()?
    };
    let (with_stop, scenes): (Vec<Scene>, Vec<Scene>) =
        scenes.into_iter().partition(|scene| matches!(scene.model, Model::BumpStop(_)));
    let comparisons = compare(&scenes, &Extent::WHOLE)?;
    let with_stop = bump_stop::compare(&with_stop, &Extent::WHOLE)?;
    // Of what there is: the two kinds have columns of their own.
    let joined = |one: String, other: String| {
        let both = [one, other];
        both.iter().filter(|text| !text.is_empty()).cloned().collect::<Vec<_>>().join("\n")
    };
    print(&match arguments.format {
        Format::Table => joined(text(&comparisons), bump_stop::text(&with_stop)),
        Format::Csv => {
            let headed = |heading: &str, rows: String| {
                if rows.is_empty() { rows } else { heading.to_owned() + &rows }
            };
            joined(
                headed(table::CSV_HEADING, comparisons.iter().map(Comparison::csv).collect()),
                headed(bump_stop_table::CSV_HEADING, with_stop.iter().map(BumpStopComparison::csv).collect()),
            )
        }
        Format::Json => match serde_json::to_string_pretty(&all(&comparisons, &with_stop)) {
            Ok(text) => text + "\n",
            Err(error) => return Err(Failure::Input(format!("--format json: {error}"))),
        },
    })
}

/// The tables of all kinds, in one list.
fn all<'a>(comparisons: &'a [Comparison], with_stop: &'a [BumpStopComparison]) -> Vec<AnyTable<'a>> {
    comparisons.iter().map(AnyTable::Other).chain(with_stop.iter().map(AnyTable::BumpStop)).collect()
}

/// A table of either kind.
#[derive(serde::Serialize)]
#[serde(untagged)]
enum AnyTable<'a> {
    Other(&'a Comparison),
    BumpStop(&'a BumpStopComparison),
}

/// The shipped scenes at the resistances of the report, of each scene at most so many.
pub(super) fn shipped(overrides: &[Override], most: usize) -> Result<Vec<Scene>, Failure> {
    let mut scenes = Vec::new();
    for (name, resistances) in SHIPPED {
        for resistance in resistances.iter().take(most) {
            let mut first = vec![Override::new("load.resistance_ohm", resistance)];
            if name == "sliding.toml" {
                first.extend(SLIDING_SPAN.map(|(key, value)| Override::new(key, value)));
            }
            first.extend_from_slice(overrides);
            let mut scene = scene_file::read(&shipped_file(name), &first)?;
            // Its name without the place where it was built.
            scene.file = PathBuf::from(name);
            scenes.push(scene);
        }
    }
    Ok(scenes)
}

/// A scene that is shipped with this crate.
pub(super) fn shipped_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// Runs the comparison on each scene, with a progress bar.
pub(super) fn compare(scenes: &[Scene], extent: &Extent) -> Result<Vec<Comparison>, Failure> {
    let length = scenes.iter().map(|scene| work_precision::length(scene, extent)).sum();
    let bar: ProgressBar = progress(length);
    let comparisons =
        scenes.iter().map(|scene| work_precision::compare(scene, extent, |steps| bar.inc(steps))).collect();
    bar.finish_and_clear();
    comparisons
}

/// All tables as text.
pub(super) fn text(comparisons: &[Comparison]) -> String {
    comparisons.iter().map(Comparison::text).collect::<Vec<_>>().join("\n")
}
