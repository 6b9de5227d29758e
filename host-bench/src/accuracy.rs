//! States the accuracy of a run by runs of the same scene that differ in one source of error.
//!
//! The error by the step is estimated from a finer step or tolerance, that by rounding from a run in double
//! precision, by the sampling of a trace from a run on a smoother curve through the same samples. Two runs are
//! compared part by part of the measuring window: where the motion is chaotic, equal means of two runs would be
//! chance. Where no power is delivered, the statement is that of the largest motion and the RMS voltage.

mod difference;
mod rung;
mod warnings;

use self::difference::difference;
pub use self::warnings::imbalance;
use self::warnings::{beyond_threshold, unresolved, warning};
use crate::embedded::{DEFAULT_SHORT_STEP_S, default_accuracy};
use crate::method::{Failure, Method, Options, Precision};
use crate::outcome::{Accuracy, Outcome};
use crate::resolution::remarks;
use crate::run::run_scene;
use crate::scene_file::{Draw, Excitation, Load, Model, Scene, Trace};

/// Relative error that a bump-stop run without a given step aims at.
const BUMP_STOP_ACCURACY: f64 = 1e-3;
/// Most halvings of a bump-stop step in search of its accuracy.
pub(crate) const MOST_HALVINGS: u32 = 6;
/// Ratio of two successive differences above which halving the step is given up.
const NO_PROGRESS: f64 = 0.8;
/// Most attempted steps of a comparison, where the run itself has no limit.
const MOST_ATTEMPTS: u64 = 1 << 26;
/// Most attempted steps of a comparison with TR-BDF2, some seconds.
const MOST_ATTEMPTS_OF_TR_BDF2: u64 = 1 << 22;
/// Most attempted steps of a comparison over those of the run.
const MORE_ATTEMPTS: u64 = 4;
/// The error of a run over its difference from one with half the step. A method of first order has 2, the methods of
/// the core 1.1 to 1.4.
const BY_HALVING: f64 = 2.0;
/// Halvings of a tolerance to compare with. Half the tolerance may change no step: the motion limits the longest.
pub(crate) const TOLERANCE_HALVINGS: u32 = 4;
/// Least steps of a run with the smaller tolerance over those of the run. A method of order 5 takes 1.6 times the steps; where
/// the events and the motion choose most of them, both runs have the same error.
const MORE_STEPS: f64 = 1.1;
/// Accuracies in a row that are tried without a smaller statement.
const PATIENCE: u32 = 4;
/// The least statement. Runs of a few hundred steps were 10⁻⁵ off with no difference between two tolerances.
const LEAST: f64 = 1e-5;
/// Intervals of the smoother trace in one of the given trace.
const FINER: usize = 4;

/// Runs a scene, with the accuracy of its mean power and its warnings. A bump-stop run without a given step is repeated
/// with half the step until the estimate meets the accuracy. A run that was asked for an accuracy is repeated with smaller
/// steps or a smaller tolerance where its own statement is above it; a warning says if it cannot be held.
pub fn run_with_accuracy(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    run_with_steps(scene, options).map(|(outcome, _)| outcome)
}

/// As [`run_with_accuracy`], with the options of the run: its halvings are those that were chosen.
pub(crate) fn run_with_steps(scene: &Scene, options: &Options) -> Result<(Outcome, Options), Failure> {
    run_with_companions(scene, options, &mut Companions::default())
}

/// The statement of a run that does not tell how its steps were chosen, without the search for them.
///
/// # Errors
/// If the scene cannot be run.
pub(crate) fn statement_in_default_steps(scene: &Scene, options: &Options) -> Result<Accuracy, Failure> {
    let options = Options { blocks: true, ..*options };
    let outcome = run_scene(scene, &options)?;
    let mut companions = Companions::default();
    let mut finer = Halvings { scene, options, companions: &mut companions };
    Ok(statement(&mut finer, &options, &outcome))
}

/// Runs of one scene in double precision to compare with, by their options. Runs in single and in double precision are
/// compared with the same.
#[derive(Debug, Default)]
pub(crate) struct Companions(Vec<(Options, Option<Outcome>)>);

