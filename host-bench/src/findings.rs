//! What the two papers find, as assertions that are measured on the shipped scenes.
//!
//! The formulas and most numbers of both papers are lost, so a finding is a trend or a relation. Its thresholds are of
//! this library, set from what was measured.

mod check;
mod contact_band;
mod convergence;
mod impacts;
mod list;
mod phases;
mod resistance;
mod sampling;
mod scenes;
mod shapes;
mod shunt;
mod statistics;
mod storage;

pub use self::check::{Bound, Check};
pub use self::list::{FINDINGS, Finding};

use rayon::prelude::*;
use serde::Serialize;

use crate::attractors::elsewhere;
use crate::method::{Failure, Options};
use crate::run::stopped_as_text;

/// Whether a finding is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// By a shipped scene as it is, or with only the key changed that the finding is about.
    Shown,
    /// Only with parameters that are chosen for it.
    Chosen,
    /// Not shown.
    NotShown,
    /// Not measured: a run stopped on its way, at an edge of the model's domain or of its numerics.
    Stopped,
}

impl Mark {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shown => "shown",
            Self::Chosen => "chosen",
            Self::NotShown => "not shown",
            Self::Stopped => "stopped",
        }
    }
}

/// A finding as measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub finding: &'static Finding,
    pub checks: Vec<Check>,
}

impl Row {
    /// The mark that the measured values give.
    pub fn mark(&self) -> Mark {
        match (self.checks.iter().all(Check::holds), self.finding.mark) {
            _ if self.checks.iter().any(|check| check.bound == Bound::Completes) => Mark::Stopped,
            (true, Mark::NotShown) => Mark::Shown,
            (true, expected) => expected,
            (false, _) => Mark::NotShown,
        }
    }

    /// Whether the mark is the expected one, from measured values.
    pub fn is_as_expected(&self) -> bool {
        self.mark() == self.finding.mark && self.checks.iter().all(Check::is_measured)
    }
}

/// Checks by the number of their finding.
type Measured = Vec<(&'static str, Vec<Check>)>;

/// Runs from which some findings are measured together.
struct Experiment {
    /// Numbers of the findings.
    numbers: &'static [&'static str],
    measure: fn() -> Result<Measured, Failure>,
}

impl Experiment {
    /// The checks of its findings. A run that stops on its way is the only check of each of them, so that the others go on.
    /// Without a `single_start` each says whether displaced starts of the runs lead elsewhere.
    fn measured(&self, single_start: bool) -> Result<Measured, Failure> {
        let stopped = |error: String| {
            let checks = vec![Check::new(error.split(": ").next().unwrap_or_default(), [], Bound::Completes)];
            self.numbers.iter().map(|number| (*number, checks.clone())).collect()
        };
        let mut found = stopped_as_text((self.measure)())?.unwrap_or_else(stopped);
        let of_runs =
            found.iter_mut().flat_map(|(_, checks)| checks).flat_map(|check| check.scenes.drain(..));
        let scenes: Vec<_> = of_runs.map(|scene| (scene, Options::default())).collect();
        if single_start {
            return Ok(found);
        }
        let warnings: Vec<String> = elsewhere(&scenes)?.into_iter().flatten().collect();
        if let Some(first) = warnings.first() {
            let quantity = format!("of {} runs these may have other motions: {first}", scenes.len());
            let check = Check::new(quantity, [warnings.len() as f64], Bound::Reported);
            found.iter_mut().for_each(|(_, checks)| checks.push(check.clone()));
        }
        Ok(found)
    }
}

/// All experiments, the longest first, so that all cores end at about the same time.
static EXPERIMENTS: [Experiment; 13] = [
    Experiment { numbers: &["18", "19"], measure: convergence::measure },
    Experiment { numbers: &["33", "34", "35", "36", "40", "41", "43"], measure: contact_band::measure },
    Experiment {
        numbers: &["1", "2", "3", "4", "5", "5a", "6", "7", "8", "9", "10", "11", "12", "13"],
        measure: phases::measure,
    },
    Experiment { numbers: &["31", "32"], measure: shunt::measure },
    Experiment { numbers: &["20"], measure: storage::measure },
    Experiment { numbers: &["14", "15", "17"], measure: shapes::measure },
    Experiment { numbers: &["c", "d"], measure: phases::measure_not_reproduced },
    Experiment { numbers: &["37", "38", "39"], measure: impacts::measure },
    Experiment { numbers: &["42"], measure: impacts::measure_parasitic },
    Experiment { numbers: &["21", "22", "23", "24"], measure: resistance::measure_charge },
    Experiment { numbers: &["25", "26"], measure: resistance::measure_small_charge },
    Experiment { numbers: &["27", "28", "29", "30", "a"], measure: resistance::measure_large_charge },
    Experiment { numbers: &["16"], measure: shapes::measure_charge },
];

/// Measures the findings with these numbers on all cores, in the order of the list; all of them for an empty list.
/// `done` is called after each experiment with the number of findings it measured.
///
/// # Errors
/// A number that is not in the list, a scene that is refused, or a finding that its experiment does not measure.
pub fn measure(
    only: &[String],
    single_start: bool,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Row>, Failure> {
    let wanted = wanted(only)?;
    let is_wanted = |number: &str| wanted.iter().any(|finding| finding.number == number);
    let experiments: Vec<&Experiment> = EXPERIMENTS
        .iter()
        .filter(|experiment| experiment.numbers.iter().any(|number| is_wanted(number)))
        .collect();
    let measured: Vec<Measured> = experiments
        .par_iter()
        .with_max_len(1)
        .map(|experiment| {
            let found = experiment.measured(single_start);
            done(experiment.numbers.iter().filter(|number| is_wanted(number)).count());
            found
        })
        .collect::<Result<_, _>>()?;
    rows(wanted, measured.concat())
}

/// The rows of these findings.
fn rows(wanted: Vec<&'static Finding>, mut measured: Measured) -> Result<Vec<Row>, Failure> {
    let row = |finding: &'static Finding| {
        let at = measured.iter().position(|(number, checks)| *number == finding.number && !checks.is_empty());
        let (_, checks) = at
            .map(|at| measured.swap_remove(at))
            .ok_or_else(|| Failure::Step(format!("findings: finding {} was not measured", finding.number)))?;
        Ok(Row { finding, checks })
    };
    wanted.into_iter().map(row).collect()
}

/// The findings with these numbers, in the order of the list; all of them for an empty list.
pub fn wanted(only: &[String]) -> Result<Vec<&'static Finding>, Failure> {
    if let Some(unknown) =
        only.iter().find(|number| FINDINGS.iter().all(|finding| finding.number != **number))
    {
        let numbers: Vec<&str> = FINDINGS.iter().map(|finding| finding.number).collect();
        return Err(Failure::Input(format!("--only {unknown}: must be of {}", numbers.join(", "))));
    }
    let is_wanted =
        |finding: &&Finding| only.is_empty() || only.iter().any(|number| number == finding.number);
    Ok(FINDINGS.iter().filter(is_wanted).collect())
}

#[cfg(test)]
mod tests;
