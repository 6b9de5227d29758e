//! Error against cost of the embedded core alone and of general integrators of other crates, on the same equations.

mod table;

use std::process::Command;
use std::time::Instant;

use serde::Serialize;

use super::least;
use crate::method::Failure;
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{Load, RunSpan, Scene};
use harvester_peers::{Case, Method, PeerRun, Stop, fits};

use rayon::prelude::*;
pub(crate) use table::{csv, draw, text};

/// Errors of mean power at which costs are compared.
pub(crate) const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-5];

/// Instructions are counted of the rows that are the loosest ones to meet one of these errors.
const COUNTED: [f64; 7] = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];

/// Run time in s above which a row is counted only if its cost is compared.
const LONGEST_COUNTED: f64 = 0.02;

/// Runs in a row that are given up for their length, after which tighter settings are not tried: one alone may be unstable.
const MOST_GIVEN_UP: u32 = 3;

/// Most runs that are timed, and seconds after which a row is not run again.
const RUNS: usize = 5;
const SECONDS: f64 = 0.2;

/// A method at one setting on one scene.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(crate) struct Row {
    pub(crate) scene: &'static str,
    /// Load resistance in Ω; `None` behind a bridge.
    load_ohm: Option<f64>,
    pub(crate) method: &'static str,
    /// The crate of a peer.
    #[serde(rename = "crate")]
    package: Option<&'static str>,
    pub(crate) peer: bool,
    tolerance: Option<f64>,
    steps_per_period: Option<f64>,
    /// Relative error of mean power against the reference.
    pub(crate) error: Option<f64>,
    pub(crate) instructions_per_simulated_second: Option<f64>,
    pub(crate) seconds_per_simulated_second: Option<f64>,
    /// The largest processor time over the least, less 1.
    time_spread: Option<f64>,
    steps_per_simulated_second: Option<f64>,
    failure: Option<String>,
}

impl Row {
    /// Instructions where they are counted, else seconds, per simulated second.
    pub(crate) fn cost(&self, by_count: bool) -> Option<f64> {
        if by_count { self.instructions_per_simulated_second } else { self.seconds_per_simulated_second }
    }

    fn setting(&self) -> String {
        match (self.tolerance, self.steps_per_period) {
            (Some(tolerance), _) => format!("{tolerance:.0e}"),
            (None, Some(steps)) => format!("T/{steps}"),
            (None, None) => String::new(),
        }
    }

    fn meets(&self, target: f64) -> bool {
        self.error.is_some_and(|error| error <= target)
    }
}

/// A scene with the rows of all methods.
pub(crate) struct Comparison {
    pub(crate) case: Case,
    mean_power_w: f64,
    /// Rows by method, each from loose to tight.
    pub(crate) methods: Vec<Vec<Row>>,
    pub(crate) by_count: bool,
}

/// The loosest row of a method that meets a target together with the next finer one.
pub(crate) fn reaching(rows: &[Row], target: f64) -> Option<&Row> {
    let pair = rows.windows(2).find(|pair| pair.iter().all(|row| row.meets(target)))?;
    pair.first()
}

impl Comparison {
    /// The cheapest row that meets a target, of the peers or of the core.
    fn best(&self, peer: bool, target: f64) -> Option<&Row> {
        let rows = self.methods.iter().filter_map(|rows| reaching(rows, target));
        let rows = rows.filter(|row| row.peer == peer);
        rows.min_by(|one, other| {
            let cost = |row: &Row| row.cost(self.by_count).unwrap_or(f64::INFINITY);
            cost(one).total_cmp(&cost(other))
        })
    }

    /// Cost of the best peer over that of the best method of the core.
    pub(crate) fn ratio(&self, target: f64) -> Option<f64> {
        let cost = |peer| self.best(peer, target)?.cost(self.by_count);
        Some(cost(true)? / cost(false)?)
    }
}

