//! What can be asked of a run: method, precision, elementary functions, step; and why a run has no outcome.

use std::fmt::Display;

use serde::Serialize;

use crate::scene_file::{Load, Model, Scene, SceneError, finite_number_in};

/// Integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The embedded core, with the method that suits the scene: exponential Radau or the discrete gradient.
    #[default]
    Auto,
    /// Exponential Radau: exact motion, Radau IIA for the circuit: the embedded core, triboelectric scenes only.
    ExponentialRadau,
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

impl Precision {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// Elementary functions of the embedded core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Math {
    /// The polynomials of the core.
    Polynomial,
    /// The crate libm: accurate to an ulp.
    Libm,
    /// The crate micromath: small and coarse, single precision only.
    Micromath,
}

/// How to run a scene. The method chooses what is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default, clap::Args)]
pub struct Options {
    /// Integration method; a scene refuses a method that it does not have
    #[arg(long, value_enum, default_value_t)]
    pub method: Method,
    /// Precision of the embedded core [default: f64; f32 with micromath]
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Elementary functions of the embedded core [default: polynomial]
    #[arg(long, value_enum)]
    pub math: Option<Math>,
    /// Fixed step in seconds; of a bump-stop scene near contact, throughout without --long-step [default: by --tolerance;
    /// 1e-6 near contact of a bump-stop scene; rk4: what is stable]
    #[arg(long = "step", value_name = "S", conflicts_with = "tolerance", allow_hyphen_values = true,
        value_parser = finite_number_in("s", "S"))]
    pub step_s: Option<f64>,
    /// Step in seconds of a bump-stop scene in free flight, at least that near contact [default: --step, 2e-5 without]
    #[arg(long = "long-step", value_name = "S", conflicts_with = "tolerance", allow_hyphen_values = true,
        value_parser = finite_number_in("s", "S"))]
    pub long_step_s: Option<f64>,
    /// Relative error of the mean power to aim at, by exponential Radau, and by run in a bump-stop scene; tolerance or steps
    /// follow [default: 1e-6; 3e-6 of a slider in f32; 1e-3 in a bump-stop scene]
    #[arg(long, value_name = "REL", conflicts_with_all = ["step_s", "tolerance"], allow_hyphen_values = true,
        value_parser = finite_number_in("", "REL"))]
    pub accuracy: Option<f64>,
    /// Relative tolerance of the adaptive step of a triboelectric scene [default: by --accuracy; 1e-5 with tr-bdf2, 1e-12
    /// with the reference]
    #[arg(long, value_name = "REL", allow_hyphen_values = true, value_parser = finite_number_in("", "REL"))]
    pub tolerance: Option<f64>,
    /// Distance in s of the rows of the recorded motion.
    #[arg(skip)]
    pub trace_every_s: Option<f64>,
    /// Distance in s of instants at which a step ends on the core: of recorded rows, so that none is interpolated, or to shorten
    /// the steps of a tolerance.
    #[arg(skip)]
    pub ends_every_s: Option<f64>,
    /// Whether a run on the core keeps no energy ledger and meters the measuring window only, as firmware would: for
    /// measuring its run time.
    #[arg(skip)]
    pub bare: bool,
    /// Whether shooting for the periodic steady state replaces the run.
    #[arg(skip)]
    pub steady_state: bool,
    /// How often the step or the tolerance is halved.
    #[arg(skip)]
    pub halvings: u32,
    /// Whether the energies of the parts of the window are kept, to compare two runs.
    #[arg(skip)]
    pub blocks: bool,
    /// Number of attempted steps after which the core's hybrid driver stops with [`Failure::StepLimitExceeded`].
    #[arg(skip)]
    pub most_attempts: Option<u64>,
}

/// Why there is no outcome.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The input is bad: exit code 2.
    #[error("{0}")]
    Input(String),
    /// The scene could not be stepped to its end: exit code 3. The text has the error, the simulated time and the state.
    #[error("{0}")]
    Step(String),
    /// The run was stopped because it took more steps than it was allowed: exit code 3.
    #[error("{0}")]
    StepLimitExceeded(String),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl Failure {
    /// Bad input that a scene file is to blame for.
    pub fn of_file(scene: &Scene, reason: impl Display) -> Self {
        Self::Input(format!("{}: {reason}", scene.file.display()))
    }

    /// The failure with the case in front, if the run could not be stepped to its end.
    pub fn of_case(self, case: &str) -> Self {
        match self {
            Self::Step(error) => Self::Step(format!("{case}: {error}")),
            other => other,
        }
    }
}

impl Options {
    /// The factor that the halvings apply to a step or a tolerance.
    pub fn refinement(&self) -> f64 {
        0.5_f64.powi(self.halvings.cast_signed())
    }