/// As [`run_with_steps`], with the runs to compare with that are known, all of this scene; new ones are added.
pub(crate) fn run_with_companions(
    scene: &Scene,
    options: &Options,
    companions: &mut Companions,
) -> Result<(Outcome, Options), Failure> {
    let asked = options.accuracy;
    // The halvings meet it; the run itself has no rule for it.
    let accuracy = match has_own_steps(scene, options) {
        true => None,
        false => asked.map(rung::at_or_below).or(by_default(scene, options)),
    };
    let mut options = Options { blocks: true, accuracy, ..*options };
    let mut finer = Halvings { scene, options, companions };
    options.halvings = chosen_halvings(&mut finer, asked);
    let mut outcome = run_scene(scene, &options)?;
    let mut doubts = Vec::new();
    if options.method != Method::Reference {
        outcome.accuracy = statement(&mut finer, &options, &outcome);
        if let Some(asked) = asked {
            (outcome, options) = tightened(&mut finer, options, outcome, asked);
        }
        let unresolved = unresolved(scene, &outcome).or_else(|| beyond_threshold(scene, &outcome));
        if unresolved.is_some() {
            outcome.accuracy.total = None;
        }
        doubts.extend(unresolved.or_else(|| warning(scene, &outcome, asked)));
    }
    doubts.extend(imbalance(&outcome));
    outcome.warnings.splice(..0, doubts);
    let remarks: Vec<String> = remarks(scene, &outcome).collect();
    outcome.warnings.extend(remarks);
    Ok((outcome, options))
}

/// The run again with half the steps, or by [`by_rungs`] with a smaller tolerance, as long as its statement is above the accuracy
/// that was asked for, the step is the largest part of it, and it falls.
fn tightened(
    finer: &mut Halvings<'_>,
    mut options: Options,
    mut outcome: Outcome,
    asked: f64,
) -> (Outcome, Options) {
    let scene = finer.scene;
    if let Some(first) = options.accuracy {
        return by_rungs(finer, options, outcome, [asked, first]);
    }
    let by_steps =
        has_own_steps(scene, &options) && options.step_s.is_none() && options.long_step_s.is_none();
    if !by_steps {
        return (outcome, options);
    }
    while let Accuracy { total: Some(total), step: Some(step), .. } = outcome.accuracy
        && total > asked.max(LEAST)
        && step > 0.5 * total
        && options.halvings < MOST_HALVINGS
    {
        let tighter = Options {
            halvings: options.halvings + 1,
            most_attempts: options.most_attempts.or(Some(MOST_ATTEMPTS)),
            ..options
        };
        // A run beyond its attempts is stopped: what there is stays.
        let Ok(mut again) = run_scene(scene, &tighter) else { break };
        again.accuracy = statement(finer, &tighter, &again);
        if !again.accuracy.total.is_some_and(|again| again <= NO_PROGRESS * total) {
            break;
        }
        again.processor_s += outcome.processor_s;
        (outcome, options) = (again, Options { most_attempts: options.most_attempts, ..tighter });
    }
    (outcome, options)
}

/// As [`tightened`], by the tolerances of lower and lower accuracies. All requests try the same ones, so that a tighter request
/// that is held never has a looser tolerance.
fn by_rungs(
    finer: &mut Halvings<'_>,
    options: Options,
    outcome: Outcome,
    [asked, first]: [f64; 2],
) -> (Outcome, Options) {
    let scene = finer.scene;
    let (mut best, mut rung, mut vain) = ((outcome, options), first, 0);
    let mut spent_s = best.0.processor_s;
    while let Accuracy { total: Some(total), step: Some(step), .. } = best.0.accuracy
        && total > asked.max(LEAST)
        && step > 0.5 * total
        && vain < PATIENCE
        && rung > rung::LOWEST
    {
        rung = rung::below(rung);
        let most_attempts = options.most_attempts.or(Some(MOST_ATTEMPTS));
        let tighter = Options { accuracy: Some(rung), most_attempts, ..options };
        // A tolerance below the rounding of the precision is refused, a run beyond its attempts stopped: what there is stays.
        let Ok(mut again) = run_scene(scene, &tighter) else { break };
        let mut companions = Halvings { scene, options: tighter, companions: &mut *finer.companions };
        again.accuracy = statement(&mut companions, &tighter, &again);
        spent_s += again.processor_s;
        vain += 1;
        let Some(other) = again.accuracy.total.filter(|other| *other < total) else { continue };
        if other <= NO_PROGRESS * total {
            vain = 0;
        }
        best = (again, Options { most_attempts: options.most_attempts, ..tighter });
    }
    best.0.processor_s = spent_s;
    best
}

