//! What the absence of a part changes: two runs compared, or the means of several.

use serde::Serialize;

use crate::method::{Failure, Options};
use crate::outcome::{Outcome, SwitchCycles, standard_error_of_sum};
use crate::run::{run_scene, try_each};
use crate::scene_file::{Excitation, Load, Scene};
use crate::seeds::quantile;
use crate::shift::shaken;

/// Intervals by which a change must be beyond the accuracy or within it while more runs can be added: looking several
/// times would find chance more often than once in twenty.
const EARLY: f64 = 2.0;

/// What a run has in place of what the full scene has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Change {
    /// Relative change of the mean power; `None` if both deliver none.
    pub(crate) mean_power: Option<f64>,
    /// Relative change of the RMS voltage; `None` if both have none.
    pub(crate) rms_voltage: Option<f64>,
    /// Relative change of the voltage of the storage at the end; `None` if one of the two has none.
    pub(crate) store_voltage: Option<f64>,
    /// Relative change of the peak displacement; 0 if nothing moves in both.
    pub(crate) displacement: Option<f64>,
    /// Impacts or contacts in the window, of the first run.
    pub(crate) impacts: Option<u64>,
    /// The largest half 95 % interval of the changes that decide, from the scatter of the runs; `None` without chaos.
    pub(crate) sampling_error: Option<f64>,
    /// Number of runs that were compared.
    pub(crate) runs: usize,
    /// The corner of the range at which it is found; `None` at the scene's own point.
    pub(crate) at: Option<Corner>,
}

/// Amplitude in m/s² and frequency in Hz.
pub(crate) type Corner = [f64; 2];

pub(crate) fn corner_name([amplitude, frequency]: Corner) -> String {
    format!("{} m/s² and {frequency} Hz", (1e6 * amplitude).round() / 1e6)
}

impl Change {
    /// Compares `run` with the run `full` of the full scene, neither of them chaotic.
    pub(crate) fn between(full: &Outcome, run: &Outcome) -> Self {
        let change = Self::of_means(std::slice::from_ref(full), std::slice::from_ref(run));
        Self { sampling_error: None, ..change }
    }

    /// Compares the means of several runs with those of the full scene; a single run of it is exact.
    pub(crate) fn of_means(full: &[Outcome], runs: &[Outcome]) -> Self {
        let of = |value: fn(&Outcome) -> Option<f64>| {
            let [full, runs] = [full, runs].map(|all| all.iter().map(value).collect::<Option<Vec<f64>>>());
            change(&full?, &runs?)
        };
        let store = |outcome: &Outcome| outcome.store.and_then(|store| store.store_voltage_v);
        let electrical = [of(|run| run.mean_power_w), of(|run| run.rms_voltage_v), of(store)];
        let displacement = of(Outcome::largest_motion_m).or_else(|| {
            let is_at_rest = |run: &Outcome| run.largest_motion_m() == Some(0.0);
            full.iter().chain(runs).all(is_at_rest).then_some([0.0; 2])
        });
        let errors = electrical.iter().flatten().map(|[_, error]| *error).reduce(f64::max);
        let [mean_power, rms_voltage, store_voltage] =
            electrical.map(|change| change.map(|[change, _]| change));
        Self {
            mean_power,
            rms_voltage,
            store_voltage,
            displacement: displacement.map(|[change, _]| change),
            impacts: runs.first().and_then(impacts),
            sampling_error: errors.or(displacement.map(|[_, error]| error)),
            runs: runs.len(),
            at: None,
        }
    }

    /// The largest of the changes that decide: power, RMS voltage and storage. Where the full scene has none of them, the displacement.
    pub(crate) fn largest(&self) -> f64 {
        let electrical = [self.mean_power, self.rms_voltage, self.store_voltage];
        let magnitudes = electrical.into_iter().flatten().map(f64::abs);
        // Not-a-number counts as a change.
        let larger = |one: f64, other: f64| if one.is_nan() || one > other { one } else { other };
        let largest = magnitudes.reduce(larger).or(self.displacement.map(f64::abs));
        largest.filter(|change| !change.is_nan()).unwrap_or(f64::INFINITY)
    }

