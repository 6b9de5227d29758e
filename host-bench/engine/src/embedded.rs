//! The embedded core on the host: the very code of the firmware, for any scene file.
//!
//! Every choice that firmware makes at compile time is made here at run time, by the core's `Any…`
//! types; precision and elementary functions are type parameters and dispatched below.

/// What is done with the harvester of a scene: the same for both triboelectric ones, and for bump-stop.
macro_rules! by_harvester {
    ($scene:expr, triboelectric($model:ident) => $one:expr, bump_stop($beam:pat) => $other:expr $(,)?) => {
        match &$scene.model {
            harvester_scene::scene_file::Model::ContactSeparation($model) => $one,
            harvester_scene::scene_file::Model::Sliding($model) => $one,
            harvester_scene::scene_file::Model::BumpStop($beam) => $other,
        }
    };
}

mod auto;
mod bump_stop;
mod co_simulation;
mod contact_separation;
mod continuation;
mod excitation;
mod limits;
mod minutes;
mod report;
mod run;
mod shooting;
mod sliding;
mod store_in_loop;
mod triboelectric;
mod whole_day;

use model_core::scalar::{Libm, Mathematics, Micromath, Polynomial, Scalar};

use self::excitation::with_setting;
use crate::steady_state::{BestLoad, Resonance};
use harvester_scene::method::{Failure, Math, Options, Precision};
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::Scene;

pub use auto::default_accuracy;
pub use bump_stop::{
    ContactInterval, DEFAULT_LONG_STEP_S, DEFAULT_SHORT_STEP_S, DeflectedShape, ShapePoint,
    chattering_phases, contact_intervals, deflected_shapes, parameters as bump_stop_parameters,
};
pub use co_simulation::{CoSimulation, Variable, co_simulation, variables};
pub use contact_separation::parameters as contact_separation_parameters;
pub use continuation::{
    AmplitudeContinuation, Motion, MotionKind, fingerprint, natural_frequency_hz, with_continuation,
};
pub use minutes::{Deviation, LINES, Vibration, energies_by_minute};
pub use shooting::Memory;
pub use sliding::parameters as sliding_parameters;
pub use store_in_loop::{Midnight, StoreInLoop, Stretch};
pub use whole_day::{Daily, WholeDay, whole_day};

/// Relative tolerance per radian of TR-BDF2 where neither step nor tolerance is given.
pub const DEFAULT_TOLERANCE: f64 = 1e-5;

/// Runs a scene on the embedded core.
pub fn run(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    match (options.chosen_precision(), options.math.unwrap_or(Math::Polynomial)) {
        (Precision::F64, Math::Polynomial) => run_as::<f64, Polynomial>(scene, options),
        (Precision::F64, Math::Libm) => run_as::<f64, Libm>(scene, options),
        (Precision::F32, Math::Polynomial) => run_as::<f32, Polynomial>(scene, options),
        (Precision::F32, Math::Libm) => run_as::<f32, Libm>(scene, options),
        (Precision::F32, Math::Micromath) => run_as::<f32, Micromath>(scene, options),
        (Precision::F64, Math::Micromath) => Err(Failure::Input(
            "--math micromath: must be with --precision f32, it has no double precision".to_owned(),
        )),
    }
}

fn run_as<S: Scalar, M: Mathematics<S>>(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    with_setting::<S, M, _>(scene, options, |setting| {
        by_harvester!(scene,
            triboelectric(model) => triboelectric::run::<S, M, _>(setting, model),
            bump_stop(model) => bump_stop::run(setting, model))
    })
}

/// The periodic steady state of a scene under one sine, by shooting; the scene's own run where it has no stable orbit of one period.
pub fn steady_state(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    Ok(steady_state_from(scene, options, None)?.0)
}

/// As [`steady_state`], from a remembered motion of the same harvester under another sine or with other parameters; and the
/// motion that was reached.
///
/// The orbit that continues the remembered one is taken where it is stable. Otherwise the motion goes on from the
/// remembered one; without one it goes from the start.
pub fn steady_state_from(
    scene: &Scene,
    options: &Options,
    memory: Option<&Memory>,
) -> Result<(Outcome, Memory), Failure> {
    match options.math {
        Some(Math::Libm) => shooting::resume::<Libm>(scene, options, memory),
        _ => shooting::resume::<Polynomial>(scene, options, memory),
    }
}

/// The refusal of a bump-stop scene where only a triboelectric scene will do.
fn refuse_bump_stop(scene: &Scene, purpose: &str) -> Failure {
    let name = scene.name();
    Failure::of_file(
        scene,
        format!("scene = {name:?}: must be \"contact-separation\" or \"sliding\" {purpose}"),
    )
}

/// The frequencies of a range in Hz at which the steady state of a scene responds most, by following its orbit upwards over `points`
/// frequencies and then to the peaks; and the simulated periods it took. `None` if the steady state is a stable orbit at no frequency.
///
/// Where two orbits are stable the one is followed on which the path came. Where it ends, or loses its
/// stability, the steady state from the scene's start takes its place.
pub fn resonance_peak(
    scene: &Scene,
    range: [f64; 2],
    points: usize,
    options: &Options,
) -> Result<(Option<Resonance>, f64), Failure> {
    search(scene, &Search { range_hz: range, points, with_power: false }, options, &mut || {})
}

/// What a search for a resonance covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Lowest and highest frequency in Hz.
    pub range_hz: [f64; 2],
    /// Frequencies of the first scan.
    pub points: usize,
    /// Whether the largest mean power is sought too.
    pub with_power: bool,
}

/// As [`resonance_peak`]; calls `done` before each frequency.
pub fn search(
    scene: &Scene,
    search: &Search,
    options: &Options,
    done: &mut dyn FnMut(),
) -> Result<(Option<Resonance>, f64), Failure> {
    let options = &Options { steady_state: true, ..*options };
    options.check()?;
    options.check_scene(scene)?;
    match options.math {
        Some(Math::Libm) => shooting::peaks::<Libm>(scene, search, options, done),
        _ => shooting::peaks::<Polynomial>(scene, search, options, done),
    }
}

/// The resistance in place of the load of a scene that takes the most power in the steady state at the scene's frequency,
/// from 1 Ω to 10 TΩ, and the simulated periods that it took; calls `done` before each resistance. `None` if the power
/// has no largest value in this range.
pub fn best_resistance(
    scene: &Scene,
    options: &Options,
    done: &mut dyn FnMut(),
) -> Result<(Option<BestLoad>, f64), Failure> {
    let options = &Options { steady_state: true, ..*options };
    options.check()?;
    options.check_scene(scene)?;
    match options.math {
        Some(Math::Libm) => shooting::best_resistance::<Libm>(scene, options, done),
        _ => shooting::best_resistance::<Polynomial>(scene, options, done),
    }
}

/// The name of a precision, as the command line writes it.
pub fn precision_name<S: Scalar>() -> &'static str {
    if S::IS_DOUBLE { "f64" } else { "f32" }
}
