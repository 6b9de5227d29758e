//! The embedded core on the host: the very code of the firmware, for any scene file.
//!
//! Every choice that firmware makes at compile time is made here at run time, by the core's `Any…`
//! types; precision and elementary functions are type parameters and dispatched below.

mod contact_separation;
mod excitation;
mod recorder;
mod steady_state;

use model_core::scalar::{Libm, Mathematics, Micromath, Polynomial, Scalar};

use crate::method::{Failure, Math, Method, Options, Precision};
use crate::outcome::Outcome;
use crate::scene_file::{Model, Scene};
use crate::steady_state::Resonance;

pub use contact_separation::parameters as contact_separation_parameters;

/// Relative tolerance per radian where neither step nor tolerance is given.
pub const DEFAULT_TOLERANCE: f64 = 1e-5;

/// Runs a scene on the embedded core.
///
/// # Errors
/// [`Failure::Input`] if the options do not fit the method or the core refuses the scene,
/// [`Failure::Step`] if a step cannot be taken.
pub fn run(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    let precision = options.precision.unwrap_or(match options.math {
        Some(Math::Micromath) => Precision::F32,
        _ => Precision::F64,
    });
    match (precision, options.math.unwrap_or(Math::Polynomial)) {
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
    match &scene.model {
        Model::ContactSeparation(model) => contact_separation::run::<S, M>(scene, model, options),
    }
}

/// The periodic steady state of a scene under one sine, by shooting; the scene's own run where it has no
/// stable orbit of one period.
///
/// # Errors
/// As [`run`].
pub fn steady_state(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    options.check()?;
    options.check_scene(scene)?;
    match (&scene.model, options.math) {
        (Model::ContactSeparation(model), Some(Math::Libm)) => {
            contact_separation::steady_state::<Libm>(scene, model, options)
        }
        (Model::ContactSeparation(model), _) => {
            contact_separation::steady_state::<Polynomial>(scene, model, options)
        }
    }
}

/// The frequencies of a range in Hz at which the steady state of a scene responds most, by following
/// its orbit upwards over `points` frequencies and then to the peaks; and the simulated periods it
/// took. `None` if the steady state is a stable orbit at no frequency.
///
/// Where two orbits are stable the one is followed on which the path came. Where it ends, or loses its
/// stability, the steady state from the scene's start takes its place.
///
/// # Errors
/// As [`run`].
pub fn resonance_peak(
    scene: &Scene,
    range: [f64; 2],
    points: usize,
    options: &Options,
) -> Result<(Option<Resonance>, f64), Failure> {
    let options = &Options { steady_state: true, ..*options };
    options.check()?;
    options.check_scene(scene)?;
    match (&scene.model, options.math) {
        (Model::ContactSeparation(model), Some(Math::Libm)) => {
            contact_separation::resonance_peak::<Libm>(scene, model, range, points, options)
        }
        (Model::ContactSeparation(model), _) => {
            contact_separation::resonance_peak::<Polynomial>(scene, model, range, points, options)
        }
    }
}

/// The name of a precision, as the command line writes it.
#[must_use]
pub fn precision_name<S: Scalar>() -> &'static str {
    if size_of::<S>() == 4 { "f32" } else { "f64" }
}

/// The method that runs, as the command line writes it.
fn method_name(method: Method) -> &'static str {
    match method {
        Method::Auto | Method::TrBdf2 => "tr-bdf2",
        Method::Rk4 => "rk4",
        Method::Reference => "reference",
    }
}