    /// Whether the change is within `accuracy`; `None` where that may be chance.
    pub(crate) fn is_within(&self, accuracy: f64) -> Option<bool> {
        self.is_within_by(accuracy, 1.0)
    }

    /// What may be the largest of the changes that decide.
    pub(super) fn most(&self) -> f64 {
        self.largest() + self.sampling_error.unwrap_or(0.0)
    }

    /// Whether more runs would hardly change whether it is within `accuracy`.
    pub(super) fn is_clear(&self, accuracy: f64) -> bool {
        self.is_within_by(accuracy, EARLY).is_some()
    }

    /// Whether the change is within `accuracy` by some intervals.
    fn is_within_by(&self, accuracy: f64, intervals: f64) -> Option<bool> {
        let chance = intervals * self.sampling_error.unwrap_or(0.0);
        if self.largest() + chance <= accuracy {
            Some(true)
        } else if self.largest() - chance > accuracy {
            Some(false)
        } else {
            None
        }
    }
}

/// Impacts or contacts in the window; `None` in a sliding scene.
pub(crate) fn impacts(outcome: &Outcome) -> Option<u64> {
    let separating = outcome.contact_separation().map(|found| found.impacts);
    separating.or(outcome.bump_stop().map(|found| found.contacts))
}

/// The larger of the change from one run to the other and two standard errors of the sum of the changes in the parts of
/// the window, over that of `one`: as far as two runs of a chaotic motion are apart, also where their sums are not.
pub(super) fn apart(one: &Outcome, other: &Outcome) -> f64 {
    let blocks = one.block_energies_j.iter().zip(&other.block_energies_j);
    let apart: Vec<f64> = blocks.map(|(one, other)| other - one).collect();
    let whole: f64 = one.block_energies_j.iter().sum();
    let by_parts = 2.0 * standard_error_of_sum(&apart) / whole.abs();
    // Not-a-number without power.
    Change::between(one, other).largest().max(by_parts)
}

// Several runs of a scene whose motion is chaotic: their base accelerations differ by less than matters.
//
// The mean power of one window of such a scene is a random number. What a part changes is the change of its mean over
// runs, and the scatter of the runs says how well that is known. More runs are added until the change is clearly within
// the accuracy or clearly above it.

/// Relative distance of the base accelerations of two neighbouring runs over the accuracy. The powers of the outermost of
/// [`MOST_RUNS`] differ by a tenth of the accuracy, as much in one direction as in the other.
const DISTANCE: f64 = 1e-4;
/// Fewest and most runs, and most steps of all of them but the fewest.
pub(super) const FEWEST_RUNS: usize = 4;
const MOST_RUNS: usize = 512;
const MOST_STEPS: u64 = 1 << 26;
/// Part of the variance of independent runs below which that of the differences is no chance: of four runs in one of a thousand cases.
const IN_COMMON: f64 = 0.01;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Runs of one scene by the same options.
pub(super) struct Sampled<'a> {
    scene: &'a Scene,
    options: Options,
    accuracy: f64,
    pub(super) runs: Vec<Outcome>,
}

impl<'a> Sampled<'a> {
    /// The runs after the first, which is that of the scene itself, are to come.
    pub(super) fn new(scene: &'a Scene, options: &Options, accuracy: f64, first: Outcome) -> Self {
        Self { scene, options: *options, accuracy, runs: vec![first] }
    }

    /// The most runs, by the steps of the first.
    pub(super) fn most_runs(&self) -> usize {
        let steps = self.runs.first().map_or(1, |run| (run.steps + run.rejected_steps).max(1));
        usize::try_from(MOST_STEPS / steps).unwrap_or(MOST_RUNS).clamp(FEWEST_RUNS, MOST_RUNS)
    }

    /// The first runs, of which there are at least `count`.
    pub(super) fn first(&self, count: usize) -> &[Outcome] {
        self.runs.get(..count).unwrap_or(&self.runs)
    }

