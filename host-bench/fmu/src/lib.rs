//! FMI 3.0 for co-simulation: the functions that an importer calls, over a scene on the embedded core in `f64`.
//!
//! The scene is the file `scene.toml` in the resources of the FMU, so that one library serves all scenes. A state of the FMU is a
//! snapshot of the core. A function that an FMU for co-simulation needs not support returns `fmi3Error`.
//!
//! As FMI demands, a pointer of the importer is null or valid for the call, and an instance is called by one thread at a time.
#![allow(non_snake_case, reason = "the names of FMI")]
#![allow(improper_ctypes_definitions, reason = "an importer does not look into an instance or a state")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::slice;

use harvester_engine::embedded::{CoSimulation, co_simulation, fingerprint};
use harvester_scene::method::Failure;
use harvester_scene::scene_file;
use model_core::scalar::Polynomial;

/// `fmi3Status`.
type Status = c_int;
const OK: Status = 0;
const ERROR: Status = 3;
const FATAL: Status = 4;

/// Environment, status, category, message.
type LogMessage = Option<extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// `fmi3Instance`.
struct Instance {
    simulation: Box<dyn CoSimulation>,
    /// The state at its start.
    first: Vec<u8>,
    environment: *mut c_void,
    message: LogMessage,
}

/// `fmi3FMUState`: a snapshot.
struct State(Vec<u8>);

/// An instance of the importer; null is `None`.
type One<'a> = Option<&'a mut Instance>;

/// A place of the importer for a result, which may be null.
type Place<'a, T> = Option<&'a mut MaybeUninit<T>>;

/// What `run` returns; a failure or a panic goes to the importer as a message.
fn guarded<T>(
    environment: *mut c_void,
    message: LogMessage,
    run: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Status> {
    let (status, text) = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(value)) => return Ok(value),
        Ok(Err(failure)) => (ERROR, failure.to_string()),
        Err(_) => (FATAL, "panic".to_owned()),
    };
    if let (Some(message), Ok(text)) = (message, CString::new(text)) {
        message(environment, status, c"logStatusError".as_ptr(), text.as_ptr());
    }
    Err(status)
}

/// Calls `run` with an instance.
fn call(one: One<'_>, run: impl FnOnce(&mut Instance) -> Result<(), Failure>) -> Status {
    let Some(instance) = one else { return ERROR };
    guarded(instance.environment, instance.message, || run(instance)).err().unwrap_or(OK)
}

fn put<T>(place: Place<'_, T>, value: T) {
    if let Some(place) = place {
        place.write(value);
    }
}

/// An array of the importer.
fn array<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: the importer passes an array of `count` values, valid for the call.
    if values.is_null() || count == 0 { &[] } else { unsafe { slice::from_raw_parts(values, count) } }
}

/// An array of the importer for results.
fn places<'a, T>(values: *mut MaybeUninit<T>, count: usize) -> &'a mut [MaybeUninit<T>] {
    // SAFETY: the importer passes room for `count` values, valid for the call and not read or written by others.
    if values.is_null() || count == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(values, count) } }
}

/// Value references with as many values: all variables are scalars.
fn paired<I: ExactSizeIterator>(
    at: &[u32],
    values: I,
) -> Result<impl Iterator<Item = (&u32, I::Item)>, Failure> {
    let counts = (at.len(), values.len());
    let error = || Failure::Input(format!("{} values for {} value references", counts.1, counts.0));
    (counts.0 == counts.1).then(|| at.iter().zip(values)).ok_or_else(error)
}

/// A text of the importer; empty for null.
fn text<'a>(text: *const c_char) -> Result<&'a str, Failure> {
    // SAFETY: the importer passes a string that ends with a zero, valid for the call.
    let text = if text.is_null() { c"" } else { unsafe { CStr::from_ptr(text) } };
    text.to_str().map_err(|error| Failure::Input(error.to_string()))
}

/// The bytes of a state of the importer.
fn saved(state: Option<&State>) -> Result<&[u8], Failure> {
    state.map(|state| &*state.0).ok_or_else(|| Failure::Input("FMUState: is null".to_owned()))
}

