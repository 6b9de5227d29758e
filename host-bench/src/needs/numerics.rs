//! The cheapest method, precision and step that hold an accuracy.

use serde::Serialize;

use super::{Change, Study};
use crate::method::{Method, Options, Precision};
use crate::run::{each, run_scene};
use crate::scene_file::{Model, Scene};
use crate::work_precision::least;

/// Tolerances of an adaptive step, the loosest first.
const TOLERANCES: [f64; 11] = [5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 1e-5];
/// The longest fixed step in s: 1/256 s is the longest that a triboelectric scene takes.
const LONGEST_STEP_S: f64 = 1.0 / 256.0;
/// Steps of a bump-stop scene near contact in s, the longest first.
const SHORT_STEPS_S: [f64; 7] = [16e-6, 8e-6, 4e-6, 2e-6, 1e-6, 0.5e-6, 0.25e-6];
/// Its step in free flight over that near contact.
const LONG_OVER_SHORT: f64 = 20.0;
/// Halvings of a fixed step.
const HALVINGS: u32 = 10;
/// Runs of which the shortest is the cost.
pub(crate) const REPEATS: usize = 5;

/// What decides on the length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Control {
    /// A relative tolerance.
    Tolerance(f64),
    /// A fixed step in s.
    FixedStep(f64),
    /// Steps in s near contact and in free flight.
    ShortAndLong([f64; 2]),
}

/// A method, a precision and a control of the step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Setting {
    pub(crate) method: Method,
    pub(crate) precision: Precision,
    pub(crate) control: Control,
}

/// The loosest control of a method and precision that holds the accuracy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Numerics {
    #[serde(flatten)]
    pub(crate) setting: Setting,
    /// What the cut scene changes by it, against the full one.
    #[serde(flatten)]
    pub(crate) change: Change,
    /// Steps, kept and rejected, per simulated second.
    pub(crate) steps_per_s: f64,
    /// Processor time of the host over simulated time, the least of some runs.
    pub(crate) host_s_per_s: f64,
    /// The largest of them over the least, less 1.
    pub(crate) host_spread: Option<f64>,
}

impl Setting {
    pub(crate) fn options(&self) -> Options {
        let options = Options {
            method: self.method,
            precision: Some(self.precision),
            blocks: true,
            ..Options::default()
        };
        match self.control {
            Control::Tolerance(tolerance) => Options { tolerance: Some(tolerance), ..options },
            Control::FixedStep(step_s) => Options { step_s: Some(step_s), ..options },
            Control::ShortAndLong([short, long]) => {
                Options { step_s: Some(short), long_step_s: Some(long), ..options }
            }
        }
    }
}

/// The settings of each method and precision that the core has for a scene, from the loosest to the tightest.
fn ladders(scene: &Scene) -> Vec<Vec<Setting>> {
    let ladder = |method, precision, controls: &[Control]| {
        controls.iter().map(|control| Setting { method, precision, control: *control }).collect()
    };
    let kinds: Vec<(Method, Vec<Control>)> = if matches!(scene.model, Model::BumpStop(_)) {
        let both =
            SHORT_STEPS_S.map(|short| Control::ShortAndLong([short, LONG_OVER_SHORT * short])).to_vec();
        let single = SHORT_STEPS_S.map(Control::FixedStep).to_vec();
        vec![(Method::DiscreteGradient, both), (Method::DiscreteGradient, single)]
    } else {
        let adaptive = TOLERANCES.map(Control::Tolerance).to_vec();
        let halved = |halvings: u32| LONGEST_STEP_S * 0.5_f64.powi(halvings.cast_signed());
        let fixed: Vec<Control> = (0..=HALVINGS).map(halved).map(Control::FixedStep).collect();
        vec![
            (Method::ExponentialRadau, adaptive.clone()),
            (Method::ExponentialRadau, fixed.clone()),
            (Method::TrBdf2, adaptive),
            (Method::Rk4, fixed),
        ]
    };
    let precisions = [Precision::F32, Precision::F64];
    let ladders = kinds
        .iter()
        .flat_map(|(method, controls)| precisions.map(|precision| ladder(*method, precision, controls)));
    ladders.collect()
}

/// Work of a step over that of a Runge–Kutta or bump-stop step: run times on a host, rounded.
fn work_of_step(method: Method) -> f64 {
    match method {
        Method::ExponentialRadau => 1.8,
        Method::TrBdf2 => 1.4,
        _ => 1.0,
    }
}

/// The loosest setting of each method and precision that holds the accuracy for a scene, which is chaotic or not, against
/// the full one, that of the least work first. The order does not depend on the host. A setting holds if the next tighter one does too.
pub(crate) fn cheapest(
    study: &Study,
    (scene, is_chaotic): (&Scene, bool),
    done: impl Fn(usize) + Sync,
) -> Vec<Numerics> {
    let ladders = ladders(scene);
    let count = ladders.len();
    let found = each(&ladders, |ladder| {
        let found = loosest(study, (scene, is_chaotic), ladder);
        done(count);
        found
    });
    let mut found: Vec<Numerics> = found.into_iter().flatten().collect();
    for numerics in &mut found {
        (numerics.host_s_per_s, numerics.host_spread) = host_time(scene, &numerics.setting.options());
    }
    let work = |found: &Numerics| found.steps_per_s * work_of_step(found.setting.method);
    found.sort_by(|one, other| work(one).total_cmp(&work(other)));
    found
}

fn loosest(study: &Study, (scene, is_chaotic): (&Scene, bool), ladder: &[Setting]) -> Option<Numerics> {
    let mut candidate: Option<Numerics> = None;
    for setting in ladder {
        let options = Options { most_attempts: study.options.most_attempts, ..setting.options() };
        let accepted =
            study.compared(scene, Some(&options), Some(is_chaotic)).ok().and_then(|(change, run)| {
                let steps_per_s = (run.steps + run.rejected_steps) as f64 / run.duration_s;
                let holds = change.is_within(study.accuracy) == Some(true);
                holds.then_some(Numerics {
                    setting: *setting,
                    change,
                    steps_per_s,
                    host_s_per_s: f64::NAN,
                    host_spread: None,
                })
            });
        match (candidate.is_some(), accepted.is_some()) {
            (true, true) => return candidate,
            _ => candidate = accepted,
        }
    }
    // The tightest setting has no tighter one to confirm it.
    None
}

/// Processor time of the host over simulated time, as firmware would run it, and its spread.
pub(crate) fn host_time(scene: &Scene, options: &Options) -> (f64, Option<f64>) {
    let options = Options { bare: true, blocks: false, ..*options };
    let runs = (0..REPEATS).filter_map(|_| run_scene(scene, &options).ok());
    least(&runs.map(|run| run.processor_s / scene.run.duration_s).collect::<Vec<_>>())
}
