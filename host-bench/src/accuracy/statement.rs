//! The statement of one run, by source.

use super::difference::{Difference, delivers, difference};
use super::ensemble::{chaotic, ensemble};
use super::runs::{Runs, companion, in_double_precision};
use super::warnings::differing_peak;
use super::{LEAST, has_own_steps, has_tolerance};
use crate::embedded::DEFAULT_SHORT_STEP_S;
use crate::method::{Options, Precision};
use crate::outcome::{Accuracy, Outcome, standard_error_of_sum};
use crate::scene_file::{Draw, Excitation, Load, Model, Scene, Trace};

/// Stated errors over differences: of the energies delivered, and of those in the parts of the window, which cancel by chance in
/// the whole. Both are fitted to random scenes: docs/verification.md.
const STATED: [f64; 2] = [3.0, 0.3];
/// Halvings of a tolerance to compare with. The error falls to a sixtieth, and half the tolerance may change no step.
const TOLERANCE_HALVINGS: u32 = 3;
/// Least steps of a run to compare with over those of the run: in the same steps both have the same error.
const MORE_STEPS: f64 = 1.3;
/// Intervals of the smoother trace in one of the given trace.
const FINER: usize = 4;
/// Length of the window over which the sampling error is half as large, in windows.
const HALVING: f64 = 4.0;

/// The stated error of a difference.
fn stated(difference: Difference) -> f64 {
    let [of_whole, of_parts] = STATED;
    (of_whole * difference.whole).max(of_parts * difference.parts)
}

/// States the accuracy of a run that has given `outcome`. Of a chaotic motion its mean power becomes that of the ensemble.
pub(super) fn state(scene: &Scene, options: &Options, outcome: &mut Outcome) {
    let mut runs = Runs { scene, steps: 0 };
    // A bare run of bump-stop does not measure the voltage that is compared where no power is delivered.
    let bare = delivers(outcome);
    let options = &Options { bare, ..*options };
    let double = in_double_precision(options);
    let single = outcome.precision == Precision::F32.name();
    let exact = if single { runs.get(&double) } else { None };
    outcome.accuracy = Accuracy::default();
    let alike = if single { exact.as_ref() } else { Some(&*outcome) };
    let Some(alike) = alike else { return };
    let smoother = smoother(scene);
    let sampling = smoother.as_ref().and_then(|smoother| companion(smoother, &double));
    let sampling = sampling.and_then(|smooth| difference(alike, &smooth)).map(|found| found.whole);
    let is_layered = has_fast_storage(scene, &double, alike) || has_start_charge(scene, &double);
    let finer = finer(&mut runs, &double, alike, is_layered);
    let between = finer.as_ref().and_then(|(_, finer)| difference(alike, finer));
    let can_be = delivers(outcome) && !is_coarse(scene, &double);
    let peaks = finer.as_ref().and_then(|(_, finer)| differing_peak(outcome, finer));
    let between_steps = between.filter(|_| can_be);
    let rounding = exact.as_ref().and_then(|exact| difference(outcome, exact));
    let displaced = chaotic(&mut runs, &double, alike, [between_steps, rounding]);
    let found = displaced
        .zip(finer)
        .and_then(|(displaced, finer)| ensemble(&mut runs, options, (outcome, [alike, &displaced]), &finer));
    let work = runs.steps as f64 / outcome.steps.max(1) as f64;
    let window = (found.is_some() || scene.excitation.is_irregular()).then(|| window(outcome)).flatten();
    let mut accuracy = Accuracy { sampling, window, work, ..Accuracy::default() };
    accuracy.window_halved_s =
        window.map(|_| outcome.settle_s + HALVING * (outcome.duration_s - outcome.settle_s));
    if let Some(found) = found {
        let [chaos, step] = found.errors();
        let length_s = outcome.duration_s - outcome.settle_s;
        outcome.mean_power_w = Some(found.mean_j / length_s);
        outcome.mean_power_standard_error_w = Some(found.standard_error_j / length_s);
        outcome.accuracy = Accuracy { chaos: Some(chaos), step: Some(step.max(LEAST)), ..accuracy }.summed();
        return;
    }
    outcome.warnings.extend(peaks);
    accuracy.step = between.map(stated).map(|step| step.max(LEAST));
    accuracy.rounding = rounding.map(|found| found.whole);
    if is_layered {
        accuracy.boundary_layers = accuracy.step;
    }
    let is_unknown = single && accuracy.rounding.is_none();
    outcome.accuracy = if is_unknown { accuracy } else { accuracy.summed() };
}

