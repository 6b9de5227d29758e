//! Whether the embedded core gives a right answer, or says that it does not, over the whole range of
//! stiff and extreme scenes of contact-separation and of sliding.
//!
//! Each case is run in single and in double precision and judged by runs that are more accurate, by
//! the independent reference where that is asked for, and by its own energy ledger.

pub mod bump_stop;
mod grid;
pub mod table;

use std::cell::OnceCell;

use serde::Serialize;

use crate::method::{Failure, Method, Options, Precision, run_scene};
use crate::outcome::{Outcome, Particular};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{Model, Scene};

pub use self::grid::{ContactSeparationSetting, Grid, Kind, Setting, SlidingSetting};

/// Relative tolerance per radian of the runs that are judged, in both precisions.
pub const TOLERANCE: f64 = 1e-4;
/// Those of the double-precision run by which they are judged: the second where the first fails with
/// a named error. Where that does too, the reference stands in, and where it fails, a looser run.
pub const TIGHT: [f64; 2] = [TOLERANCE / 10.0, TOLERANCE / 3.0];
/// Those of the run which tells whether the tighter run itself has converged; else the reference.
const FINER: [f64; 2] = [TOLERANCE / 100.0, TOLERANCE / 30.0];
/// That of a run which tells whether the error falls with the tolerance where only looser ones run.
const LOOSE: f64 = TOLERANCE * 10.0;
/// Relative difference in mean power and motion (peak gap, or amplitude) up to which two runs agree.
pub const AGREEMENT: f64 = 1e-2;
/// Residual of the energy ledger from which a run says itself that it is not to be trusted.
pub const LEDGER: f64 = 1e-2;
/// Relative shifts of the starting position and of the stiffness that tell sensitive scenes: of the position from
/// a rounding in single precision to what the tolerance makes of the first flight, of the stiffness
/// what the method's error of the period amounts to at that tolerance.
const SHIFTS: [[f64; 2]; 10] = [
    [1e-6, 0.0],
    [-1e-6, 0.0],
    [1e-5, 0.0],
    [-1e-5, 0.0],
    [1e-4, 0.0],
    [-1e-4, 0.0],
    [0.0, 1e-5],
    [0.0, -1e-5],
    [0.0, 3e-5],
    [0.0, -3e-5],
];
/// Standard deviations of the shifted runs by which the statistics of a sensitive scene may be off
/// their mean: by Student's distribution one run in a hundred is off by more.
const DEVIATIONS: f64 = 4.0;
/// Relative tolerance of the reference.
const REFERENCE_TOLERANCE: f64 = 1e-8;
/// Attempted steps after which a run is given up: ten seconds of computing.
const MOST_ATTEMPTS: u64 = 20_000_000;

/// What became of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Agrees with the tighter run to [`AGREEMENT`] in mean power and motion.
    Converged,
    /// The scene itself is sensitive: its start shifted by at most 10⁻⁴ or its stiffness by at most
    /// 3·10⁻⁵, the tighter run disagrees with itself. The case's mean power and peak gap are within four standard deviations of the
    /// mean of the shifted runs, and its energy ledger closes.
    Chaotic,
    /// Off by more than [`AGREEMENT`], no further than double precision at ten times the tolerance, and
    /// in double precision the difference falls with the tolerance to runs that agree: a graze makes
    /// more of the tolerance.
    Converging,
    /// Does not agree, and its energy ledger says so.
    Flagged,
    /// The parameters are refused.
    Refused,
    /// A step could not be taken, and the error says why.
    Error,
    /// Given up after 2·10⁷ attempted steps.
    StepLimitExceeded,
    /// Runs, and its ledger closes, but no run in double precision does to judge it by.
    Unjudged,
    /// Off, and neither the ledger, nor an error, nor the scene being sensitive, says why.
    Silent,
}

impl Class {
    /// All classes, in the order of the tables.
    pub const ALL: [Self; 9] = [
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
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Chaotic => "chaotic",
            Self::Converging => "converging",
            Self::Flagged => "flagged by ledger",
            Self::Refused => "refused",
            Self::Error => "named error",
            Self::StepLimitExceeded => "too dear",
            Self::Unjudged => "unjudged",
            Self::Silent => "unexplained",
        }
    }
}

/// One case in one precision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The case.
    #[serde(flatten)]
    pub setting: Setting,
    /// Precision.
    pub precision: Precision,
    /// What became of it.
    pub class: Class,
    /// Why it is not converged.
    pub reason: String,
    /// Relative difference of the mean power to the tighter run.
    pub power_difference: Option<f64>,
    /// Relative difference of the peak gap, or of the slider's amplitude, to the tighter run.
    pub motion_difference: Option<f64>,
    /// Residual of the energy ledger.
    pub energy_residual: Option<f64>,
    /// Steps, kept and rejected, per simulated second.
    pub steps_per_s: Option<f64>,
    /// Whether the tighter run agrees with the reference; `None` if that was not asked, or could not
    /// run.
    pub reference_agrees: Option<bool>,
}

