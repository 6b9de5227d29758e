//! The mean power of a chaotic motion, over runs from displaced starts.
//!
//! A motion is chaotic where a base acceleration that is larger by 10⁻⁹ (a displaced start, where the base is at rest) changes
//! the energies in the sixteen parts of the window by more than 10⁻⁶ of the whole, and half the step changes them by more than
//! 10⁻⁴. The power of one run is then that of one motion of many.

use super::{Difference, Runs, delivers, difference, motions, to_compare};
use crate::method::Options;
use crate::outcome::Outcome;
use crate::shift::SHIFT;

/// Relative differences of the parts above which a motion is chaotic: from the run in half the steps, and from a displaced one.
const CHAOTIC: [f64; 2] = [1e-4, 1e-6];
/// Relative difference of the parts of a run in single precision from one in double precision up to which a motion is not
/// chaotic: its roundings are displacements, too.
const BY_ROUNDING: f64 = 1e-4;
/// Displaced starts in the steps of the run and in half of them. The displacements are as large as errors by the step: runs of
/// smaller ones stay together for longer than a run stays with the exact motion, and scatter less than its error.
const DISPLACED: [f64; 4] = [1e-4, -1e-4, 2e-4, -2e-4];
/// Most work of a statement of a chaotic motion, in runs, as long as each group has a displaced start.
const MOST_WORK: u64 = 16;
/// Standard errors that are stated: 95 % of Student's distribution with seven degrees of freedom, of nine runs in two groups: 2.36.
const CONFIDENCE: f64 = 2.4;

/// The energies delivered in the window, over displaced starts, in J; where none is, the largest motion in m or the RMS voltage in V.
pub(super) struct Ensemble {
    pub(super) mean_j: f64,
    /// Standard error of the mean from the mean of accurate runs; where no energy is delivered, that of one run from another.
    pub(super) standard_error_j: f64,
    /// By the step: the difference of the means in the steps of the run and in half of them, less its own standard error.
    pub(super) bias_j: f64,
}

impl Ensemble {
    /// The stated relative errors by the scatter of the starts, and by the step.
    pub(super) fn errors(&self) -> [f64; 2] {
        [CONFIDENCE * self.standard_error_j, self.bias_j].map(|error_j| error_j / self.mean_j.abs())
    }
}

/// Whether the motion is chaotic of a run in double precision that differs from that in half the steps by `between`, and from
/// that in single precision by `rounding`.
pub(super) fn chaotic(
    runs: &mut Runs<'_>,
    double: &Options,
    alike: &Outcome,
    [between, rounding]: [Option<Difference>; 2],
) -> bool {
    let [by_step, by_start] = CHAOTIC;
    let may_be = between.is_some_and(|between| between.parts > by_step)
        && rounding.is_none_or(|rounding| rounding.parts > BY_ROUNDING);
    let other = if may_be { runs.at(double, &[SHIFT]).pop() } else { None };
    other.and_then(|other| difference(alike, &other)).is_some_and(|other| other.parts > by_start)
}

/// The ensemble of a run of a chaotic motion, with one in half the steps and its options; and the other runs of it.
pub(super) fn ensemble(
    runs: &mut Runs<'_>,
    options: &Options,
    outcome: &Outcome,
    (finer, half): &(Options, Outcome),
) -> Option<(Ensemble, Vec<Outcome>)> {
    let near = runs.at(finer, &[SHIFT]).pop()?;
    let affordable = |left: u64, steps: u64| (left / steps.max(1)).clamp(1, DISPLACED.len() as u64) as usize;
    let left = |runs: &Runs<'_>| (MOST_WORK * outcome.steps).saturating_sub(runs.steps);
    let count = affordable(left(runs).saturating_sub(half.steps), outcome.steps);
    let mut own = runs.at(&to_compare(options), &DISPLACED[..count]);
    own.push(outcome.clone());
    let count = affordable(left(runs), half.steps);
    let mut halves = runs.at(finer, &DISPLACED[..count]);
    halves.push(half.clone());
    let of = |parts: &dyn Fn(&Outcome) -> Vec<f64>, near: [&Outcome; 2]| {
        of_energies([&own, &halves].map(|runs| runs.iter().map(parts).collect()), &near.map(parts))
    };
    let found = if delivers(outcome) {
        of(&|run| run.block_energies_j.clone(), [half, &near])
    } else {
        // The run is one of many: it stays together with itself.
        let of_motion = |index: usize| of(&|run| vec![motions(run)[index]], [outcome; 2]);
        let found = [0, 1].into_iter().filter_map(of_motion).filter(|found| found.mean_j != 0.0);
        found.max_by(|one, other| one.errors()[0].total_cmp(&other.errors()[0]))
    }?;
    own.extend(halves);
    Some((found, own))
}