    /// Adds runs up to a number of them.
    pub(super) fn grow(&mut self, count: usize) -> Result<(), Failure> {
        let (scene, options, accuracy) = (self.scene, &self.options, self.accuracy);
        let more: Vec<usize> = (self.runs.len()..count).collect();
        self.runs.extend(try_each(&more, |&index| {
            let shift = DISTANCE * accuracy * place(index);
            // A base at rest has no runs that differ.
            shaken(scene, shift)
                .map_or_else(|| run_cycles(scene, options), |other| run_cycles(&other, options))
        })?);
        Ok(())
    }
}

/// The places of the runs: 0, 1, −1, 2, −2, …
fn place(index: usize) -> f64 {
    let distance = index.div_ceil(2) as f64;
    if index % 2 == 1 { distance } else { -distance }
}

/// The mean of values; not-a-number of none.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance of the mean of some values, 0 of a single one, which then is known.
fn variance_of_mean(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    if values.len() < 2 { 0.0 } else { squares / (count * (count - 1.0)) }
}

/// The standard deviation of values over the magnitude of their mean; 0 of a single one.
pub(super) fn relative_deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    (variance_of_mean(values) * values.len() as f64).sqrt() / mean(values).abs()
}

/// The relative change from the mean of `full` to that of `runs`, and half its 95 % interval by Student's t. Where runs at
/// the same places have most of their scatter in common, they are compared with each other: it cancels. `None` where both means are 0.
pub(super) fn change(full: &[f64], runs: &[f64]) -> Option<[f64; 2]> {
    let apart = Apart::of(full, runs)?;
    let alike = full.get(..runs.len()).filter(|_| runs.len() > 1).and_then(|full| {
        let ratio = mean(runs) / mean(full);
        let differences: Vec<f64> = full.iter().zip(runs).map(|(full, run)| run - ratio * full).collect();
        let variance = variance_of_mean(&differences);
        (variance < IN_COMMON * apart.variance).then_some(Apart { variance, ..Apart::of(full, runs)? })
    });
    Some(alike.unwrap_or(apart).with_interval())
}

/// Two means.
struct Apart {
    from: f64,
    to: f64,
    /// Variance of the second less its ratio to the first times the first.
    variance: f64,
    /// The smaller number of runs of the two that scatter; `None` if none does.
    count: Option<usize>,
}

impl Apart {
    /// Of independent runs; `None` if both means are 0.
    fn of(full: &[f64], runs: &[f64]) -> Option<Self> {
        let (from, to) = (mean(full), mean(runs));
        let variance = variance_of_mean(runs) + (to / from).powi(2) * variance_of_mean(full);
        let count = [full.len(), runs.len()].into_iter().filter(|count| *count > 1).min();
        (from != 0.0 || to != 0.0).then_some(Self { from, to, variance, count })
    }

    fn with_interval(&self) -> [f64; 2] {
        if self.from == 0.0 {
            return [f64::INFINITY, 0.0];
        }
        let freedom = self.count.map(|count| u32::try_from(count - 1).unwrap_or(u32::MAX));
        let t = freedom.map_or(0.0, |freedom| quantile(freedom, CONFIDENCE));
        [self.to / self.from - 1.0, t * self.variance.sqrt() / self.from.abs()]
    }
}

/// Whole cycles of the switch of a draw that a window has, and the longest window for them over that of the scene.
const FEWEST_CYCLES: f64 = 4.0;
const LONGEST: f64 = 8.0;

/// A run with the means over the whole cycles of the switch of a draw in place of those of its window.
pub(super) fn run_cycles(scene: &Scene, options: &Options) -> Result<Outcome, Failure> {
    run_scene(scene, options).map(over_cycles)
}

/// The means over whole cycles, where there are any, in place of those of the window.
pub(super) fn over_cycles(mut outcome: Outcome) -> Outcome {
    if let (Some(cycles), Some(store)) = (cycles(&outcome), &mut outcome.store) {
        outcome.mean_power_w = Some(cycles.mean_power_w);
        outcome.rms_voltage_v = Some(cycles.rms_voltage_v);
        store.store_voltage_v = Some(cycles.mean_store_voltage_v);
    }
    outcome
}

