//! The rows of one run: recorded, or read from a trace; amplitudes of the lines of a record.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use harvester_scene::progress;

use crate::input::{MOST_OF_DATA, read, repeated};
use crate::method::Failure;
use crate::name::Name;
use crate::outcome::{EnergyFlow, Outcome};
use crate::run::each;
use crate::scene_file::{Load, Scene};

/// The power into a resistor, which follows from the voltage.
const POWER: &str = "power_w";

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Its name among others.
    pub(crate) name: String,
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    pub(crate) impacts_s: Vec<f64>,
    /// Where the energy went; unknown of a trace.
    pub(crate) flow: Option<EnergyFlow>,
}

impl Series {
    /// A run that was recorded. The power into a resistor is added to its columns.
    pub(crate) fn of(name: impl Into<String>, scene: &Scene, outcome: &Outcome) -> Self {
        let trace = outcome.trace.as_ref();
        let mut columns: Vec<String> =
            trace.map_or(&[][..], |trace| trace.columns).iter().map(|&name| name.to_owned()).collect();
        let mut rows = trace.map(|trace| trace.rows.clone()).unwrap_or_default();
        if let (Load::Resistor { resistance_ohm }, Some(at)) =
            (scene.load, columns.iter().position(|column| column == "voltage_v"))
            && resistance_ohm > 0.0
            && resistance_ohm.is_finite()
        {
            columns.push(POWER.to_owned());
            for row in &mut rows {
                let voltage = row.get(at).copied().unwrap_or(f64::NAN);
                row.push(voltage * voltage / resistance_ohm);
            }
        }
        let impacts_s = trace.map(|trace| trace.impacts_s.clone()).unwrap_or_default();
        Self { name: name.into(), columns, rows, impacts_s, flow: outcome.flow }
    }

    /// A file as `run --trace` writes it.
    pub(crate) fn read(file: &Path) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::Input(format!("{}: {reason}", file.display()));
        let bytes = read(file, MOST_OF_DATA).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let heading = reader.headers().map_err(|error| refuse(format!("has no heading: {error}")))?.clone();
        let columns: Vec<String> = heading.iter().map(|name| Name::new(name.trim()).line()).collect();
        if columns.first().is_none_or(|name| name != "time_s") {
            return Err(refuse("must be a trace of run --trace, whose first column is time_s".to_owned()));
        }
        if let Some(name) = repeated(columns.iter().map(String::as_str)) {
            return Err(refuse(format!("column {name:?}: must be there once")));
        }
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let line = index + 2;
            let record = record.map_err(|error| refuse(format!("line {line}: {error}")))?;
            let values: Result<Vec<f64>, String> = record
                .iter()
                .map(|cell| {
                    cell.trim().parse::<f64>().map_err(|_| format!("line {line}: {cell:?} is no number"))
                })
                .collect();
            rows.push(values.map_err(refuse)?);
        }
        if rows.len() < 2 {
            return Err(refuse(format!("has {} rows, must have at least 2", rows.len())));
        }
        let name = Name::of_file(file).line();
        Ok(Self { name, columns, rows, impacts_s: Vec::new(), flow: None })
    }

    /// The names of the columns beside the time.
    pub(crate) fn columns(&self) -> &[String] {
        self.columns.get(1..).unwrap_or_default()
    }

    /// The columns that a picture shows where none are asked for: position, force, voltages or power.
    pub(crate) fn usual_quantities(&self) -> Vec<String> {
        let has =
            |name: &&str| self.over_time(name).iter().any(|(_, value)| value.is_finite() && *value != 0.0);
        let wanted = [
            "gap_m",
            "displacement_m",
            "tip_displacement_m",
            "contact_force_n",
            "store_voltage_v",
            POWER,
            "voltage_v",
        ];
        wanted.iter().filter(|name| has(name)).map(|&name| name.to_owned()).collect()
    }

    pub(crate) fn position(&self) -> Option<&str> {
        let column = ["gap_m", "displacement_m", "tip_displacement_m"];
        self.columns.iter().map(String::as_str).find(|name| column.contains(name))
    }

    /// Time in s and value of a column; nothing if there is none of this name.
    pub(crate) fn over_time(&self, column: &str) -> Vec<(f64, f64)> {
        let Some(at) = self.columns.iter().position(|name| name == column) else { return Vec::new() };
        self.rows.iter().filter_map(|row| Some((*row.first()?, *row.get(at)?))).collect()
    }

    /// The value of a column at an instant in s, on the line between two rows.
    pub(crate) fn at(&self, column: &str, instant: f64) -> Option<f64> {
        let points = self.over_time(column);
        let after = points.partition_point(|(time, _)| *time <= instant);
        let (before, after) = (points.get(after.checked_sub(1)?)?, points.get(after)?);
        let part = (instant - before.0) / (after.0 - before.0);
        Some(before.1 + part * (after.1 - before.1))
    }

    /// Time, position and velocity within two instants in s; a velocity that is not recorded is a difference of positions.
    pub(crate) fn portrait(&self, [from, to]: [f64; 2]) -> Vec<[f64; 3]> {
        let Some(column) = self.position() else { return Vec::new() };
        let positions = self.over_time(column);
        let recorded = self.over_time("velocity_m_per_s");
        let velocity = |index: usize| match recorded.get(index) {
            Some((_, velocity)) => Some(*velocity),
            None => {
                let (before, after) = (positions.get(index.checked_sub(1)?)?, positions.get(index + 1)?);
                Some((after.1 - before.1) / (after.0 - before.0))
            }
        };
        let within = positions.iter().enumerate().filter(|(_, (time, _))| (from..=to).contains(time));
        within.filter_map(|(index, (time, position))| Some([*time, *position, velocity(index)?])).collect()
    }
}

