//! The motion over the last periods of a run.

use crate::embedded::{ContactInterval, chattering_phases};
use crate::method::{Failure, Options};
use crate::run::run_scene;
use crate::scene_file::{RunSpan, Scene};

/// Periods of the base before those that are shown. The free motion of the beam decays by a factor of e in 3 periods.
pub(super) const SETTLE: u32 = 22;
/// Periods that are shown.
pub(super) const SHOWN: u32 = 3;
/// Length of each step, and distance of the samples, in s. Contacts last some 4 µs.
pub(super) const STEP_S: f64 = 1e-6;

/// Columns of a row: time in s, displacements in m, voltage in V, force in N.
const TIME: usize = 0;
/// Displacement of the tip.
pub const TIP: usize = 1;
/// Displacement of the beam at the stop.
pub const STOP_POINT: usize = 2;
/// Displacement of the rod's face.
pub const ROD: usize = 3;
/// Voltage at the terminals.
pub const VOLTAGE: usize = 4;
/// Contact force.
pub const CONTACT_FORCE: usize = 5;

/// Samples over the periods that are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Frequency of the base in Hz.
    pub frequency: f64,
    pub rows: Vec<Vec<f64>>,
}

/// The options of the runs.
pub(super) fn options() -> Options {
    Options { step_s: Some(STEP_S), ..Options::default() }
}

/// The scene over the periods before and those shown.
pub(super) fn spanned(scene: &Scene) -> Result<(Scene, f64), Failure> {
    let frequency = scene
        .excitation
        .single_frequency()
        .ok_or_else(|| Failure::of_file(scene, "excitation.kind must be \"sine\""))?;
    let run = RunSpan {
        duration_s: f64::from(SETTLE + SHOWN) / frequency,
        settle_s: f64::from(SETTLE) / frequency,
    };
    Ok((Scene { run, ..scene.clone() }, frequency))
}

impl Motion {
    /// The last periods of a run from rest.
    pub fn of(scene: &Scene) -> Result<Self, Failure> {
        let (scene, frequency) = spanned(scene)?;
        let outcome = run_scene(&scene, &Options { trace_every_s: Some(STEP_S), ..options() })?;
        let mut rows = outcome.trace.map(|trace| trace.rows).unwrap_or_default();
        rows.retain(|row| row.first().is_some_and(|time| *time >= scene.run.settle_s));
        Ok(Self { frequency, rows })
    }

    /// A column over time in periods since the start, `scale` times as large; every so many rows.
    pub fn over_periods(&self, column: usize, scale: f64, every: usize) -> Vec<(f64, f64)> {
        let point = |row: &Vec<f64>| Some((row.get(TIME)? * self.frequency, row.get(column)? * scale));
        self.rows.iter().step_by(every).filter_map(point).collect()
    }

    /// A column over time in µs since `from` in s, `scale` times as large, within two instants in s.
    pub fn within(&self, [from, to]: [f64; 2], column: usize, scale: f64) -> Vec<(f64, f64)> {
        let rows = self.rows.iter().filter(|row| (from..=to).contains(&row[TIME]));
        rows.filter_map(|row| Some((1e6 * (row[TIME] - from), row.get(column)? * scale))).collect()
    }

    /// First and last instant in s of the longest chattering phase that is shown.
    pub fn longest_cluster(&self) -> Option<[f64; 2]> {
        let touching =
            self.rows.iter().filter(|row| row.get(CONTACT_FORCE).is_some_and(|force| *force > 0.0));
        let samples: Vec<ContactInterval> =
            touching.map(|row| ContactInterval { begins_s: row[TIME], ends_s: row[TIME] }).collect();
        let phases = chattering_phases(&samples, 1.0 / self.frequency);
        let spans = phases.filter_map(|phase| Some([phase.first()?.begins_s, phase.last()?.ends_s]));
        spans.max_by(|one, other| (one[1] - one[0]).total_cmp(&(other[1] - other[0])))
    }

    /// First and last instant in s of the longest contact within two instants in s.
    pub fn longest_contact(&self, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let rows: Vec<&Vec<f64>> = self.rows.iter().filter(|row| (from..=to).contains(&row[TIME])).collect();
        let touches = |row: &Vec<f64>| row.get(CONTACT_FORCE).is_some_and(|force| *force > 0.0);
        let runs = rows.chunk_by(|one, next| touches(one) == touches(next));
        let contacts = runs.filter(|run| run.first().is_some_and(|row| touches(row)));
        let longest = contacts.max_by_key(|run| run.len())?;
        Some([longest.first()?[TIME], longest.last()?[TIME]])
    }
}
