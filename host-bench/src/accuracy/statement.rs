//! The statement of one run, by source.

use std::f64::consts::TAU;

use serde_json::json;

use super::ensemble::{chaotic, ensemble};
use super::warnings::{beyond_threshold, differing_peak, lost_rms};
use super::{
    Difference, LEAST, Runs, delivers, difference, has_own_steps, has_tolerance, in_double_precision,
    run_as_it_is,
};
use crate::command::warn;
use crate::embedded::{DEFAULT_LONG_STEP_S, DEFAULT_SHORT_STEP_S};
use crate::method::{Failure, Options, Precision};
use crate::outcome::{Accuracy, Fields, Outcome, fields, standard_error_of_sum};
use crate::resolution::{natural_frequency_hz, resonances};
use crate::run::{run_scene, try_each};
use crate::scene_file::{Draw, Excitation, Load, Scene, Tone, Trace};

/// Stated errors over differences: of the energies delivered, and of those in the parts of the window, which cancel by chance in
/// the whole. Both are fitted to random scenes: docs/verification.md.
const STATED: [f64; 2] = [2.7, 0.27];
/// Halvings of a tolerance to compare with. Half the tolerance may change no step.
const TOLERANCE_HALVINGS: u32 = 2;
/// Least steps of a run to compare with over those of the run: in the same steps both have the same error.
const MORE_STEPS: f64 = 1.2;
/// Length of the steps of a run to compare with over the mean of the run, where another tolerance or step takes hardly more steps.
const SHORTER: f64 = 2.0 / 3.0;
/// Mean step in radians of the fastest oscillation above which another tolerance takes hardly more steps: steps end at 0.8.
const LONGEST: f64 = 0.5;
/// Mean step in periods of the slowest oscillation above which its turns are missed.
const QUARTER: f64 = 0.25;
/// Step of a run to compare with, in periods of a rod's slowest mode, above which impacts within one are missed.
const HALF: f64 = 0.5;
/// Intervals of the smoother trace in one of the given trace.
const FINER: usize = 4;
/// Length of the window over which the sampling error is half as large, in windows.
const HALVING: f64 = 4.0;

/// Lengths of the longer steps that a beam which bounces at rest is compared with, over those of the run.
const COARSER: [f64; 3] = [2.0, 4.0, 8.0];

fn stated(difference: Difference) -> f64 {
    let [of_whole, of_parts] = STATED;
    (of_whole * difference.whole).max(of_parts * difference.parts)
}

