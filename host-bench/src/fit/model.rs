//! The model side of the data: for a set of free numbers, one value for each measured one.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::data::{Data, Direction, Row, Rows};
use super::free::{Free, Place};
use crate::embedded::{self, Memory};
use crate::method::{Failure, Options};
use crate::outcome::{Outcome, number};
use crate::run::{each, try_each};
use crate::scene_file::{self, Excitation, Load, Override, RunSpan, Scene, Tone, Trace};

/// Relative size of the coordinate's change by which a motion without a period is differentiated: its means are noisy.
const WIDE: f64 = 0.02;

/// What joins the samples of a recorded acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// A smooth curve: the samples are those of a motion that is slow beside them.
    Smooth,
    /// Straight lines.
    Linear,
}

/// Rows that are run one after the other.
#[derive(Debug, Clone)]
enum Task {
    /// Rows of a sweep in the order in which they were measured.
    Chain(usize, Vec<usize>),
    Trace(usize),
}

pub(crate) struct Problem<'a> {
    pub(crate) file: &'a Path,
    pub(crate) overrides: &'a [Override],
    pub(crate) options: Options,
    pub(crate) data: Vec<Data>,
    pub(crate) free: Vec<Free>,
    pub(crate) interpolation: Interpolation,
    /// Iterations after which a search is given up.
    pub(crate) iterations: usize,
    /// Sets of free numbers for which the data were computed.
    pub(crate) evaluations: AtomicUsize,
    /// Called after each of them.
    done: &'a (dyn Fn() + Sync),
    tasks: Vec<Task>,
    /// Index of the first value of each file.
    first: Vec<usize>,
}

/// The values of the model for all data, in the order of files, columns and rows.
#[derive(Debug, Clone)]
pub(crate) struct Evaluation {
    pub(crate) values: Vec<f64>,
    /// For each row of each file, the motion that was reached; `None` of a trace, and of a storage that fills.
    motions: Vec<Vec<Option<Memory>>>,
}

impl Evaluation {
    /// Whether the motion of a row has one period.
    pub(crate) fn has_orbit(&self, file: usize, row: usize) -> bool {
        self.motions[file][row].as_ref().is_some_and(Memory::is_orbit)
    }

    /// The rows of sweeps whose motion has no period, each with the number of its file.
    pub(crate) fn rows_without_orbit<'a>(
        &'a self,
        data: &'a [Data],
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        let sweeps = data.iter().enumerate().filter(|(_, data)| matches!(data.rows, Rows::Sweep(_)));
        sweeps.flat_map(move |(file, data)| {
            (0..data.count()).filter(move |row| !self.has_orbit(file, *row)).map(move |row| (file, row))
        })
    }
}

