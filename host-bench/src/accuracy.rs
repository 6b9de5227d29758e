//! States the accuracy of a run by runs of the same scene that differ in one source of error.
//!
//! The error by the step is estimated from a finer step or tolerance, that by rounding from a run in double precision, by
//! the sampling of a trace from a run on a smoother curve through the same samples. A run in the same steps shows nothing, and
//! states nothing. Where the motion is chaotic the mean power is that of an ensemble, and its error that of the mean. Where no
//! power is delivered, the statement is that of the largest motion and the RMS voltage.

mod ensemble;
mod statement;
mod warnings;

use crate::embedded::default_accuracy;
use crate::method::{Failure, Method, Options, Precision};
use crate::outcome::{Accuracy, BLOCKS, Outcome};
use crate::resolution::remarks;
use crate::run::{each, run_scene};
use crate::scene_file::{Model, Scene};
use crate::shift::shifted;
use statement::state;
pub(crate) use statement::{Statements, print_warnings};
pub use warnings::imbalance;
use warnings::{beyond_threshold, sampled, unresolved, warning};

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
        false => asked.map(at_or_below).or(by_default(scene, options)),
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
        // The RMS voltage of single precision may be one of roundings: the statement has asked that of double precision.
        let is_unknown = outcome.accuracy.total.is_none();
        let missed = || beyond_threshold(scene, outcome).filter(|_| is_unknown);
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
        if let Accuracy { chaos: None, step: Some(found), total: Some(_), .. } = again.accuracy
            && options.accuracy.is_none()
        {
            // An error falls with the square of the step at most: runs that agree better do so by chance.
            let least = step * 0.25_f64.powi((tighter.halvings - best.1.halvings).cast_signed());
            again.accuracy = Accuracy { step: Some(found.max(least)), ..again.accuracy }.summed();
        }
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
        let lower = Options { accuracy: Some(below(accuracy)), ..*options };
        return (accuracy > LOWEST).then_some(lower);
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
    (adapts && by_accuracy).then(|| default_accuracy(scene, options.chosen_precision()))
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

/// The least accuracy that an option may ask for.
const LOWEST: f64 = 1e-12;

/// The largest rung that is not above an accuracy, from the least one on.
fn at_or_below(accuracy: f64) -> f64 {
    let decade = accuracy.log10().floor() as i32;
    // By their decimal texts, so that they are the numbers that options have.
    let rungs = (decade - 1..=decade + 1)
        .rev()
        .flat_map(|decade| [3, 1].map(|digit| format!("{digit}e{decade}").parse::<f64>().unwrap_or(LOWEST)));
    // A product such as 0.1 × 0.03 is a rung but for its rounding.
    let mut below = rungs.filter(|rung| *rung <= accuracy * (1.0 + 1e-12));
    below.next().unwrap_or(LOWEST).max(LOWEST)
}

/// The next rung below one.
fn below(rung: f64) -> f64 {
    at_or_below(0.9 * rung)
}

/// Most attempted steps of a comparison, where the run itself has no limit.
pub(crate) const MOST_ATTEMPTS: u64 = 1 << 26;
/// Most attempted steps of a comparison over those of the run.
const MORE_ATTEMPTS: u64 = 4;

struct Runs<'a> {
    scene: &'a Scene,
    /// Steps of all runs so far.
    steps: u64,
}

impl Runs<'_> {
    /// The run of the scene; `None` if it cannot be run to its end.
    fn get(&mut self, options: &Options) -> Option<Outcome> {
        self.at(options, &[0.0]).pop()
    }

    /// The runs of displaced starts, on all cores: the base acceleration, or the start where the base is at rest, is changed by
    /// such parts. Runs that do not come to their end are left out.
    fn at(&mut self, options: &Options, shifts: &[f64]) -> Vec<Outcome> {
        let scene = self.scene;
        let run = |shift: &f64| run_scene(&shifted(scene, *shift)?, options).ok();
        let found: Vec<Outcome> = each(shifts, run).into_iter().flatten().collect();
        self.steps += found.iter().map(|run| run.steps).sum::<u64>();
        found
    }
}

