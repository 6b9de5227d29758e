//! The triboelectric scenes: each case is run in single and in double precision, and judged by runs that are more
//! accurate, by the independent reference for some cases, and by its own energy ledger.

mod contact_separation;
mod judge;
mod sliding;
mod table;

use serde::Serialize;

pub(crate) use self::contact_separation::ContactSeparationSetting;
pub(crate) use self::sliding::SlidingSetting;
use super::{Grid, Subject, ohms};
use crate::method::Precision;
use crate::outcome::{number, optional_number};
use crate::scene_file::{ForceLaw, Scene};

/// One case: what differs from the shipped scene.
pub(crate) trait Setting: Copy + Send + Sync + Serialize {
    /// Heading of the table.
    const HEADING: &'static str;
    /// Name of the scene.
    const SCENE: &'static str;

    /// The cases of a grid.
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

    /// The other values, as the cells of [`OTHERS`].
    fn other_cells(&self) -> [String; OTHERS.len()];
}

/// What a case of both scenes has.
pub(crate) struct Common {
    /// Load resistance in Ω.
    resistance_ohm: f64,
    /// Tribo-charge density in C/m².
    charge_density_c_per_m2: f64,
    force_law: ForceLaw,
}

/// Columns of which a scene fills its own.
const OTHERS: [&str; 6] =
    ["parasitic_capacitance_f", "restitution", "relaxing", "friction", "amplitude_m_per_s2", "frequency_hz"];

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
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
    Flagged,
    /// The parameters are refused.
    Refused,
    /// A step could not be taken, and the error says why.
    Error,
    /// Stopped after [`judge::MOST_ATTEMPTS`] attempted steps.
    StepLimitExceeded,
    /// Runs, and its ledger closes, but no run in double precision is there to judge it by.
    Unjudged,
    /// Differs, and neither the ledger nor an error nor a sensitive scene explains it.
    Silent,
}

impl Class {
    /// All classes, in the order of the tables.
    const ALL: [Self; 9] = [
        Self::Converged,
        Self::Chaotic,
        Self::Converging,
        Self::Flagged,
        Self::Refused,
        Self::Error,
        Self::StepLimitExceeded,
        Self::Unjudged,
        Self::Silent,
    ];

    /// Its name.
    fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Chaotic => "chaotic",
            Self::Converging => "converging",
            Self::Flagged => "flagged by ledger",
            Self::Refused => "refused",
            Self::Error => "named error",
            Self::StepLimitExceeded => "step limit",
            Self::Unjudged => "unjudged",
            Self::Silent => "unexplained",
        }
    }
}

/// One case in one precision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding<T> {
    /// The case.
    #[serde(flatten)]
    setting: T,
    /// Precision.
    precision: Precision,
    /// What became of it.
    class: Class,
    /// Why it is not converged.
    reason: String,
    /// Relative difference of the mean power to the tighter run.
    power_difference: Option<f64>,
    /// Relative difference of the peak gap, or of the slider's amplitude, to the tighter run.
    motion_difference: Option<f64>,
    /// Residual of the energy ledger.
    energy_residual: Option<f64>,
    /// Steps, kept and rejected, per simulated second.
    steps_per_s: Option<f64>,
    /// Whether the tighter run agrees with the reference; `None` if the reference did not run the case.
    reference_agrees: Option<bool>,
}

impl<T: Setting> super::Finding for Finding<T> {
    fn case(&self) -> Vec<(&'static str, String)> {
        let Common { resistance_ohm, charge_density_c_per_m2, force_law } = self.setting.common();
        let mut case = vec![
            ("scene", T::SCENE.to_owned()),
            ("resistance_ohm", ohms(resistance_ohm)),
            ("charge_density_c_per_m2", number(charge_density_c_per_m2)),
            ("force_law", law_name(force_law).to_owned()),
        ];
        case.extend(OTHERS.into_iter().zip(self.setting.other_cells()));
        case.push(("precision", self.precision.name().to_owned()));
        case
    }

    fn verdict(&self) -> Vec<(&'static str, String)> {
        vec![
            ("class", self.class.name().to_owned()),
            ("power_difference", optional_number(self.power_difference)),
            ("motion_difference", optional_number(self.motion_difference)),
            ("energy_residual", optional_number(self.energy_residual)),
            ("steps_per_s", optional_number(self.steps_per_s)),
            ("reference_agrees", self.reference_agrees.map_or_else(String::new, |agrees| agrees.to_string())),
            ("reason", self.reason.clone()),
        ]
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
    }
}

fn law<S: serde::Serializer>(law: &ForceLaw, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(law_name(*law))
}

#[cfg(test)]
mod tests;