/// States the accuracy of a run that has given `outcome`. Of a chaotic motion its mean power becomes that of the ensemble.
pub(super) fn state(scene: &Scene, options: &Options, outcome: &mut Outcome) {
    let mut runs = Runs { scene, steps: 0 };
    let single = outcome.precision == Precision::F32.name();
    let exact = if single { runs.get(&in_double_precision(options)) } else { None };
    // A bare run of bump-stop does not measure the voltage that is compared where no power is delivered.
    let bare = delivers(outcome);
    let options = &Options { bare, ..*options };
    let double = in_double_precision(options);
    outcome.accuracy = Accuracy::default();
    let alike = if single { exact.as_ref() } else { Some(&*outcome) };
    let Some(alike) = alike else { return };
    let smoother = smoother(scene);
    let sampling = smoother.as_ref().and_then(|smoother| run_scene(smoother, &double).ok());
    let sampling = sampling.and_then(|smooth| difference(alike, &smooth)).map(|found| found.whole);
    let is_layered = has_fast_storage(scene, &double, alike) || has_start_charge(scene, &double);
    let finer = finer(&mut runs, &double, alike, is_layered);
    let between = finer.as_ref().and_then(|(_, finer)| difference(alike, finer));
    // All of a power that is delivered in double precision only is lost.
    let is_lost = delivers(alike) && !delivers(outcome);
    let between_steps = between.filter(|_| !is_lost && !is_coarse(scene, &double));
    let is_missed = beyond_threshold(scene, alike).is_some();
    let is_unresolved = !delivers(alike) && misses_turns(scene, alike);
    let misses_impacts = finer.as_ref().is_some_and(|(options, _)| misses_impacts(scene, options, outcome));
    let rounding = exact.as_ref().and_then(|exact| difference(outcome, exact));
    // What a comparison cannot show.
    let is_blind = is_missed || is_unresolved || misses_impacts;
    let is_chaotic = !is_blind && chaotic(&mut runs, &double, alike, [between_steps, rounding]);
    let half = finer.as_ref().filter(|_| is_chaotic);
    let found = half.and_then(|half| ensemble(&mut runs, options, outcome, half));
    let coarser = if found.is_none() { by_coarser_steps(&mut runs, &double, alike) } else { 0.0 };
    let work = runs.steps as f64 / outcome.steps.max(1) as f64;
    let window = (found.is_some() || scene.excitation.is_irregular()).then(|| window(outcome)).flatten();
    let mut accuracy = Accuracy { sampling, window, work, ..Accuracy::default() };
    accuracy.window_halved_s =
        window.map(|_| outcome.settle_s + HALVING * (outcome.duration_s - outcome.settle_s));
    let finer = finer.as_ref().map_or(&[][..], |(_, finer)| std::slice::from_ref(finer));
    let peaks = differing_peak(outcome, found.as_ref().map_or(finer, |(_, others)| others), found.is_some());
    let rms = exact.as_ref().filter(|_| found.is_none()).and_then(|exact| lost_rms(outcome, exact));
    outcome.warnings.extend(peaks.into_iter().chain(rms));
    if let Some((found, _)) = found {
        let [chaos, step] = found.errors();
        if delivers(outcome) {
            let length_s = outcome.duration_s - outcome.settle_s;
            outcome.mean_power_w = Some(found.mean_j / length_s);
            outcome.mean_power_standard_error_w = Some(found.standard_error_j / length_s);
        }
        outcome.accuracy = Accuracy { chaos: Some(chaos), step: Some(step.max(LEAST)), ..accuracy }.summed();
        return;
    }
    accuracy.step = between.map(stated).map(|step| step.max(coarser).max(LEAST));
    accuracy.rounding = if is_lost { Some(1.0) } else { rounding.map(|found| found.whole) };
    if is_layered {
        accuracy.boundary_layers = accuracy.step;
    }
    let is_unknown = is_blind || single && accuracy.rounding.is_none();
    outcome.accuracy = if is_unknown { accuracy } else { accuracy.summed() };
}

/// The relative standard error of the mean over the window, from its parts.
fn window(outcome: &Outcome) -> Option<f64> {
    let whole = outcome.block_energies_j.iter().sum::<f64>().abs();
    Some(standard_error_of_sum(&outcome.block_energies_j) / whole).filter(|error| error.is_finite())
}

/// A run in shorter steps, with its options; `None` if there is none that can be compared. Where a smaller tolerance or a shorter
/// step takes hardly more steps, and where a circuit relaxes within a step, it is one in steps of at most two thirds of the mean length.
fn finer(
    runs: &mut Runs<'_>,
    double: &Options,
    alike: &Outcome,
    is_layered: bool,
) -> Option<(Options, Outcome)> {
    let scene = runs.scene;
    if is_coarse(scene, double) {
        let default = Options { step_s: None, long_step_s: None, halvings: 0, ..*double };
        return runs.get(&default).map(|found| (default, found));
    }
    let more = if has_tolerance(scene, double) { TOLERANCE_HALVINGS } else { 1 };
    let shorter = Options { halvings: double.halvings + more, ..*double };
    if is_layered || has_tolerance(scene, double) && are_longest(scene, alike) {
        return in_shorter_steps(runs, &shorter, alike);
    }
    let found = runs.get(&shorter).filter(|finer| is_comparable(runs.scene, finer, alike));
    found.map(|found| (shorter, found)).or_else(|| in_shorter_steps(runs, &shorter, alike))
}

