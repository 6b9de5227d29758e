//! The points of a sweep or a tolerance: a scene with values for some keys, run on all cores and kept as they are done.

use std::path::{Path, PathBuf};

use super::rows::{Rows, file_of};
use crate::accuracy::run_with_accuracy;
use crate::attractors::add_branches;
use crate::budget::day_numbers;
use crate::command::files::{Outputs, make_folder};
use crate::command::rows::Parts;
use crate::command::{
    NODE, SceneArguments, StorageVoltage, check_keys, fail_after_result, note, one_more, print, with_progress,
};
use crate::input::{self, MOST_OF_DATA};
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::outcome::{Fields, Outcome, STABLE, fields, flattened, number, rows_csv};
use crate::report::Picture;
use crate::report::setting::{margin, setting};
use crate::run::{run_scene, stopped_as_text, try_each, try_run_scene};
use crate::scene_file::{self, Override, Scene};
use crate::stability::{build, fnv_1a};

#[derive(Debug, Clone, Default, clap::Args)]
pub(in crate::command) struct PointArguments {
    #[command(flatten)]
    pub(in crate::command) scene: SceneArguments,
    /// Write the table, the picture and the page, named as the command (such as sweep.csv, sweep.svg and sweep.html), into this
    /// folder; points are kept there as they are done, and a command that was interrupted goes on from them when it is given again
    #[arg(long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Seek the periodic steady state under one sine by shooting at each point, in place of the run; the
    /// run where there is none that is stable
    #[arg(long)]
    steady_state: bool,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Simulate the day of the scene's node at each point too, as budget does: numbers node_…, and keys node.…
    #[arg(long)]
    node: bool,
    /// Run each point once only: without the accuracy statement, and a bump-stop scene with its default steps
    #[arg(long)]
    no_accuracy: bool,
    /// Leave out the runs of each point from displaced starts; --no-accuracy leaves them out too
    #[arg(long)]
    single_start: bool,
    #[command(flatten)]
    parts: Parts,
}

impl PointArguments {
    /// Each point run once: without an accuracy statement, displaced starts, files and node.
    pub(in crate::command) fn of_single_runs(scene: SceneArguments) -> Self {
        Self { scene, no_accuracy: true, single_start: true, ..Self::default() }
    }

    pub(in crate::command) fn options(&self) -> Options {
        Options { steady_state: self.steady_state, ..self.scene.options }
    }
}

/// Points of a command, by their numbers.
pub(in crate::command) struct Points<'a> {
    pub(in crate::command) arguments: &'a PointArguments,
    /// The command, which names its files.
    pub(in crate::command) command: &'static str,
    /// The keys, each with the option that gives its values.
    pub(in crate::command) keys: Vec<(&'static str, &'a str)>,
    pub(in crate::command) count: usize,
    /// The values of the keys at a point.
    pub(in crate::command) values: Box<dyn Fn(usize) -> Vec<f64> + Sync + 'a>,
    /// What was asked for beside the arguments: other points are of another command.
    pub(in crate::command) asked: String,
    /// Whether to make the runs beside the steady states.
    pub(in crate::command) compare: bool,
}

pub(in crate::command) struct Point {
    pub(in crate::command) values: Vec<(String, f64)>,
    pub(in crate::command) found: Result<Fields, String>,
    /// The cost of the steady state against that of the run, if a steady state was sought.
    pub(super) compared: Option<Compared>,
}

/// The points that were run, and the files that wait for them.
pub(in crate::command) struct Done {
    pub(in crate::command) points: Vec<Point>,
    outputs: Outputs,
    rows: Option<Rows>,
}

