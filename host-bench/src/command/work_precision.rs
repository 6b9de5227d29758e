//! `work-precision`: error against run time.

use std::path::PathBuf;

use super::files::{Outputs, make_folder, report_folder};
use super::{NODE, SHIPPED_SCENES, check_overrides, json_text, note, one_more, print, progress};
use crate::method::Failure;
use crate::outcome::Format;
use crate::report::report;
use crate::scene_file::{self, Model, Override, Scene};
use crate::work_precision::grid::{self, Grid};
use crate::work_precision::{self, Comparison, Extent, table};

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: three minutes of one core for the shipped scenes")]
pub struct WorkPrecisionArguments {
    /// Scene files; without any, the shipped scenes at several loads
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// What auto chooses, against the cheapest choice that is accurate enough, over loads, force laws and excitations
    #[arg(long, conflicts_with = "scenes")]
    grid: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of each scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    /// Beside peers: the core alone and general integrators of other crates, on these scenes of a fixed list, or on all;
    /// needs the feature peers
    #[arg(long, value_name = "NAME", num_args = 0.., conflicts_with_all = ["scenes", "overrides", "grid"])]
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

/// Runs the comparison and prints it.
pub fn run(arguments: &WorkPrecisionArguments) -> Result<(), Failure> {
    check_overrides(&arguments.overrides, &[NODE])?;
    if arguments.grid {
        return run_grid(arguments);
    }
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

/// Runs the grid and prints it.
fn run_grid(arguments: &WorkPrecisionArguments) -> Result<(), Failure> {
    let cells = grid::cells(&arguments.overrides)?;
    let bar = progress(cells.len());
    let mut rows = Vec::new();
    for cell in &cells {
        rows.extend(grid::examine(cell)?);
        one_more(&bar);
    }
    bar.finish_and_clear();
    let grid = Grid::of(rows);
    print(&match arguments.format {
        Format::Table => grid::text(&grid),
        Format::Csv => grid::csv(&grid),
        Format::Json => json_text(&grid)?,
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
    use super::files::Outputs;
    use super::{SHIPPED_SCENES, print_line};
    use crate::work_precision::peers;

    let cases = peers::cases(names)?;
    let outputs = Outputs::of_shipped(SHIPPED_SCENES);
    if arguments.csv.is_some() && arguments.csv == arguments.picture {
        return Err(Failure::Input("--picture: must be another file than --csv".to_owned()));
    }
    for (option, file) in [("--csv", &arguments.csv), ("--picture", &arguments.picture)] {
        file.as_ref().map_or(Ok(()), |file| outputs.check(option, file))?;
    }
    let bar = progress(cases.len());
    let compared = |case| {
        let comparison = peers::compare(case, &|line| bar.suspend(|| print_line(line)));
        one_more(&bar);
        comparison
    };
    let comparisons: Vec<_> = cases.into_iter().map(compared).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    if let Some(file) = &arguments.csv {
        outputs.keep(file, peers::csv(&comparisons));
    }
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

/// Makes one run.
#[cfg(feature = "peers")]
pub fn run_row(arguments: &RowArguments) -> Result<(), Failure> {
    let RowArguments { scene, method, setting, duration_s } = arguments;
    work_precision::peers::run_one(scene, method, *setting, *duration_s)
}

/// The shipped scenes of an extent.
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
    let bar = progress(scenes.iter().map(|scene| work_precision::length(scene, extent)).sum());
    let comparisons =
        scenes.iter().map(|scene| work_precision::compare(scene, extent, || bar.inc(1))).collect();
    bar.finish_and_clear();
    comparisons
}

/// The page of the report.
const PAGE: &str = "index.html";

/// Runs the short comparison, prints it and writes the report.
pub fn run_default() -> Result<(), Failure> {
    let scenes = shipped(&[], &Extent::SHORT)?;
    let (outputs, folder) = (Outputs::of_shipped(SHIPPED_SCENES), report_folder());
    outputs.check_in("", &folder, &[PAGE])?;
    let comparisons = compare(&scenes, &Extent::SHORT)?;
    print(&table::text(&comparisons))?;
    let page = report(&comparisons)?;
    make_folder(&folder)?;
    let file = folder.join(PAGE);
    outputs.write(&file, &page)?;
    note(&format!("report: {}", file.display()));
    Ok(())
}