/// What is compared of a run: mean power in W, of a slider the mean square of the voltage, which an open
/// circuit has too; and peak gap or amplitude in m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Statistics {
    power: f64,
    motion: f64,
}

impl Statistics {
    fn of(outcome: &Outcome) -> Self {
        let (power, motion) = match &outcome.particular {
            Particular::ContactSeparation(found) => (outcome.mean_power_w, found.peak_gap_m),
            Particular::Sliding(found) => {
                (outcome.rms_voltage_v.map(|voltage| voltage * voltage), found.amplitude_m)
            }
            Particular::BumpStop(found) => (outcome.mean_power_w, found.peak_tip_displacement_m),
        };
        Self { power: power.unwrap_or(0.0), motion: motion.unwrap_or(0.0) }
    }

    fn differences(&self, other: &Self) -> [f64; 2] {
        let relative = |one: f64, two: f64| {
            let larger = one.abs().max(two.abs());
            // Written so that not-a-number is no agreement.
            if larger <= 1e-30 { 0.0 } else { (one - two).abs() / larger }
        };
        [relative(self.power, other.power), relative(self.motion, other.motion)]
    }

    fn agree(&self, other: &Self) -> bool {
        self.differences(other).iter().all(|difference| *difference <= AGREEMENT)
    }

    /// Whether both numbers are within [`DEVIATIONS`] of the mean of those of `runs`.
    fn within(&self, runs: &[Self]) -> bool {
        [|run: &Self| run.power, |run: &Self| run.motion].iter().all(|number| {
            let count = runs.len() as f64;
            let mean = runs.iter().map(number).sum::<f64>() / count;
            let squares: f64 = runs.iter().map(|run| (number(run) - mean).powi(2)).sum();
            let deviation = (squares / (count - 1.0)).sqrt();
            (number(self) - mean).abs() <= DEVIATIONS * deviation + AGREEMENT * mean.abs()
        })
    }
}

fn run(scene: &Scene, precision: Precision, tolerance: f64) -> Result<Outcome, Failure> {
    let options = Options {
        method: Method::TrBdf2,
        precision: Some(precision),
        tolerance: Some(tolerance),
        most_attempts: Some(MOST_ATTEMPTS),
        ..Options::default()
    };
    run_scene(scene, &options)
}

/// The first of the tolerances at which double precision gets to the end, and what it finds.
fn first_of(scene: &Scene, tolerances: &[f64]) -> Option<(f64, Statistics)> {
    tolerances.iter().find_map(|&tolerance| {
        run(scene, Precision::F64, tolerance).ok().map(|outcome| (tolerance, Statistics::of(&outcome)))
    })
}

fn ask_reference(scene: &Scene) -> Option<Statistics> {
    let options = ReferenceOptions {
        tolerance: REFERENCE_TOLERANCE,
        record_every: None,
        most_steps: Some(MOST_ATTEMPTS),
    };
    reference::run(scene, &options).ok().map(|outcome| Statistics::of(&outcome))
}

/// Runs one case in both precisions; `with_reference` asks the reference too.
#[must_use]
pub fn examine(base: &Scene, setting: Setting, with_reference: bool) -> [Finding; 2] {
    let scene = setting.scene(base);
    let reference = with_reference.then(|| ask_reference(&scene)).flatten();
    let tight = first_of(&scene, &TIGHT)
        .or_else(|| Some((TOLERANCE, reference.or_else(|| ask_reference(&scene))?)))
        .or_else(|| first_of(&scene, &[LOOSE]));
    let judge = Judge { scene: &scene, tight, reference, shifted: OnceCell::new(), finer: OnceCell::new() };
    [Precision::F32, Precision::F64].map(|precision| judge.finding(setting, precision))
}

/// What the runs of one case are judged by.
struct Judge<'a> {
    scene: &'a Scene,
    /// The tighter run and its tolerance.
    tight: Option<(f64, Statistics)>,
    reference: Option<Statistics>,
    /// Tight runs from shifted starts, if they were needed.
    shifted: OnceCell<Vec<Statistics>>,
    /// The run at one of [`FINER`] or the reference, if it was needed and could run.
    finer: OnceCell<Option<Statistics>>,
}