impl Points<'_> {
    /// Runs all points. Bad input at any of them refuses the whole command before it begins; one that fails on its way has its
    /// error in place of its outcome. The command reads these files beside the scene. `None`: it does one part of the points.
    pub(in crate::command) fn run(&self, others: &[PathBuf]) -> Result<Option<Done>, Failure> {
        let PointArguments { scene, output, storage_voltage, parts, .. } = self.arguments;
        let options = self.arguments.options();
        options.check()?;
        storage_voltage.check(options.steady_state)?;
        let outputs = Outputs::of(&scene.scene, &scene.overrides)?.and(others);
        let all: Vec<usize> = (0..self.count).collect();
        try_each(&all, |&index| options.check_scene(&self.scene(&(self.values)(index))?))?;
        // A key that is set may vary about that value.
        let is_about = |key: &str| self.keys.iter().any(|one| one.0 != "--over" && one.1 == key);
        let overrides = scene.overrides.iter().map(|change| ("--set", change.key()));
        let overrides = overrides.filter(|(_, key)| !is_about(key));
        let keys: Vec<(&str, &str)> = overrides.chain(self.keys.iter().copied()).collect();
        check_keys(&keys, &storage_voltage.unused(if self.arguments.node { &[] } else { &[NODE] }))?;
        let rows = match output {
            Some(folder) => {
                let files = self.files();
                check_folder(folder, &files)?;
                // Other parts may be at work in this folder.
                let tables = files.each_ref().map(String::as_str);
                let tables = if parts.is_one() { &[] } else { &tables[..] };
                outputs.check_in("--output", folder, tables)?;
                make_folder(folder)?;
                outputs.check("--output", &parts.file(&folder.join(file_of(self.command))))?;
                Some(Rows::open(folder, self.command, &self.identity()?, (*parts, self.count))?)
            }
            None => None,
        };
        let own: Vec<usize> = all.into_iter().filter(|index| parts.has(*index)).collect();
        if let Some(done) = rows.as_ref().map(Rows::count).filter(|done| *done > 0) {
            note(&format!("{done} of {} points were done before", own.len()));
        }
        let stage = format!("{} {}", self.command, self.keys.first().map_or("", |(_, key)| key));
        let points = with_progress(stage, own.len(), |bar| {
            try_each(&own, |&index| {
                let point = self.point(&options, index, rows.as_ref());
                one_more(bar);
                point
            })
        })?;
        if parts.is_one() {
            let failed = points.iter().filter(|point| point.found.is_err()).count();
            note(&format!("{} points of this part are done, {failed} of them failed", points.len()));
            return Ok(None);
        }
        Ok(Some(Done { points, outputs, rows }))
    }

    /// Writes the table of the points, and the picture if there is one, prints the result, and fails if a point did.
    pub(in crate::command) fn end(
        &self,
        Done { points, outputs, rows }: Done,
        picture: Option<&Picture>,
        text: &str,
    ) -> Result<(), Failure> {
        if let Some(folder) = &self.arguments.output {
            let [table, drawings @ ..] = self.files().map(|name| folder.join(name));
            make_folder(folder)?;
            outputs.keep(&table, csv(&points));
            for (file, picture) in drawings.iter().zip(picture.iter().cycle()) {
                outputs.keep(file, picture.of_file(file)?);
            }
        }
        print(text)?;
        outputs.ended()?;
        // The rows wait no longer.
        rows.into_iter().for_each(Rows::remove);
        let mut failed = points.iter().filter_map(|point| Some((point, point.found.as_ref().err()?)));
        let Some((point, error)) = failed.next() else { return Ok(()) };
        let (count, all, place) = (1 + failed.count(), points.len(), point.place());
        fail_after_result(format!("{count} of {all} points failed, the first at {place}: {error}"))
    }

    fn files(&self) -> [String; 3] {
        ["csv", "svg", "html"].map(|ending| format!("{}.{ending}", self.command))
    }

    pub(in crate::command) fn scene(&self, values: &[f64]) -> Result<Scene, Failure> {
        let (file, overrides) = (&self.arguments.scene.scene, self.overrides(values));
        let mut scene = match self.arguments.node {
            true => scene_file::read_with_node(file, &overrides)?.0,
            false => scene_file::read(file, &overrides)?,
        };
        self.arguments.storage_voltage.hold(&mut scene)?;
        Ok(scene)
    }

    /// The title of their picture: the file, the method, the parameters without these, and the smallest margin.
    pub(in crate::command) fn title(&self, found: &[Point], without: &[&str]) -> Result<String, Failure> {
        let file = Name::of_file(&self.arguments.scene.scene).line();
        let method = found.iter().find_map(|point| point.text("method")).unwrap_or("no run");
        let parameters = setting(&self.scene(&(self.values)(0))?, without);
        let limits = found.iter().filter_map(|point| point.found.as_ref().ok()?.get("limits")?.as_array());
        let limits = limits.flatten().filter_map(|one| Some((one["name"].as_str()?, one["margin"].as_f64())));
        let smallest = margin(limits);
        Ok(format!("{file}, {method}: {parameters}{smallest}"))
    }

    fn overrides(&self, values: &[f64]) -> Vec<Override> {
        let keys = self.keys.iter().zip(values);
        let keys = keys.map(|((option, key), value)| Override::new(key, &number(*value)).by(option));
        self.arguments.scene.overrides.iter().cloned().chain(keys).collect()
    }

    /// The numbers of a point, without its statement.
    pub(in crate::command) fn numbers(&self, index: usize) -> Result<Fields, Failure> {
        let values = (self.values)(index);
        let numbers = fields(&run_scene(&self.scene(&values)?, &self.arguments.options())?);
        Ok(flattened(numbers).into_iter().chain(self.day(&values)?).collect())
    }

    /// The numbers of the day of the node, if it is simulated.
    fn day(&self, values: &[f64]) -> Result<Fields, Failure> {
        match self.arguments.node {
            true => day_numbers(&self.arguments.scene.scene, &self.overrides(values)),
            false => Ok(Fields::new()),
        }
    }

    /// Runs the point of a number, unless it was done before.
    fn point(&self, options: &Options, index: usize, rows: Option<&Rows>) -> Result<Point, Failure> {
        let PointArguments { no_accuracy, single_start, .. } = *self.arguments;
        let numbers = (self.values)(index);
        let values = self.keys.iter().zip(&numbers).map(|((_, key), value)| ((*key).to_owned(), *value));
        let values = values.collect();
        if let Some(found) = rows.and_then(|rows| rows.known(index)) {
            return Ok(Point { values, found, compared: None });
        }
        let scene = self.scene(&numbers)?;
        let run = if no_accuracy { run_scene } else { run_with_accuracy };
        let mut found = stopped_as_text(run(&scene, options))?;
        if let (Ok(outcome), false) = (&mut found, no_accuracy || single_start) {
            add_branches(&scene, options, outcome);
        }
        let compared = match &found {
            Ok(outcome) => compared(&scene, outcome, self.compare.then_some(options))?,
            Err(_) => None,
        };
        let found = match found {
            Ok(outcome) => stopped_as_text(self.day(&numbers))?
                .map(|day| fields(&outcome).into_iter().chain(day).collect()),
            Err(error) => Err(error),
        };
        rows.map_or(Ok(()), |rows| rows.add(index, &found))?;
        Ok(Point { values, found, compared })
    }

    /// Which points they are: the build, the files that are read, and what was asked for.
    fn identity(&self) -> Result<String, Failure> {
        // The same points in another folder or format are the same.
        let PointArguments { scene, output: _, steady_state, storage_voltage, .. } = self.arguments;
        let PointArguments { no_accuracy, single_start, node, .. } = self.arguments;
        let flags = [*steady_state, self.compare, *no_accuracy, *single_start, *node];
        let asked = (&scene.options, &scene.overrides, &self.asked, storage_voltage, flags);
        let mut asked = format!("{asked:?}").into_bytes();
        for file in scene_file::files(&scene.scene, &scene.overrides)? {
            let content = input::read(&file, MOST_OF_DATA)
                .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", file.display())))?;
            asked.extend(content);
        }
        Ok(format!("{} {:016x}", build(), fnv_1a(&asked)))
    }
}

