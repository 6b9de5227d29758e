//! Judges the run of a case by runs that are more accurate.

use std::panic::{AssertUnwindSafe, catch_unwind};

use serde::{Deserialize, Serialize};

use super::Case;
use crate::accuracy::run_with_steps;
use crate::method::{Failure, Options, Precision};
use crate::outcome::Outcome;
use crate::reference::{self, ReferenceOptions};
use crate::run::run_scene;
use crate::scene_file::{Model, Scene};

/// Relative error of the mean power up to which a run is right, in double and in single precision.
const RIGHT: [f64; 2] = [0.01, 0.02];
/// Halvings of the tolerance of a triboelectric run that give the tighter run.
const TIGHTER: u32 = 5;
/// Halvings of the steps of a bump-stop run that give the tighter run.
const SHORTER: u32 = 2;
/// Attempted steps of the tighter run and steps of the reference over those of the run.
const MORE_ATTEMPTS: u64 = 8;
/// Relative change of the base acceleration that shows a chaotic motion.
const SHIFT: f64 = 1e-9;

/// What became of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// The mean power is within 1 % in double precision and 2 % in single precision of that of the more accurate run.
    Right,
    /// It is not, and a warning that begins with `accuracy:` says so.
    Warned,
    /// It is not, but the more accurate run itself changes by more where the base acceleration is larger by 10⁻⁹.
    Chaotic,
    /// The scene is refused before the run.
    Refused,
    /// A step could not be taken, and the error says why.
    NamedError,
    /// Stopped after the most attempted steps.
    TooDear,
    /// No more accurate run came to its end.
    Unjudged,
    /// The mean power is off, and nothing says so.
    Wrong,
    /// A panic, or a number that is not finite.
    Broken,
}

impl Class {
    /// Whether nothing explains it.
    #[must_use]
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Wrong | Self::Broken)
    }
}

/// How much a case may cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Most attempted steps of the run.
    pub most_attempts: u64,
    /// Whether the reference judges, where it comes to its end; otherwise a run of the same method with a tighter
    /// tolerance or shorter steps in double precision.
    pub by_reference: bool,
}

/// A run that was judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// What became of it.
    pub class: Class,
    /// Relative error of the mean power.
    pub error: Option<f64>,
    /// The statement of the relative error.
    pub stated: Option<f64>,
    /// Whether a warning begins with `accuracy:`.
    pub is_warned: bool,
    /// Whether the reference was the more accurate run.
    pub by_reference: bool,
    /// Why there is no mean power, or what is wrong with it.
    pub reason: String,
}

impl Finding {
    fn new(class: Class, reason: impl Into<String>) -> Self {
        let reason = reason.into();
        Self { class, error: None, stated: None, is_warned: false, by_reference: false, reason }
    }

    /// Whether the error lies within the statement; `None` without both.
    #[must_use]
    pub fn is_within_statement(&self) -> Option<bool> {
        Some(self.error? <= self.stated?)
    }
}

/// Runs a case with its accuracy statement, and judges it.
#[must_use]
pub fn judge(case: &Case, effort: Effort) -> Finding {
    let scene = match case.read() {
        Ok(scene) => scene,
        Err(error) => return Finding::new(Class::Refused, error.to_string()),
    };
    catch_unwind(AssertUnwindSafe(|| judge_scene(&scene, case.precision, effort)))
        .unwrap_or_else(|_| Finding::new(Class::Broken, "panicked"))
}

