//! A day of simulated time in single precision against double precision: what a node sums up, drifts by, and claims.

use clap::ValueEnum as _;
use serde::Serialize;

use super::Kind;
use crate::method::{Failure, Options, Precision};
use crate::outcome::{Outcome, standard_error_of_sum};
use crate::rows::{Column, Digits};
use crate::run::run_scene;
use crate::scene_file::{self, Override, RunSpan, Scene};

pub(crate) const DAY_S: f64 = 86_400.0;
/// The relative error of the mean power that the runs in single precision claim.
const CLAIMED: f64 = 1e-3;
/// That of the triboelectric runs in double precision.
const EXACT: f64 = 1e-6;
/// Steps of bump-stop in s, near contact and in free flight: those of the firmware, and those with which `run` claims an error of 10⁻³.
const FIRMWARE_STEPS_S: [f64; 2] = [13e-6, 180e-6];
const FINE_STEPS_S: [f64; 2] = [0.25e-6, 5e-6];
/// Part of the day for which the latter run, ten minutes: a day of them takes four hours of a core.
const FINE_PART: f64 = 1.0 / 144.0;
/// Part of the day for which bump-stop runs in double precision: its mean has a standard error far below 10⁻³.
const DOUBLE_PART: f64 = 0.1;
/// Standard errors by which the means of two chaotic runs may differ.
const STANDARD_ERRORS: f64 = 3.0;

/// A run in single precision beside one in double precision.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    /// The shipped scene, by its name without ending.
    scene: &'static str,
    /// Lengths in s of the run in single and in double precision.
    durations_s: [f64; 2],
    /// Of the run in single and in double precision.
    options: [Options; 2],
    /// How the steps follow, in words.
    setting: String,
}

/// Two runs that were compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Compared {
    scene: &'static str,
    /// Steps or accuracies of the two runs.
    setting: String,
    /// Simulated time in s in single and in double precision.
    duration_f32_s: f64,
    duration_f64_s: f64,
    /// Steps of the run in single precision.
    steps: u64,
    /// Mean power in W in single and in double precision.
    mean_power_f32_w: f64,
    mean_power_f64_w: f64,
    /// Relative difference of the two.
    difference: f64,
    /// Its relative standard error, from the sixteen parts of the windows: the two runs are taken as independent.
    standard_error: f64,
    /// Processor time in s of the run in single and in double precision.
    processor_f32_s: f64,
    processor_f64_s: f64,
}

impl Compared {
    /// Whether the means agree within what is claimed, or where chance is larger, within chance.
    pub(crate) fn agrees(&self) -> bool {
        self.difference <= CLAIMED.max(STANDARD_ERRORS * self.standard_error)
    }
}

/// The pairs of runs of each shipped scene of some kinds.
pub(crate) fn pairs(kind: Option<Kind>, day_s: f64) -> Vec<Pair> {
    let kinds: Vec<Kind> = kind.map_or_else(|| Kind::value_variants().to_vec(), |kind| vec![kind]);
    kinds.into_iter().flat_map(|kind| of_kind(kind, day_s)).collect()
}

fn of_kind(kind: Kind, day_s: f64) -> Vec<Pair> {
    let by_accuracy = |scene| Pair {
        scene,
        durations_s: [day_s; 2],
        options: [CLAIMED, EXACT].map(|accuracy| Options { accuracy: Some(accuracy), ..Options::default() }),
        setting: format!("accuracy {CLAIMED:e} against {EXACT:e}"),
    };
    let by_steps = |[short, long]: [f64; 2], durations_s| Pair {
        scene: kind.scene(),
        durations_s,
        options: [Options { step_s: Some(short), long_step_s: Some(long), ..Options::default() }; 2],
        setting: format!("{} and {} µs", micro(short), micro(long)),
    };
    match kind {
        Kind::ContactSeparation => vec![by_accuracy(kind.scene()), by_accuracy("rectified")],
        Kind::Sliding => vec![by_accuracy(kind.scene())],
        Kind::BumpStop => {
            vec![
                by_steps(FIRMWARE_STEPS_S, [day_s, DOUBLE_PART * day_s]),
                by_steps(FINE_STEPS_S, [FINE_PART * day_s; 2]),
            ]
        }
    }
}