/// Refuses a new folder with the name of a file.
fn check_folder(folder: &Path, [table, drawing, page]: &[String; 3]) -> Result<(), Failure> {
    let ending = folder.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !["csv", "svg", "html", "json"].contains(&ending.as_str()) || folder.exists() {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "--output {}: must be a folder, into which {table}, {drawing} and {page} are written, is named as a file",
        folder.display()
    )))
}

impl Point {
    pub(in crate::command) fn number(&self, name: &str) -> Option<f64> {
        self.found.as_ref().ok()?.get(name)?.as_f64()
    }

    /// Whether it was run with an accuracy statement, known or not.
    pub(super) fn is_stated(&self) -> bool {
        self.warnings().any(|warning| warning.starts_with("accuracy:"))
    }

    pub(in crate::command) fn text(&self, name: &str) -> Option<&str> {
        self.found.as_ref().ok()?.get(name)?.as_str()
    }

    /// Whether a steady state was sought and its numbers are of the run, for want of a stable orbit.
    pub(in crate::command) fn is_of_a_run(&self) -> bool {
        self.text("steady_state").is_some_and(|verdict| verdict != STABLE)
    }

    pub(super) fn warnings(&self) -> impl Iterator<Item = &str> {
        let list = self.found.as_ref().ok().and_then(|fields| fields.get("warnings")?.as_array());
        list.into_iter().flatten().filter_map(|warning| warning.as_str())
    }

