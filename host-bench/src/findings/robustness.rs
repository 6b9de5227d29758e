//! How far the findings depend on the values of the parameters: in which part of some draws of these the mark of each stays.
//!
//! The letters of all draws are stored in `draws.csv`, as `findings --robustness --format csv` prints them.

use std::ops::Range;

use serde::Serialize;

use super::runs::Loader;
use super::{Check, EXPERIMENTS, Experiment, Finding, Mark, wanted};
use crate::method::Failure;
use crate::run::each;
use crate::stability::fnv_1a;
use crate::stability::random::Source;

/// A finding in a draw: it holds; it does not; or that is not known, because the draw was refused, a run stopped at an edge of
/// the model's domain, or a value lay beyond the range in which it was sought.
pub(super) const HOLDS: char = 'y';
pub(super) const FAILS: char = 'n';
pub(super) const UNKNOWN: char = 'u';
/// By how much a parameter differs at most.
const SPREAD: f64 = 0.2;
/// Part of the draws below which a finding holds at these parameters only.
const ROBUST: f64 = 0.95;

/// The factor of a key in the draw of a number: uniform, for each key that is a parameter.
pub(super) fn factor(number: u64, key: &str) -> f64 {
    let (table, name) = key.split_once('.').unwrap_or((key, ""));
    let is_parameter = match table {
        "parameters" | "stop" | "load" => !name.ends_with("_modes"),
        "excitation" => name.starts_with("amplitude"),
        _ => false,
    };
    // The stop stays at its place on the beam, and static friction above kinetic friction.
    let same = match key {
        "stop.position_m" => "parameters.beam_length_m".to_owned(),
        _ => key.replace("kinetic", "static"),
    };
    let drawn = || Source::new(fnv_1a(same.as_bytes()), number).uniform(1.0 - SPREAD, 1.0 + SPREAD);
    if is_parameter { drawn() } else { 1.0 }
}

/// The letter of a finding with these checks.
pub(super) fn letter<'a>(checks: impl Iterator<Item = &'a Check> + Clone) -> char {
    match (checks.clone().any(|check| check.is_measured() && !check.holds()), checks.clone().next()) {
        (true, _) => FAILS,
        (false, Some(_)) if checks.clone().all(Check::holds) => HOLDS,
        _ => UNKNOWN,
    }
}

/// In how many draws the mark of a finding stays: it holds, or as little as with the shipped parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Robustness {
    /// Part of the draws with a known end in which it stays; none without such a draw.
    pub share: Option<f64>,
    /// Whether that is less than 95 %.
    pub at_these_parameters: bool,
    pub stays: usize,
    pub changes: usize,
    pub unknown: usize,
}

impl Robustness {
    /// By its letters, one for each draw.
    pub(crate) fn of(letters: &str, mark: Mark) -> Self {
        let order = if mark == Mark::NotShown { [FAILS, HOLDS, UNKNOWN] } else { [HOLDS, FAILS, UNKNOWN] };
        let [stays, changes, unknown] = order.map(|letter| letters.matches(letter).count());
        let share = (stays + changes > 0).then(|| stays as f64 / (stays + changes) as f64);
        let at_these_parameters = share.is_some_and(|share| share < ROBUST);
        Self { share, at_these_parameters, stays, changes, unknown }
    }

    /// The share, its draws, and what follows of it, as printed.
    pub fn text(&self) -> String {
        let known = self.stays + self.changes;
        let Some(percent) = (100 * self.stays).checked_div(known) else {
            return "unknown in all draws".to_owned();
        };
        let local = if self.at_these_parameters { " (at these parameters)" } else { "" };
        format!("{percent} % of {known} draws{local}")
    }
}

/// The stored letters of a finding.
pub(super) fn stored(number: &str) -> &'static str {
    let of = |line: &'static str| line.rsplit_once(',').filter(|_| line.split(',').next() == Some(number));
    include_str!("draws.csv").lines().find_map(of).map_or("", |(_, letters)| letters)
}

/// A letter for each draw, of each of some findings in the order of the list, on all cores. `done` is called after each experiment of
/// a draw with the number of these findings that it measured.
///
/// # Errors
/// A number that is not in the list.
pub(crate) fn drawn(
    only: &[String],
    draws: Range<u64>,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<(&'static Finding, String)>, Failure> {
    let wanted = wanted(only)?;
    let count = |experiment: &Experiment| {
        wanted.iter().filter(|finding| experiment.numbers.contains(&finding.number)).count()
    };
    let chosen = || EXPERIMENTS.iter().filter(|experiment| count(experiment) > 0);
    let cases: Vec<_> = draws.flat_map(|draw| chosen().map(move |experiment| (draw, experiment))).collect();
    let measured = each(&cases, |(draw, experiment)| {
        let factor = |key: &str| factor(*draw, key);
        // With the shipped parameters there is no error: it is of the draw.
        let found = experiment.measured(Loader(Some(&factor)), true).unwrap_or_default();
        done(count(experiment));
        let of =
            |number: &&'static str| (*number, letter(found.iter().filter(|check| check.number == *number)));
        experiment.numbers.iter().map(of).collect::<Vec<_>>()
    })
    .concat();
    let letters = |finding: &'static Finding| {
        let own = measured.iter().filter(|(number, _)| *number == finding.number);
        (finding, own.map(|(_, letter)| *letter).collect())
    };
    Ok(wanted.into_iter().map(letters).collect())
}
