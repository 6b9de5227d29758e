//! `attractors`: the steady motions to which starts of a scene lead.

use std::path::{Path, PathBuf};

use comfy_table::presets;

use super::files::Outputs;
use super::{NODE, SceneArguments, check_overrides, json_text, one_more, print, progress, tell};
use crate::attractors::{Place, branches, ends, settled};
use crate::method::Failure;
use crate::outcome::{Branch, Fields, Format, fields, rows_csv, shown, table};
use crate::report::charts::{Charts, HINT, Look};
use crate::report::html::{document, escaped, is_page};
use crate::report::plot::{Axis, Curve, Mark, Plot, draw};
use crate::report::svg::shade;
use crate::run::run_scene;
use crate::scene_file::{self, Scene};
use crate::shift::start;

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: that of its runs on all cores: a second for triboelectric scenes, minutes for a beam that \
                  hits a stop"
)]
pub struct AttractorsArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Starts: that of the scene, and others evenly spread over displacement and velocity
    #[arg(long, value_name = "COUNT", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    starts: u32,
    /// Write the starts over displacement and velocity, in the colour of their motion (.svg), or a page with zoom (.html)
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
    let count = arguments.starts as usize;
    let mut starts = vec![start(&scene)];
    starts.extend(place.spread(count - 1));
    let bar = progress(count);
    let ends = ends(later.as_ref().unwrap_or(&scene), options, &starts, || one_more(&bar));
    bar.finish_and_clear();
    let (mut found, of) = branches(&ends);
    if found.is_empty() {
        return Err(Failure::Step(format!("all runs from {count} starts fail")));
    }
    let warnings = [
        later.is_none().then(|| {
            "run.settle_s: transients have not decayed where the window begins, and take more than ten times run.duration_s"
                .to_owned()
        }),
        (ends.len() < count).then(|| format!("{} of {count} runs failed", count - ends.len())),
    ];
    warnings.into_iter().flatten().for_each(|warning| tell(&format!("warning: {warning}")));
    if let Some(path) = &arguments.picture {
        let of: Vec<([f64; 2], usize)> = ends.iter().map(|end| end.start).zip(of).collect();
        outputs.write(path, &picture(path, &scene, &found, &of)?)?;
    }
    found.sort_by(|one, other| other.share.total_cmp(&one.share));
    print(&text(&found, *format)?)
}

fn text(found: &[Branch], format: Format) -> Result<String, Failure> {
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

/// The basins: the starts, in the colour of the motion to which they lead.
fn picture(
    path: &Path,
    scene: &Scene,
    found: &[Branch],
    of: &[([f64; 2], usize)],
) -> Result<String, Failure> {
    let title = format!("{}: starts by the motion to which they lead", scene.file.display());
    let curves = found.iter().enumerate().map(|(index, branch)| {
        let period = branch.period.map_or("not periodic".to_owned(), |period| format!("period {period}"));
        let power = branch.mean_power_w.unwrap_or(f64::NAN);
        let name = format!("{power:.3e} W, {period}, {:.0} %", 100.0 * branch.share);
        // The lightest yellow would not be seen on white.
        let colour = shade(index as f64, 0.0, 1.15 * (found.len() - 1).max(1) as f64);
        let points = of.iter().filter(|(_, motion)| *motion == index);
        Curve::new(name, colour, Mark::Dots(8.0), points.map(|([at, rate], _)| (*at, *rate)))
    });
    let span = |index: usize| {
        let values = || of.iter().map(|(start, _)| start[index]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let plot = Plot {
        title: title.clone(),
        across: Axis::linear("displacement at the start [m]", span(0), 8),
        up: Axis::linear("velocity at the start [m/s]", span(1), 8),
        curves: curves.collect(),
    };
    if !is_page(path) {
        return draw((900, 640), &[plot]).map_err(Failure::Input);
    }
    let mut charts = Charts::default();
    let chart = charts.place(&Plot { title: String::new(), ..plot }, Look { height: 560, group: None });
    let body = format!("<h1>{}</h1>\n{HINT}{chart}{}", escaped(&title), charts.scripts());
    Ok(document(&title, &body))
}
