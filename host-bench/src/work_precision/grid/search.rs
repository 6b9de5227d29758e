//! The cheapest choice of method and setting on one scene, by ladders of settings from coarse to fine.

use super::super::triboelectric::period;
use super::ACCURACIES;
use crate::method::{Failure, Method, Options};
use crate::run::{run_scene, try_run_scene};
use crate::scene_file::Scene;

/// Ratio of a setting to the next finer one.
const FINER: f64 = 1.5;
/// The coarsest tolerance.
const COARSEST: f64 = 0.1;
/// The finest tolerance of exponential Radau.
const FINEST: f64 = 3e-6;
/// Fewest steps per period of RK4.
const FEWEST: f64 = 64.0;
/// Most attempts per simulated second: a ladder ends with a run that takes more.
const MOST_ATTEMPTS_PER_S: f64 = 2e5;
/// A ladder ends with a run that takes longer than this times the slowest choice of exponential Radau.
const COST_FACTOR: f64 = 2.0;
/// Runs in a row that stop on their way after which a ladder ends.
const MOST_FAILED: usize = 6;
/// Timed runs of each candidate.
const RUNS: usize = 25;

/// A run without energy ledger: what it was asked for, and what it found.
#[derive(Debug, Clone)]
pub(super) struct Choice {
    pub(super) method: &'static str,
    pub(super) setting: String,
    options: Options,
    /// Relative error of the mean power; infinite for a run that stopped on its way.
    pub(super) error: f64,
    /// Steps, kept and rejected.
    pub(super) attempts: f64,
    /// The shortest run time in s.
    pub(super) seconds: f64,
}

/// The runs of a scene, and the ladders among them.
pub(super) struct Search<'a> {
    scene: &'a Scene,
    /// The mean power in W that errors are relative to.
    power: f64,
    choices: Vec<Choice>,
    /// Places in `choices` by ladder, from coarse to fine.
    ladders: Vec<Vec<usize>>,
}

impl<'a> Search<'a> {
    pub(super) fn new(scene: &'a Scene, power: f64) -> Self {
        Self { scene, power, choices: Vec::new(), ladders: Vec::new() }
    }

    pub(super) fn of(&self, place: usize) -> &Choice {
        &self.choices[place]
    }

    /// Runs once and returns the place of the choice.
    pub(super) fn run(
        &mut self,
        method: &'static str,
        setting: String,
        options: Options,
    ) -> Result<usize, Failure> {
        let most = MOST_ATTEMPTS_PER_S * self.scene.run.duration_s;
        let options = Options { bare: true, most_attempts: Some(most as u64), ..options };
        let choice = match try_run_scene(self.scene, &options)? {
            Ok(outcome) => Choice {
                method,
                setting,
                options,
                error: outcome
                    .mean_power_w
                    .map_or(f64::INFINITY, |power| ((power - self.power) / self.power).abs()),
                attempts: (outcome.steps + outcome.rejected_steps) as f64,
                seconds: outcome.processor_s,
            },
            Err(_) => Choice {
                method,
                setting,
                options,
                error: f64::INFINITY,
                attempts: f64::NAN,
                seconds: f64::NAN,
            },
        };
        self.choices.push(choice);
        Ok(self.choices.len() - 1)
    }

    /// Runs the ladders of all methods. Those of TR-BDF2 and RK4 end where they cannot be the cheapest any more.
    pub(super) fn climb(&mut self) -> Result<(), Failure> {
        let tolerances = |method| {
            let values = std::iter::successors(Some(COARSEST), |value| Some(value / FINER));
            values.map(move |value| {
                (format!("{value:.1e}"), Options { method, tolerance: Some(value), ..Options::default() })
            })
        };
        let rungs = ((COARSEST / FINEST).ln() / FINER.ln()).ceil() as usize;
        let radau = tolerances(Method::ExponentialRadau).take(rungs);
        self.climb_one("exponential-radau", radau, f64::INFINITY)?;
        let slowest = self.slowest();
        self.climb_one("tr-bdf2", tolerances(Method::TrBdf2), slowest)?;
        let period_s = period(self.scene);
        let steps = std::iter::successors(Some(FEWEST), |steps| Some((steps * FINER).round()));
        let explicit = steps.map(|steps| {
            let step_s = Some(period_s / steps);
            (format!("T/{steps}"), Options { method: Method::Rk4, step_s, ..Options::default() })
        });
        self.climb_one("rk4", explicit, slowest)
    }

    /// The run time in s beyond which no choice is the cheapest: of exponential Radau at the finest accuracy that it meets.
    fn slowest(&self) -> f64 {
        let met = ACCURACIES.iter().filter_map(|&accuracy| self.candidates(accuracy).first().copied());
        COST_FACTOR * met.map(|place| self.of(place).seconds).fold(0.0, f64::max)
    }

    fn climb_one(
        &mut self,
        method: &'static str,
        settings: impl Iterator<Item = (String, Options)>,
        slowest: f64,
    ) -> Result<(), Failure> {
        let mut ladder = Vec::new();
        // The attempts of a run that stopped on its way are not known: its next finer run decides.
        let mut failed = 0;
        for (setting, options) in settings {
            let place = self.run(method, setting, options)?;
            ladder.push(place);
            let Choice { seconds, error, .. } = self.of(place);
            failed = if error.is_finite() { 0 } else { failed + 1 };
            if *seconds > slowest || failed == MOST_FAILED {
                break;
            }
        }
        self.ladders.push(ladder);
        Ok(())
    }

    /// The coarsest choice of each method that meets the accuracy with all finer ones, of which there is at least one.
    pub(super) fn sure_candidates(&self, accuracy: f64) -> Vec<usize> {
        let misses = |place: &usize| !(self.of(*place).error <= accuracy);
        let coarsest = |ladder: &Vec<usize>| {
            let first = ladder.iter().rposition(misses).map_or(0, |last| last + 1);
            ladder.get(first..).filter(|rest| rest.len() > 1)?.first().copied()
        };
        self.ladders.iter().filter_map(coarsest).collect()
    }

    /// The coarsest choice of each method that meets the accuracy with the next finer one.
    pub(super) fn candidates(&self, accuracy: f64) -> Vec<usize> {
        let meets = |place: &usize| self.of(*place).error <= accuracy;
        let coarsest = |ladder: &Vec<usize>| {
            let pair = ladder.windows(2).find(|pair| pair.iter().all(meets));
            pair.and_then(|pair| pair.first().copied())
        };
        self.ladders.iter().filter_map(coarsest).collect()
    }

    /// Times choices by turns, so that a machine that is busy for a while slows all alike.
    pub(super) fn time(&mut self, places: impl Iterator<Item = usize> + Clone) -> Result<(), Failure> {
        let mut places: Vec<usize> = places.collect();
        places.sort_unstable();
        places.dedup();
        for &place in &places {
            self.choices[place].seconds = f64::INFINITY;
        }
        for _ in 0..RUNS {
            for &place in &places {
                let choice = &mut self.choices[place];
                choice.seconds = choice.seconds.min(run_scene(self.scene, &choice.options)?.processor_s);
            }
        }
        Ok(())
    }
}
