//! The embedded core on the host: the very code of the firmware, for any scene file.
//!
//! Every choice that firmware makes at compile time is made here at run time, by the core's `Any…`
//! types; precision and elementary functions are type parameters and dispatched below.

mod bump_stop;
mod contact_separation;
mod excitation;
mod hybrid_run;
mod recorder;
mod sliding;

use model_core::scalar::{Libm, Mathematics, Micromath, Polynomial, Scalar};

use crate::method::{Failure, Math, Method, Options, Precision};
use crate::outcome::Outcome;
use crate::scene_file::{Model, Scene};

pub use bump_stop::parameters as bump_stop_parameters;
pub use contact_separation::parameters as contact_separation_parameters;
pub use sliding::parameters as sliding_parameters;

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
        Model::Sliding(model) => sliding::run::<S, M>(scene, model, options),
        Model::BumpStop(model) => bump_stop::run::<S, M>(scene, model, options),
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
        Method::DiscreteGradient => "discrete-gradient",
        Method::Reference => "reference",
    }
}