/// The cases that the command line names.
pub(crate) fn cases(names: &[String]) -> Result<Vec<Case>, Failure> {
    let all = harvester_peers::CASES;
    if names.is_empty() || names.iter().any(|name| name == "all") {
        return Ok(all.to_vec());
    }
    let case = |name: &String| {
        all.iter().find(|case| case.name == name).copied().ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|case| case.name).collect();
            Failure::Input(format!("--peers {name}: must be all or one of {}", known.join(", ")))
        })
    };
    names.iter().map(case).collect()
}

fn scene(case: &Case) -> Result<Scene, Failure> {
    case.scene().map_err(|error| Failure::Input(error.to_string()))
}

/// Runs all methods on a case; `progress` is called with what is done.
pub(crate) fn compare(case: Case, progress: &dyn Fn(&str)) -> Result<Comparison, Failure> {
    let began = Instant::now();
    let scene = scene(&case)?;
    let reference = reference::run(&scene, &ReferenceOptions::default())
        .map_err(|failure| Failure::Step(failure.to_string()))?;
    let mean_power_w = reference.mean_power_w.unwrap_or(f64::NAN);
    let load_ohm = match scene.load {
        Load::Resistor { resistance_ohm } => Some(resistance_ohm),
        Load::RectifiedStore(_) | Load::DcBus { .. } => None,
    };
    let blank = |method: Method, setting: f64| Row {
        scene: case.name,
        load_ohm,
        method: method.name(),
        package: method.peer(),
        peer: method.peer().is_some(),
        tolerance: (!method.is_fixed()).then_some(setting),
        steps_per_period: method.is_fixed().then_some(setting),
        ..Row::default()
    };
    let methods: Vec<Method> = Method::all().filter(|method| fits(&scene, *method)).collect();
    let mut rows: Vec<Vec<Row>> = methods
        .iter()
        .map(|&method| ladder(&scene, method, mean_power_w, &|setting| blank(method, setting)))
        .collect();
    let timed = began.elapsed().as_secs_f64();
    let version = Command::new("valgrind").arg("--version").output();
    let by_count = version.is_ok_and(|output| output.status.success());
    if by_count {
        count(&case, &methods, &mut rows)?;
    }
    let counted = began.elapsed().as_secs_f64() - timed;
    progress(&format!("{}: {timed:.0} s of runs, {counted:.0} s of counting", case.name));
    Ok(Comparison { case, mean_power_w, methods: rows, by_count })
}

/// Runs a method from loose to tight, until two in a row meet the smallest error, or [`MOST_GIVEN_UP`] are given up.
fn ladder(scene: &Scene, method: Method, reference: f64, blank: &dyn Fn(f64) -> Row) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut given_up = 0;
    for setting in method.settings() {
        let mut row = blank(setting);
        match timed(scene, method, setting) {
            Ok((found, spread)) => {
                row.time_spread = spread;
                let error = ((found.mean_power_w - reference) / reference).abs();
                given_up = 0;
                row.error = error.is_finite().then_some(error);
                row.seconds_per_simulated_second = Some(found.seconds_per_simulated_second);
                row.steps_per_simulated_second = Some(found.steps_per_simulated_second);
            }
            Err(stop) => {
                row.failure = Some(stop.to_string());
                given_up = if let Stop::TooManySteps { .. } = stop { given_up + 1 } else { 0 };
            }
        }
        rows.push(row);
        let last = rows.len().saturating_sub(2);
        let done = rows.len() > 1 && rows[last..].iter().all(|row| row.meets(TARGETS[2]));
        if done || given_up == MOST_GIVEN_UP {
            break;
        }
    }
    rows
}

/// A run with the least of the processor times of some, and their spread.
fn timed(scene: &Scene, method: Method, setting: f64) -> Result<(PeerRun, Option<f64>), Stop> {
    let began = Instant::now();
    let found = harvester_peers::run(scene, method, setting)?;
    let mut times = vec![found.seconds_per_simulated_second];
    while times.len() < RUNS && began.elapsed().as_secs_f64() < SECONDS {
        times.push(harvester_peers::run(scene, method, setting)?.seconds_per_simulated_second);
    }
    let (seconds_per_simulated_second, spread) = least(&times);
    Ok((PeerRun { seconds_per_simulated_second, ..found }, spread))
}

