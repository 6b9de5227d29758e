//! `attractors`: the steady motions to which starts of a scene lead.

use std::path::PathBuf;

use comfy_table::presets;

use super::files::Outputs;
use super::sweep::picture::{Quantity, Words, draw};
use super::sweep::{Axis, page, values};
use super::{NODE, SceneArguments, check_overrides, json_text, one_more, print, progress, tell};
use crate::attractors::{End, Place, branches, ends, settled};
use crate::method::Failure;
use crate::outcome::{Fields, Format, fields, rows_csv, shown, table};
use crate::report::html::is_page;
use crate::run::run_scene;
use crate::scene_file;
use crate::shift::start;

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: that of its runs on all cores: a second for triboelectric scenes, minutes for a beam that \
                  hits a stop"
)]
pub struct AttractorsArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Starts beside that of the scene, in a square grid over displacement and velocity
    #[arg(long, value_name = "COUNT", default_value_t = 64, value_parser = clap::value_parser!(u32).range(4..=100_000))]
    starts: u32,
    /// Write the mean power over displacement and velocity at the start (.svg), or a page with zoom (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
}

/// Runs the scene from its starts and prints the motions, that of most starts first.
pub fn run(arguments: &AttractorsArguments) -> Result<(), Failure> {
    let SceneArguments { scene: file, options, overrides, format } = &arguments.scene;
    let scene = scene_file::read(file, overrides)?;
    check_overrides(overrides, &[NODE])?;
    let outputs = Outputs::of(file, overrides)?;
    if let Some(picture) = &arguments.picture {
        outputs.check_picture("--picture", picture, &["svg", "html"])?;
    }
    let outcome = run_scene(&scene, options)?;
    let place = Place::new(&scene, &outcome).ok_or_else(|| {
        let reason = "must be a moving harvester under a sine, sines or repeated bursts, with a load that takes power and is \
                      no storage, for its attractors";
        Failure::of_file(&scene, reason)
    })?;
    let later = settled(&scene, &outcome, scene.run.settle_s);
    if later.is_none() {
        tell(
            "warning: run.settle_s: transients have not decayed where the window begins, and take more than ten times \
             run.duration_s",
        );
    }
    let side = f64::from(arguments.starts).sqrt().ceil() as usize;
    let [displacements, velocities] = place.ranges();
    // The last one goes across.
    let axes =
        [("velocity at the start [m/s]", velocities), ("displacement at the start [m]", displacements)]
            .map(|(name, [low, high])| format!("{name}={low:e}:{high:e}:{side}").parse::<Axis>())
            .into_iter()
            .collect::<Result<Vec<Axis>, _>>()
            .map_err(Failure::Input)?;
    let grid = (0..side * side).map(|index| values(&axes, index)).map(|at| [at[1], at[0]]);
    let starts: Vec<[f64; 2]> = std::iter::once(start(&scene)).chain(grid).collect();
    let bar = progress(starts.len());
    let ends = ends(later.as_ref().unwrap_or(&scene), options, &starts, || one_more(&bar));
    bar.finish_and_clear();
    if ends.len() < starts.len() {
        tell(&format!("warning: {} of {} runs failed", starts.len() - ends.len(), starts.len()));
    }
    if let Some(path) = &arguments.picture {
        let power = |start: &[f64; 2]| Some(ends.iter().find(|end| end.start == *start)?.power_w);
        let powers = starts.iter().skip(1).map(power).collect();
        let quantity = Quantity { name: "mean power", unit: "W", values: powers };
        let title = file.display().to_string();
        let words = Words { title: &title, without: "the run failed", marked: (&[], "") };
        let draw = if is_page(path) { page::page } else { draw };
        let drawn = draw(words, &axes, &[quantity]);
        if let Some(drawn) = drawn.map_err(Failure::Input)? {
            outputs.write(path, &drawn)?;
        }
    }
    print(&text(&ends, *format)?)
}

fn text(ends: &[End], format: Format) -> Result<String, Failure> {
    let mut found = branches(ends);
    found.sort_by(|one, other| other.share.total_cmp(&one.share));
    let rows: Vec<Fields> = found.iter().map(fields).collect();
    let names = || rows.iter().take(1).flat_map(Fields::keys);
    Ok(match format {
        Format::Json => json_text(&found)?,
        Format::Csv => rows_csv(names(), &rows),
        Format::Table => {
            let cells = rows.iter().map(|row| row.values().map(shown).collect::<Vec<_>>());
            table(presets::NOTHING, names().collect::<Vec<_>>(), cells, 0)
        }
    })
}