/// Most lines of a spectrum.
const MOST_LINES: f64 = 4000.0;

/// Frequency in Hz and amplitude of lines up to a frequency, one over the length of the record apart, by the sum over the
/// rows, at equal distances, of the last part of a window. A Hann window keeps a line that is between two from spreading: a sine has its amplitude
/// at its frequency, to 15 % between two lines.
pub(super) fn amplitudes(
    points: &[(f64, f64)],
    [from, to]: [f64; 2],
    highest_hz: f64,
    period_s: Option<f64>,
) -> Vec<(f64, f64)> {
    let length = (to - from).min(MOST_LINES / highest_hz);
    // Of whole periods each harmonic is a line.
    let whole = period_s.map(|period| (length / period * (1.0 + 1e-9)).floor() * period);
    let length = whole.filter(|whole| *whole > 0.0).unwrap_or(length) * (1.0 + 1e-12);
    let rows: Vec<&(f64, f64)> =
        points.iter().filter(|(time, _)| (to - length..=to).contains(time)).collect();
    let (Some(first), Some(last), true) = (rows.first(), rows.last(), rows.len() > 2) else {
        return Vec::new();
    };
    let span = last.0 - first.0;
    let count = rows.len() as f64;
    let every = span / (count - 1.0);
    let mean = rows.iter().map(|point| point.1).sum::<f64>() / count;
    let weighted: Vec<f64> = rows
        .iter()
        .map(|(time, value)| (value - mean) * (1.0 - (TAU * (time - first.0) / span).cos()))
        .collect();
    let lines: Vec<usize> = (0..=(highest_hz.min(0.5 / every) * span) as usize).collect();
    // A million rows take longer than the run that made them.
    progress::begin();
    let begun = AtomicUsize::new(0);
    each(&lines, |&line| {
        let before = begun.fetch_add(1, Ordering::Relaxed);
        progress::report(before as f64 / lines.len() as f64, [(before * weighted.len()) as u64, 0]);
        let frequency = line as f64 / span;
        // One turn from row to row: all rows are needed, because what is left out would appear at other frequencies.
        let (sine, cosine) = (TAU * frequency * every).sin_cos();
        let (mut turned, mut sum) = ([1.0, 0.0], [0.0, 0.0]);
        for value in &weighted {
            sum = [sum[0] + value * turned[0], sum[1] + value * turned[1]];
            turned = [turned[0] * cosine - turned[1] * sine, turned[0] * sine + turned[1] * cosine];
        }
        (frequency, 2.0 / count * f64::hypot(sum[0], sum[1]))
    })
}