fn is_counted(row: &Row, rows: &[Row], duration_s: f64) -> bool {
    let is_short = row.seconds_per_simulated_second.is_some_and(|s| s * duration_s <= LONGEST_COUNTED);
    let targets = COUNTED.iter().filter(|target| is_short || TARGETS.contains(target));
    let mut loosest = targets.filter_map(|&target| reaching(rows, target));
    loosest.any(|other| std::ptr::eq(row, other))
}

/// Counts the instructions of rows, two at a time.
fn count(case: &Case, methods: &[Method], rows: &mut [Vec<Row>]) -> Result<(), Failure> {
    let duration_s = scene(case)?.run.duration_s;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let threads = threads.map_err(|error| Failure::Input(format!("--peers: {error}")))?;
    threads.install(|| {
        methods.par_iter().zip(rows).try_for_each(|(&method, rows)| {
            let counted: Vec<bool> = rows.iter().map(|row| is_counted(row, rows, duration_s)).collect();
            let mut counted: Vec<(&mut Row, f64)> = (rows.iter_mut().zip(counted))
                .filter(|(_, counted)| *counted)
                .filter_map(|(row, _)| row.tolerance.or(row.steps_per_period).map(|setting| (row, setting)))
                .collect();
            let Some(&(_, setting)) = counted.first() else { return Ok(()) };
            let counter = Counter::new(case, method, setting)?;
            counted.par_iter_mut().try_for_each(|(row, setting)| {
                row.instructions_per_simulated_second = Some(counter.of(*setting, duration_s)?);
                Ok(())
            })
        })
    })
}

/// The subcommand that makes one run.
const RUN_ONE: &str = "work-precision-row";

/// Counts the instructions of a method on a case, less those of a run of no duration.
struct Counter<'a> {
    case: &'a Case,
    method: Method,
    start_up: f64,
}

impl<'a> Counter<'a> {
    /// Counts the start of the program and of the method; `setting` is any with which the method runs.
    fn new(case: &'a Case, method: Method, setting: f64) -> Result<Self, Failure> {
        Ok(Self { case, method, start_up: instructions(case, method, setting, 0.0)? })
    }

    /// Instructions per simulated second of a run of so many seconds.
    fn of(&self, setting: f64, duration_s: f64) -> Result<f64, Failure> {
        Ok((instructions(self.case, self.method, setting, duration_s)? - self.start_up) / duration_s)
    }
}

/// Instructions of a process that simulates so many seconds.
fn instructions(case: &Case, method: Method, setting: f64, duration_s: f64) -> Result<f64, Failure> {
    let failed = |reason: String| Failure::Input(format!("valgrind: {reason}"));
    let program = std::env::current_exe().map_err(|error| failed(error.to_string()))?;
    let output = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(program)
        .args([RUN_ONE, case.name, method.name(), &setting.to_string(), &duration_s.to_string()])
        .output()
        .map_err(|error| failed(error.to_string()))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let counted = text.lines().find_map(|line| line.split_once("I refs:").or(line.split_once("I   refs:")));
    let count = counted.and_then(|(_, count)| count.trim().replace(',', "").parse().ok());
    count.filter(|_| output.status.success()).ok_or_else(|| {
        let last = text.lines().last().unwrap_or("no output");
        failed(format!("{} of {}: {last}", method.name(), case.name))
    })
}

/// Makes one run of the named case and method, to be counted.
pub(crate) fn run_one(case: &str, method: &str, setting: f64, duration_s: f64) -> Result<(), Failure> {
    let unknown = || Failure::Input(format!("{RUN_ONE} {case} {method}: no such method"));
    let method = Method::named(method).ok_or_else(unknown)?;
    let case = cases(&[case.to_owned()])?.pop().ok_or_else(unknown)?;
    let mut scene = scene(&case)?;
    scene.run = RunSpan { duration_s, settle_s: 0.0 };
    harvester_peers::run(&scene, method, setting).map_err(|stop| Failure::Step(stop.to_string()))?;
    Ok(())
}

#[cfg(test)]
mod tests;