/// A time in s in µs, to the nanosecond.
fn micro(seconds: f64) -> f64 {
    (1e9 * seconds).round() / 1e3
}

impl Pair {
    /// Runs one of the two: the index of its precision.
    pub(crate) fn run(&self, index: usize) -> Result<Outcome, Failure> {
        let scene = scene_file::read(&scene_file::shipped(self.scene), &[] as &[Override])?;
        let run = RunSpan { duration_s: self.durations_s[index], ..scene.run };
        let precision = [Precision::F32, Precision::F64][index];
        let options = Options { precision: Some(precision), blocks: true, bare: true, ..self.options[index] };
        run_scene(&Scene { run, ..scene }, &options)
    }

    /// Compares the runs in single and in double precision.
    pub(crate) fn compared(&self, [single, double]: [&Outcome; 2]) -> Result<Compared, Failure> {
        let power_of = |run: &Outcome| {
            run.mean_power_w.ok_or_else(|| Failure::Step(format!("{}: no mean power", self.scene)))
        };
        let (mean_power_f32_w, mean_power_f64_w) = (power_of(single)?, power_of(double)?);
        let [of_single, of_double] = [single, double].map(|run| {
            let blocks = &run.block_energies_j;
            standard_error_of_sum(blocks) / blocks.iter().sum::<f64>()
        });
        Ok(Compared {
            scene: self.scene,
            setting: self.setting.clone(),
            duration_f32_s: self.durations_s[0],
            duration_f64_s: self.durations_s[1],
            steps: single.steps,
            mean_power_f32_w,
            mean_power_f64_w,
            difference: ((mean_power_f32_w - mean_power_f64_w) / mean_power_f64_w).abs(),
            standard_error: of_single.hypot(of_double),
            processor_f32_s: single.processor_s,
            processor_f64_s: double.processor_s,
        })
    }
}

/// The columns of the table of comparisons, of which the first two are words.
pub(crate) const COLUMNS: [Column<'_>; 11] = [
    ("scene", "scene", Digits::Six),
    ("f32 against f64", "setting", Digits::Six),
    ("simulated f32 [s]", "duration_f32_s", Digits::Six),
    ("f64", "duration_f64_s", Digits::Six),
    ("steps", "steps", Digits::Six),
    ("f32 [W]", "mean_power_f32_w", Digits::Exponent(6)),
    ("f64 [W]", "mean_power_f64_w", Digits::Exponent(6)),
    ("difference", "difference", Digits::Exponent(1)),
    ("standard error", "standard_error", Digits::Exponent(1)),
    ("processor f32 [s]", "processor_f32_s", Digits::Fixed(1.0, 0)),
    ("f64", "processor_f64_s", Digits::Fixed(1.0, 0)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_claims_what_it_holds_over_minutes() {
        for pair in pairs(Some(Kind::ContactSeparation), 120.0) {
            let [single, double] = [0, 1].map(|index| pair.run(index).expect("a shipped scene"));
            let found = pair.compared([&single, &double]).expect("power");
            assert!(found.agrees() && found.difference > 0.0, "{found:?}");
            // A difference beyond both is noticed.
            let beyond = 3.0 * CLAIMED.max(STANDARD_ERRORS * found.standard_error);
            let mut other = single.clone();
            other.mean_power_w = single.mean_power_w.map(|power| (1.0 + beyond) * power);
            assert!(!pair.compared([&other, &double]).expect("power").agrees());
        }
    }

    #[test]
    fn every_kind_has_a_whole_day() {
        for kind in Kind::value_variants() {
            let days = pairs(Some(*kind), DAY_S);
            assert!(days.iter().any(|pair| pair.durations_s[0] >= DAY_S), "{kind:?}");
        }
        assert_eq!(pairs(None, DAY_S).len(), 5);
    }
}
