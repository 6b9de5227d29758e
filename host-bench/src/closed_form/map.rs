//! The error map: the closed form of a scene against its trajectory, over amplitude, frequency and load.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;

use super::{Estimate, estimate};
use crate::method::{Failure, Method, Options, Precision};
use crate::outcome::{Fields, fields};
use crate::run::try_run_scene;
use crate::scene_file::{Excitation, Load, Model, RunSpan, Scene, Tone};

/// An error of the mean power beyond which a claim to hold is wrong.
pub const WRONG: f64 = 0.1;

/// Where the map is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Place {
    /// Load resistance in Ω.
    pub resistance_ohm: f64,
    /// Amplitude of the base acceleration in m/s².
    pub amplitude_m_per_s2: f64,
    /// Its frequency in Hz.
    pub frequency_hz: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub place: Place,
    pub estimate: Estimate,
    /// Mean power of the trajectory in W, or why there is none.
    pub trajectory: Result<f64, String>,
    /// Mean power by the independent reference in W, where it was asked for.
    pub reference: Option<Result<f64, String>>,
}

impl Point {
    /// Error of the closed form relative to the trajectory; infinite where there is none.
    pub fn error(&self) -> f64 {
        self.trajectory.as_ref().map_or(f64::INFINITY, |power| relative(self.estimate.mean_power_w, *power))
    }
}

/// `|found − expected| / expected`; 0 where both are nothing.
pub fn relative(found: f64, expected: f64) -> f64 {
    if found == expected { 0.0 } else { (found / expected - 1.0).abs() }
}

/// The map over some places; calls `done` after each. The closed form is in the given precision, the trajectory in double
/// precision. The reference is run too at `references` points of those at which the closed form is claimed to hold.
///
/// The trajectory is that of the core: the periodic steady state that the motion from the scene's start reaches, by
/// shooting. Without a steady state, and for a bump-stop scene, it is the scene's own run in whole periods.
///
/// # Errors
/// Bad input at any place.
pub fn map(
    scene: &Scene,
    places: &[Place],
    precision: Precision,
    references: usize,
    done: impl Fn() + Sync,
) -> Result<Vec<Point>, Failure> {
    let mut points = places
        .par_iter()
        .map(|&place| {
            let scene = at(scene, place);
            let estimate = estimate(&scene, precision)?;
            let steady_state = !matches!(scene.model, Model::BumpStop(_));
            let trajectory = power(&scene, &Options { steady_state, ..Options::default() })?;
            done();
            Ok(Point { place, estimate, trajectory, reference: None })
        })
        .collect::<Result<Vec<Point>, Failure>>()?;
    let holding: Vec<usize> = (0..points.len())
        .filter(|&index| points[index].estimate.holds() && points[index].estimate.mean_power_w > 0.0)
        .collect();
    let count = references.min(holding.len());
    // Evenly among these points, without both ends.
    let chosen: Vec<usize> = (0..count).map(|k| holding[(2 * k + 1) * holding.len() / (2 * count)]).collect();
    let found = chosen.par_iter().map(|&index| {
        power(&at(scene, points[index].place), &Options { method: Method::Reference, ..Options::default() })
    });
    for (index, found) in chosen.iter().zip(found.collect::<Result<Vec<_>, Failure>>()?) {
        points[*index].reference = Some(found);
    }
    Ok(points)
}

/// The scene at a place, run in whole periods.
fn at(scene: &Scene, place: Place) -> Scene {
    let mut scene = scene.clone();
    let phase_rad = match &scene.excitation {
        Excitation::Sine(tone) => tone.phase_rad,
        _ => 0.0,
    };
    let Place { resistance_ohm, amplitude_m_per_s2, frequency_hz } = place;
    scene.excitation = Excitation::Sine(Tone { amplitude_m_per_s2, frequency_hz, phase_rad });
    scene.load = Load::Resistor { resistance_ohm };
    let whole = |seconds: f64| (seconds * frequency_hz).ceil() / frequency_hz;
    let settle_s = whole(scene.run.settle_s);
    scene.run = RunSpan { duration_s: settle_s + whole(scene.run.window_s()), settle_s };
    scene
}

/// Mean power of a run, or why it could not be run to its end.
fn power(scene: &Scene, options: &Options) -> Result<Result<f64, String>, Failure> {
    let outcome = try_run_scene(scene, options)?;
    Ok(outcome.and_then(|outcome| outcome.mean_power_w.ok_or_else(|| "no mean power".to_owned())))
}