/// The whole cycles of the switch of a draw in the window of a run.
pub(crate) fn cycles(outcome: &Outcome) -> Option<SwitchCycles> {
    outcome.store.and_then(|store| store.cycles)
}

/// Whether the draw of a scene is switched on and off.
pub(super) fn switches(scene: &Scene) -> bool {
    matches!(scene.load, Load::RectifiedStore(store) if store.draw.lockout().is_some())
}

/// The scene with a window of [`FEWEST_CYCLES`] whole cycles of its draw, and a warning where [`LONGEST`] windows have fewer.
pub(super) fn with_cycles(scene: &Scene) -> Result<(Scene, Option<String>), Failure> {
    let mut longer = scene.clone();
    if !switches(scene) {
        return Ok((longer, None));
    }
    if !matches!(&scene.excitation, Excitation::File(trace) if !trace.repeat) {
        longer.run.duration_s = scene.run.settle_s + LONGEST * scene.run.window_s();
    }
    let most_s = longer.run.duration_s;
    let found = cycles(&run_scene(&longer, &Options { blocks: true, ..Options::default() })?);
    // Half a cycle more than it takes, wherever the window ended.
    let cycle_s = |found: SwitchCycles| (found.until_s - found.from_s) / found.count as f64;
    let needed = found.map(|found| found.from_s + (FEWEST_CYCLES + 0.5) * cycle_s(found));
    let needed = needed.filter(|needed| *needed <= most_s);
    longer.run.duration_s = scene.run.duration_s.max(needed.unwrap_or(0.0));
    let text = format!(
        "load.draw: fewer than {FEWEST_CYCLES} whole cycles of its switch until {most_s} s: the verdicts depend on the window"
    );
    Ok((longer, needed.is_none().then_some(text)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_as_far_to_one_side_as_to_the_other() {
        assert_eq!([0, 1, 2, 3, 4].map(place), [0.0, 1.0, -1.0, 2.0, -2.0]);
    }

    #[test]
    fn what_two_samples_have_in_common_is_no_scatter_of_their_change() {
        let full = [1.0, 1.1, 0.9, 1.05, 0.95];
        let doubled = full.map(|value| 2.0 * value);
        let [ratio, error] = change(&full, &doubled[..4]).expect("a change");
        assert!((ratio - 1.0).abs() < 1e-15 && error < 1e-15, "{ratio} {error}");
        let [ratio, error] = change(&full[..1], &doubled).expect("a change");
        // By hand: mean 2, variance of the mean (0 + 0.04 + 0.04 + 0.01 + 0.01) / 20, t of 4 degrees of freedom 2.776.
        assert!((ratio - 1.0).abs() < 1e-15, "{ratio}");
        assert!((error - 2.776_445 * 0.005_f64.sqrt()).abs() < 1e-6, "{error}");
    }

    #[test]
    fn an_interval_holds_the_change_of_the_means_in_nineteen_of_twenty_cases() {
        // Uniform numbers of a linear congruence, sums of twelve of them, almost Gaussian.
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut sample = |mean: f64, count: usize| -> Vec<f64> {
            let mut one = || mean + 0.05 * (0..12).map(|_| uniform()).sum::<f64>();
            (0..count).map(|_| one()).collect()
        };
        for [full, runs] in [[8, 8], [16, 4], [4, 16], [1, 8]] {
            let cases = 2000;
            let covered = (0..cases).filter(|_| {
                let exact = vec![1.0];
                let full = if full == 1 { exact } else { sample(1.0, full) };
                let [ratio, error] = change(&full, &sample(1.02, runs)).expect("a change");
                (ratio - 0.02).abs() <= error
            });
            // Three standard errors of such a count are 30; fewer degrees of freedom than there are make the interval wider.
            let covered = covered.count();
            assert!((1870..=1990).contains(&covered), "{full} {runs}: {covered}");
        }
    }
}