fn simulation(token: *const c_char, resources: *const c_char) -> Result<Box<dyn CoSimulation>, Failure> {
    let scene = scene_file::read(&Path::new(text(resources)?).join("scene.toml"), &[])?;
    let (token, expected) = (text(token)?, format!("{:08x}", fingerprint(&scene)?));
    if token != expected {
        return Err(Failure::of_file(&scene, format!("instantiationToken = {token}: must be {expected}")));
    }
    co_simulation::<Polynomial>(&scene)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    message: LogMessage,
    _update: *const c_void,
) -> Option<Box<Instance>> {
    let made = guarded(environment, message, || {
        let simulation = simulation(token, resources)?;
        let first = simulation.save()?;
        Ok(Box::new(Instance { simulation, first, environment, message }))
    });
    made.ok()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3FreeInstance(_instance: Option<Box<Instance>>) {}

#[unsafe(no_mangle)]
extern "C" fn fmi3EnterInitializationMode(
    one: One<'_>,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
) -> Status {
    call(one, |instance| instance.simulation.begin(start_s))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3Reset(one: One<'_>) -> Status {
    call(one, |instance| instance.simulation.restore(&instance.first))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetFloat64(
    one: One<'_>,
    at: *const u32,
    count: usize,
    values: *mut MaybeUninit<f64>,
    n: usize,
) -> Status {
    call(one, |instance| {
        let mut pairs = paired(array(at, count), places(values, n).iter_mut())?;
        pairs.try_for_each(|(&reference, place)| {
            place.write(instance.simulation.get(reference as usize)?);
            Ok(())
        })
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetFloat64(
    one: One<'_>,
    at: *const u32,
    count: usize,
    values: *const f64,
    n: usize,
) -> Status {
    call(one, |instance| {
        let mut pairs = paired(array(at, count), array(values, n).iter())?;
        pairs.try_for_each(|(&reference, &value)| instance.simulation.set(reference as usize, value))
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3DoStep(
    one: One<'_>,
    at_s: f64,
    step_s: f64,
    _no_state_before: bool,
    event_needed: Place<'_, bool>,
    terminate: Place<'_, bool>,
    early_return: Place<'_, bool>,
    last_time: Place<'_, f64>,
) -> Status {
    call(one, |instance| {
        [event_needed, terminate, early_return].into_iter().for_each(|place| put(place, false));
        let done = instance.simulation.advance(at_s, step_s);
        put(last_time, instance.simulation.get(0)?);
        done
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetFMUState(one: One<'_>, state: Option<&mut Option<Box<State>>>) -> Status {
    call(one, |instance| {
        let saved = Box::new(State(instance.simulation.save()?));
        // An earlier state of the importer is freed; null is `None`.
        state.map(|state| state.replace(saved));
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetFMUState(one: One<'_>, state: Option<&State>) -> Status {
    call(one, |instance| instance.simulation.restore(saved(state)?))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3FreeFMUState(_one: One<'_>, state: Option<&mut Option<Box<State>>>) -> Status {
    state.map(Option::take);
    OK
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SerializedFMUStateSize(
    one: One<'_>,
    state: Option<&State>,
    size: Place<'_, usize>,
) -> Status {
    call(one, |_| {
        put(size, saved(state)?.len());
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SerializeFMUState(
    one: One<'_>,
    state: Option<&State>,
    bytes: *mut MaybeUninit<u8>,
    size: usize,
) -> Status {
    call(one, |_| {
        let (state, places) = (saved(state)?, places(bytes, size));
        if places.len() < state.len() {
            return Err(Failure::Input(format!("size = {size}: must be at least {}", state.len())));
        }
        places.iter_mut().zip(state).for_each(|(place, &byte)| put(Some(place), byte));
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3DeserializeFMUState(
    one: One<'_>,
    bytes: *const u8,
    size: usize,
    state: Place<'_, Option<Box<State>>>,
) -> Status {
    call(one, |_| {
        put(state, Some(Box::new(State(array(bytes, size).to_vec()))));
        Ok(())
    })
}

/// Functions with one result. The caller removes arguments that a function does not name. An importer may need the symbols of all.
macro_rules! constant {
    ($result:expr, $type:ty: $($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> $type {
            $result
        }
    )*};
}

constant! { OK, Status: fmi3ExitInitializationMode fmi3EnterStepMode fmi3Terminate fmi3SetDebugLogging }
constant! { None, Option<Box<Instance>>: fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }
constant! { ERROR, Status:
    fmi3EnterEventMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetInt64
    fmi3GetUInt64 fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64
    fmi3SetUInt64 fmi3SetBoolean fmi3SetString fmi3SetBinary fmi3SetClock
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3GetOutputDerivatives
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3ActivateModelPartition
    fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime fmi3SetContinuousStates
    fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates
    fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates
}