/// The stated error of a beam that bounces at a rigid stop without a gap, by runs in longer steps. Impacts between two steps are
/// missed there at any step: two runs may agree by chance, and the error falls with the root of the step at most.
fn by_coarser_steps(runs: &mut Runs<'_>, double: &Options, alike: &Outcome) -> f64 {
    let stop = runs.scene.bump_stop().ok().and_then(|model| model.stop.as_ref());
    let bounces_at_rest = stop.is_some_and(|stop| stop.gap_m == 0.0 && stop.restitution.is_some());
    if !bounces_at_rest || !has_own_steps(runs.scene, double) {
        return 0.0;
    }
    let short_s = double.step_s.unwrap_or(DEFAULT_SHORT_STEP_S);
    let long_s = double.long_step_s.or(double.step_s).unwrap_or(DEFAULT_LONG_STEP_S);
    let of = |times: f64| {
        let steps = [short_s, long_s].map(|step_s| Some(times * step_s));
        let coarser = runs.get(&Options { step_s: steps[0], long_step_s: steps[1], ..*double })?;
        Some(stated(difference(alike, &coarser)?))
    };
    COARSER.into_iter().filter_map(of).fold(0.0, f64::max)
}

/// Whether a bump-stop run has longer steps than the default ones: half the step does not show the errors of too few for a period.
fn is_coarse(scene: &Scene, options: &Options) -> bool {
    has_own_steps(scene, options) && options.step_s.is_some_and(|step_s| step_s > DEFAULT_SHORT_STEP_S)
}

/// Whether a run has other steps, and delivers power where another does.
fn is_comparable(scene: &Scene, finer: &Outcome, than: &Outcome) -> bool {
    // The methods of the host count no steps.
    let has_more = than.steps == 0 || MORE_STEPS * mean_step(scene, finer) <= mean_step(scene, than);
    has_more && difference(finer, than).is_some()
}

/// A run in steps that are limited by the mean length, by twice the tolerance of `shorter` if it has one.
fn in_shorter_steps(runs: &mut Runs<'_>, shorter: &Options, alike: &Outcome) -> Option<(Options, Outcome)> {
    let shorter_s = Some(SHORTER * mean_step(runs.scene, alike));
    let limited = match has_tolerance(runs.scene, shorter) {
        true => Options { ends_every_s: shorter_s, halvings: shorter.halvings - 1, ..*shorter },
        false => Options { step_s: shorter_s, long_step_s: None, halvings: 0, ..*shorter },
    };
    let found = runs.get(&limited).filter(|finer| is_comparable(runs.scene, finer, alike))?;
    Some((limited, found))
}

/// Whether a triboelectric run starts with a charge of its own. In a resistor, the force of a charge that is gone within
/// nanoseconds acts throughout its first step; behind a bridge its kilovolts scale the errors of what is left of it.
fn has_start_charge(scene: &Scene, options: &Options) -> bool {
    has_tolerance(scene, options) && scene.model.summary().start.is_some_and(|[.., charge]| charge.is_some())
}

/// Whether the steps of a run are mostly as long as they are at any tolerance: to the samples of a trace, or a part of a period.
fn are_longest(scene: &Scene, outcome: &Outcome) -> bool {
    let (natural_hz, _) = resonances(scene, outcome);
    let fastest_hz = natural_hz.into_iter().fold(scene.excitation.highest_hz(), f64::max);
    let is_sampled = matches!(scene.excitation, Excitation::File(_));
    is_sampled || TAU * fastest_hz * mean_step(scene, outcome) > LONGEST
}

/// Whether the turns of the slowest oscillation fall between the ends of steps, and with them the largest motion.
fn misses_turns(scene: &Scene, outcome: &Outcome) -> bool {
    natural_frequency_hz(scene, outcome)
        .is_some_and(|slowest_hz| slowest_hz * mean_step(scene, outcome) > QUARTER)
}

/// Whether a rod that is hit with a coefficient of restitution oscillates within the steps of a run to compare with: impacts that
/// follow each other in a period of the rod are one at any such step, so that two of them agree.
fn misses_impacts(scene: &Scene, finer: &Options, outcome: &Outcome) -> bool {
    let stop = scene.bump_stop().ok().and_then(|model| model.stop.as_ref());
    let has_impacts = has_own_steps(scene, finer) && stop.is_some_and(|stop| stop.restitution.is_some());
    let step_s = finer.step_s.unwrap_or(DEFAULT_SHORT_STEP_S) * finer.refinement();
    let hit = outcome.bump_stop().filter(|found| has_impacts && found.first_contact_s.is_some());
    hit.and_then(|found| found.rod_natural_frequencies_hz.first())
        .is_some_and(|slowest| slowest * step_s > HALF)
}