/// Counts and largest errors of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    pub points: usize,
    /// Points at which the closed form is claimed to hold.
    pub holding: usize,
    /// Points among those at which there is no power, rightly.
    pub without_power: usize,
    /// Largest error of the mean power among the others of those.
    pub largest_error: Option<f64>,
    /// Its median there.
    pub median_error: Option<f64>,
    /// Points among them with an error above [`WRONG`], or without a trajectory.
    pub wrongly_holding: usize,
    /// Points at which a trajectory is said to be needed, by reason.
    pub needing: BTreeMap<&'static str, usize>,
    /// Points among those at which the closed form is within [`WRONG`] all the same.
    pub needlessly: usize,
    /// Largest difference of closed form and reference, where the reference was run.
    pub largest_reference_error: Option<f64>,
}

impl Summary {
    pub fn of(points: &[Point]) -> Self {
        let nothing =
            |point: &&Point| point.estimate.mean_power_w == 0.0 && point.trajectory.as_ref() == Ok(&0.0);
        let holding = || points.iter().filter(|point| point.estimate.holds());
        let mut errors: Vec<f64> = holding().filter(|point| !nothing(point)).map(Point::error).collect();
        errors.sort_by(f64::total_cmp);
        let mut needing = BTreeMap::new();
        for reason in points.iter().filter_map(|point| point.estimate.reason) {
            *needing.entry(reason).or_insert(0) += 1;
        }
        let within = |point: &&Point| !point.estimate.holds() && point.error() <= WRONG;
        let of_reference = points.iter().filter_map(|point| {
            let power = point.reference.as_ref()?.as_ref();
            Some(power.map_or(f64::INFINITY, |power| relative(point.estimate.mean_power_w, *power)))
        });
        Self {
            points: points.len(),
            holding: holding().count(),
            without_power: holding().filter(nothing).count(),
            largest_error: errors.last().copied(),
            median_error: errors.get(errors.len() / 2).copied(),
            wrongly_holding: errors.iter().filter(|error| !(**error <= WRONG)).count(),
            needing,
            needlessly: points.iter().filter(within).count(),
            largest_reference_error: of_reference.max_by(f64::total_cmp),
        }
    }

    /// Names and values, as the command line prints them.
    pub(crate) fn fields(&self) -> Fields {
        let share = |count: usize| count as f64 / self.points.max(1) as f64;
        let mut fields = fields(&json!({
            "points": self.points,
            "holding": self.holding,
            "holding_without_power": self.without_power,
            "share_holding": share(self.holding),
            "largest_error": self.largest_error,
            "median_error": self.median_error,
            "wrongly_holding": self.wrongly_holding,
            "share_needing_trajectory": share(self.needing.values().sum()),
            "needing_but_within_10_percent": self.needlessly,
            "largest_error_to_reference": self.largest_reference_error,
        }));
        fields
            .extend(self.needing.iter().map(|(reason, &count)| (format!("needing: {reason}"), count.into())));
        fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(power: f64, reason: Option<&'static str>, trajectory: Result<f64, String>) -> Point {
        Point {
            place: Place { resistance_ohm: 1.0, amplitude_m_per_s2: 1.0, frequency_hz: 1.0 },
            estimate: Estimate {
                mean_power_w: power,
                rms_voltage_v: 1.0,
                amplitude_m: 1.0,
                mean_store_current_a: None,
                reason,
                margin: 0.5,
            },
            trajectory,
            reference: None,
        }
    }

    #[test]
    fn a_summary_counts_claims_that_are_wrong_and_refusals_that_are_needless() {
        let points = [
            point(1.01, None, Ok(1.0)),
            point(1.02, None, Ok(1.0)),
            point(1.2, None, Ok(1.0)),
            point(0.0, None, Ok(0.0)),
            point(1.0, None, Err("stopped".to_owned())),
            point(1.05, Some("sticks"), Ok(1.0)),
            point(3.0, Some("sticks"), Ok(1.0)),
            point(3.0, Some("impacts"), Err("stopped".to_owned())),
        ];
        let summary = Summary::of(&points);
        assert_eq!((summary.points, summary.holding, summary.wrongly_holding), (8, 5, 2));
        assert_eq!((summary.largest_error, summary.needlessly), (Some(f64::INFINITY), 1));
        assert_eq!(summary.without_power, 1);
        assert!((summary.median_error.expect("some") - 0.2).abs() < 1e-12);
        assert_eq!(summary.needing, BTreeMap::from([("impacts", 1), ("sticks", 2)]));
        assert_eq!(Summary::of(&[]).largest_error, None);
    }
}
