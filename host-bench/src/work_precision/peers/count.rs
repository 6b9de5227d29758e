//! Instructions of a run, counted by valgrind.

use std::process::Command;

use harvester_peers::{Case, Method};

use super::{cases, scene};
use crate::method::Failure;
use crate::scene_file::RunSpan;

/// The subcommand that makes one run.
const RUN_ONE: &str = "work-precision-row";

/// Whether instructions can be counted.
pub(super) fn available() -> bool {
    let version = Command::new("valgrind").arg("--version").output();
    version.is_ok_and(|output| output.status.success())
}

/// Counts the instructions of a method on a case, less those of a run of no duration.
pub(super) struct Counter<'a> {
    case: &'a Case,
    method: Method,
    start_up: f64,
}

impl<'a> Counter<'a> {
    /// Counts the start of the program and of the method; `setting` is any with which the method runs.
    pub(super) fn new(case: &'a Case, method: Method, setting: f64) -> Result<Self, Failure> {
        Ok(Self { case, method, start_up: instructions(case, method, setting, 0.0)? })
    }

    /// Instructions per simulated second of a run of so many seconds.
    pub(super) fn of(&self, setting: f64, duration_s: f64) -> Result<f64, Failure> {
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
    let told = String::from_utf8_lossy(&output.stderr);
    let counted = told.lines().find_map(|line| line.split_once("I refs:").or(line.split_once("I   refs:")));
    let count = counted.and_then(|(_, count)| count.trim().replace(',', "").parse().ok());
    count.filter(|_| output.status.success()).ok_or_else(|| {
        let last = told.lines().last().unwrap_or("no output");
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