/// The relative standard error of the mean over the window, from its parts.
fn window(outcome: &Outcome) -> Option<f64> {
    let whole = outcome.block_energies_j.iter().sum::<f64>().abs();
    Some(standard_error_of_sum(&outcome.block_energies_j) / whole).filter(|error| error.is_finite())
}

/// A run in shorter steps, with its options; `None` if there is none that can be compared. Where a smaller tolerance or a shorter
/// step takes hardly more steps, and where a circuit relaxes within a step, it is one in steps of at most half the mean length.
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
    // Steps end at the samples of a trace at any tolerance.
    if is_layered || matches!(scene.excitation, Excitation::File(_)) && has_tolerance(scene, double) {
        return in_halves(runs, &shorter, alike);
    }
    let found = runs.get(&shorter).filter(|finer| is_comparable(finer, alike));
    found.map(|found| (shorter, found)).or_else(|| in_halves(runs, &shorter, alike))
}

/// Whether a bump-stop run has steps that are longer than the default ones: too few steps for a period have errors that half the
/// step does not show.
fn is_coarse(scene: &Scene, options: &Options) -> bool {
    has_own_steps(scene, options) && options.step_s.is_some_and(|step_s| step_s > DEFAULT_SHORT_STEP_S)
}

/// Whether a run has other steps, and delivers power where another does.
fn is_comparable(finer: &Outcome, than: &Outcome) -> bool {
    // The methods of the host count no steps.
    let has_more = than.steps == 0 || finer.steps as f64 >= MORE_STEPS * than.steps as f64;
    has_more && difference(finer, than).is_some()
}

/// A run in steps of at most half the mean length, by the same tolerance if there is one.
fn in_halves(runs: &mut Runs<'_>, shorter: &Options, alike: &Outcome) -> Option<(Options, Outcome)> {
    let half_s = Some(0.5 * mean_step(runs.scene, alike));
    let halves = match has_tolerance(runs.scene, shorter) {
        true => Options { ends_every_s: half_s, ..*shorter },
        false => Options { step_s: half_s, long_step_s: None, halvings: 0, ..*shorter },
    };
    let found = runs.get(&halves).filter(|finer| is_comparable(finer, alike))?;
    Some((halves, found))
}

/// Whether a triboelectric run starts with a charge of its own. In a resistor, the force of a charge that is gone within
/// nanoseconds acts throughout its first step; behind a bridge its kilovolts scale the errors of what is left of it.
fn has_start_charge(scene: &Scene, options: &Options) -> bool {
    let charge_c = match &scene.model {
        Model::ContactSeparation(model) => model.initial.charge_c,
        Model::Sliding(model) => model.initial.charge_c,
        Model::BumpStop(_) => None,
    };
    has_tolerance(scene, options) && charge_c.is_some()
}

/// The mean step of a run in s.
fn mean_step(scene: &Scene, outcome: &Outcome) -> f64 {
    scene.run.duration_s / outcome.steps.max(1) as f64
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
    let trace = Trace { samples_m_per_s2: finer.into(), rate_hz, repeat: trace.repeat };
    Some(Scene { excitation: Excitation::File(trace), ..scene.clone() })
}

/// The cubic through values at −1, 0, 1 and 2, at `x`.
fn cubic([before, left, right, after]: [f64; 4], x: f64) -> f64 {
    -before * x * (x - 1.0) * (x - 2.0) / 6.0 + left * (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0
        - right * (x + 1.0) * x * (x - 2.0) / 2.0
        + after * (x + 1.0) * x * (x - 1.0) / 6.0
}