/// From where each row of a sweep is run.
#[derive(Clone, Copy)]
enum Begin<'a> {
    /// From rest, or from the row before it in the direction of the sweep.
    Start,
    /// From the orbits of a near set of numbers; a row without one is left out.
    Near(&'a Evaluation),
    /// From the motions of a near set of numbers; a row with an orbit is left out.
    WithoutOrbit(&'a Evaluation),
}

/// The values and the motion of one row.
type RowFound = (usize, Vec<f64>, Option<Memory>);

impl<'a> Problem<'a> {
    pub(crate) fn new(
        file: &'a Path,
        overrides: &'a [Override],
        options: Options,
        data: Vec<Data>,
        free: Vec<Free>,
        done: &'a (dyn Fn() + Sync),
    ) -> Self {
        let tasks = data.iter().enumerate().flat_map(|(index, data)| tasks(index, data)).collect();
        let mut first = vec![0];
        for data in &data {
            first.push(first[first.len() - 1] + data.columns.len() * data.count());
        }
        Self {
            file,
            overrides,
            options,
            data,
            free,
            interpolation: Interpolation::Smooth,
            iterations: 0,
            evaluations: AtomicUsize::new(0),
            done,
            tasks,
            first,
        }
    }

    /// Number of measured values.
    pub(crate) fn count(&self) -> usize {
        self.first[self.data.len()]
    }

    pub(crate) fn index(&self, file: usize, column: usize, row: usize) -> usize {
        self.first[file] + column * self.data[file].count() + row
    }

    pub(crate) fn measured(&self) -> Vec<f64> {
        let columns = self.data.iter().flat_map(|data| &data.columns);
        columns.flat_map(|column| column.values.iter().copied()).collect()
    }

    /// The scene with the free numbers at these coordinates.
    pub(crate) fn scene(&self, at: &[f64]) -> Result<Scene, Failure> {
        let mut overrides = self.overrides.to_vec();
        for (free, &coordinate) in self.free.iter().zip(at) {
            if free.place == Place::Key {
                let value = number(free.value(coordinate));
                overrides.push(Override::new(&free.name, &value).by("--free"));
            }
        }
        Ok(scene_file::read(self.file, &overrides)?)
    }

    pub(crate) fn evaluate(&self, at: &[f64], options: &Options) -> Result<Evaluation, Failure> {
        self.evaluate_from(at, options, Begin::Start)
    }

    fn evaluate_from(&self, at: &[f64], options: &Options, from: Begin<'_>) -> Result<Evaluation, Failure> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let scene = self.scene(at)?;
        let found = try_each(&self.tasks, |task| match task {
            Task::Chain(file, rows) => Ok((*file, self.chain(&scene, options, *file, rows, from)?)),
            Task::Trace(file) => Ok((*file, self.trace(&scene, options, *file, at)?)),
        });
        let mut values = vec![f64::NAN; self.count()];
        let mut motions: Vec<Vec<Option<Memory>>> =
            self.data.iter().map(|data| vec![None; data.count()]).collect();
        for (file, rows) in found? {
            for (row, of_columns, motion) in rows {
                for (column, value) in of_columns.into_iter().enumerate() {
                    values[self.index(file, column, row)] = value;
                }
                motions[file][row] = motion;
            }
        }
        (self.done)();
        Ok(Evaluation { values, motions })
    }

    /// Rows of a sweep, each from the one before it.
    fn chain(
        &self,
        scene: &Scene,
        options: &Options,
        file: usize,
        rows: &[usize],
        from: Begin<'_>,
    ) -> Result<Vec<RowFound>, Failure> {
        let Rows::Sweep(all) = &self.data[file].rows else { return Ok(Vec::new()) };
        let mut last: Option<Memory> = None;
        let mut found = Vec::new();
        for &row in rows {
            let memory = match from {
                Begin::Start => last.as_ref(),
                Begin::Near(base) if !base.has_orbit(file, row) => continue,
                Begin::WithoutOrbit(base) if base.has_orbit(file, row) => continue,
                Begin::Near(base) | Begin::WithoutOrbit(base) => base.motions[file][row].as_ref(),
            };
            let (outcome, motion) = steady(&at_row(scene, &all[row])?, options, memory)?;
            let columns = self.data[file].columns.iter();
            let values: Option<Vec<f64>> =
                columns.map(|column| quantity(&outcome, &column.name).filter(|v| v.is_finite())).collect();
            let values =
                values.ok_or_else(|| Failure::Step("a value of the model is undefined".to_owned()))?;
            last.clone_from(&motion);
            found.push((row, values, motion));
        }
        Ok(found)
    }

    fn trace(
        &self,
        scene: &Scene,
        options: &Options,
        file: usize,
        at: &[f64],
    ) -> Result<Vec<RowFound>, Failure> {
        let data = &self.data[file];
        let mut scene = with_trace(scene, data, self.interpolation);
        for (free, &coordinate) in self.free.iter().zip(at) {
            if free.place == Place::StartOf(file) {
                displace(&mut scene, free.value(coordinate));
            }
        }
        let Some(recorded) = record(&scene, data, options)? else { return Ok(Vec::new()) };
        let origin = origin(&scene, data);
        let rows = recorded.into_iter().enumerate().map(|(row, [displacement, voltage])| {
            let value = |name: &str| if name == "voltage_v" { voltage } else { displacement - origin };
            (row, data.columns.iter().map(|column| value(&column.name)).collect(), None)
        });
        let rows: Vec<RowFound> = rows.collect();
        match rows.iter().all(|(_, values, _)| values.iter().all(|value| value.is_finite())) {
            true => Ok(rows),
            false => Err(Failure::Step("a value of the model is not finite".to_owned())),
        }
    }

    /// The derivative of each value by each coordinate, by central differences of the size `step`; one-sided where the model
    /// fails on one side, and 0 where it fails on both. The differences go beyond a bound that was asked for.
    pub(crate) fn jacobian(&self, at: &[f64], base: &Evaluation, step: f64) -> Vec<Vec<f64>> {
        let near = self.differences(at, base, step, Begin::Near(base));
        if base.rows_without_orbit(&self.data).next().is_none() {
            return near;
        }
        let wide = self.differences(at, base, WIDE, Begin::WithoutOrbit(base));
        let merged = near.into_iter().zip(wide);
        merged
            .map(|(near, wide)| {
                let pairs = near.into_iter().zip(wide);
                pairs.map(|(near, wide)| if near == 0.0 { wide } else { near }).collect()
            })
            .collect()
    }

    fn differences(&self, at: &[f64], base: &Evaluation, step: f64, from: Begin<'_>) -> Vec<Vec<f64>> {
        let sides: Vec<(usize, f64)> =
            (0..at.len()).flat_map(|index| [(index, -step), (index, step)]).collect();
        let found = each(&sides, |&(index, change)| {
            let mut beside = at.to_vec();
            beside[index] += change;
            let moved = beside[index] - at[index];
            (moved, self.evaluate_from(&beside, &self.options, from).ok())
        });
        let pairs = found.chunks_exact(2);
        pairs
            .map(|pair| {
                let side = |index: usize| {
                    let (moved, evaluation) = &pair[index];
                    let values = evaluation.as_ref().map_or(&base.values, |evaluation| &evaluation.values);
                    (if evaluation.is_some() { *moved } else { 0.0 }, values)
                };
                let ((left, below), (right, above)) = (side(0), side(1));
                let values = below.iter().zip(above);
                let slope = |(below, above): (&f64, &f64)| {
                    let slope = (above - below) / (right - left);
                    if slope.is_finite() { slope } else { 0.0 }
                };
                values.map(slope).collect()
            })
            .collect()
    }
}

/// The rows of a file that are run one after the other: those of one direction, amplitude and resistance.
fn tasks(index: usize, data: &Data) -> Vec<Task> {
    let Rows::Sweep(rows) = &data.rows else { return vec![Task::Trace(index)] };
    let mut chains: Vec<Vec<usize>> = Vec::new();
    for (row, place) in rows.iter().enumerate() {
        let is_like = |chain: &&mut Vec<usize>| {
            let Row { amplitude_m_per_s2, resistance_ohm, direction, .. } = rows[chain[0]];
            direction.is_some()
                && (amplitude_m_per_s2, resistance_ohm, direction)
                    == (place.amplitude_m_per_s2, place.resistance_ohm, place.direction)
        };
        match chains.iter_mut().find(is_like) {
            Some(chain) => chain.push(row),
            None => chains.push(vec![row]),
        }
    }
    for chain in &mut chains {
        chain.sort_by(|&one, &other| rows[one].frequency_hz.total_cmp(&rows[other].frequency_hz));
        if rows[chain[0]].direction == Some(Direction::Down) {
            chain.reverse();
        }
    }
    chains.into_iter().map(|rows| Task::Chain(index, rows)).collect()
}

/// The scene under the sine of a row, into its load.
pub(super) fn at_row(scene: &Scene, row: &Row) -> Result<Scene, Failure> {
    let (own, phase_rad) = match scene.excitation {
        Excitation::Sine(tone) => (Some(tone.amplitude_m_per_s2), tone.phase_rad),
        _ => (None, 0.0),
    };
    let amplitude_m_per_s2 = row.amplitude_m_per_s2.or(own).ok_or_else(|| {
        Failure::of_file(
            scene,
            "excitation.kind: must be \"sine\" for a sweep without a column of the amplitude",
        )
    })?;
    let mut scene = scene.clone();
    scene.excitation =
        Excitation::Sine(Tone { amplitude_m_per_s2, frequency_hz: row.frequency_hz, phase_rad });
    if let Some(resistance_ohm) = row.resistance_ohm {
        scene.load = Load::Resistor { resistance_ohm };
    }
    Ok(scene)
}

/// The periodic steady state, the run where there is none; a storage that fills has none.
pub(super) fn steady(
    scene: &Scene,
    options: &Options,
    memory: Option<&Memory>,
) -> Result<(Outcome, Option<Memory>), Failure> {
    if matches!(scene.load, Load::RectifiedStore(_)) {
        return Ok((embedded::run(scene, options)?, None));
    }
    let options = Options { steady_state: true, ..*options };
    let (outcome, motion) = embedded::steady_state_from(scene, &options, memory)?;
    Ok((outcome, Some(motion)))
}

/// A number of a result by its name.
pub(super) fn quantity(outcome: &Outcome, name: &str) -> Option<f64> {
    match name {
        "rms_voltage_v" => outcome.rms_voltage_v,
        "mean_power_w" => outcome.mean_power_w,
        "peak_voltage_v" => outcome.peak_voltage_v,
        "peak_gap_m" => outcome.contact_separation().and_then(|found| found.peak_gap_m),
        "peak_displacement_m" => outcome.sliding().and_then(|found| found.peak_displacement_m),
        "peak_tip_displacement_m" => outcome.bump_stop().and_then(|found| found.peak_tip_displacement_m),
        _ => None,
    }
}

/// The scene under the acceleration of a trace, for its duration.
pub(crate) fn with_trace(scene: &Scene, data: &Data, interpolation: Interpolation) -> Scene {
    let mut scene = scene.clone();
    if let Rows::Trace { spacing_s, acceleration } = &data.rows {
        let duration_s = spacing_s * (data.count() as f64 - 0.5);
        scene.run = RunSpan { duration_s, settle_s: 0.0 };
        scene.excitation = match acceleration {
            None => Excitation::Silence,
            Some(samples) => Excitation::File(Trace {
                samples_m_per_s2: joined(samples, interpolation),
                rate_hz: 1.0 / spacing_s,
                repeat: false,
                resampled: None,
            }),
        };
    }
    scene
}

/// The samples that the model joins by straight lines, and one more at the end.
///
/// Lines between the samples of a sine have `1 − (ω h)²/12` of its amplitude. A twelfth of the second difference makes up
/// for it, up to `0.011 (ω h)⁴`.
fn joined(samples: &[f64], interpolation: Interpolation) -> Arc<[f64]> {
    let at = |index: usize| samples[index.min(samples.len() - 1)];
    let sharpened = |index: usize| {
        if interpolation == Interpolation::Linear || index == 0 || index + 1 >= samples.len() {
            return at(index);
        }
        at(index) - (at(index + 1) - 2.0 * at(index) + at(index - 1)) / 12.0
    };
    (0..=samples.len()).map(sharpened).collect()
}

/// Displacement and voltage at the times of a trace.
pub(crate) fn record(
    scene: &Scene,
    data: &Data,
    options: &Options,
) -> Result<Option<Vec<[f64; 2]>>, Failure> {
    let Rows::Trace { spacing_s, .. } = data.rows else { return Ok(None) };
    let options =
        Options { trace_every_s: Some(spacing_s), ends_every_s: Some(spacing_s), bare: true, ..*options };
    let outcome = embedded::run(scene, &options)?;
    let Some(trace) = outcome.trace else { return Ok(None) };
    let voltage = trace.columns.iter().position(|name| *name == "voltage_v").unwrap_or(0);
    let rows: Vec<[f64; 2]> =
        trace.rows.iter().take(data.count()).map(|row| [row[1], row[voltage]]).collect();
    match rows.len() == data.count() {
        true => Ok(Some(rows)),
        false => Err(Failure::Step(format!("the run has {} of {} rows", rows.len(), data.count()))),
    }
}

/// What is subtracted from the coordinate of a scene for the displacement in a file.
///
/// The displacement of contact-separation is that from rest, opening positive. A gap is never negative; a displacement that
/// never is, beyond a thousandth of its largest value, is the gap.
pub(crate) fn origin(scene: &Scene, data: &Data) -> f64 {
    let Ok(model) = scene.contact_separation() else { return 0.0 };
    let Some(column) = data.columns.iter().find(|column| column.name == "displacement_m") else { return 0.0 };
    let (low, high) = crate::report::svg::extremes(column.values.iter().copied());
    if low < -1e-3 * high.abs() { model.parameters.initial_gap_m } else { 0.0 }
}

/// Starts the motion of a scene at a coordinate: gap, displacement, or displacement of the first mode.
pub(crate) fn displace(scene: &mut Scene, value: f64) {
    if let Ok(model) = scene.contact_separation_mut() {
        model.initial.position_m = Some(value.max(0.0));
    } else if let Some([coordinate, ..]) = scene.model.start_mut() {
        *coordinate = Some(value);
    } else if let Some(first) =
        scene.bump_stop_mut().ok().and_then(|model| model.initial.modal_displacement.first_mut())
    {
        *first = value;
    }
}
