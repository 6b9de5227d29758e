//! The bump-stop scenes: mode counts, gaps, loads, stiffness of the rod, damping, contact laws, steps and precisions.
//!
//! From the shipped scene with a few modes, one quantity at a time is taken through its range, under each contact law, at
//! all steps and in both precisions. Each run must give finite numbers or a named error, must have no negative contact
//! force, and must close its energy ledger. Its RMS voltage is compared with the reference where the step resolves a
//! contact and the motion is not sensitive.

mod grid;
mod table;

use serde::Serialize;

pub(crate) use self::grid::Setting;
use self::grid::{settings, steps};
use super::{Finding, Grid, Subject, difference};
use crate::method::{Method, Options, Precision};
use crate::outcome::{Outcome, Particular, name};
use crate::run::run_scene;
use crate::scene_file::{Contact, Model, Scene};

/// Relative difference in RMS voltage up to which a run agrees with the reference.
const AGREEMENT: f64 = 0.05;
/// Longest step in s that resolves a contact: contacts last from a few microseconds on.
const RESOLVING_STEP: f64 = 1e-6;
/// Residual of the energy ledger up to which the ledger closes, in double and in single precision.
const LEDGER: [f64; 2] = [1e-9, 1e-3];
/// Relative shifts of the gap that show a sensitive motion: far above the error of a contact's time at a resolving step.
const SHIFTS: [f64; 2] = [-1e-3, 1e-3];
/// Relative change of the RMS voltage under such a shift above which the motion counts as sensitive.
const SENSITIVE: f64 = 0.01;
/// Rows of the recording in which the contact force is checked.
const ROWS: f64 = 1000.0;
/// Column of the contact force in a recording.
const FORCE: usize = 5;

pub(crate) struct BumpStop;

impl Subject for BumpStop {
    type Setting = Setting;
    type Finding = BumpStopFinding;

    const HEADING: &'static str = "Bump-stop";
    const SCENE: &'static str = "bump-stop";

    fn settings(_grid: Grid) -> Vec<Setting> {
        settings()
    }

    fn examine(base: &Scene, setting: Setting, grid: Grid) -> Vec<BumpStopFinding> {
        examine(base, setting, steps(grid))
    }

    fn text(findings: &[BumpStopFinding]) -> String {
        table::text(findings)
    }
}

/// What became of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    /// Within [`AGREEMENT`] of the reference.
    Agrees,
    /// The step does not resolve the contacts: finite, no negative contact force, and the ledger closes.
    #[value(name = "unresolved step")]
    Unresolved,
    /// As [`Verdict::Unresolved`], and there is no reference for a contact that is a constraint in each step.
    #[value(name = "no reference")]
    NoReference,
    /// As [`Verdict::Unresolved`], and the reference itself changes when the gap is shifted by a thousandth.
    Sensitive,
    /// Refused, or a named error.
    #[value(name = "named error")]
    Error,
    /// Finite and far from the reference, and none of the above.
    Off,
    /// Not finite, a negative contact force, or a ledger that does not close.
    Broken,
}

impl Verdict {
    /// Whether nothing explains it.
    fn is_failure(self) -> bool {
        matches!(self, Self::Off | Self::Broken)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct BumpStopFinding {
    #[serde(flatten)]
    setting: Setting,
    /// Step in s.
    step_s: f64,
    precision: Precision,
    verdict: Verdict,
    reason: String,
    /// Relative difference of the RMS voltage to the reference.
    voltage_difference: Option<f64>,
    energy_residual: Option<f64>,
    contacts: Option<u64>,
}

impl Finding for BumpStopFinding {
    const CASE: &'static [&'static str] = &[
        "contact",
        "beam_modes",
        "rod_modes",
        "gap_m",
        "resistance_ohm",
        "rod_young_modulus_pa",
        "damping_ratio",
        "precision",
        "step_s",
    ];
    const RESULT: &'static [&'static str] =
        &["verdict", "voltage_difference", "energy_residual", "contacts", "reason"];

    fn verdict(&self) -> String {
        name(&self.verdict)
    }

    fn is_failure(&self) -> bool {
        self.verdict.is_failure()
    }

    fn options(&self) -> String {
        format!("--precision {} --step {:e} {}", self.precision.name(), self.step_s, self.setting.overrides())
    }
}

/// What the reference says of a case.
#[derive(Debug, Clone, Copy)]
struct Reference {
    rms_voltage: f64,
    is_sensitive: bool,
}

