//! `optimise`: the values of a few keys at which a number of the result is best.

use std::fmt::Write;
use std::path::PathBuf;

use super::files::Outputs;
use super::fit::{beside, folder};
use super::{
    NODE, SceneArguments, StorageVoltage, check_keys, count, json_text, next_stage, one_more, print,
    progress, warn,
};
use crate::fit::{Entry, fitted_scene};
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::optimise::{Constraint, Optimum, Point, Range, Request, Runs, most_runs, optimise, picture};
use crate::outcome::{Branch, Format, folded, shown, small, text};
use crate::report::setting::{margin, named, number_and_unit};
use crate::scene_file::Scene;

/// Points of the grid for each of one to four keys.
const GRID: [usize; 4] = [41, 15, 7, 5];
/// Most points of the grid.
const MOST: usize = 100_000;
/// The constraint of `--keep-margins`.
const MARGINS: &str = "impossible_margin>=1";

#[derive(Debug, Clone, clap::Args)]
#[command(group(clap::ArgGroup::new("sought").required(true)))]
#[command(
    override_usage = "host-bench optimise --maximise|--minimise QUANTITY --over KEY=LOW:HIGH[:log] [OPTIONS] SCENE"
)]
pub struct OptimiseArguments {
    /// The number of the result that shall be largest, such as mean_power_w
    #[arg(long, alias = "maximize", value_name = "QUANTITY", group = "sought")]
    maximise: Option<String>,
    /// The number of the result that shall be smallest
    #[arg(long, alias = "minimize", value_name = "QUANTITY", group = "sought")]
    minimise: Option<String>,
    /// A key of the scene and its range; one to four
    #[arg(long = "over", value_name = "KEY=LOW:HIGH[:log]", required = true, allow_hyphen_values = true)]
    ranges: Vec<Range>,
    /// A bound of a number of the result, such as "peak_gap_m<=0.004"; may be repeated
    #[arg(long = "subject-to", value_name = "QUANTITY<=VALUE")]
    constraints: Vec<Constraint>,
    /// Keep every limit of the model beyond which nothing real is: --subject-to "impossible_margin>=1"
    #[arg(long)]
    keep_margins: bool,
    /// Points of the coarse grid for each key [default: 41, 15, 7 or 5 for one to four keys]
    #[arg(long, value_name = "COUNT", value_parser = count::<usize>(3..=MOST as u64))]
    grid: Option<usize>,
    /// Seek the periodic steady state under one sine by shooting at each point, in place of the run
    #[arg(long)]
    steady_state: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Simulate the day of the scene's node at each point too, as budget does: quantities node_…, and keys node.…
    #[arg(long)]
    node: bool,
    /// Run the best point from its own start only
    #[arg(long)]
    single_start: bool,
    /// Write the scene with the best values, and a picture beside it (.svg)
    #[arg(long, value_name = "BEST.toml")]
    output: Option<PathBuf>,
    /// Write a curve over the key, or a map over the first two, with the best point (.svg); or a page with zoom, the values
    /// at the pointer and the way of the search (.html)
    #[arg(long, value_name = "FILE.svg|.html")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArguments,
}

/// How long it takes, for the help.
pub(super) fn run_time() -> String {
    let most = |is_constrained: bool| {
        let [one, two, three, four] =
            [1, 2, 3, 4].map(|keys| most_runs(keys, GRID[keys - 1], is_constrained));
        format!("{one}, {two}, {three} and {four}")
    };
    format!(
        "Run time: that of its runs on all cores: at most {} of them over one to four keys, with constraints {}; most searches \
         end after a quarter of them",
        most(false),
        most(true)
    )
}

/// Seeks the optimum, writes the files, and prints the result.
pub(super) fn run(arguments: &OptimiseArguments) -> Result<(), Failure> {
    let SceneArguments { scene: file, options, overrides, format } = &arguments.scene;
    let options = Options { steady_state: arguments.steady_state, ..*options };
    options.check()?;
    arguments.storage_voltage.check(arguments.steady_state)?;
    let grid = grid(arguments)?;
    let keys = overrides.iter().map(|change| ("--set", change.key()));
    let keys = keys.chain(arguments.ranges.iter().map(|range| ("--over", range.key.as_str())));
    let unused = &[NODE, ("fit", "[fit] is of the command fit")][usize::from(arguments.node)..];
    check_keys(&keys.collect::<Vec<_>>(), &arguments.storage_voltage.unused(unused))?;
    let outputs = Outputs::of(file, overrides)?;
    let pictures = [arguments.output.as_deref().and_then(beside), arguments.picture.clone()];
    for path in arguments.output.iter().chain(&pictures[0]) {
        outputs.check("--output", path)?;
    }
    outputs.check_picture("--picture", &arguments.picture)?;
    let of_margins: Option<Constraint> = arguments.keep_margins.then(|| MARGINS.parse().ok()).flatten();
    let bar = progress("", 0);
    let request = Request {
        file,
        overrides,
        options,
        hold: &|scene: &mut Scene| arguments.storage_voltage.hold(scene),
        done: &|| one_more(&bar),
        runs: Runs::default(),
        quantity: arguments.maximise.clone().or(arguments.minimise.clone()).unwrap_or_default(),
        is_largest: arguments.maximise.is_some(),
        ranges: arguments.ranges.clone(),
        constraints: arguments.constraints.iter().cloned().chain(of_margins).collect(),
        grid,
        node: arguments.node,
        single_start: arguments.single_start,
    };
    // A search may end before its most runs.
    let found = optimise(&request, &|stage, count| next_stage(&bar, stage, count));
    bar.finish_and_clear();
    let found = found?;
    found.warnings().for_each(|warning| warn(warning));
    let name = Name::of_file(file).line();
    let sought = if request.is_largest { "largest" } else { "smallest" };
    let words = number_and_unit(&request.quantity).0;
    let title = format!("{name}: {sought} {words}{}", margin(named(&found.outcome.margins)));
    let picture = picture(&found, &request, title);
    for path in pictures.iter().flatten() {
        outputs.keep(path, picture.of_file(path)?);
    }
    if let Some(path) = &arguments.output {
        let is_moved = folder(path) != folder(file);
        outputs.keep(path, fitted_scene(file, overrides, &entries(&found, &request), is_moved)?);
    }
    let text = match format {
        Format::Json => json_text(&found.json(&request))?,
        Format::Csv => text(&short(&found, &request), Format::Csv),
        Format::Table => for_people(&found, &request),
    };
    print(&text)?;
    outputs.ended()
}

