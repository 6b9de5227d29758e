//! The native half of the Python package `vibration_harvester`: results as JSON text and arrays as bytes, which
//! `vibration_harvester/__init__.py` turns into dictionaries and NumPy arrays.
//!
//! Options are those of the command line, parsed and checked by the same code. The interpreter lock is released while
//! the engine runs in a thread of its own, and the caller looks for signals such as Ctrl-C.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use clap::Parser;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use host_bench::accuracy::run_with_accuracy;
use host_bench::command::line::Command;
use host_bench::command::printed;
use host_bench::method::{Failure, Options};
use host_bench::outcome::{Format, Outcome, fields, number, text};
use host_bench::run::{run_scene, try_each};
use host_bench::scene_file::{self, Override, Scene};
use model_core::energy::ResponseMap;
use model_core::energy::response_map::{Branch, Response};

#[pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use super::{command, look_up, response_map, run, sweep};
}

/// The options of `run` and `sweep` as the command line has them.
#[derive(clap::Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Given {
    #[command(flatten)]
    options: Options,
}

/// Bad input is a `ValueError`, a run that could not be stepped to its end a `RuntimeError`.
fn raised(failure: Failure) -> PyErr {
    match failure {
        Failure::Input(text) => PyValueError::new_err(text),
        Failure::Step(text) | Failure::StepLimitExceeded(text) => PyRuntimeError::new_err(text),
    }
}

/// Time from one look for signals to the next.
const LOOK: Duration = Duration::from_millis(50);

/// The result of a computation in a thread of its own. A signal, such as Ctrl-C, ends the wait with its exception and sets
/// the flag by which the computation begins nothing new; what it has begun it ends unseen.
fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    compute: impl FnOnce(&AtomicBool) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let stopped = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stopped);
    let (sender, mut receiver) = channel();
    let thread = std::thread::spawn(move || {
        // After a signal nobody waits.
        let _ = sender.send(compute(&flag));
    });
    loop {
        let (found, again) = py.detach(move || (receiver.recv_timeout(LOOK), receiver));
        receiver = again;
        match found {
            Ok(found) => return found.map_err(raised),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stopped.store(true, Ordering::Relaxed))?;
            }
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => return Err(PyRuntimeError::new_err("the computation ended without a result")),
            },
        }
    }
}

/// Parses arguments such as `["--tolerance", "1e-3"]`.
fn parsed<A: Parser>(given: &[String]) -> Result<A, Failure> {
    A::try_parse_from(given).map_err(|error| {
        let text = error.to_string();
        // Behind the error stands how the command line is used.
        let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
        let line = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        Failure::Input(line.trim_start_matches("error: ").to_owned())
    })
}

fn options(given: &[String]) -> Result<Options, Failure> {
    let options = parsed::<Given>(given)?.options;
    options.check()?;
    Ok(options)
}

fn overrides(set: &[(String, String)]) -> Vec<Override> {
    set.iter().map(|(key, value)| Override::new(key, value)).collect()
}

fn outcome(scene: &Scene, options: &Options, states_accuracy: bool) -> Result<Outcome, Failure> {
    if states_accuracy { run_with_accuracy(scene, options) } else { run_scene(scene, options) }
}