/// The mean step of a run in s.
fn mean_step(scene: &Scene, outcome: &Outcome) -> f64 {
    // A search for an orbit takes as many periods as it needs.
    let of_search = outcome.steady_state.as_ref().zip(scene.excitation.single_frequency());
    let simulated_s = of_search.map(|(found, frequency)| found.simulated_periods / frequency);
    simulated_s.unwrap_or(scene.run.duration_s) / outcome.steps.max(1) as f64
}

/// Whether a storage behind the bridge of a triboelectric run discharges within a step: the tolerance does not hold its
/// charge, which the step control does not see.
fn has_fast_storage(scene: &Scene, options: &Options, outcome: &Outcome) -> bool {
    let Load::RectifiedStore(store) = scene.load else { return false };
    let drawing = match store.draw {
        Draw::Resistor { resistance_ohm, .. } => 1.0 / resistance_ohm,
        _ => 0.0,
    };
    let relaxation_s = store.capacitance_f / (drawing + 1.0 / store.leakage_ohm);
    has_tolerance(scene, options) && relaxation_s < mean_step(scene, outcome)
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
    let trace = Trace { samples_m_per_s2: finer.into(), rate_hz, ..trace.clone() };
    Some(Scene { excitation: Excitation::File(trace), ..scene.clone() })
}

/// The cubic through values at −1, 0, 1 and 2, at `x`.
fn cubic([before, left, right, after]: [f64; 4], x: f64) -> f64 {
    -before * x * (x - 1.0) * (x - 2.0) / 6.0 + left * (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0
        - right * (x + 1.0) * x * (x - 2.0) / 2.0
        + after * (x + 1.0) * x * (x - 1.0) / 6.0
}

/// A scene, the amplitude in m/s² and frequency in Hz of its sine, and the mean power in W of its orbit there, if it is known.
pub(crate) type Place<'a> = (&'a Scene, [f64; 2], Option<f64>);

/// Relative difference of the mean powers of one orbit.
const ALIKE: f64 = 1e-2;

/// The largest statement of some runs, and their warnings: the worst of each kind, and how many runs have one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Statements {
    accuracy: Option<Accuracy>,
    runs: usize,
    warnings: Vec<(String, usize)>,
}

impl Statements {
    /// Of the steady motions at some places, from the start of each scene. That of another motion than the orbit is no statement.
    pub(crate) fn of_orbits(places: &[Place<'_>], options: &Options) -> Result<Self, Failure> {
        let options = Options { steady_state: true, ..*options };
        let run = |(scene, [amplitude_m_per_s2, frequency_hz], power_w): &Place<'_>| {
            let tone =
                Tone { amplitude_m_per_s2: *amplitude_m_per_s2, frequency_hz: *frequency_hz, phase_rad: 0.0 };
            let scene = Scene { excitation: Excitation::Sine(tone), ..(*scene).clone() };
            let own = run_as_it_is(&scene, &options)?;
            let own_w = own.mean_power_w.unwrap_or(f64::NAN);
            let is_alike = |power_w: f64| (own_w - power_w).abs() <= ALIKE * power_w.abs();
            if own.is_of_an_orbit() && power_w.is_none_or(is_alike) {
                return Ok(own);
            }
            let other = "accuracy: the start of the scene does not lead to the orbit there, which would have a statement";
            let powers = power_w.map_or(String::new(), |power_w| {
                format!(
                    ": it has {power_w:.6e} W at {frequency_hz:.5} Hz, the motion from the start {own_w:.6e} W"
                )
            });
            Ok(Outcome { warnings: vec![other.to_owned() + &powers], accuracy: Accuracy::default(), ..own })
        };
        Ok(Self::of(&try_each(places, run)?))
    }