impl Reference {
    /// `None` for a contact law that the reference does not have, or if the reference cannot run.
    fn of(scene: &Scene) -> Option<Self> {
        let ask = |scene: &Scene| {
            let options = Options { method: Method::Reference, ..Options::default() };
            run_scene(scene, &options).ok().and_then(|outcome| outcome.rms_voltage_v)
        };
        let rms_voltage = ask(scene)?;
        let changes = SHIFTS.iter().filter_map(|shift| {
            let mut shifted = scene.clone();
            if let Model::BumpStop(model) = &mut shifted.model
                && let Some(stop) = &mut model.stop
            {
                stop.gap_m *= 1.0 + shift;
            }
            ask(&shifted).map(|shifted| difference(shifted, rms_voltage))
        });
        let largest = changes.fold(0.0, f64::max);
        Some(Self { rms_voltage, is_sensitive: largest > SENSITIVE })
    }
}

/// Runs one case at all steps in both precisions.
fn examine(base: &Scene, setting: Setting, steps: &[f64]) -> Vec<BumpStopFinding> {
    let scene = setting.scene(base);
    let reference = Reference::of(&scene);
    let mut findings = Vec::new();
    for &step_s in steps {
        for precision in [Precision::F32, Precision::F64] {
            findings.push(finding(&scene, setting, step_s, precision, reference));
        }
    }
    findings
}

fn finding(
    scene: &Scene,
    setting: Setting,
    step_s: f64,
    precision: Precision,
    reference: Option<Reference>,
) -> BumpStopFinding {
    let options = Options {
        precision: Some(precision),
        step_s: Some(step_s),
        trace_every_s: Some(scene.run.duration_s / ROWS),
        ..Options::default()
    };
    let mut finding = BumpStopFinding {
        setting,
        step_s,
        precision,
        verdict: Verdict::Error,
        reason: String::new(),
        voltage_difference: None,
        energy_residual: None,
        contacts: None,
    };
    match run_scene(scene, &options) {
        Err(failure) => finding.reason = failure.to_string(),
        Ok(outcome) => {
            finding.energy_residual = outcome.energy_residual;
            if let Particular::BumpStop(found) = &outcome.particular {
                finding.contacts = Some(found.contacts);
            }
            let voltage = outcome.rms_voltage_v.unwrap_or(f64::NAN);
            finding.voltage_difference = reference.map(|exact| difference(voltage, exact.rms_voltage));
            (finding.verdict, finding.reason) = judge(&outcome, &finding, reference);
        }
    }
    finding
}

fn judge(outcome: &Outcome, finding: &BumpStopFinding, reference: Option<Reference>) -> (Verdict, String) {
    if let Some(reason) = broken(outcome, finding) {
        return (Verdict::Broken, reason.to_owned());
    }
    let plain = |verdict| (verdict, String::new());
    if finding.step_s > RESOLVING_STEP {
        return plain(Verdict::Unresolved);
    }
    match (reference, finding.voltage_difference) {
        (Some(_), Some(difference)) if difference <= AGREEMENT => plain(Verdict::Agrees),
        (Some(exact), Some(_)) if exact.is_sensitive => plain(Verdict::Sensitive),
        (Some(_), _) => (Verdict::Off, "the RMS voltage is not that of the reference".to_owned()),
        (None, _) => plain(Verdict::NoReference),
    }
}

/// What no run may do.
fn broken(outcome: &Outcome, finding: &BumpStopFinding) -> Option<&'static str> {
    let Particular::BumpStop(found) = &outcome.particular else { return Some("another scene") };
    let numbers = [
        outcome.rms_voltage_v,
        outcome.mean_power_w,
        outcome.peak_voltage_v,
        outcome.mean_voltage_v,
        found.peak_tip_displacement_m,
        found.peak_stop_point_displacement_m,
        found.contact_fraction,
        found.peak_force_n,
        found.mean_force_n,
    ];
    if !numbers.iter().all(|number| number.is_some_and(f64::is_finite)) {
        return Some("a number is not finite");
    }
    let rows = outcome.trace.as_ref().map_or(&[][..], |recording| &recording.rows);
    // Not-a-number included.
    let pulls = |force: f64| !(force >= 0.0);
    if rows.iter().filter_map(|row| row.get(FORCE)).copied().any(pulls)
        || found.mean_force_n.is_some_and(pulls)
    {
        return Some("the contact pulls");
    }
    let [double, single] = LEDGER;
    let allowed = if finding.precision == Precision::F64 { double } else { single };
    // A constraint and an impact have no potential energy to conserve: their losses are booked as such.
    let conserves = finding.setting.contact == Contact::ResidualFlexibility;
    let closes = outcome.energy_residual.is_none_or(|residual| residual <= allowed);
    (conserves && !closes).then_some("the energy ledger does not close")
}

#[cfg(test)]
mod tests;