/// Columns of a recording, and its rows one after the other as the bytes of doubles of this machine.
type Trace = (Vec<&'static str>, Py<PyBytes>);

/// Runs a scene: the result of `run --format json`, and the recorded motion where `trace_every_s` is given.
#[pyfunction]
fn run(
    py: Python<'_>,
    scene: PathBuf,
    set: Vec<(String, String)>,
    given: Vec<String>,
    how: (Option<f64>, bool, bool),
) -> PyResult<(String, Option<Trace>)> {
    let (trace_every_s, steady_state, states_accuracy) = how;
    let found = interruptible(py, move |_| {
        let options = Options { trace_every_s, steady_state, ..options(&given)? };
        options.check()?;
        let scene = scene_file::read(&scene, &overrides(&set)).map_err(Failure::from)?;
        outcome(&scene, &options, states_accuracy)
    })?;
    let trace = found.trace.as_ref().map(|recording| {
        let bytes: Vec<u8> = recording.rows.iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
        (recording.columns.to_vec(), PyBytes::new(py, &bytes).unbind())
    });
    Ok((found.text(Format::Json), trace))
}

/// Runs a scene at some points, each with a value for each of `keys`, on all cores: one JSON object for each point. A run that
/// fails is an object with `error`.
#[pyfunction]
fn sweep(
    py: Python<'_>,
    scene: PathBuf,
    set: Vec<(String, String)>,
    keys: Vec<String>,
    points: Vec<Vec<f64>>,
    given: Vec<String>,
    how: (bool, bool),
) -> PyResult<Vec<String>> {
    let (steady_state, states_accuracy) = how;
    interruptible(py, move |stopped| {
        let options = Options { steady_state, ..options(&given)? };
        let read = |values: &Vec<f64>| {
            let mut changes = overrides(&set);
            let at_point = keys.iter().zip(values);
            changes.extend(at_point.map(|(key, value)| Override::new(key, &number(*value)).by("over")));
            let scene = scene_file::read(&scene, &changes).map_err(Failure::from)?;
            options.check_scene(&scene)?;
            Ok(scene)
        };
        let scenes = try_each(&points, read)?;
        let run = |scene: &Scene| {
            if stopped.load(Ordering::Relaxed) {
                return Err(Failure::Step("stopped by a signal".to_owned()));
            }
            match outcome(scene, &options, states_accuracy) {
                Ok(found) => Ok(found.text(Format::Json)),
                Err(Failure::Input(text)) => Err(Failure::Input(text)),
                Err(failure) => Ok(text(&serde_json::json!({ "error": failure.to_string() }), Format::Json)),
            }
        };
        try_each(&scenes, run)
    })
}

/// A command with its arguments, as the command line has them.
#[derive(clap::Parser)]
#[command(no_binary_name = true, disable_help_flag = true, disable_help_subcommand = true)]
struct Call {
    #[command(subcommand)]
    command: Command,
}

/// Runs a command, whose name is the first argument: what it prints.
#[pyfunction]
fn command(py: Python<'_>, given: Vec<String>) -> PyResult<String> {
    interruptible(py, move |_| {
        let Call { command } = parsed(&given)?;
        printed(|| command.run())
    })
}

/// The words of a map as little-endian bytes, the fingerprint of its harvester, its agreement with the full model as JSON, its
/// picture as SVG, its page as HTML, and its Rust module.
type Map = (Py<PyBytes>, u32, String, String, String, String);

/// Makes the response map of a scene; `command` is named in the head of the module.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the package calls it, no person")]
fn response_map(
    py: Python<'_>,
    scene: PathBuf,
    set: Vec<(String, String)>,
    ranges: [[f64; 2]; 2],
    voltages: Vec<f64>,
    places: (f64, usize, u64),
    given: Vec<String>,
    command: String,
) -> PyResult<Map> {
    let ([amplitudes, frequencies], (error, places, seed)) = (ranges, places);
    let (found, name) = interruptible(py, move |_| {
        let options = options(&given)?;
        let scene = scene_file::read(&scene, &overrides(&set)).map_err(Failure::from)?;
        let request = host_bench::map::Request { amplitudes, frequencies, voltages, error, places, seed };
        request.check()?;
        let found = host_bench::map::map(&scene, &request, &options, &|_| ())?;
        Ok((found, scene.name().to_owned()))
    })?;
    let agreement = text(&fields(&found.agreement), Format::Json);
    let [picture, page] = host_bench::map::drawn(&found, &name).map_err(raised)?;
    let image = PyBytes::new(py, &host_bench::map::bytes(&found)).unbind();
    Ok((
        image,
        found.image.fingerprint,
        agreement,
        picture,
        page,
        host_bench::map::module(&found, &name, &command),
    ))
}

/// Looks places up in the words of a map, as a node does: value, lower and upper bound of each as the bytes of doubles,
/// not-a-number outside the map; and 0 for the lower motion, 1 for the upper, 2 for both, 3 outside.
#[pyfunction]
fn look_up<'py>(
    py: Python<'py>,
    image: &[u8],
    fingerprint: u32,
    places: Vec<[f64; 2]>,
    voltage: Option<f64>,
) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyBytes>)> {
    let words: Vec<u16> = image.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    let map = ResponseMap::new(&words[..], fingerprint);
    let map = map.map_err(|error| PyValueError::new_err(format!("image: is no map: {error}")))?;
    let (mut values, mut motions) = (Vec::new(), Vec::new());
    for [amplitude, frequency] in places.into_iter().map(|place| place.map(|number| number as f32)) {
        let found = match voltage {
            Some(voltage) => map.at_voltage(amplitude, frequency, voltage as f32),
            None => map.at(amplitude, frequency),
        };
        let income = found.income();
        let numbers = income.map_or([f64::NAN; 3], |of| [of.value, of.low, of.high].map(f64::from));
        values.extend(numbers.iter().flat_map(|number| number.to_ne_bytes()));
        motions.push(match found {
            Response::One { branch: Branch::Lower, .. } => 0,
            Response::One { branch: Branch::Upper, .. } => 1,
            Response::Two { .. } => 2,
            Response::Outside(_) => 3,
        });
    }
    Ok((PyBytes::new(py, &values), PyBytes::new(py, &motions)))
}
