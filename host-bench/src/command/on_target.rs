//! `on-target`: what the models cost on a microcontroller.

mod cores;
mod node;
pub(super) mod rows;
mod work_precision;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use comfy_table::presets;
use firmware_example::workload::contact_separation::{self, SMOOTH, SMOOTH_STEP, SMOOTH_TOLERANCES};
use firmware_example::workload::{bump_stop, named, peer, sliding};
use serde_json::Value;

use super::count;
use super::files::Outputs;
use crate::method::Failure;
use crate::on_target::qemu::{self, Core};
use crate::on_target::{Bench, Error, build, day, native};
use crate::outcome;
use crate::run::each;
use crate::scene_file::finite_number_in;
use rows::{Case, Column, RADAU, Row, Steps};

/// Build the firmware for each core, run it under QEMU, check its bits against the host, and report instructions, flash, RAM and stack.
#[derive(Debug, Clone, Args)]
pub struct OnTargetArguments {
    /// The cores, separated by commas [default: all; M4F where one of the options below is given]
    #[arg(long, value_delimiter = ',', value_name = "CORE")]
    core: Vec<Core>,

    /// How long a run may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120,
        value_parser = |text: &str| count::<u64>(1..=86_400)(&finite_number_in("s", "SECONDS")(text)?.to_string()))]
    time_limit: u64,

    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Error against instructions, over tolerances, fixed steps and methods
    #[arg(long, group = "report")]
    work_precision: bool,

    /// The sensor node: a day with losses of power, its log compared with the host's [default: M4F and M0]
    #[arg(long, group = "report")]
    node: bool,

    /// Make the day of the sensor node with the full model, and write it into this file for the firmware's build
    #[arg(long, group = "report", value_name = "FILE")]
    day: Option<PathBuf>,

    /// What an estimate costs for each sample, and a look-up in a response map for each call [default: M4F and M0]
    #[arg(long, group = "report")]
    estimators: bool,

    /// The smooth scene by the crate numeris beside ours
    #[arg(long, group = "report")]
    peer: bool,
}

/// Prints the chosen report.
///
/// # Errors
///
/// At the first core whose firmware does not build or run, or computes other bits than the host.
pub fn run(arguments: &OnTargetArguments) -> Result<(), Error> {
    if let Some(file) = &arguments.day {
        let outputs = Outputs::of_shipped([]);
        let failed = |failure: Failure| Error::File { path: "--day".into(), what: failure.to_string() };
        outputs.check("", file).map_err(failed)?;
        outputs.keep(file, day::table(&day::day()?));
        return outputs.ended().map_err(failed);
    }
    build::workspace().map_err(|what| Error::File { path: "on-target".into(), what })?;
    qemu::find()?;
    let limit = Duration::from_secs(arguments.time_limit);
    let mut output = Output { format: arguments.format, objects: Vec::new() };
    let cores = |default: &[Core]| match &arguments.core[..] {
        [] => default.to_vec(),
        chosen => chosen.to_vec(),
    };
    let of_bench: fn(&Bench, &mut Output) -> Result<(), Error> = if arguments.work_precision {
        work_precision::report
    } else if arguments.estimators {
        estimators
    } else if arguments.peer {
        beside_peer
    } else {
        let all = if arguments.node { &[Core::M4f, Core::M0] } else { Core::value_variants() };
        let cores = cores(all);
        if arguments.node {
            node::report(&cores, limit, &mut output)?;
        } else {
            cores::report(&cores, limit, &mut output)?;
        }
        output.finish();
        return Ok(());
    };
    for core in cores(if arguments.estimators { &[Core::M4f, Core::M0] } else { &[Core::M4f] }) {
        of_bench(&bench(core, limit)?, &mut output)?;
    }
    output.finish();
    Ok(())
}

/// What `run` gives on each core; the cores are built and run side by side.
fn on_each<T: Send>(cores: &[Core], run: impl Fn(Core) -> Result<T, Error> + Sync) -> Result<Vec<T>, Error> {
    each(cores, |&core| run(core)).into_iter().collect()
}

/// The bench on `core`, announced on standard error.
fn bench(core: Core, limit: Duration) -> Result<Bench, Error> {
    announce(core);
    Bench::new(core, limit)
}

fn announce(core: Core) {
    eprintln!("{core}, on the board {}", core.hardware().board);
}

