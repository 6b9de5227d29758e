//! What the runs behind the numbers of a command state of themselves.

use rayon::prelude::*;
use serde_json::json;

use super::run_as_it_is;
use crate::command::tell;
use crate::method::{Failure, Options};
use crate::outcome::{Accuracy, Fields, Outcome, fields};
use crate::scene_file::{Excitation, Scene, Tone};

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
                    ": it has {power_w:.3e} W at {frequency_hz} Hz, the motion from the start {own_w:.3e} W"
                )
            });
            Ok(Outcome { warnings: vec![other.to_owned() + &powers], accuracy: Accuracy::default(), ..own })
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
pub(crate) fn tell_warnings(found: &Fields) {
    let warnings = found.get("warnings").and_then(|warnings| warnings.as_array());
    let texts = warnings.into_iter().flatten().filter_map(|warning| warning.as_str());
    texts.for_each(|warning| tell(&format!("warning: {warning}")));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_each_kind_of_warning_the_worst_is_told() {
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
                let told = Statements::of(&order.map(with)).fields(&[])["warnings"].to_string();
                assert!(told.contains(&format!("2 of 2 runs: {worse}")), "{told}");
            }
        }
    }
}
