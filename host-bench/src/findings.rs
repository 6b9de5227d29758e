//! What the two papers find, as assertions that are measured on the shipped scenes.
//!
//! The formulas and most numbers of both papers are lost, so a finding is a trend or a relation. Its thresholds are of
//! this library, set from what was measured.

mod check;
mod contact_band;
mod convergence;
mod impacts;
mod phases;
mod resistance;
mod robustness;
mod runs;
mod shapes;
mod statistics;

use self::check::check;
pub use self::check::{Bound, Check};
pub use self::robustness::Robustness;
pub(crate) use self::robustness::drawn;
use self::robustness::stored;
use self::runs::Loader;

use std::sync::LazyLock;

use serde::Serialize;

use crate::attractors::elsewhere;
use crate::method::{Failure, Options};
use crate::run::{stopped_as_text, try_each};

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

/// A result that a paper states, as an assertion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Its number; a letter for what no parameters tried reproduce.
    pub number: &'static str,
    /// Where the paper states it.
    pub source: &'static str,
    pub statement: &'static str,
    /// The scenes that show it, and what is changed in them.
    pub scene: &'static str,
    /// The expected mark.
    pub mark: Mark,
    /// What to know of the mark; empty if nothing.
    pub note: &'static str,
    /// In which part of the draws its mark stays.
    pub robustness: Robustness,
}

/// All findings: the second paper's from 1 to 20, the first paper's from 21 to 43, and what is not reproduced. A line of the
/// list has number, mark, source, scene, statement and note.
pub static FINDINGS: LazyLock<Vec<Finding>> = LazyLock::new(|| {
    let line = |line: &'static str| {
        let mut cells = line.split('|').map(str::trim);
        let mut cell = || cells.next().unwrap_or_default();
        let (number, mark) = (cell(), cell());
        let marks = [Mark::Shown, Mark::Chosen, Mark::NotShown];
        let mark = marks.into_iter().find(|known| known.name() == mark).unwrap_or(Mark::Stopped);
        let robustness = Robustness::of(stored(number), mark);
        Finding { number, mark, source: cell(), scene: cell(), statement: cell(), note: cell(), robustness }
    };
    include_str!("findings/list.txt").lines().map(line).collect()
});

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

/// The checks of some findings; those of one in their order.
type Measured = Vec<Check>;

/// Runs from which some findings are measured together.
struct Experiment {
    numbers: &'static [&'static str],
    measure: fn(Loader<'_>) -> Result<Measured, Failure>,
}

impl Experiment {
    /// The checks of its findings. A run that stops on its way is the only check of each of them, so that the others go on.
    /// Without a `single_start` each says whether displaced starts of the runs lead elsewhere.
    fn measured(&self, loader: Loader<'_>, single_start: bool) -> Result<Measured, Failure> {
        let stopped = |error: String| {
            let error = error.split(": ").next().unwrap_or_default();
            self.numbers.iter().map(|number| check(number, error, [], Bound::Completes)).collect()
        };
        let mut found = stopped_as_text((self.measure)(loader))?.unwrap_or_else(stopped);
        let of_runs = found.iter_mut().flat_map(|check| check.scenes.drain(..));
        let scenes: Vec<_> = of_runs.map(|scene| (scene, Options::default())).collect();
        if single_start {
            return Ok(found);
        }
        let warnings: Vec<String> = elsewhere(&scenes)?.into_iter().flatten().collect();
        if let Some(first) = warnings.first() {
            let quantity = format!("{first}; such runs, of {}", scenes.len());
            let warned = [warnings.len() as f64];
            let warning = |number: &&'static str| check(number, &*quantity, warned, Bound::Reported);
            found.extend(self.numbers.iter().map(warning));
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
    Experiment { numbers: &["31", "32"], measure: resistance::measure },
    Experiment { numbers: &["20"], measure: convergence::measure_storage },
    Experiment { numbers: &["14", "15", "17"], measure: shapes::measure },
    Experiment { numbers: &["c", "d"], measure: phases::measure_not_reproduced },
    Experiment { numbers: &["37", "38", "39"], measure: impacts::measure },
    Experiment { numbers: &["42"], measure: impacts::measure_parasitic },
    Experiment {
        numbers: &["21", "22", "23", "24"],
        measure: |loader| resistance::measure_charge(loader, "0.36"),
    },
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
    measure_of(&EXPERIMENTS, wanted(only)?, single_start, done)
}

fn measure_of(
    all: &[Experiment],
    wanted: Vec<&'static Finding>,
    single_start: bool,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Row>, Failure> {
    let is_wanted = |number: &&&str| wanted.iter().any(|finding| finding.number == **number);
    let count = |experiment: &&Experiment| experiment.numbers.iter().filter(is_wanted).count();
    let chosen: Vec<&Experiment> = all.iter().filter(|experiment| count(experiment) > 0).collect();
    let measured = try_each(&chosen, |experiment| {
        let found = experiment.measured(Loader(None), single_start);
        done(count(experiment));
        found
    });
    let measured = measured?.concat();
    let row = |finding: &'static Finding| {
        let number = finding.number;
        let checks: Vec<Check> = measured.iter().filter(|check| check.number == number).cloned().collect();
        let missing = || Failure::Step(format!("findings: finding {number} was not measured"));
        if checks.is_empty() { Err(missing()) } else { Ok(Row { finding, checks }) }
    };
    wanted.into_iter().map(row).collect()
}

/// The findings with these numbers, or of ranges such as 5-8, in the order of the list; all of them for an empty list.
pub fn wanted(only: &[String]) -> Result<Vec<&'static Finding>, Failure> {
    let place = |number: &str| FINDINGS.iter().position(|finding| finding.number == number);
    let range = |text: &String| {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        let places = place(first).zip(place(last)).filter(|(first, last)| first <= last);
        let form = "must be of 1, 2, 5a and so on, as docs/findings.md has them, or a range such as 5-8";
        places.ok_or_else(|| Failure::Input(format!("--only {text}: {form}")))
    };
    let ranges = only.iter().map(range).collect::<Result<Vec<_>, _>>()?;
    let is_wanted =
        |at: usize| only.is_empty() || ranges.iter().any(|(first, last)| (*first..=*last).contains(&at));
    Ok(FINDINGS.iter().enumerate().filter(|(at, _)| is_wanted(*at)).map(|(_, finding)| finding).collect())
}

#[cfg(test)]
mod tests;