const ESTIMATE: Column = ("estimate", |row| row.workload.name.clone());
const PER_CALL: Column = ("instructions per sample or call", rows::PER_STEP.1);
const PER_SECOND: Column = ("per second", rows::PER_SECOND.1);

/// Measures the estimators of all scenes and the look-up, and prints their instructions.
fn estimators(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    let estimator =
        |scene, method, steps| Case { steps, by_sample: true, ..Case::new("estimator", scene, method) };
    let cases = vec![
        estimator("contact-separation", RADAU, Steps::Tolerance(contact_separation::TOLERANCE)),
        estimator("sliding", RADAU, Steps::Tolerance(sliding::TOLERANCE)),
        estimator("bump-stop", "discrete gradient", Steps::ShortAndLong([bump_stop::SHORT, bump_stop::LONG])),
    ];
    let mut found = rows::measure(bench, &const { named("estimators::all") }, cases)?;
    let look_up = |motions| Case::new("look-up", "contact-separation", motions);
    let cases = vec![
        look_up("one motion"),
        look_up("two motions"),
        Case { by_sample: true, ..Case::new("estimator", "strongest-sine", "bank of lines") },
    ];
    found.extend(rows::measure(bench, &const { named("response_map::all") }, cases)?);
    let columns = [rows::CORE, ESTIMATE, PER_CALL, PER_SECOND, rows::STACK];
    let note =
        "Samples at 400 a second (contact-separation, lines of the band), 367 (sliding) and 3520 (bump-stop).
A response map is called once a second. Each estimate has the host's bits.";
    output.rows(&found, &columns, 2, note);
    Ok(())
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Format {
    /// Tables for people.
    #[default]
    Table,
    /// One JSON array with an object for each row.
    Json,
}

/// Prints tables at once; collects JSON rows until the end.
struct Output {
    format: Format,
    objects: Vec<Value>,
}

impl Output {
    /// A table of measured rows, the first `text` columns to the left, and a note below it.
    fn rows(&mut self, rows: &[Row], columns: &[Column], text: usize, note: &str) {
        let cells = |row: &Row| columns.iter().map(|(_, cell)| cell(row)).collect();
        let header = columns.iter().map(|(heading, _)| *heading).collect();
        self.table(header, rows.iter().map(cells).collect(), text, note);
        self.objects.extend(rows.iter().map(Row::json));
    }

    /// A table for people only.
    fn table(&mut self, header: Vec<&str>, rows: Vec<Vec<String>>, text: usize, note: &str) {
        if self.format == Format::Json {
            return;
        }
        let table = outcome::table(presets::ASCII_MARKDOWN, header, rows, text);
        let paragraphs = note.split(".\n").map(|lines| outcome::folded(&lines.replace('\n', " "), 2));
        println!("{table}{}\n", paragraphs.collect::<Vec<_>>().join(".\n"));
    }

    fn finish(self) {
        if self.format == Format::Json {
            println!("{:#}", Value::Array(self.objects));
        }
    }
}

fn beside_peer(bench: &Bench, output: &mut Output) -> Result<(), Error> {
    let scene = native::scene("contact-separation", &SMOOTH, 0.0)?;
    let case = |method, steps| Case::of_scene("smooth", &scene, method, steps);
    let ours = SMOOTH_TOLERANCES.map(|value| case("model-core, exponential Radau", Steps::Tolerance(value)));
    let explicit = case("model-core, Runge-Kutta 4", Steps::Fixed(SMOOTH_STEP));
    let peer = peer::TOLERANCES.map(|value| case("numeris 0.6, RODAS4", Steps::Tolerance(value)));
    let cases = ours.into_iter().chain([explicit]).chain(peer).collect::<Result<Vec<_>, _>>()?;
    let found = rows::measure(bench, &const { named("peer::smooth") }, cases)?;
    let columns = [rows::METHOD, rows::SETTING, rows::STEPS, rows::ERROR, rows::PER_STEP, rows::PER_SECOND];
    let note = format!(
        "{}. Contact-separation without impacts, 22 Hz, 0.2 g, {} s from rest, both in f32.
Error: of the mean power against the independent reference. numeris has the energy as a fourth state, and time as a
fifth in place of the derivative by time. Instructions as QEMU executes them, which are not cycles.",
        bench.core(),
        scene.run.duration_s,
    );
    output.rows(&found, &columns, 2, &note);
    Ok(())
}
