//! The commands of the binary.

mod attractors;
mod budget;
mod design;
mod export;
mod files;
mod findings;
mod fit;
mod keys;
pub mod line;
mod map;
mod needs;
mod node_strategies;
pub mod on_target;
mod optimise;
mod plot;
mod resonance;
mod rows;
mod run;
mod stability;
mod stop;
mod sweep;
mod tolerance;
mod work_precision;

use std::borrow::Cow;
use std::cell::RefCell;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::method::{Failure, Options};
use crate::name::Name;
use crate::outcome::{Format, folded};
pub(crate) use crate::report::file::{set_width_mm, width_mm};
use crate::scene_file::{Override, Scene, contains, finite_number_in, replaces};
use harvester_scene::progress;

/// Arguments that `run`, `sweep` and `resonance` have in common.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct SceneArguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub options: Options,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Another value for a key of the scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<Override>,
}

/// The scene file of a command that has other options than [`SceneArguments`].
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct FileArguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Another value for a key of the scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
}

/// The shipped scenes of the reports.
pub(crate) const SHIPPED_SCENES: [&str; 3] = ["contact-separation", "sliding", "bump-stop"];

/// A key or a table of a scene that a command does not use, and what does.
pub(crate) type Unused = (&'static str, &'static str);
/// The table of which only `budget` makes use.
pub(crate) const NODE: Unused =
    ("node", "[node] is of the command budget; sweep, tolerance and optimise take it with --node");

/// Refuses options that set a key of the scene which `unused` has, or which a later one replaces. An option is its name
/// and its key, in the order in which they apply.
pub(crate) fn check_keys(options: &[(&str, &str)], unused: &[Unused]) -> Result<(), Failure> {
    for (index, (option, key)) in options.iter().enumerate() {
        if let Some((_, reason)) = unused.iter().find(|(table, _)| contains(table, key)) {
            return Err(Failure::Input(format!("{option} {key}: is not used here: {reason}")));
        }
        if let Some((other, before)) = options[..index].iter().find(|(_, before)| replaces(key, before)) {
            let text = format!("{option} {key}: must not be given after {other} {before}, which it replaces");
            return Err(Failure::Input(text));
        }
    }
    Ok(())
}

/// As [`check_keys`], for the option `--set` alone.
pub(crate) fn check_overrides(overrides: &[Override], unused: &[Unused]) -> Result<(), Failure> {
    let options: Vec<(&str, &str)> = overrides.iter().map(|change| ("--set", change.key())).collect();
    check_keys(&options, unused)
}

/// An override as a command line has it.
pub(crate) fn set_option(change: &Override) -> String {
    format!(" --set {}", Name::new(format!("{}={}", change.key(), change.value())).shell())
}

/// Prints a failure as one line on standard error, and gives its exit code.
pub fn report(failure: &Failure) -> ExitCode {
    print_line(&format!("error: {failure}"));
    ExitCode::from(match failure {
        Failure::Input(_) => 2,
        Failure::Step(_) | Failure::StepLimitExceeded(_) => 3,
    })
}

/// Prints a line on standard error; control characters are spaces.
pub(crate) fn print_line(line: &str) {
    let line = line.replace(char::is_control, " ");
    // Without a standard error nothing can be printed.
    let _ = writeln!(std::io::stderr(), "{line}");
}

pub(crate) fn warn(text: &str) {
    print_folded(&format!("warning: {text}"));
}

fn print_folded(text: &str) {
    folded(&text.replace(char::is_control, " "), 2).lines().for_each(print_line);
}