impl Judge<'_> {
    fn finding(&self, setting: Setting, precision: Precision) -> Finding {
        let outcome = run(self.scene, precision, TOLERANCE);
        let reference_agrees = match (&self.tight, &self.reference) {
            (Some((_, tight)), Some(reference)) => Some(tight.agree(reference)),
            _ => None,
        };
        let mut finding = Finding {
            setting,
            precision,
            class: Class::Converged,
            reason: String::new(),
            power_difference: None,
            motion_difference: None,
            energy_residual: None,
            steps_per_s: None,
            reference_agrees,
        };
        match outcome {
            Err(Failure::Input(reason)) => (finding.class, finding.reason) = (Class::Refused, reason),
            Err(Failure::Step(reason)) => (finding.class, finding.reason) = (Class::Error, reason),
            Err(Failure::StepLimitExceeded(reason)) => {
                (finding.class, finding.reason) = (Class::StepLimitExceeded, reason)
            }
            Ok(outcome) => {
                let steps = outcome.steps + outcome.rejected_steps;
                finding.steps_per_s = Some(steps as f64 / outcome.duration_s);
                finding.energy_residual = outcome.energy_residual;
                let own = Statistics::of(&outcome);
                if let Some((_, tight)) = &self.tight {
                    let [power, motion] = own.differences(tight);
                    (finding.power_difference, finding.motion_difference) = (Some(power), Some(motion));
                }
                let closes = outcome.energy_residual.is_none_or(|residual| residual <= LEDGER);
                (finding.class, finding.reason) = self.class(&own, closes, reference_agrees);
            }
        }
        finding
    }

    fn class(&self, own: &Statistics, closes: bool, reference_agrees: Option<bool>) -> (Class, String) {
        if !closes {
            return (Class::Flagged, "the energy ledger does not close".to_owned());
        }
        let Some((tolerance, tight)) = &self.tight else {
            return (Class::Unjudged, "no run in f64 to judge by".to_owned());
        };
        if own.agree(tight) && reference_agrees != Some(false) {
            return (Class::Converged, String::new());
        }
        let against = if own.agree(tight) { "the reference" } else { "the tighter run" };
        let shifted = self.shifted.get_or_init(|| self.shifted(*tolerance, tight));
        let sensitive = shifted.iter().any(|run| !run.agree(tight));
        if sensitive && own.within(shifted) {
            return (Class::Chaotic, format!("differs from {against}, as shifted starts do"));
        }
        let finer = self.finer.get_or_init(|| {
            first_of(self.scene, &FINER).map(|(_, finer)| finer).or_else(|| {
                // Not to be compared with itself where it stands in for the tighter run.
                if *tolerance < TOLERANCE { ask_reference(self.scene) } else { None }
            })
        });
        // The accurate runs must agree with each other, and with the reference where it was asked; that
        // alone says nothing for the judged run, which must come close to them itself.
        let settled =
            finer.as_ref().is_some_and(|finer| finer.agree(tight)) && reference_agrees != Some(false);
        if settled && self.converges_to(own, tight) {
            return (Class::Converging, format!("differs from {against}, to which tighter runs converge"));
        }
        // Not even the accurate runs agree among themselves.
        let all: Vec<Statistics> = shifted.iter().chain(finer).copied().collect();
        let sensitive = sensitive || finer.as_ref().is_some_and(|finer| !finer.agree(tight));
        if sensitive && own.within(&all) {
            return (Class::Chaotic, format!("differs from {against}, as that does from a finer one"));
        }
        let told = if sensitive { "and from shifted starts" } else { "no shifted start does" };
        (Class::Silent, format!("differs from {against}, {told}"))
    }

    /// Whether double precision approaches `last` as its tolerance is lowered to that of the judged
    /// runs, of which this one is no worse than double precision at ten times the tolerance.
    fn converges_to(&self, judged: &Statistics, last: &Statistics) -> bool {
        let [Some((_, loose)), Some((_, own))] =
            [LOOSE, TOLERANCE].map(|tolerance| first_of(self.scene, &[tolerance]))
        else {
            return false;
        };
        let (judged, allowed) = (judged.differences(last), loose.differences(last));
        Self::converges([&loose, &own, last])
            && judged.iter().zip(allowed).all(|(judged, allowed)| *judged <= allowed + AGREEMENT)
    }

    /// Whether runs of rising accuracy approach the last: it agrees with the one before, or that one
    /// is three times closer to it than the first.
    fn converges([first, second, third]: [&Statistics; 3]) -> bool {
        let (coarse, fine) = (first.differences(third), second.differences(third));
        coarse.iter().zip(fine).all(|(coarse, fine)| fine <= AGREEMENT || 3.0 * fine <= *coarse)
    }

    /// The tight run from its own start, the reference, and the tight run from shifted starts.
    fn shifted(&self, tolerance: f64, tight: &Statistics) -> Vec<Statistics> {
        let mut runs = vec![*tight];
        runs.extend(self.reference);
        runs.extend(SHIFTS.iter().filter_map(|[shift, stiffness_shift]| {
            let mut scene = self.scene.clone();
            match &mut scene.model {
                Model::ContactSeparation(model) => {
                    let gap = model.initial.gap_m.unwrap_or(model.parameters.initial_gap_m);
                    model.initial.gap_m = Some(gap * (1.0 + shift));
                    model.parameters.stiffness_n_per_m *= 1.0 + stiffness_shift;
                }
                // A slider starts in the middle: its shift is relative to the patch.
                Model::Sliding(model) => {
                    let displacement = model.initial.displacement_m.unwrap_or(0.0);
                    model.initial.displacement_m =
                        Some(displacement + model.parameters.patch_radius_m * shift);
                    model.parameters.young_modulus_pa *= 1.0 + stiffness_shift;
                }
                Model::BumpStop(model) => {
                    model.parameters.substrate_young_modulus_pa *= 1.0 + stiffness_shift;
                }
            }
            run(&scene, Precision::F64, tolerance).ok().map(|outcome| Statistics::of(&outcome))
        }));
        runs
    }
}

#[cfg(test)]
mod tests;