/// The runs in double precision to compare with, by the number of halvings.
struct Halvings<'a> {
    scene: &'a Scene,
    options: Options,
    companions: &'a mut Companions,
}

impl Halvings<'_> {
    /// The run with this number of halvings; `None` if it cannot be run to its end.
    fn get(&mut self, halvings: u32) -> Option<Outcome> {
        let options = in_double_precision(&self.options, halvings);
        let Companions(known) = &mut *self.companions;
        if let Some((_, run)) = known.iter().find(|(other, _)| *other == options) {
            return run.clone();
        }
        let run = companion(self.scene, &options);
        known.push((options, run.clone()));
        run
    }
}

/// The accuracy by which a run without options chooses its tolerance: the runs to compare with have the same.
fn by_default(scene: &Scene, options: &Options) -> Option<f64> {
    let adapts = has_tolerance(scene, options) && options.tolerance.is_none();
    let by_accuracy = matches!(options.method, Method::Auto | Method::ExponentialRadau);
    (adapts && by_accuracy).then(|| default_accuracy(options.chosen_precision()))
}

/// Whether the library runs a bump-stop scene: by steps, which an accuracy can choose.
fn has_own_steps(scene: &Scene, options: &Options) -> bool {
    let own = matches!(options.method, Method::Auto | Method::DiscreteGradient);
    own && matches!(scene.model, Model::BumpStop(_))
}

/// The halvings of the default step with which a bump-stop run meets its accuracy, by pairs of runs in double
/// precision; 0 for any other run.
fn chosen_halvings(finer: &mut Halvings<'_>, asked: Option<f64>) -> u32 {
    let Halvings { scene, options, .. } = *finer;
    if !has_own_steps(scene, &options) || options.step_s.is_some() || options.long_step_s.is_some() {
        return 0;
    }
    let accuracy = asked.unwrap_or(BUMP_STOP_ACCURACY);
    let mut coarse = finer.get(0);
    let mut last = f64::INFINITY;
    for halvings in 1..=MOST_HALVINGS {
        let fine = finer.get(halvings);
        let (Some(one), Some(two)) = (&coarse, &fine) else { return halvings - 1 };
        // One of the two delivers nothing: they are infinitely far apart.
        let apart = difference(one, two).unwrap_or(f64::INFINITY);
        // The error of the finer run is at most this in a method of first order or higher.
        if apart <= accuracy {
            return if BY_HALVING * apart <= accuracy { halvings - 1 } else { halvings };
        }
        // The means of chaotic motions do not converge; a method of first order halves the difference.
        if apart > NO_PROGRESS * last {
            return halvings;
        }
        (coarse, last) = (fine, apart);
    }
    MOST_HALVINGS
}

/// The estimates of a run that has given `outcome`, with their sum; it is unknown if one of them is.
fn statement(finer: &mut Halvings<'_>, options: &Options, outcome: &Outcome) -> Accuracy {
    let scene = finer.scene;
    let single = outcome.precision == Precision::F32.name();
    let double = in_double_precision(options, options.halvings);
    let exact = if single { finer.get(options.halvings) } else { None };
    let alike = if single { exact.as_ref() } else { Some(outcome) };
    let step = alike.and_then(|alike| by_shorter_steps(finer, options, alike));
    let fast = alike.filter(|alike| options.step_s.is_none() && storage_is_fast(scene, alike));
    let charged = alike.filter(|_| has_start_layer(scene, options));
    let boundary_layers = match (fast, charged) {
        (Some(alike), _) => by_fixed_steps(scene, options, alike),
        (None, Some(alike)) => by_tr_bdf2(scene, options, alike),
        (None, None) => None,
    };
    let rounding = exact.as_ref().and_then(|exact| difference(outcome, exact));
    let smoother = smoother(scene);
    let smooth = smoother.as_ref().and_then(|smoother| companion(smoother, &double));
    let sampling = alike.zip(smooth.as_ref()).and_then(|(one, two)| difference(one, two));
    let accuracy = Accuracy { step, rounding, boundary_layers, sampling, total: None }.summed();
    let is_unknown = ((fast.is_some() || charged.is_some()) && boundary_layers.is_none())
        || (single && rounding.is_none())
        || (smoother.is_some() && sampling.is_none());
    if is_unknown { Accuracy { total: None, ..accuracy } } else { accuracy }
}