thread_local! {
    /// What a command of this thread has printed, while [`printed`] runs it.
    static PRINTED: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs a command for a caller in this process. Returns what it prints on standard output. `budget` and `plot` then write no file
/// that their options do not name.
///
/// # Errors
/// Those of the command, but for a part of the result that could not be had: the result says so.
pub fn printed(run: impl FnOnce() -> Result<(), Failure>) -> Result<String, Failure> {
    PRINTED.set(Some(String::new()));
    let done = run();
    let text = PRINTED.take().unwrap_or_default();
    done.map(|()| text)
}

/// Whether the command runs for a caller in this process.
pub(crate) fn is_called() -> bool {
    PRINTED.with_borrow(Option::is_some)
}

/// Fails, after the result was printed, by what the result says too.
pub(crate) fn fail_after_result(reason: String) -> Result<(), Failure> {
    if is_called() { Ok(()) } else { Err(Failure::Step(reason)) }
}

/// Prints the result on standard output, or on standard error if a file goes to standard output, without control characters but line breaks and tabs.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let text = text.replace(|letter: char| letter.is_control() && !['\n', '\t'].contains(&letter), "");
    let called = PRINTED.with_borrow_mut(|printed| printed.as_mut().map(|printed| printed.push_str(&text)));
    if called.is_some() {
        return Ok(());
    }
    let is_taken = files::OUTPUT_IS_A_FILE.load(Ordering::Relaxed);
    let mut output: Box<dyn Write> =
        if is_taken { Box::new(std::io::stderr().lock()) } else { Box::new(std::io::stdout().lock()) };
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Reads the value of an option that is a count, within bounds.
pub(crate) fn count<T: TryFrom<u64>>(
    bounds: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    move |text| {
        let count = text.parse().ok().filter(|count| bounds.contains(count));
        count
            .and_then(|count| T::try_from(count).ok())
            .ok_or_else(|| format!("must be a whole number from {} to {}", bounds.start(), bounds.end()))
    }
}

/// A bar of a stage of the work on standard error, if that is a terminal.
pub(crate) fn progress(stage: impl Into<Cow<'static, str>>, count: usize) -> ProgressBar {
    let target = if is_quiet() { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(count as u64), target).with_message(stage);
    let template =
        ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {elapsed} elapsed, {eta} to go");
    match template {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Ends a stage of the work, and begins the next one, of `count` cases.
pub(crate) fn next_stage(bar: &ProgressBar, stage: &'static str, count: usize) {
    bar.reset();
    bar.set_message(stage);
    bar.set_length(count as u64);
}

/// The result of work with a progress bar over `count` cases, which is gone after it.
pub(crate) fn with_progress<T>(
    stage: impl Into<Cow<'static, str>>,
    count: usize,
    work: impl FnOnce(&ProgressBar) -> T,
) -> T {
    let bar = progress(stage, count);
    let found = work(&bar);
    bar.finish_and_clear();
    found
}

/// Counts one more case of a long command on the bar.
pub(crate) fn one_more(bar: &ProgressBar) {
    more(bar, 1);
}

/// Counts more work on the bar. Where the bar is hidden, prints a line for each tenth of it, after the first seconds.
pub(crate) fn more(bar: &ProgressBar, work: u64) {
    bar.inc(work);
    // A search may take more cases than were foreseen.
    bar.set_length(bar.length().unwrap_or(0).max(bar.position()));
    let (done, all) = (bar.position(), bar.length().unwrap_or(0));
    let elapsed = bar.elapsed().as_secs_f64();
    // Whether this completes a tenth.
    let is_tenth = done * 10 / all.max(1) > done.saturating_sub(work) * 10 / all.max(1);
    if bar.is_hidden() && is_tenth && elapsed >= EVERY.as_secs_f64() {
        let to_go = elapsed * all.saturating_sub(done) as f64 / done as f64;
        let stage = bar.message();
        note(&format!("{stage}: {} %  {elapsed:.0} s elapsed, {to_go:.0} s to go", 100 * done / all));
    }
}

/// A value as JSON over several lines, line break included.
pub(crate) fn json_text(value: &impl serde::Serialize) -> Result<String, Failure> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(Failure::Input(format!("--format json: {error}"))),
    }
}

/// Highest voltage of a storage or bus in V, as in a scene file.
const HIGHEST_V: f64 = 1e6;
/// Keys of a storage that a held voltage replaces.
const REPLACED: [Unused; 5] = [
    ("load.voltage_v", "--storage-voltage gives the voltage"),
    ("load.capacitance_f", "--storage-voltage holds the voltage of the storage"),
    ("load.initial_v", "--storage-voltage holds the voltage of the storage"),
    ("load.leakage_ohm", "--storage-voltage holds the voltage of the storage"),
    ("load.draw", "--storage-voltage holds the voltage of the storage"),
];

#[derive(Debug, Clone, Copy, Default, clap::Args)]
struct StorageVoltage {
    /// Hold the voltage of the storage or bus behind the bridge at this value in V
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = finite_number_in("V", "V"))]
    storage_voltage: Option<f64>,
}