fn judge_scene(scene: &Scene, precision: Precision, effort: Effort) -> Finding {
    let options = Options {
        precision: Some(precision),
        most_attempts: Some(effort.most_attempts),
        ..Options::default()
    };
    let (outcome, options) = match run_with_steps(scene, &options) {
        Ok(found) => found,
        Err(Failure::Input(reason)) => return Finding::new(Class::Refused, reason),
        Err(Failure::Step(reason)) => return Finding::new(Class::NamedError, reason),
        Err(Failure::StepLimitExceeded(reason)) => return Finding::new(Class::TooDear, reason),
    };
    let exact = Exact::of(scene, &options, effort);
    let mut finding = Finding {
        stated: outcome.accuracy.total,
        is_warned: outcome.warnings.iter().any(|warning| warning.starts_with("accuracy:")),
        ..Finding::new(Class::Unjudged, "")
    };
    if !is_finite(&outcome) {
        return Finding { class: Class::Broken, reason: "a number is not finite".to_owned(), ..finding };
    }
    let (Some(exact), Some(found)) = (exact, outcome.mean_power_w) else { return finding };
    let error = relative(found, exact.mean_power_w);
    finding.error = Some(error);
    finding.by_reference = exact.by_reference;
    let [double, single] = RIGHT;
    let allowed = if precision == Precision::F64 { double } else { single };
    finding.class = match finding.is_warned {
        _ if error <= allowed => Class::Right,
        true => Class::Warned,
        false if is_chaotic(scene, &options, allowed) => Class::Chaotic,
        false => Class::Wrong,
    };
    if finding.class == Class::Wrong {
        finding.reason = format!("mean power {found:e} W instead of {:e} W", exact.mean_power_w);
    }
    finding
}

/// The mean power by a more accurate run.
struct Exact {
    mean_power_w: f64,
    by_reference: bool,
}

impl Exact {
    fn of(scene: &Scene, options: &Options, effort: Effort) -> Option<Self> {
        let by_reference = || {
            let options = ReferenceOptions {
                most_steps: Some(effort.most_attempts.saturating_mul(MORE_ATTEMPTS)),
                ..ReferenceOptions::default()
            };
            // The scene has no reference if it is refused.
            reference::refusal(scene).is_none().then(|| reference::run(scene, &options).ok()).flatten()
        };
        let found =
            if effort.by_reference { by_reference().and_then(|found| found.mean_power_w) } else { None };
        match found {
            Some(mean_power_w) => Some(Self { mean_power_w, by_reference: true }),
            None => Some(Self { mean_power_w: tighter(scene, options)?, by_reference: false }),
        }
    }
}

/// The mean power in double precision with a tighter tolerance, or shorter steps, than `options`.
fn tighter(scene: &Scene, options: &Options) -> Option<f64> {
    let more = if matches!(scene.model, Model::BumpStop(_)) { SHORTER } else { TIGHTER };
    let options = Options {
        precision: Some(Precision::F64),
        halvings: options.halvings + more,
        bare: true,
        most_attempts: options.most_attempts.map(|most| most.saturating_mul(MORE_ATTEMPTS)),
        ..*options
    };
    run_scene(scene, &options).ok()?.mean_power_w
}

/// Whether the tighter run of a scene changes by more than `allowed` where the base acceleration is slightly larger.
fn is_chaotic(scene: &Scene, options: &Options, allowed: f64) -> bool {
    let shifted = Scene { excitation: scene.excitation.scaled(1.0 + SHIFT), ..scene.clone() };
    match (tighter(scene, options), tighter(&shifted, options)) {
        (Some(one), Some(other)) => relative(one, other) > allowed,
        _ => false,
    }
}

/// `|found − exact|` over the magnitude of `exact`; 0 where both are 0.
fn relative(found: f64, exact: f64) -> f64 {
    if found == exact { 0.0 } else { ((found - exact) / exact).abs() }
}

fn is_finite(outcome: &Outcome) -> bool {
    let numbers = [
        outcome.mean_power_w,
        outcome.rms_voltage_v,
        outcome.peak_voltage_v,
        outcome.mean_voltage_v,
        outcome.delivered_energy_j,
        outcome.created_energy_j,
        outcome.energy_residual,
        outcome.accuracy.total,
    ];
    numbers.iter().flatten().all(|number| number.is_finite())
}