/// The estimated error by the step of a run in double precision that has given `outcome`.
fn by_shorter_steps(runs: &mut Halvings<'_>, options: &Options, outcome: &Outcome) -> Option<f64> {
    let scene = runs.scene;
    let adaptive = has_tolerance(scene, options);
    let finer = options.halvings + if adaptive { TOLERANCE_HALVINGS } else { 1 };
    let finer = runs.get(finer)?;
    let mut step = BY_HALVING * difference(outcome, &finer)?;
    // Motions far below the size of the harvester have errors below any tolerance: the step is then the longest. So it is of what
    // is left of a start that is far from rest, by whose voltages the errors are scaled.
    let changes_few = (finer.steps as f64) < MORE_STEPS * outcome.steps as f64;
    if adaptive && (changes_few || start_charge(scene).is_some()) {
        step = step.max(by_fixed_steps(scene, options, outcome)?);
    }
    if let Some(run) = by_default_steps(scene, options) {
        step = step.max(difference(outcome, &run?)?);
    }
    if let Some(earlier) = by_earlier_halvings(runs, options) {
        step = step.max(earlier);
    }
    Some(step.max(LEAST))
}

/// The error that the differences of three runs in longer steps lead to expect of a run, where they are known: one small
/// difference after slow progress is luck. The error is the sum of a geometric series with the ratio of the two differences.
fn by_earlier_halvings(runs: &mut Halvings<'_>, options: &Options) -> Option<f64> {
    if !has_own_steps(runs.scene, options) || options.step_s.is_some() || options.halvings < 2 {
        return None;
    }
    let [one, two, three] = [2, 1, 0].map(|more| runs.get(options.halvings - more));
    let (one, two, three) = (one?, two?, three?);
    let (first, second) = (difference(&one, &two)?, difference(&two, &three)?);
    let ratio = (second / first).min(NO_PROGRESS);
    Some(BY_HALVING * second * ratio / (1.0 - ratio))
}

/// The run of a bump-stop scene in default steps, where its own are longer: too few steps for a period have errors
/// that half the step does not show. `None` where they are not longer, within it if the run does not come to its end.
fn by_default_steps(scene: &Scene, options: &Options) -> Option<Option<Outcome>> {
    let step_s =
        options.step_s.filter(|step_s| has_own_steps(scene, options) && *step_s > DEFAULT_SHORT_STEP_S);
    step_s.map(|_| {
        let options = Options { step_s: None, long_step_s: None, ..in_double_precision(options, 0) };
        companion(scene, &options)
    })
}

/// Whether the steps of a run follow from a tolerance.
fn has_tolerance(scene: &Scene, options: &Options) -> bool {
    let adaptive = options.step_s.is_none() && options.method != Method::Rk4;
    adaptive && !matches!(scene.model, Model::BumpStop(_))
}

/// The estimated error of a triboelectric run in double precision, from a run in fixed steps, twice as many.
fn by_fixed_steps(scene: &Scene, options: &Options, outcome: &Outcome) -> Option<f64> {
    let step_s = mean_step(scene, outcome) / BY_HALVING;
    let fixed =
        Options { step_s: Some(step_s), tolerance: None, accuracy: None, ..in_double_precision(options, 0) };
    Some(BY_HALVING * difference(outcome, &companion(scene, &fixed)?)?)
}

/// Whether a run by exponential Radau starts with a charge of its own in a resistor. The force of a charge that is gone
/// within nanoseconds acts throughout its first step.
fn has_start_layer(scene: &Scene, options: &Options) -> bool {
    let own = matches!(options.method, Method::Auto | Method::ExponentialRadau);
    let conducts = matches!(scene.load, Load::Resistor { resistance_ohm } if resistance_ohm.is_finite());
    own && conducts && start_charge(scene).is_some()
}

/// The charge in C with which a triboelectric scene starts, if it is given.
fn start_charge(scene: &Scene) -> Option<f64> {
    match &scene.model {
        Model::ContactSeparation(model) => model.initial.charge_c,
        Model::Sliding(model) => model.initial.charge_c,
        Model::BumpStop(_) => None,
    }
}