impl StorageVoltage {
    fn is_given(self) -> bool {
        self.storage_voltage.is_some()
    }

    /// The keys that a command does not use, with those that the option replaces.
    fn unused(self, others: &[Unused]) -> Vec<Unused> {
        let replaced: &[Unused] = if self.is_given() { &REPLACED } else { &[] };
        [others, replaced].concat()
    }

    fn hold(self, scene: &mut Scene) -> Result<(), Failure> {
        let Some(voltage) = self.storage_voltage else { return Ok(()) };
        if !(0.0..=HIGHEST_V).contains(&voltage) {
            let text = format!("--storage-voltage {voltage}: must be a number from 0 to {HIGHEST_V:e}");
            return Err(Failure::Input(text));
        }
        scene.load = scene.load.with_voltage(voltage).ok_or_else(|| {
            Failure::of_file(
                scene,
                "load.kind: must be a bridge (\"rectified-store\", \"dc-bus\") with --storage-voltage",
            )
        })?;
        Ok(())
    }

    /// Refuses the option without `--steady-state`.
    fn check(self, steady_state: bool) -> Result<(), Failure> {
        if self.is_given() && !steady_state {
            return Err(Failure::Input("--storage-voltage: must be with --steady-state".to_owned()));
        }
        Ok(())
    }
}

/// Time from one line to the next, and before the first.
const EVERY: Duration = Duration::from_secs(3);

/// Time from one look at the progress to the next.
const LOOK: Duration = Duration::from_millis(100);

/// Whether only errors and warnings are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Prints errors and warnings only from here on.
pub(crate) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints on standard error what is neither an error nor a warning.
pub(crate) fn note(text: &str) {
    if !is_quiet() {
        print_folded(text);
    }
}

/// Prints every few seconds how far the runs of this process are, until it is dropped.
pub(crate) struct Watch {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    pub(crate) fn new() -> Self {
        if is_quiet() {
            return Self { stop: None, thread: None };
        }
        let (stop, stopped) = mpsc::channel::<()>();
        let (before, ..) = progress::read();
        let thread = thread::spawn(move || {
            let (mut run, mut began, mut reported) = (before, Instant::now(), Instant::now());
            // The sender is dropped where the watch is.
            while stopped.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                let (runs, part, done) = progress::read();
                if runs != run {
                    (run, began) = (runs, Instant::now());
                }
                if reported.elapsed() >= EVERY {
                    reported = Instant::now();
                    print_line(&line(
                        run.saturating_sub(before).max(1),
                        part,
                        done,
                        began.elapsed().as_secs_f64(),
                    ));
                }
            }
        });
        Self { stop: Some(stop), thread: Some(thread) }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A display that panicked has nothing more to show.
            let _ = thread.join();
        }
    }
}

/// How far a run is, what it does in a second, and how long it will take if it goes on like that.
fn line(run: u64, part: f64, done: [u64; 2], elapsed_s: f64) -> String {
    let to_go = if part > 0.0 && elapsed_s > 0.0 {
        format!(", about {:.0} s to go", elapsed_s * (1.0 - part) / part)
    } else {
        String::new()
    };
    // A run that has only begun has no rate yet.
    let [steps, events] = done.map(|count| count as f64 / elapsed_s.max(LOOK.as_secs_f64()));
    let rates = format!("{steps:.0} steps and {events:.0} events a second");
    format!("run {run}: {:.1} % done, {elapsed_s:.0} s elapsed{to_go}; {rates}", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_to_go_follows_from_the_part_that_is_done() {
        let quarter = "run 1: 25.0 % done, 10 s elapsed, about 30 s to go; 500 steps and 2 events a second";
        assert_eq!(line(1, 0.25, [5000, 20], 10.0), quarter);
        assert_eq!(
            line(2, 0.0, [0, 0], 3.0),
            "run 2: 0.0 % done, 3 s elapsed; 0 steps and 0 events a second"
        );
    }
}