/// Of energies in the parts of the window, of runs in the steps of the run and in half of them, and of two runs in half of them
/// from starts next to each other, in J; `None` of fewer than two.
///
/// Accurate runs from near starts stay together until they have diverged, and a run in steps leaves them before. The energy
/// until then is that of one motion, from which the mean of an ensemble is as far as another motion is.
fn of_energies(runs: [Vec<Vec<f64>>; 2], near: &[Vec<f64>; 2]) -> Option<Ensemble> {
    let [one, two] = runs.each_ref().map(|runs| runs.len() as f64);
    if runs.iter().any(|runs| runs.len() < 2) {
        return None;
    }
    let of_runs = |energy: &dyn Fn(&[f64]) -> f64| {
        runs.each_ref().map(|runs| runs.iter().map(|parts| energy(parts)).collect::<Vec<f64>>())
    };
    let energies = of_runs(&|parts| parts.iter().sum());
    let variance = pooled(&energies);
    let scatter = |part: usize| pooled(&of_runs(&|parts| parts[part]));
    let apart = near[0].iter().zip(&near[1]).map(|(one, other)| 0.5 * (one - other).powi(2));
    let together = apart.enumerate().take_while(|(part, apart)| *apart <= scatter(*part)).count();
    let shared = pooled(&of_runs(&|parts| parts[..together].iter().sum()));
    let [own, halves] = energies.map(|energies| mean(&energies));
    let bias = (own - halves).powi(2) - variance * (1.0 / one + 1.0 / two);
    Some(Ensemble {
        mean_j: (own * one + halves * two) / (one + two),
        standard_error_j: (shared + variance / (one + two)).sqrt(),
        bias_j: bias.max(0.0).sqrt(),
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance of two groups about their own means.
fn pooled(groups: &[Vec<f64>; 2]) -> f64 {
    let squares = groups.each_ref().map(|group| {
        let mean = mean(group);
        group.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
    });
    let count: usize = groups.iter().map(Vec::len).sum();
    squares.iter().sum::<f64>() / (count as f64 - 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(own: &[f64], halves: &[f64], near: [f64; 2]) -> Option<Ensemble> {
        of_energies(
            [own, halves].map(|runs| runs.chunks(1).map(<[f64]>::to_vec).collect()),
            &near.map(|run| vec![run]),
        )
    }

    #[test]
    fn a_bias_counts_above_its_standard_error() {
        // By hand: means 2 and 2, squares 2 + 2, variance 4/4 = 1; near starts differ by twice as much.
        let scattered = [1.0, 3.0];
        let found = of(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0], scattered).expect("enough");
        assert_eq!([found.mean_j, found.bias_j], [2.0, 0.0]);
        assert!((found.standard_error_j - (1.0_f64 / 6.0).sqrt()).abs() < 1e-7);
        // The means differ by 4, with a variance of 1/3 + 1/3.
        let found = of(&[1.0, 2.0, 3.0], &[5.0, 6.0, 7.0], scattered).expect("enough");
        assert!((found.bias_j - (16.0_f64 - 2.0 / 3.0).sqrt()).abs() < 1e-15 && found.mean_j == 4.0);
        assert!(of(&[1.0], &[1.0, 2.0], scattered).is_none());
    }

    #[test]
    fn where_near_starts_stay_together_the_mean_is_off_by_the_scatter() {
        let found = of(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0], [2.0, 2.0]).expect("enough");
        assert!((found.standard_error_j - (7.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        // In the first of two parts only, with a variance of 1; that of both is 16.
        let runs = || [-1.0, 0.0, 1.0].map(|at| vec![at, 3.0 * at]).to_vec();
        let found = of_energies([runs(), runs()], &[vec![1.0, 1.0], vec![1.0, 7.0]]).expect("enough");
        assert!((found.standard_error_j - (1.0_f64 + 16.0 / 6.0).sqrt()).abs() < 1e-15);
    }
}
