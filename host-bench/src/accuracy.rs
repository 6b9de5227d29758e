//! States the accuracy of a run by runs of the same scene that differ in one source of error.
//!
//! The error by the step is estimated from a finer step or tolerance, that by rounding from a run in double precision, by
//! the sampling of a trace from a run on a smoother curve through the same samples. A run in the same steps shows nothing, and
//! states nothing. Where the motion is chaotic the mean power is that of an ensemble, and its error that of the mean. Where no
//! power is delivered, the statement is that of the largest motion and the RMS voltage.

mod difference;
mod ensemble;
mod rung;
mod runs;
mod statement;
mod statements;
mod warnings;

pub(crate) use self::runs::MOST_ATTEMPTS;
use self::statement::state;
pub(crate) use self::statements::{Statements, tell_warnings};
pub use self::warnings::imbalance;
use self::warnings::{beyond_threshold, sampled, unresolved, warning};
use crate::embedded::default_accuracy;
use crate::method::{Failure, Method, Options};
use crate::outcome::{Accuracy, Outcome};
use crate::resolution::remarks;
use crate::run::run_scene;
use crate::scene_file::{Model, Scene};

/// Relative error that a bump-stop run without a given step aims at.
const BUMP_STOP_ACCURACY: f64 = 1e-3;
/// Most halvings of a bump-stop step in search of its accuracy.
pub(crate) const MOST_HALVINGS: u32 = 6;
/// Ratio of two successive statements above which a further search is given up.
const NO_PROGRESS: f64 = 0.8;
/// Accuracies in a row that are tried without a smaller statement.
const PATIENCE: u32 = 4;
/// The least statement. Runs of a few hundred steps were 10⁻⁵ off with no difference between two tolerances.
const LEAST: f64 = 1e-5;

/// Runs a scene, with the accuracy of its mean power and its warnings. A run that was asked for an accuracy, and a bump-stop run
/// without a given step, is repeated with smaller steps or a smaller tolerance where its own statement is above it; a warning
/// says if it cannot be held.
pub fn run_with_accuracy(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    run_with_steps(scene, options).map(|(outcome, _)| outcome)
}

/// Runs a scene by its options as they are, without the search for steps, with its statement and its warnings.
///
/// # Errors
/// If the scene cannot be run.
pub(crate) fn run_as_it_is(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    let options = Options { blocks: true, ..*options };
    let mut outcome = run_scene(scene, &options)?;
    if options.method != Method::Reference {
        state(scene, &options, &mut outcome);
    }
    warn(scene, &mut outcome, &options, None);
    Ok(outcome)
}

/// As [`run_with_accuracy`], with the options of the run: its halvings are those that were chosen.
pub(crate) fn run_with_steps(scene: &Scene, options: &Options) -> Result<(Outcome, Options), Failure> {
    let asked = options.accuracy;
    // The halvings meet it; the run itself has no rule for it.
    let accuracy = match has_own_steps(scene, options) {
        true => None,
        false => asked.map(rung::at_or_below).or(by_default(scene, options)),
    };
    let mut options = Options { blocks: true, accuracy, ..*options };
    let mut outcome = run_scene(scene, &options)?;
    if options.method != Method::Reference {
        state(scene, &options, &mut outcome);
        let by_default = chooses_steps(scene, &options).then_some(BUMP_STOP_ACCURACY);
        if let Some(asked) = asked.or(by_default) {
            (outcome, options) = tightened(scene, options, outcome, asked);
        }
    }
    warn(scene, &mut outcome, &options, asked);
    Ok((outcome, options))
}

/// Adds what is to be known of a run with a statement to its warnings.
fn warn(scene: &Scene, outcome: &mut Outcome, options: &Options, asked: Option<f64>) {
    let mut doubts = Vec::new();
    if options.method != Method::Reference {
        let unresolved = unresolved(scene, outcome);
        if unresolved.is_some() {
            outcome.accuracy.total = None;
        }
        let missed = || beyond_threshold(scene, outcome);
        doubts.extend(unresolved.or_else(missed).or_else(|| warning(outcome, asked)));
        doubts.extend(sampled(scene, outcome));
    }
    doubts.extend(imbalance(outcome));
    outcome.warnings.splice(..0, doubts);
    let remarks: Vec<String> = remarks(scene, outcome).collect();
    outcome.warnings.extend(remarks);
}

