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
    /// Scene files; without any, the shipped scene at 100 and at 1 megohm
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of each scene, such as run.duration_s=5; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
}

/// Load resistances in Ω at which the shipped scene is compared: one at which the circuit is as slow
/// as the motion, one at which it is stiff.
const RESISTANCES: [&str; 2] = ["1e8", "1e6"];

/// Runs the comparison and prints it.
///
/// # Errors
/// A scene that is refused, or that the reference cannot run.
pub fn run(arguments: &WorkPrecisionArguments) -> Result<(), Failure> {
    let scenes = if arguments.scenes.is_empty() {
        let mut scenes = shipped(&arguments.overrides)?;
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

/// The shipped scene at the resistances of the report.
pub(super) fn shipped(overrides: &[Override]) -> Result<Vec<Scene>, Failure> {
    let file = shipped_file();
    let read = |resistance: &str| {
        let first = [Override::new("load.resistance_ohm", resistance)];
        let mut scene = scene_file::read(&file, &[&first, overrides].concat())?;
        // Its name without the place where it was built.
        scene.file = PathBuf::from("contact-separation.toml");
        Ok(scene)
    };
    RESISTANCES.iter().map(|resistance| read(resistance)).collect()
}

/// The contact-separation scene that is shipped with this crate.
pub(super) fn shipped_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/contact-separation.toml")
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
