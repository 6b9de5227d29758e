//! What the runs behind the numbers of a command state of themselves.

use rayon::prelude::*;
use serde_json::json;

use super::run_as_it_is;
use crate::command::tell;
use crate::method::{Failure, Options};
use crate::outcome::{Accuracy, Fields, Outcome, fields};
use crate::scene_file::{Excitation, Scene, Tone};

/// The largest statement of some runs, and their warnings: the first of each kind, and how many runs have one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Statements {
    accuracy: Option<Accuracy>,
    runs: usize,
    warnings: Vec<(String, usize)>,
}

impl Statements {
    /// Of the steady motions at some amplitudes in m/s² and frequencies in Hz, from the start of each scene.
    pub(crate) fn of_orbits(places: &[(&Scene, [f64; 2])], options: &Options) -> Result<Self, Failure> {
        let options = Options { steady_state: true, ..*options };
        let run = |(scene, [amplitude_m_per_s2, frequency_hz]): &(&Scene, [f64; 2])| {
            let tone =
                Tone { amplitude_m_per_s2: *amplitude_m_per_s2, frequency_hz: *frequency_hz, phase_rad: 0.0 };
            let outcome =
                run_as_it_is(&Scene { excitation: Excitation::Sine(tone), ..(*scene).clone() }, &options)?;
            let other = "accuracy: the start of the scene does not lead to an orbit there, which would have a statement";
            let warnings = vec![other.to_owned()];
            Ok(if outcome.is_of_an_orbit() { outcome } else { Outcome { warnings, ..outcome } })
        };
        let outcomes: Vec<Outcome> = places.par_iter().map(run).collect::<Result<_, Failure>>()?;
        Ok(Self::of(&outcomes))
    }

    /// Of some runs.
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
                Some((_, count)) => *count += 1,
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

/// Prints the warnings among the fields of a result on standard error.
pub(crate) fn tell_warnings(found: &Fields) {
    let warnings = found.get("warnings").and_then(|warnings| warnings.as_array());
    let texts = warnings.into_iter().flatten().filter_map(|warning| warning.as_str());
    texts.for_each(|warning| tell(&format!("warning: {warning}")));
}
