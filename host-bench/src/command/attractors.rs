//! `attractors`: the steady motions to which starts of a scene lead.

use std::cmp::Reverse;
use std::path::PathBuf;

use comfy_table::presets;

use super::files::Outputs;
use super::sweep::Axis;
use super::sweep::picture::kinds;
use super::{NODE, SceneArguments, check_overrides, count, one_more, print, with_progress};
use crate::accuracy::{Statements, print_warnings, run_as_it_is};
use crate::attractors::{self, End, Place, UNSETTLED, branches, ends, failed, motions, settled};
use crate::method::Failure;
use crate::name::Name;
use crate::outcome::{Branch, Fields, Format, Outcome, fields};
use crate::report::chart::MARKS;
use crate::report::setting::distinct_labels;
use crate::rows::{Digits, Rows};
use crate::run::{run_scene, try_each};
use crate::scene_file;
use crate::shift::{start, started};

/// The parts of both axes by which each start is beside the one before, which fill the square evenly (Roberts's sequence R2).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// The help of `--accuracy`.
const ACCURACY: &str = "Relative error of the mean power to aim at, by exponential Radau; the tolerance follows [default: 1e-4; \
                        a bump-stop scene has its default steps]";

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: that of its runs on all cores: a second for triboelectric scenes, minutes for a beam that \
                  hits a stop",
    mut_arg("accuracy", |arg| arg.help(ACCURACY))
)]
pub struct AttractorsArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Starts, the first that of the scene, the others spread evenly over displacement and velocity
    #[arg(long, value_name = "COUNT", default_value_t = 64, value_parser = count::<u32>(4..=100_000))]
    starts: u32,
    /// Write the starts over displacement and velocity, each with the sign of its motion (.svg), or a page with zoom (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
}

/// Runs the scene from its starts and prints the motions, that of most starts first.
pub(super) fn run(arguments: &AttractorsArguments) -> Result<(), Failure> {
    let SceneArguments { scene: file, options, overrides, format } = &arguments.scene;
    let scene = scene_file::read(file, overrides)?;
    check_overrides(overrides, &[NODE])?;
    let outputs = Outputs::of(file, overrides)?;
    outputs.check_picture("--picture", &arguments.picture)?;
    let outcome = run_scene(&scene, options)?;
    let place = Place::new(&scene, &outcome).ok_or_else(|| {
        let reason = "must be a moving harvester under a sine, sines or repeated bursts, with a load that takes power and is \
                      no storage, for its attractors";
        Failure::of_file(&scene, reason)
    })?;
    let later = settled(&scene, &outcome, scene.run.settle_s);
    let unsettled = later.is_none().then(|| UNSETTLED.to_owned());
    let later = later.unwrap_or(scene);
    let side = f64::from(arguments.starts).sqrt().ceil() as usize;
    let [displacements, velocities] = place.ranges();
    // The last one goes across.
    let axes =
        [("velocity at the start [m/s]", velocities), ("displacement at the start [m]", displacements)]
            .map(|(name, ends)| Axis::new(name, ends, side, false));
    let at = |number: u32, axis: usize| axes[axis].at((STEPS[axis] * f64::from(number)).fract());
    // Of a slider some places would be nearer to an edge than they are: they are left out.
    let spread =
        (1..).map(|number| [at(number, 1), at(number, 0)]).filter(|start| place.within(*start) == *start);
    let spread = spread.take(arguments.starts as usize - 1);
    let starts: Vec<[f64; 2]> = std::iter::once(start(&later)).chain(spread).collect();
    let ends = with_progress("starts", starts.len(), |bar| ends(&later, options, &starts, || one_more(bar)));
    let mut motions = motions(&ends);
    motions.sort_by_key(|motion| Reverse(motion.len()));
    let found = branches(&motions, starts.len());
    let stated = |branch: &Branch| {
        let from = started(&later, [branch.displacement_m, branch.velocity_m_per_s]);
        run_as_it_is(&from, &attractors::options(&later, options))
    };
    let outcomes = try_each(&found, stated)?;
    let doubts: Vec<String> = unsettled.into_iter().chain(failed(&ends, starts.len())).collect();
    if let Some(path) = &arguments.picture {
        let title = Name::of_file(file).line();
        // Of more motions than there are signs the rarest have one sign.
        let named = if motions.len() > MARKS { MARKS - 1 } else { motions.len() };
        let (named, others) = motions.split_at(named);
        let rest = others.concat();
        let rest_name = format!("{} other motions, {} of {} starts", others.len(), rest.len(), starts.len());
        let rest = (!rest.is_empty()).then(|| (rest_name, rest.iter().map(|end| end.start).collect()));
        let kinds = kinds(&title, &axes, named.iter().map(|motion| basin(motion, starts.len())).chain(rest));
        outputs.keep(path, kinds.of_file(path)?);
    }
    print_warnings(&Statements::of(&outcomes).fields(&doubts));
    print(&text(&found, &outcomes, &doubts, *format))?;
    outputs.ended()
}

/// What a motion is called, and the starts that lead to it, with the last axis first.
fn basin(motion: &[&End], starts: usize) -> (String, Vec<[f64; 2]>) {
    let period = motion[0].period.map_or_else(String::new, |period| format!(", period {period}"));
    let power = distinct_labels(&[motion[0].power_w], "W").concat();
    let name = format!("{power}{period}, {} of {starts} starts", motion.len());
    (name, motion.iter().map(|end| end.start).collect())
}

const COLUMNS: [&str; 7] =
    ["mean_power_w", "period", "share", "starts", "displacement_m", "velocity_m_per_s", "accuracy_total"];

/// A row for each motion, with the statement and the warnings of its first run, those of the command first.
fn text(found: &[Branch], runs: &[Outcome], doubts: &[String], format: Format) -> String {
    let row = |(branch, outcome): (&Branch, &Outcome)| -> Fields {
        fields(branch).into_iter().chain(Statements::of([outcome]).fields(doubts)).collect()
    };
    let rows = Rows(found.iter().zip(runs).map(row).collect());
    let columns = COLUMNS.map(|name| (name, name, Digits::Six));
    rows.text(format, |rows| rows.table(presets::NOTHING, &columns, 0))
}
