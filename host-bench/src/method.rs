//! How a scene is run: the one place where a method is chosen.

use serde::Serialize;

use crate::embedded;
use crate::outcome::Outcome;
use crate::peer;
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{Load, Model, Scene, SceneError};

/// Integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The embedded core, with the method that suits the scene.
    #[default]
    Auto,
    /// TR-BDF2, implicit, for stiff circuits: the embedded core; of a bump-stop scene, the host.
    TrBdf2,
    /// The classical Runge-Kutta method of order 4: the embedded core; of a bump-stop scene, the host.
    Rk4,
    /// The embedded core by exact modal steps and a discrete-gradient contact: bump-stop scenes only.
    DiscreteGradient,
    /// Newmark's method of average acceleration on the host, in double precision: bump-stop scenes only.
    Newmark,
    /// The independent reference on the host, in double precision.
    Reference,
}

/// Precision of the embedded core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// Elementary functions of the embedded core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Math {
    /// Polynomials of our own.
    Polynomial,
    /// The crate `libm`: right to an ulp.
    Libm,
    /// The crate `micromath`: small and coarse, single precision only.
    Micromath,
}

/// How to run a scene. What is `None` is left to the method.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Integration method.
    pub method: Method,
    /// Precision of the embedded core.
    pub precision: Option<Precision>,
    /// Elementary functions of the embedded core.
    pub math: Option<Math>,
    /// Fixed step in s; of a bump-stop scene, the step near contact.
    pub step_s: Option<f64>,
    /// Step in s of a bump-stop scene in free flight.
    pub long_step_s: Option<f64>,
    /// Relative tolerance of an adaptive step.
    pub tolerance: Option<f64>,
    /// Distance in s of the rows of [`Outcome::trace`].
    pub trace_every_s: Option<f64>,
    /// Whether a bump-stop run on the core keeps no energy ledger and looks at the measuring window only:
    /// for its run time, as firmware would have it.
    pub bare: bool,
    /// Whether the periodic steady state is sought by shooting, in place of the run.
    pub steady_state: bool,
    /// Attempted steps after which a run on the core's hybrid driver is given up, [`Failure::StepLimitExceeded`].
    pub most_attempts: Option<u64>,
}

/// Why there is no outcome.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The input is bad: exit code 2.
    #[error("{0}")]
    Input(String),
    /// The scene could not be stepped to its end: exit code 3. The error, the simulated time and the
    /// state.
    #[error("{0}")]
    Step(String),
    /// The run was given up because it took more steps than it was allowed: exit code 3.
    #[error("{0}")]
    StepLimitExceeded(String),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl Options {
    /// Checks what can be checked without a scene.
    ///
    /// # Errors
    /// [`Failure::Input`] that names the option, its value and its bound.
    pub fn check(&self) -> Result<(), Failure> {
        let within = |name: &str, value: Option<f64>, [lowest, highest]: [f64; 2]| match value {
            Some(value) if !(lowest..=highest).contains(&value) => Err(Failure::Input(format!(
                "{name} {value}: must be a number from {lowest:e} to {highest:e}"
            ))),
            _ => Ok(()),
        };
        within("--step", self.step_s, [1e-9, 1.0])?;
        within("--long-step", self.long_step_s, [1e-9, 1.0])?;
        within("--tolerance", self.tolerance, [1e-13, 0.1])?;
        within("--trace-every", self.trace_every_s, [1e-9, 1e7])?;
        let refuse = |text: &str| Err(Failure::Input(text.to_owned()));
        if self.math == Some(Math::Micromath) && self.precision == Some(Precision::F64) {
            return refuse("--math micromath: must be with --precision f32, it has no double precision");
        }
        if self.method == Method::Reference {
            if self.precision == Some(Precision::F32) {
                return refuse("--precision f32: the reference must be in f64");
            }
            if self.math.is_some() {
                return refuse("--math: must not be given for the reference, which uses that of the host");
            }
            if self.step_s.is_some() {
                return refuse("--step: must not be given for the reference, which adapts its step");
            }
        }
        if self.steady_state {
            if self.method == Method::Reference {
                return refuse("--method reference: must be of the core for a steady state, such as tr-bdf2");
            }
            if self.precision == Some(Precision::F32) {
                return refuse("--precision f32: a steady state must be in f64");
            }
            if self.math == Some(Math::Micromath) {
                return refuse("--math micromath: a steady state must be in f64, which it does not have");
            }
            if self.trace_every_s.is_some() {
                return refuse("--trace-every: must not be given for a steady state");
            }
        }
        Ok(())
    }

    /// Checks what depends on the kind of the scene.
    ///
    /// # Errors
    /// [`Failure::Input`] that names the file, the key and what it must be.
    pub fn check_scene(&self, scene: &Scene) -> Result<(), Failure> {
        if self.steady_state && scene.excitation.single_frequency().is_none() {
            return Err(Failure::Input(format!(
                "{}: excitation.kind: must be \"sine\" with a frequency_hz above 0 for a periodic steady state",
                scene.file.display()
            )));
        }
        // What a search by shooting returns to itself does not hold a store that fills.
        let bridge = !matches!(scene.load, Load::Resistor { .. });
        if bridge && self.steady_state {
            return Err(Failure::Input(format!(
                "{}: load.kind: must be \"resistor\" for a periodic steady state",
                scene.file.display()
            )));
        }
        let by_peer = matches!(self.method, Method::TrBdf2 | Method::Rk4 | Method::Newmark);
        if bridge && by_peer && matches!(scene.model, Model::BumpStop(_)) {
            return Err(Failure::Input(format!(
                "{}: load.kind: must be \"resistor\" for this scene by this method",
                scene.file.display()
            )));
        }
        Ok(())
    }
}

/// Runs a scene.
///
/// # Errors
/// [`Failure::Input`] if the options do not fit together or to the scene, [`Failure::Step`] if the
/// integration cannot go on.
pub fn run_scene(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    options.check()?;
    options.check_scene(scene)?;
    if let Some(every) = options.trace_every_s {
        const ROWS: f64 = 2e7;
        if scene.run.duration_s / every > ROWS {
            let least = scene.run.duration_s / ROWS;
            return Err(Failure::Input(format!(
                "--trace-every {every}: must be at least {least:e} for at most {ROWS:e} rows"
            )));
        }
    }
    match options.method {
        Method::Reference => {
            if let Some(refusal) = reference::refusal(scene) {
                return Err(Failure::Input(refusal));
            }
            let default = ReferenceOptions::default();
            let tolerance = options.tolerance.unwrap_or(default.tolerance);
            let options =
                ReferenceOptions { tolerance, record_every: options.trace_every_s, most_steps: None };
            reference::run(scene, &options).map_err(|failure| Failure::Step(failure.to_string()))
        }
        _ if options.steady_state => embedded::steady_state(scene, options),
        method => match &scene.model {
            // The core has no such method for this scene.
            Model::BumpStop(model) if !matches!(method, Method::Auto | Method::DiscreteGradient) => {
                peer::bump_stop(scene, model, options)
            }
            _ => embedded::run(scene, options),
        },
    }
}