    pub(crate) fn of<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>) -> Self {
        let mut statements = Self::default();
        outcomes.into_iter().for_each(|outcome| statements.add(outcome));
        statements
    }

    /// Adds a run. An unknown error is larger than any.
    pub(crate) fn add(&mut self, outcome: &Outcome) {
        let size = |accuracy: &Accuracy| accuracy.total.unwrap_or(f64::INFINITY);
        let is_stated = outcome.steady_state.is_none() || outcome.is_of_an_orbit();
        if is_stated && self.accuracy.as_ref().is_none_or(|largest| size(&outcome.accuracy) > size(largest)) {
            self.accuracy = Some(outcome.accuracy);
        }
        self.runs += 1;
        // Warnings that differ in their numbers only are of one kind.
        let kind =
            |warning: &str| warning.split(|letter: char| letter.is_ascii_digit()).next().map(str::to_owned);
        for warning in &outcome.warnings {
            match self.warnings.iter_mut().find(|(other, _)| kind(other) == kind(warning)) {
                Some((worst, count)) => {
                    *count += 1;
                    if badness(warning) > badness(worst) {
                        worst.clone_from(warning);
                    }
                }
                None => self.warnings.push((warning.clone(), 1)),
            }
        }
    }

    /// The fields `accuracy` and `warnings`, those of the command first; a warning has the number of its runs.
    pub(crate) fn fields(&self, others: &[String]) -> Fields {
        let text = |(warning, count): &(String, usize)| match self.runs {
            1 => warning.clone(),
            runs => format!("{count} of {runs} runs: {warning}"),
        };
        let warnings: Vec<String> = others.iter().cloned().chain(self.warnings.iter().map(text)).collect();
        fields(&json!({ "accuracy": self.accuracy.unwrap_or_default(), "warnings": warnings }))
    }

    /// The largest estimated relative error; `None` if one is unknown.
    pub(crate) fn total(&self) -> Option<f64> {
        self.accuracy.and_then(|accuracy| accuracy.total)
    }
}

/// How bad a warning is among those of its kind: by its margin to a limit, or else by the first number after a word that leads to it.
fn badness(warning: &str) -> Option<f64> {
    let after = |word: &str| {
        let rest = warning.split(word).skip(1);
        let number = |text: &str| text.split([' ', ':', ')', ',']).next()?.parse::<f64>().ok();
        rest.into_iter().find_map(number)
    };
    let words = [" is ", " = ", " differs by ", "rate_hz: "];
    after("(margin ").map(f64::recip).or_else(|| words.into_iter().find_map(after))
}

/// Prints the warnings among the fields of a result on standard error.
pub(crate) fn print_warnings(found: &Fields) {
    let warnings = found.get("warnings").and_then(|warnings| warnings.as_array());
    let texts = warnings.into_iter().flatten().filter_map(|warning| warning.as_str());
    texts.for_each(warn);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_each_kind_of_warning_the_worst_is_printed() {
        let scene = crate::scene_file::read(&crate::scene_file::shipped("contact-separation"), &[]);
        let run = crate::run::run_scene(&scene.expect("valid"), &Options::default()).expect("runs");
        let with = |warning: &str| Outcome { warnings: vec![warning.to_owned()], ..run.clone() };
        for (mild, worse) in [
            (
                "limit: gap_voltage_v = 9e3 at 1 s is above 8e3 (margin 0.9)",
                "limit: gap_voltage_v = 8e3 at 2 s is above 4e3 (margin 0.5)",
            ),
            (
                "accuracy: the error of the mean power is 1.0e-2: by the step",
                "accuracy: the error of the mean power is 2.5e-1: by the step",
            ),
            (
                "accuracy: energy_residual = 1.1e-2 is more than 0.01",
                "accuracy: energy_residual = 3.0e1 is more than 0.01",
            ),
            (
                "peaks: peak_voltage_v differs by 9.1e-2 in finer steps (--accuracy, --step or --tolerance)",
                "peaks: peak_voltage_v differs by 1.2e-1 in finer steps (--accuracy, --step or --tolerance)",
            ),
            (
                "excitation.rate_hz: 9.0e-3 of the mean power by the sampling of the trace",
                "excitation.rate_hz: 1.0e-1 of the mean power by the sampling of the trace",
            ),
        ] {
            for order in [[mild, worse], [worse, mild]] {
                let printed = Statements::of(&order.map(with)).fields(&[])["warnings"].to_string();
                assert!(printed.contains(&format!("2 of 2 runs: {worse}")), "{printed}");
            }
        }
    }
}