/// The options of a run to compare with, in double precision.
fn in_double_precision(options: &Options) -> Options {
    to_compare(&Options { precision: Some(Precision::F64), math: None, ..*options })
}

/// The options of a run to compare with.
fn to_compare(options: &Options) -> Options {
    let most = options.most_attempts.map_or(MOST_ATTEMPTS, |most| most.saturating_mul(MORE_ATTEMPTS));
    Options {
        precision: Some(options.chosen_precision()),
        blocks: true,
        trace_every_s: None,
        most_attempts: Some(most),
        ..*options
    }
}

/// Least mean number of steps in a part of the window.
const STEPS_PER_PART: u64 = 64;

/// Whether a run delivers power.
fn delivers(outcome: &Outcome) -> bool {
    outcome.delivered_energy_j.is_some_and(|energy| energy != 0.0)
}

/// How two runs differ, relative to the smaller energy of the two.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Difference {
    /// Of the energies delivered; where none is, the larger of the relative differences of the largest motion and of the RMS voltage.
    whole: f64,
    /// The root of the sum of the squares of the differences in the parts of the window.
    parts: f64,
}

/// The difference of two runs; `None` if one of the two alone delivers nothing.
fn difference(one: &Outcome, two: &Outcome) -> Option<Difference> {
    let (energy, other) = (one.delivered_energy_j?, two.delivered_energy_j?);
    if energy == 0.0 && other == 0.0 {
        let [motion, voltage] = [0, 1].map(|index| relative(motions(one)[index], motions(two)[index]));
        let whole = motion?.max(voltage?);
        return Some(Difference { whole, parts: whole });
    }
    // Where a part has few steps, the energy of the step across its border is a part of it.
    let parts = (one.steps.min(two.steps) / STEPS_PER_PART).clamp(1, BLOCKS as u64);
    let blocks_of_part = BLOCKS >> parts.ilog2();
    let blocks = one.block_energies_j.iter().zip(&two.block_energies_j);
    let apart: Vec<f64> = blocks.map(|(one, two)| one - two).collect();
    let squares = apart.chunks(blocks_of_part).map(|part| part.iter().sum::<f64>().powi(2)).sum::<f64>();
    let over = |apart_j: f64| if apart_j == 0.0 { 0.0 } else { apart_j / energy.abs().min(other.abs()) };
    let found = Difference { whole: over((energy - other).abs()), parts: over(squares.sqrt()) };
    (found.whole.is_finite() && found.parts.is_finite()).then_some(found)
}

/// The largest gap, displacement of the slider or displacement of the tip in m, and the RMS voltage in V; 0 where there is none.
fn motions(outcome: &Outcome) -> [f64; 2] {
    [outcome.largest_motion_m(), outcome.rms_voltage_v].map(|value| value.unwrap_or(0.0))
}

/// The difference of two values over the smaller magnitude; `None` if one of the two alone is 0.
fn relative(one: f64, other: f64) -> Option<f64> {
    let apart = (one - other).abs() / one.abs().min(other.abs());
    if one == other { Some(0.0) } else { apart.is_finite().then_some(apart) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_are_one_and_three_times_powers_of_ten() {
        for (accuracy, rung) in [
            (1e-6, 1e-6),
            (0.1 * 0.03, 3e-3),
            (2e-3, 1e-3),
            (0.1, 0.1),
            (5e-2, 3e-2),
            (9.99e-5, 3e-5),
            (1e-12, 1e-12),
        ] {
            assert_eq!(at_or_below(accuracy), rung, "{accuracy}");
        }
        let mut all = vec![0.1];
        while let Some(&last) = all.last().filter(|last| **last > LOWEST) {
            all.push(below(last));
        }
        assert_eq!(all.len(), 23);
        assert!(all.windows(2).all(|pair| (2.9..3.5).contains(&(pair[0] / pair[1]))), "{all:?}");
    }
}