/// The difference from a run by TR-BDF2, which takes the boundary layer out of its steps.
fn by_tr_bdf2(scene: &Scene, options: &Options, outcome: &Outcome) -> Option<f64> {
    let method = Method::TrBdf2;
    let other = Options {
        method,
        step_s: None,
        tolerance: None,
        accuracy: None,
        most_attempts: Some(MOST_ATTEMPTS_OF_TR_BDF2),
        ..in_double_precision(options, 0)
    };
    difference(outcome, &companion(scene, &other)?)
}

/// The mean step of a run in s.
fn mean_step(scene: &Scene, outcome: &Outcome) -> f64 {
    scene.run.duration_s / outcome.steps.max(1) as f64
}

/// Whether a storage behind the bridge of a triboelectric run discharges within a step: the tolerance does not hold its
/// charge, which the step control does not see.
fn storage_is_fast(scene: &Scene, outcome: &Outcome) -> bool {
    let Load::RectifiedStore(store) = scene.load else { return false };
    let drawing = match store.draw {
        Draw::Resistor { resistance_ohm, .. } => 1.0 / resistance_ohm,
        _ => 0.0,
    };
    let relaxation_s = store.capacitance_f / (drawing + 1.0 / store.leakage_ohm);
    !matches!(scene.model, Model::BumpStop(_)) && relaxation_s < mean_step(scene, outcome)
}

/// The options of a run to compare with, in double precision.
fn in_double_precision(options: &Options, halvings: u32) -> Options {
    Options {
        precision: Some(Precision::F64),
        math: None,
        halvings,
        blocks: true,
        trace_every_s: None,
        most_attempts: Some(
            options.most_attempts.map_or(MOST_ATTEMPTS, |most| most.saturating_mul(MORE_ATTEMPTS)),
        ),
        ..*options
    }
}

/// A run to compare with; `None` if it cannot be run to its end.
fn companion(scene: &Scene, options: &Options) -> Option<Outcome> {
    run_scene(scene, &Options { bare: takes_power(scene), ..*options }).ok()
}

/// Whether the load of a scene can take power. Where it cannot, the RMS voltage is compared, which a bare run of
/// bump-stop does not measure.
pub(crate) fn takes_power(scene: &Scene) -> bool {
    match scene.load {
        Load::Resistor { resistance_ohm } => resistance_ohm > 0.0 && resistance_ohm.is_finite(),
        Load::RectifiedStore(_) | Load::DcBus { .. } => true,
    }
}

/// The scene with more samples in its trace, on the cubic through four samples; `None` without a trace.
fn smoother(scene: &Scene) -> Option<Scene> {
    let Excitation::File(trace) = &scene.excitation else { return None };
    let samples = &trace.samples_m_per_s2;
    let count = samples.len();
    let at = |index: usize, offset: isize| {
        let place = index.cast_signed() + offset;
        let place = if trace.repeat {
            place.rem_euclid(count.cast_signed())
        } else {
            place.clamp(0, count.cast_signed() - 1)
        };
        samples[place.unsigned_abs()]
    };
    let last = if trace.repeat { count } else { count - 1 };
    let mut finer = Vec::with_capacity(FINER * count);
    for index in 0..last {
        let around = [-1, 0, 1, 2].map(|offset| at(index, offset));
        finer.extend((0..FINER).map(|part| cubic(around, part as f64 / FINER as f64)));
    }
    if !trace.repeat {
        finer.push(samples[count - 1]);
    }
    let rate_hz = trace.rate_hz * FINER as f64;
    let trace = Trace { samples_m_per_s2: finer.into(), rate_hz, repeat: trace.repeat };
    Some(Scene { excitation: Excitation::File(trace), ..scene.clone() })
}

/// The cubic through values at −1, 0, 1 and 2, at `x`.
fn cubic([before, left, right, after]: [f64; 4], x: f64) -> f64 {
    -before * x * (x - 1.0) * (x - 2.0) / 6.0 + left * (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0
        - right * (x + 1.0) * x * (x - 2.0) / 2.0
        + after * (x + 1.0) * x * (x - 1.0) / 6.0
}