    pub(super) fn place(&self) -> String {
        let short = |value: f64| format!("{value:.6e}").parse().unwrap_or(value);
        let place = |(key, value): &(String, f64)| format!("{key} = {}", short(*value));
        self.values.iter().map(place).collect::<Vec<_>>().join(", ")
    }

    /// Its names and values: those of its outcome, or its error.
    pub(super) fn row(&self) -> Fields {
        let mut row: Fields = self.values.iter().map(|(key, value)| (key.clone(), (*value).into())).collect();
        match &self.found {
            Ok(fields) => row.extend(fields.clone()),
            Err(error) => row.extend([("error".to_owned(), error.as_str().into())]),
        }
        row
    }
}

/// One point: the steady state, and the run of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compared {
    /// Simulated periods of each.
    pub(super) periods: [f64; 2],
    /// Time of each in s, if the run was made.
    pub(super) seconds: Option<[f64; 2]>,
    pub(super) is_stable: bool,
}

/// Compares the steady state with the run, which is made by these options if there are any; `None` without a steady state.
fn compared(
    scene: &Scene,
    outcome: &Outcome,
    compare: Option<&Options>,
) -> Result<Option<Compared>, Failure> {
    let (Some(steady), Some(frequency)) = (&outcome.steady_state, scene.excitation.single_frequency()) else {
        return Ok(None);
    };
    let run = |options: &Options| try_run_scene(scene, &Options { steady_state: false, ..*options });
    // A run that fails leaves nothing to compare with.
    let run = compare.map(run).transpose()?.and_then(Result::ok);
    Ok(Some(Compared {
        periods: [steady.simulated_periods, frequency * scene.run.duration_s],
        seconds: run.map(|run| [outcome.processor_s, run.processor_s]),
        is_stable: outcome.is_of_an_orbit(),
    }))
}

pub(super) fn csv(points: &[Point]) -> String {
    let rows: Vec<Fields> = points.iter().map(|point| flattened(point.row())).collect();
    let run = points.iter().position(|point| point.found.is_ok()).unwrap_or(0);
    let mut columns: Vec<String> = rows.get(run).into_iter().flat_map(Fields::keys).cloned().collect();
    columns.retain(|column| column != "error");
    columns.push("error".to_owned());
    rows_csv(&columns, &rows)
}
