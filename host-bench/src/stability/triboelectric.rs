//! The triboelectric scenes: each case is run in single and in double precision, and judged by runs that are more
//! accurate, by the independent reference for some cases, and by its own energy ledger.

mod contact_separation;
mod judge;
mod sliding;
mod table;

use serde::Serialize;

pub(crate) use self::contact_separation::ContactSeparationSetting;
pub(crate) use self::sliding::SlidingSetting;
use super::{Grid, Subject};
use crate::method::Precision;
use crate::outcome::name;
use crate::scene_file::{ForceLaw, Scene};

/// One case: what differs from the shipped scene.
pub(crate) trait Setting: Copy + Send + Sync + Serialize {
    const HEADING: &'static str;
    const SCENE: &'static str;

    fn all(grid: Grid) -> Vec<Self>;

    /// The scene of this case, made of the shipped one.
    fn scene(&self, base: &Scene) -> Scene;

    /// Whether the reference runs this case as well.
    fn is_for_reference(&self) -> bool;

    /// The options that make `run` run this case.
    fn overrides(&self) -> String;

    /// What both scenes have.
    fn common(&self) -> Common;

    /// The other values, as words for a table.
    fn others(&self) -> String;
}

/// What a case of both scenes has.
pub(crate) struct Common {
    /// Load resistance in Ω.
    resistance_ohm: f64,
    /// Tribo-charge density in C/m².
    charge_density_c_per_m2: f64,
    force_law: ForceLaw,
}

impl<T: Setting> Subject for T {
    type Setting = T;
    type Finding = Finding<T>;

    const HEADING: &'static str = T::HEADING;
    const SCENE: &'static str = T::SCENE;

    fn settings(grid: Grid) -> Vec<T> {
        T::all(grid)
    }

    fn examine(base: &Scene, setting: T, _grid: Grid) -> Vec<Finding<T>> {
        judge::examine(base, setting, setting.is_for_reference()).to_vec()
    }

    fn text(findings: &[Finding<T>]) -> String {
        table::text(findings)
    }
}

/// What became of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Class {
    /// Agrees with the tighter run to [`judge::AGREEMENT`] in mean power and motion.
    Converged,
    /// The scene is sensitive: the tighter run disagrees with itself where the start is shifted by at most 10⁻⁴ or the
    /// stiffness by at most 3·10⁻⁵. Mean power and motion are within [`judge::DEVIATIONS`] standard deviations of the mean of the
    /// shifted runs, and the energy ledger closes.
    Chaotic,
    /// Differs by more than [`judge::AGREEMENT`], but by no more than double precision at ten times the tolerance, and in double
    /// precision the difference falls with the tolerance to runs that agree. Grazing amplifies the error.
    Converging,
    /// Does not agree, and its energy ledger does not close.
    #[value(name = "flagged by ledger")]
    Flagged,
    Refused,
    /// A step could not be taken, and the error says why.
    #[value(name = "named error")]
    Error,
    /// Stopped after [`judge::MOST_ATTEMPTS`] attempted steps.
    #[value(name = "step limit")]
    StepLimitExceeded,
    /// Runs, and its ledger closes, but no run in double precision is there to judge it by.
    Unjudged,
    /// Differs, and neither the ledger nor an error nor a sensitive scene explains it.
    #[value(name = "unexplained")]
    Silent,
}

/// One case in one precision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding<T> {
    #[serde(flatten)]
    setting: T,
    precision: Precision,
    class: Class,
    /// Why it is not converged.
    reason: String,
    /// Relative difference of the mean power to the tighter run.
    power_difference: Option<f64>,
    /// Relative difference of the peak gap, or of the slider's amplitude, to the tighter run.
    motion_difference: Option<f64>,
    energy_residual: Option<f64>,
    /// Steps, kept and rejected, per simulated second.
    steps_per_s: Option<f64>,
    /// Whether the tighter run agrees with the reference; `None` if the reference did not run the case.
    reference_agrees: Option<bool>,
}

impl<T: Setting> super::Finding for Finding<T> {
    const CASE: &'static [&'static str] = &[
        "scene",
        "resistance_ohm",
        "charge_density_c_per_m2",
        "force_law",
        "parasitic_capacitance_f",
        "restitution",
        "relaxing",
        "friction",
        "amplitude_m_per_s2",
        "frequency_hz",
        "precision",
    ];
    const RESULT: &'static [&'static str] = &[
        "class",
        "power_difference",
        "motion_difference",
        "energy_residual",
        "steps_per_s",
        "reference_agrees",
        "reason",
    ];

    fn verdict(&self) -> String {
        name(&self.class)
    }

    fn is_failure(&self) -> bool {
        self.class == Class::Silent
    }

    fn options(&self) -> String {
        self.setting.overrides()
    }
}

/// The name that a scene file has for a force law.
fn law_name(law: ForceLaw) -> &'static str {
    match law {
        ForceLaw::TransferredCharge => "transferred-charge",
        ForceLaw::GapField => "gap-field",
        ForceLaw::None => "none",
    }
}

fn law<S: serde::Serializer>(law: &ForceLaw, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(law_name(*law))
}

#[cfg(test)]
mod tests;
