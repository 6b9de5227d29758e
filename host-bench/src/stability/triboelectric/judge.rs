//! Judges the runs of a case by runs that are more accurate.

use std::cell::OnceCell;

use super::{Class, Finding, Setting};
use crate::method::{Failure, Method, Options, Precision};
use crate::outcome::{Outcome, Particular};
use crate::reference::{self, ReferenceOptions};
use crate::run::run_scene;
use crate::scene_file::{Model, Scene};
use crate::stability::difference;

/// Relative tolerance per radian of the runs that are judged, in both precisions.
pub(super) const TOLERANCE: f64 = 1e-4;
/// Tolerances of the run in double precision by which they are judged: the second where the first fails with a named
/// error. Where both fail, the reference judges, and where that fails, a run at [`LOOSE`].
pub(super) const TIGHT: [f64; 2] = [TOLERANCE / 10.0, TOLERANCE / 3.0];
/// Tolerances of the run which tells whether the run at [`TIGHT`] has converged; where both fail, the reference tells.
const FINER: [f64; 2] = [TOLERANCE / 100.0, TOLERANCE / 30.0];
/// Tolerance of the run which tells whether the error falls with the tolerance.
const LOOSE: f64 = TOLERANCE * 10.0;
/// Relative difference in mean power and motion (peak gap, or amplitude) up to which two runs agree.
pub(super) const AGREEMENT: f64 = 1e-2;
/// Relative residual of the energy ledger above which a run is not to be trusted.
pub(super) const LEDGER: f64 = 1e-2;
/// Relative shifts of the starting position and of the stiffness that show a sensitive scene. Those of the position go
/// from a rounding in single precision to the error of the first flight at the tolerance; those of the stiffness are the
/// error of the period at the tolerance.
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
/// Number of standard deviations of the shifted runs by which a run of a sensitive scene may differ from their mean. By
/// Student's distribution one run in a hundred differs by more.
const DEVIATIONS: f64 = 4.0;
const REFERENCE_TOLERANCE: f64 = 1e-8;
/// Attempted steps after which a run is stopped: ten seconds of computing.
pub(super) const MOST_ATTEMPTS: u64 = 20_000_000;

/// What is compared of a run: its power, and the peak gap or amplitude in m. The power is the mean power in W; of a slider
/// the mean square of the voltage in V², which an open circuit has too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Statistics {
    pub(super) power: f64,
    pub(super) motion: f64,
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
        [difference(self.power, other.power), difference(self.motion, other.motion)]
    }

    pub(super) fn agree(&self, other: &Self) -> bool {
        self.differences(other).iter().all(|difference| *difference <= AGREEMENT)
    }

    /// Whether both numbers are within [`DEVIATIONS`] of the mean of those of `runs`.
    pub(super) fn within(&self, runs: &[Self]) -> bool {
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
pub(super) fn first_of(scene: &Scene, tolerances: &[f64]) -> Option<(f64, Statistics)> {
    tolerances.iter().find_map(|&tolerance| {
        run(scene, Precision::F64, tolerance).ok().map(|outcome| (tolerance, Statistics::of(&outcome)))
    })
}

fn by_reference(scene: &Scene) -> Option<Statistics> {
    let options = ReferenceOptions {
        tolerance: REFERENCE_TOLERANCE,
        record_every: None,
        most_steps: Some(MOST_ATTEMPTS),
    };
    reference::run(scene, &options).ok().map(|outcome| Statistics::of(&outcome))
}

/// Runs one case in both precisions; `with_reference` runs the reference too.
pub(super) fn examine<T: Setting>(base: &Scene, setting: T, with_reference: bool) -> [Finding<T>; 2] {
    let scene = setting.scene(base);
    let reference = with_reference.then(|| by_reference(&scene)).flatten();
    let tight = first_of(&scene, &TIGHT)
        .or_else(|| Some((TOLERANCE, reference.or_else(|| by_reference(&scene))?)))
        .or_else(|| first_of(&scene, &[LOOSE]));
    let judge = Judge::new(&scene, tight, reference);
    [Precision::F32, Precision::F64].map(|precision| judge.finding(setting, precision))
}

/// What the runs of one case are judged by.
pub(super) struct Judge<'a> {
    scene: &'a Scene,
    /// The tighter run and its tolerance.
    tight: Option<(f64, Statistics)>,
    reference: Option<Statistics>,
    /// The tight runs of [`Judge::shifted`], if they were needed.
    shifted: OnceCell<Vec<Statistics>>,
    /// The run at one of [`FINER`] or the reference, if it was needed and could run.
    finer: OnceCell<Option<Statistics>>,
}