/// Points of the grid for each key.
fn grid(arguments: &OptimiseArguments) -> Result<usize, Failure> {
    let keys = arguments.ranges.len();
    let refuse = |text: String| Err(Failure::Input(text));
    let Some(default) = keys.checked_sub(1).and_then(|index| GRID.get(index)) else {
        return refuse(format!("--over: must be given one to four times, is given {keys} times"));
    };
    let count = arguments.grid.unwrap_or(*default);
    let all = u32::try_from(keys).ok().and_then(|keys| count.checked_pow(keys));
    if all.is_none_or(|all| all > MOST) {
        return refuse(format!("--grid {count}: must have at most {MOST} points over {keys} keys"));
    }
    Ok(count)
}

fn entries(found: &Optimum, request: &Request<'_>) -> Vec<Entry> {
    let sought = if request.is_largest { "largest" } else { "smallest" };
    let values = Optimum::values(request, &found.best).into_iter().zip(&found.flat);
    let entry = |((key, value), [low, high]): ((String, f64), &[f64; 2])| Entry {
        key,
        value,
        comment: format!("{sought} {}, within 1 % from {low:.4e} to {high:.4e}", request.quantity),
    };
    values.map(entry).collect()
}

/// The result without the numbers of the best run; each constraint as a field of its own.
fn short(found: &Optimum, request: &Request<'_>) -> serde_json::Map<String, serde_json::Value> {
    let mut all = found.json(request);
    all.remove("result");
    for constraint in all.get_mut("constraints").and_then(|all| all.as_array_mut()).into_iter().flatten() {
        constraint["name"] = constraint["constraint"].take();
        constraint.as_object_mut().map(|fields| fields.remove("constraint"));
    }
    all
}

fn for_people(found: &Optimum, request: &Request<'_>) -> String {
    let json = found.json(request);
    let number = |key: &str| json.get(key).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let mut text = String::new();
    let sought = if request.is_largest { "largest" } else { "smallest" };
    let _ = writeln!(text, "{sought} {}: {:.6e}", request.quantity, number("value"));
    if let Some((value, Branch { share, starts, .. })) = found.better(request) {
        let line = "a motion from other starts is better at these values";
        let _ = writeln!(text, "{line}: {value:.6e}, of {:.0} of {starts} starts", share * *starts as f64);
    }
    let place = |point: &Point, flat: &[[f64; 2]], text: &mut String| {
        let values = Optimum::values(request, point).into_iter().zip(flat);
        for (index, ((key, value), [low, high])) in values.enumerate() {
            let bound = if point.is_at_bound(index) { ", at its bound" } else { "" };
            let _ =
                writeln!(text, "  {key} = {value:.6e}{bound}, within 1 % of it from {low:.4e} to {high:.4e}");
        }
    };
    place(&found.best, &found.flat, &mut text);
    for (point, flat) in &found.others {
        let value = point.value().unwrap_or(f64::NAN);
        let best = found.best.value().unwrap_or(f64::NAN);
        let _ = writeln!(
            text,
            "another optimum: {:.6e}, {:.2} % off the {sought}",
            request.signed(value),
            100.0 * (best - value).abs() / best.abs()
        );
        place(point, flat, &mut text);
    }
    if let Some(without) = &found.unconstrained {
        for constraint in json["constraints"].as_array().into_iter().flatten() {
            let active = if constraint["active"] == true { ", active" } else { "" };
            let name = constraint["constraint"].as_str().unwrap_or_default();
            let _ = writeln!(text, "subject to {name}: {}{active}", shown(&constraint["value"]));
        }
        let place = Optimum::values(request, without);
        let place: Vec<String> =
            place.into_iter().map(|(key, value)| format!("{key} = {value:.4e}")).collect();
        let without = format!(
            "without constraints {:.6e} at {}: they cost {:.2} %",
            number("unconstrained_value"),
            place.join(", "),
            100.0 * number("constraint_cost_relative")
        );
        text += &(folded(&without, 2) + "\n");
    }
    let stated = small(found.outcome.accuracy.total);
    let _ = writeln!(text, "accuracy of the mean power there: {stated}");
    let [runs, failed] = found.runs;
    let _ = writeln!(text, "{runs} runs, {failed} failed");
    let _ = writeln!(text, "{}", folded(&format!("searched: {}", found.searched), 2));
    text
}
