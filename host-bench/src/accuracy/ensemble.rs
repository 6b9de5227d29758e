//! The mean power of a chaotic motion, over runs from displaced starts.
//!
//! A motion is chaotic where a base acceleration that is larger by 10⁻⁹ (a displaced start, where the base is at rest) changes
//! the energies in the sixteen parts of the window by more than 10⁻⁶ of the whole, and half the step changes them by more than
//! 10⁻⁴. The power of one run is then that of one motion of many.

use super::difference::{Difference, difference};
use super::runs::{Runs, to_compare};
use crate::method::{Options, Precision};
use crate::outcome::Outcome;
use crate::shift::SHIFT;

/// Relative differences of the parts above which a motion is chaotic: from the run in half the steps, and from that of a
/// displaced start.
const CHAOTIC: [f64; 2] = [1e-4, 1e-6];
/// Further displaced starts in the steps of the run: in double precision besides that of the test of chaos, and in single
/// precision. The displacements are as large as errors by the step: runs of smaller ones stay together for longer than a run
/// stays with the exact motion, and scatter less than its error.
const DISPLACED: [&[f64]; 2] = [&[-1e-5, 2e-5, -2e-5, 3e-5, -3e-5], &[1e-5, -1e-5, 2e-5, -2e-5]];
/// Displaced starts in half the steps.
const DISPLACED_IN_HALVES: &[f64] = &[1e-5, -1e-5, 2e-5, -2e-5];
/// Standard errors of the mean that are stated, fitted to random scenes: the errors by the step that are below the scatter of
/// so few runs are in it too, and the powers of short windows have heavy tails.
const CONFIDENCE: f64 = 6.0;

/// The energies delivered in the window, over displaced starts, in J.
pub(super) struct Ensemble {
    pub(super) mean_j: f64,
    /// Standard error of the mean.
    pub(super) standard_error_j: f64,
    /// By the step: the difference of the means in the steps of the run and in half of them, less its own standard error.
    pub(super) bias_j: f64,
}

impl Ensemble {
    /// The stated relative errors by the finite number of starts, and by the step.
    pub(super) fn errors(&self) -> [f64; 2] {
        [CONFIDENCE * self.standard_error_j, self.bias_j].map(|error_j| error_j / self.mean_j.abs())
    }
}

/// The run of a displaced start by which a motion is chaotic, if it is: of a run in double precision that differs from that in
/// half the steps by `between`.
pub(super) fn chaotic(
    runs: &mut Runs<'_>,
    double: &Options,
    alike: &Outcome,
    between: &Difference,
) -> Option<Outcome> {
    let [by_step, by_start] = CHAOTIC;
    let other = if between.parts > by_step { runs.at(double, &[SHIFT]).pop() } else { None };
    other.filter(|other| difference(alike, other).is_some_and(|other| other.parts > by_start))
}

/// The ensemble of a run of a chaotic motion, with a run of a displaced start in double precision, and one in half the steps with
/// its options.
pub(super) fn ensemble(
    runs: &mut Runs<'_>,
    options: &Options,
    [outcome, displaced]: [&Outcome; 2],
    (finer, half): &(Options, Outcome),
) -> Option<Ensemble> {
    let is_single = options.chosen_precision() == Precision::F32;
    let mut own = runs.at(&to_compare(options), DISPLACED[usize::from(is_single)]);
    own.extend((!is_single).then(|| displaced.clone()));
    own.push(outcome.clone());
    let mut halves = runs.at(finer, DISPLACED_IN_HALVES);
    halves.push(half.clone());
    of_energies(&energies(&own)?, &energies(&halves)?)
}

fn energies(runs: &[Outcome]) -> Option<Vec<f64>> {
    runs.iter().map(|run| run.delivered_energy_j).collect()
}

/// Of energies in the steps of the run and in half of them, in J; `None` of fewer than two.
fn of_energies(own: &[f64], halves: &[f64]) -> Option<Ensemble> {
    let count = |energies: &[f64]| energies.len() as f64;
    let mean = |energies: &[f64]| energies.iter().sum::<f64>() / count(energies);
    let squares = |energies: &[f64]| {
        let mean = mean(energies);
        energies.iter().map(|energy| (energy - mean).powi(2)).sum::<f64>()
    };
    let (one, two) = (count(own), count(halves));
    if own.len() < 2 || halves.len() < 2 {
        return None;
    }
    let variance = (squares(own) + squares(halves)) / (one + two - 2.0);
    let apart = (mean(own) - mean(halves)).powi(2) - variance * (1.0 / one + 1.0 / two);
    Some(Ensemble {
        mean_j: (mean(own) * one + mean(halves) * two) / (one + two),
        standard_error_j: (variance / (one + two)).sqrt(),
        bias_j: apart.max(0.0).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_counts_above_its_standard_error() {
        // By hand: means 2 and 2, squares 2 + 2, variance 4/4 = 1.
        let found = of_energies(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]).expect("enough");
        assert_eq!([found.mean_j, found.bias_j], [2.0, 0.0]);
        assert!((found.standard_error_j - (1.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        // The means differ by 4, with a variance of 1/3 + 1/3.
        let found = of_energies(&[1.0, 2.0, 3.0], &[5.0, 6.0, 7.0]).expect("enough");
        assert!((found.bias_j - (16.0_f64 - 2.0 / 3.0).sqrt()).abs() < 1e-15 && found.mean_j == 4.0);
        assert!(of_energies(&[1.0], &[1.0, 2.0]).is_none());
    }
}