impl<'a> Judge<'a> {
    /// Judges runs of `scene` by the tighter run, with its tolerance, and by the reference.
    pub(super) fn new(
        scene: &'a Scene,
        tight: Option<(f64, Statistics)>,
        reference: Option<Statistics>,
    ) -> Self {
        Self { scene, tight, reference, shifted: OnceCell::new(), finer: OnceCell::new() }
    }

    fn finding<T>(&self, setting: T, precision: Precision) -> Finding<T> {
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
            Err(failure) => {
                finding.reason = failure.to_string();
                finding.class = match failure {
                    Failure::Input(_) => Class::Refused,
                    Failure::Step(_) => Class::Error,
                    Failure::StepLimitExceeded(_) => Class::StepLimitExceeded,
                };
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

    pub(super) fn class(
        &self,
        own: &Statistics,
        closes: bool,
        reference_agrees: Option<bool>,
    ) -> (Class, String) {
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
                // Where the reference is the tighter run it must not be compared with itself.
                if *tolerance < TOLERANCE { by_reference(self.scene) } else { None }
            })
        });
        // The accurate runs must agree with each other, and with the reference where it was run. The judged run must
        // come close to them as well.
        let reliable =
            finer.as_ref().is_some_and(|finer| finer.agree(tight)) && reference_agrees != Some(false);
        if reliable && self.converges_to(own, tight) {
            return (Class::Converging, format!("differs from {against}, to which tighter runs converge"));
        }
        // The accurate runs may disagree among themselves.
        let all: Vec<Statistics> = shifted.iter().chain(finer).copied().collect();
        let sensitive = sensitive || finer.as_ref().is_some_and(|finer| !finer.agree(tight));
        if sensitive && own.within(&all) {
            return (Class::Chaotic, format!("differs from {against}, as that does from a finer one"));
        }
        let shifts = if sensitive { "and from shifted starts" } else { "no shifted start does" };
        (Class::Silent, format!("differs from {against}, {shifts}"))
    }

    /// Whether double precision approaches `last` as its tolerance is lowered to that of the judged runs, and the
    /// judged run is no worse than double precision at ten times the tolerance.
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

    /// Whether runs of rising accuracy approach the last: the second agrees with it, or is three times closer to it than
    /// the first.
    fn converges([first, second, third]: [&Statistics; 3]) -> bool {
        let (coarse, fine) = (first.differences(third), second.differences(third));
        coarse.iter().zip(fine).all(|(coarse, fine)| fine <= AGREEMENT || 3.0 * fine <= *coarse)
    }

    /// The tight run, the reference, and the tight run with shifted start or stiffness.
    fn shifted(&self, tolerance: f64, tight: &Statistics) -> Vec<Statistics> {
        let mut runs = vec![*tight];
        runs.extend(self.reference);
        let shifted = SHIFTS
            .iter()
            .filter_map(|shift| run(&self.shifted_scene(*shift), Precision::F64, tolerance).ok());
        runs.extend(shifted.map(|outcome| Statistics::of(&outcome)));
        runs
    }

    /// The scene with its start and its stiffness shifted by these parts of themselves.
    fn shifted_scene(&self, [start, stiffness]: [f64; 2]) -> Scene {
        let mut scene = self.scene.clone();
        match &mut scene.model {
            Model::ContactSeparation(model) => {
                let gap = model.initial.gap_m.unwrap_or(model.parameters.initial_gap_m);
                model.initial.gap_m = Some(gap * (1.0 + start));
                model.parameters.stiffness_n_per_m *= 1.0 + stiffness;
            }
            // A slider starts in the middle: its shift is relative to the radius of the patch.
            Model::Sliding(model) => {
                let displacement = model.initial.displacement_m.unwrap_or(0.0);
                model.initial.displacement_m = Some(displacement + model.parameters.patch_radius_m * start);
                model.parameters.young_modulus_pa *= 1.0 + stiffness;
            }
            Model::BumpStop(model) => model.parameters.substrate_young_modulus_pa *= 1.0 + stiffness,
        }
        scene
    }
}