/// The run again with the shorter steps that its statement asks for, or the smaller tolerance of a lower accuracy, as long as its statement is above the
/// accuracy that was asked for, the step is the largest part of it, and it falls. All requests try the same accuracies, so that
/// a tighter request that is held never has a looser tolerance.
fn tightened(scene: &Scene, options: Options, outcome: Outcome, asked: f64) -> (Outcome, Options) {
    let mut spent_s = outcome.processor_s;
    let (mut best, mut tried, mut vain) = ((outcome, options), options, 0);
    while let Accuracy { total: Some(total), step: Some(step), .. } = best.0.accuracy
        && total > asked.max(LEAST)
        && step > 0.5 * total
        && vain < PATIENCE
    {
        let Some(tighter) = tighter(scene, &tried, step / asked.max(LEAST)) else { break };
        // A tolerance below the rounding of the precision is refused, a run beyond its attempts stopped: what there is stays.
        let limited = Options { most_attempts: tighter.most_attempts.or(Some(MOST_ATTEMPTS)), ..tighter };
        let Ok(mut again) = run_scene(scene, &limited) else { break };
        state(scene, &limited, &mut again);
        tried = tighter;
        spent_s += again.processor_s;
        vain += 1;
        let Some(other) = again.accuracy.total.filter(|other| *other < total) else { continue };
        if other <= NO_PROGRESS * total {
            vain = 0;
        }
        best = (again, tighter);
    }
    best.0.processor_s = spent_s;
    best
}

/// The options of a run whose error by the step is so many times as small: of bump-stop in halves of the default steps, if the
/// error falls with the square of the step, of another in the tolerance of the next lower accuracy. `None` where steps or
/// tolerance were given, and at the least.
fn tighter(scene: &Scene, options: &Options, times: f64) -> Option<Options> {
    if let Some(accuracy) = options.accuracy {
        let lower = Options { accuracy: Some(rung::below(accuracy)), ..*options };
        return (accuracy > rung::LOWEST).then_some(lower);
    }
    let more = (0.5 * times.log2()).ceil().max(1.0) as u32;
    let halvings = (options.halvings + more).min(MOST_HALVINGS);
    let may_be = chooses_steps(scene, options) && halvings > options.halvings;
    may_be.then_some(Options { halvings, ..*options })
}

/// The accuracy by which a run without options chooses its tolerance: the runs to compare with have the same.
fn by_default(scene: &Scene, options: &Options) -> Option<f64> {
    let adapts = has_tolerance(scene, options) && options.tolerance.is_none();
    let by_accuracy = matches!(options.method, Method::Auto | Method::ExponentialRadau);
    (adapts && by_accuracy).then(|| default_accuracy(&scene.model, options.chosen_precision()))
}

/// Whether the library runs a bump-stop scene: by steps, which an accuracy can choose.
pub(crate) fn has_own_steps(scene: &Scene, options: &Options) -> bool {
    let own = matches!(options.method, Method::Auto | Method::DiscreteGradient);
    own && matches!(scene.model, Model::BumpStop(_))
}

/// Whether the accuracy chooses the steps of a bump-stop run.
fn chooses_steps(scene: &Scene, options: &Options) -> bool {
    has_own_steps(scene, options) && options.step_s.is_none() && options.long_step_s.is_none()
}

/// Whether the steps of a run follow from a tolerance.
fn has_tolerance(scene: &Scene, options: &Options) -> bool {
    let adaptive = options.step_s.is_none() && options.method != Method::Rk4;
    adaptive && !matches!(scene.model, Model::BumpStop(_))
}