    /// The precision of a run on the core: double, or that of its elementary functions.
    pub fn chosen_precision(&self) -> Precision {
        self.precision.unwrap_or(match self.math {
            Some(Math::Micromath) => Precision::F32,
            _ => Precision::F64,
        })
    }

    /// Checks what can be checked without a scene.
    pub fn check(&self) -> Result<(), Failure> {
        within("--step", self.step_s, [1e-9, 1.0])?;
        within("--long-step", self.long_step_s, [1e-9, 1.0])?;
        within("--tolerance", self.tolerance, [1e-13, 0.1])?;
        within("--accuracy", self.accuracy, [1e-12, 0.1])?;
        within("--trace-every", self.trace_every_s, [1e-9, 1e7])?;
        let Self { method, precision, math, steady_state, .. } = *self;
        let reference = method == Method::Reference;
        let single = precision == Some(Precision::F32);
        let coarse = math == Some(Math::Micromath);
        let refusals = [
            (
                coarse && precision == Some(Precision::F64),
                "--math micromath: must be with --precision f32, it has no double precision",
            ),
            (reference && single, "--precision f32: the reference must be in f64"),
            (
                reference && math.is_some(),
                "--math: must not be given for the reference, which uses that of the host",
            ),
            (reference && self.step_s.is_some(), "--step: must not be given for the reference"),
            (reference && self.long_step_s.is_some(), "--long-step: must not be given for the reference"),
            (
                reference && self.accuracy.is_some(),
                "--accuracy: must not be given for the reference; give --tolerance",
            ),
            (
                self.accuracy.is_some() && matches!(method, Method::TrBdf2 | Method::Rk4 | Method::Newmark),
                "--accuracy: must be with --method auto, exponential-radau or discrete-gradient",
            ),
            (
                steady_state && reference,
                "--method reference: must be of the core for a steady state, such as exponential-radau",
            ),
            (steady_state && single, "--precision f32: a steady state must be in f64"),
            (
                steady_state && coarse,
                "--math micromath: a steady state must be in f64, which it does not have",
            ),
            (
                steady_state && self.trace_every_s.is_some(),
                "--trace-every: must not be given for a steady state",
            ),
        ];
        refuse_first(&refusals)
    }

    /// Checks what depends on the kind of the scene.
    pub fn check_scene(&self, scene: &Scene) -> Result<(), Failure> {
        let refuse = |reason: &str| Err(Failure::of_file(scene, reason));
        if self.steady_state && scene.excitation.single_frequency().is_none() {
            return refuse(
                "excitation.kind: must be \"sine\" with a frequency_hz above 0 for a periodic steady state",
            );
        }
        let is_bump_stop = matches!(scene.model, Model::BumpStop(_));
        refuse_first(&[
            (
                is_bump_stop && self.method == Method::ExponentialRadau,
                "--method exponential-radau: must be with a triboelectric scene; a bump-stop scene has \
                 discrete-gradient, tr-bdf2, rk4, newmark and reference",
            ),
            (
                is_bump_stop && self.accuracy.is_some(),
                "--accuracy: must be with a triboelectric scene, or with run without --no-accuracy; give --step",
            ),
            (
                is_bump_stop && self.method == Method::Reference && self.tolerance.is_some(),
                "--tolerance: must not be given for the reference of a bump-stop scene, which is exact from event to \
                 event",
            ),
        ])?;
        // The storage behind a bridge fills: its voltage is not periodic.
        if self.steady_state && matches!(scene.load, Load::RectifiedStore(_)) {
            return refuse(
                "load.kind: must be \"resistor\" or \"dc-bus\" for a periodic steady state; --storage-voltage holds \
                 the voltage of a storage",
            );
        }
        let bridge = !matches!(scene.load, Load::Resistor { .. });
        let by_peer = matches!(self.method, Method::TrBdf2 | Method::Rk4 | Method::Newmark);
        if self.steady_state && by_peer && is_bump_stop {
            return refuse(
                "--method: must be auto or discrete-gradient for a periodic steady state of this scene",
            );
        }
        if bridge && by_peer && is_bump_stop {
            return refuse("load.kind: must be \"resistor\" for this scene by this method");
        }
        Ok(())
    }
}

/// Refuses the first of some conditions that holds, with its reason.
pub fn refuse_first(refusals: &[(bool, &str)]) -> Result<(), Failure> {
    match refusals.iter().find(|(refused, _)| *refused) {
        Some((_, reason)) => Err(Failure::Input((*reason).to_owned())),
        None => Ok(()),
    }
}

fn within(name: &str, value: Option<f64>, [lowest, highest]: [f64; 2]) -> Result<(), Failure> {
    match value {
        Some(value) if !(lowest..=highest).contains(&value) => {
            Err(Failure::Input(format!("{name} {value}: must be a number from {lowest:e} to {highest:e}")))
        }
        _ => Ok(()),
    }
}
