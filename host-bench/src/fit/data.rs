//! Measurements from CSV files: sweeps over frequency, traces over time, ring-downs.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use crate::command::note;
use crate::input::{self, MOST_OF_DATA, repeated};
use crate::method::Failure;
use crate::outcome::shown;
use crate::scene_file::{Delimiter, GRAVITY, Model, Numbers, Scene, resample};

/// Columns that a sweep may measure, and the kind of scene that has them.
const SWEEP: [(&str, Option<&str>); 6] = [
    ("rms_voltage_v", None),
    ("mean_power_w", None),
    ("peak_voltage_v", None),
    ("peak_gap_m", Some("contact-separation")),
    ("peak_displacement_m", Some("sliding")),
    ("peak_tip_displacement_m", Some("bump-stop")),
];
/// The others of a sweep.
const PLACES: [&str; 5] =
    ["frequency_hz", "amplitude_m_per_s2", "amplitude_g", "resistance_ohm", "direction"];
/// Columns that a trace may measure. The gap is of contact-separation.
const TRACE: [&str; 3] = ["voltage_v", "displacement_m", "gap_m"];
/// The others of a trace.
const TIMES: [&str; 2] = ["time_s", "acceleration_m_per_s2"];
/// Ending of the name of a standard deviation.
const STD: &str = "_std";
/// Largest distance of a time from its place in even spacing, as a part of the spacing.
const UNEVEN: f64 = 0.25;

/// In which direction a sweep went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Direction {
    Up,
    Down,
}

/// One row of a sweep: what shakes, and into what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) frequency_hz: f64,
    /// `None`: that of the scene, as below.
    pub(crate) amplitude_m_per_s2: Option<f64>,
    pub(crate) resistance_ohm: Option<f64>,
    pub(crate) direction: Option<Direction>,
}

/// The rows of a file, without what was measured.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rows {
    Sweep(Vec<Row>),
    Trace {
        /// Time in s from one sample to the next.
        spacing_s: f64,
        /// One acceleration of the base in m/s² for each row; none of a ring-down.
        acceleration: Option<Vec<f64>>,
    },
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) values: Vec<f64>,
    /// Standard deviation of each value.
    pub(crate) std: Option<Vec<f64>>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Data {
    pub(crate) file: PathBuf,
    pub(crate) rows: Rows,
    pub(crate) columns: Vec<Column>,
    /// The line of each row.
    pub(crate) lines: Vec<u64>,
}

impl Data {
    /// Whether it is a motion without excitation.
    pub(crate) fn is_ring_down(&self) -> bool {
        matches!(self.rows, Rows::Trace { acceleration: None, .. })
    }

    pub(crate) fn count(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}

/// A CSV file as text cells, with the line of each row.
struct Table<'a> {
    file: &'a Path,
    heading: Vec<String>,
    rows: Vec<(u64, Vec<String>)>,
    /// Reads its cells, all with the same decimal mark.
    cells: RefCell<Numbers>,
}

impl Table<'_> {
    fn read(file: &Path) -> Result<Table<'_>, Failure> {
        let refuse = |text: String| Failure::Input(format!("{}{text}", file.display()));
        let text = input::text(file, MOST_OF_DATA / 4)
            .map_err(|error| refuse(format!(": cannot be read: {error}")))?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let delimiter = Delimiter::of(text);
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .delimiter(delimiter.byte())
            .from_reader(text.as_bytes());
        let fault = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            let reason = match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("has {len} cells, must have {expected_len} as the heading")
                }
                _ => error.to_string(),
            };
            refuse(format!(":{line}: {reason}"))
        };
        let heading: Vec<String> = reader.headers().map_err(fault)?.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(fault)?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push((line, record.iter().map(str::to_owned).collect()));
        }
        Ok(Table { file, heading, rows, cells: RefCell::new(Numbers::new(delimiter)) })
    }

    fn refuse<T>(&self, text: &str) -> Result<T, Failure> {
        Err(Failure::Input(format!("{}: {text}", self.file.display())))
    }

    fn refuse_at<T>(&self, row: usize, text: &str) -> Result<T, Failure> {
        let line = self.rows.get(row).map_or(1, |(line, _)| *line);
        Err(Failure::Input(format!("{}:{line}: {text}", self.file.display())))
    }

    fn lines(&self) -> Vec<u64> {
        self.rows.iter().map(|(line, _)| *line).collect()
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.heading.iter().position(|column| column == name)
    }

    /// The numbers of a column within bounds, if there is such a column.
    fn numbers(&self, name: &str, low: f64, high: f64) -> Result<Option<Vec<f64>>, Failure> {
        let Some(index) = self.index(name) else { return Ok(None) };
        let number = |(row, (_, cells)): (usize, &(u64, Vec<String>))| {
            let cell = &cells[index];
            let reason = match self.cells.borrow_mut().read(cell) {
                Ok(value) if (low..=high).contains(&value) => return Ok(value),
                Ok(value) if value.is_finite() => {
                    format!("{name} = {cell}: must be a number from {low:e} to {high:e}")
                }
                Ok(_) => format!("{name} = {cell:?}: must be a finite number"),
                Err(reason) => format!("{name}: {reason}, must be a finite number"),
            };
            self.refuse_at(row, &reason)
        };
        self.rows.iter().enumerate().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Refuses a name that is given twice or that is not one of `known`, or the standard deviation of one of `measured`.
    fn check_names(&self, kind: &str, known: &[&str], measured: &[&str]) -> Result<(), Failure> {
        if let Some(name) = repeated(self.heading.iter().map(String::as_str)) {
            return self.refuse(&format!("column {name}: must be there once"));
        }
        for name in &self.heading {
            let base = name.strip_suffix(STD).filter(|base| measured.contains(base));
            if let Some(base) = base {
                if self.index(base).is_none() {
                    return self
                        .refuse(&format!("column {name}: must stand beside {base}, which is missing"));
                }
            } else if !known.contains(&name.as_str()) && !measured.contains(&name.as_str()) {
                let all = [known, measured].concat().join(", ");
                return self.refuse(&format!(
                    "column {name:?}: unknown in a {kind}; known: {all}, and the measured ones with {STD}"
                ));
            }
        }
        Ok(())
    }

    fn measured(&self, names: &[&str]) -> Result<Vec<Column>, Failure> {
        let mut columns = Vec::new();
        for name in names {
            let Some(values) = self.numbers(name, -1e300, 1e300)? else { continue };
            let of_std = format!("{name}{STD}");
            let std = self.numbers(&of_std, 0.0, 1e300)?;
            if let Some(row) = std.iter().flatten().position(|std| *std == 0.0) {
                return self.refuse_at(row, &format!("{of_std} = 0: must be above 0"));
            }
            columns.push(Column { name: (*name).to_owned(), values, std });
        }
        if columns.is_empty() {
            return self.refuse(&format!("must have one or more of the columns {}", names.join(", ")));
        }
        Ok(columns)
    }
}

/// The columns of a file of numbers, with their names.
pub(crate) fn columns(file: &Path) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let table = Table::read(file)?;
    table.check_names(
        "file of numbers",
        &table.heading.iter().map(String::as_str).collect::<Vec<_>>(),
        &[],
    )?;
    let column = |name: &String| {
        let values = table.numbers(name, f64::MIN, f64::MAX)?;
        values
            .filter(|values| !values.is_empty())
            .map_or_else(|| table.refuse("has no row below its heading"), |values| Ok((name.clone(), values)))
    };
    table.heading.iter().map(column).collect()
}

/// Reads a file of measurements of a scene; a trace at even times of a rate in Hz where one is given.
pub(crate) fn read(file: &Path, scene: &Scene, resample_hz: Option<f64>) -> Result<Data, Failure> {
    let table = Table::read(file)?;
    let data = match (table.index("frequency_hz"), table.index("time_s")) {
        (Some(_), None) => sweep(&table, scene)?,
        (None, Some(_)) => trace(&table, scene, resample_hz)?,
        (Some(_), Some(_)) => {
            return table.refuse("must have the column frequency_hz (a sweep) or time_s (a trace), has both");
        }
        (None, None) => {
            return table.refuse("the column frequency_hz (a sweep) or time_s (a trace) is missing");
        }
    };
    if data.count() == 0 {
        return table.refuse("has no row below its heading");
    }
    Ok(data)
}

fn sweep(table: &Table<'_>, scene: &Scene) -> Result<Data, Failure> {
    let names = SWEEP.map(|(name, _)| name);
    table.check_names("sweep", &PLACES, &names)?;
    for (name, kind) in SWEEP {
        if let Some(kind) = kind.filter(|kind| *kind != scene.name() && table.index(name).is_some()) {
            return table.refuse(&format!("column {name}: is of a {kind} scene, this is {}", scene.name()));
        }
    }
    let columns = table.measured(&names)?;
    let frequencies = table.numbers("frequency_hz", 1e-6, 1e6)?.unwrap_or_default();
    let [in_si, in_g] = ["amplitude_m_per_s2", "amplitude_g"];
    if table.index(in_si).is_some() && table.index(in_g).is_some() {
        return table.refuse(&format!("must have one of the columns {in_si} and {in_g}, has both"));
    }
    let amplitudes = match table.numbers(in_g, 0.0, 1e4)? {
        Some(values) => Some(values.iter().map(|value| value * GRAVITY).collect()),
        None => table.numbers(in_si, 0.0, 1e5)?,
    };
    let resistances = table.numbers("resistance_ohm", 0.0, f64::INFINITY)?;
    let directions = directions(table)?;
    let rows = frequencies.iter().enumerate().map(|(index, &frequency_hz)| Row {
        frequency_hz,
        amplitude_m_per_s2: amplitudes.as_ref().map(|values: &Vec<f64>| values[index]),
        resistance_ohm: resistances.as_ref().map(|values| values[index]),
        direction: directions.as_ref().map(|values| values[index]),
    });
    Ok(Data { file: table.file.to_owned(), rows: Rows::Sweep(rows.collect()), columns, lines: table.lines() })
}

fn directions(table: &Table<'_>) -> Result<Option<Vec<Direction>>, Failure> {
    let Some(index) = table.index("direction") else { return Ok(None) };
    let direction = |(row, (_, cells)): (usize, &(u64, Vec<String>))| match cells[index].as_str() {
        "up" => Ok(Direction::Up),
        "down" => Ok(Direction::Down),
        other => table.refuse_at(row, &format!("direction = {other:?}: must be up or down")),
    };
    table.rows.iter().enumerate().map(direction).collect::<Result<_, _>>().map(Some)
}

fn trace(table: &Table<'_>, scene: &Scene, resample_hz: Option<f64>) -> Result<Data, Failure> {
    table.check_names("trace", &TIMES, &TRACE)?;
    if table.index("gap_m").is_some() {
        if !matches!(scene.model, Model::ContactSeparation(_)) {
            return table.refuse(&format!(
                "column gap_m: is of a contact-separation scene, this is {}",
                scene.name()
            ));
        }
        if table.index("displacement_m").is_some() {
            return table.refuse("must have one of the columns gap_m and displacement_m, has both");
        }
    }
    let (mut columns, mut lines) = (table.measured(&TRACE)?, table.lines());
    let times = table.numbers("time_s", -1e9, 1e9)?.unwrap_or_default();
    if times.len() < 2 {
        return table.refuse("must have at least two rows");
    }
    let acceleration = table.numbers("acceleration_m_per_s2", -1e5, 1e5)?;
    let mut acceleration = acceleration.filter(|values| values.iter().any(|value| *value != 0.0));
    let spacing_s = resample_hz.map_or_else(|| spacing(table, &times), |rate_hz| Ok(1.0 / rate_hz))?;
    if let Some(rate_hz) = resample_hz {
        if let Some(column) = columns.iter().find(|column| column.std.is_some()) {
            return table.refuse(&format!("column {}{STD}: must not be with --resample", column.name));
        }
        let all = columns.iter_mut().map(|column| &mut column.values).chain(&mut acceleration);
        let [moved, filled] = resample((&times, &lines), all, rate_hz)
            .or_else(|reason| table.refuse(&format!("--resample {rate_hz}: {reason}")))?;
        let (file, count) = (table.file.display(), columns[0].values.len());
        note(&format!("{file}: of {count} samples {moved} are moved to even times, {filled} fill gaps"));
        // The last row before each time.
        let row = |index: usize| {
            times.partition_point(|time| *time <= times[0] + (index as f64 + 0.01) / rate_hz) - 1
        };
        lines = (0..count).map(|index| lines[row(index)]).collect();
    }
    Ok(Data { file: table.file.to_owned(), rows: Rows::Trace { spacing_s, acceleration }, columns, lines })
}

/// The distance of even times in s; refuses others.
fn spacing(table: &Table<'_>, times: &[f64]) -> Result<f64, Failure> {
    let (first, last) = (times[0], times[times.len() - 1]);
    let spacing_s = (last - first) / (times.len() - 1) as f64;
    if !(spacing_s > 0.0) {
        return table.refuse("time_s: must rise");
    }
    // The message names the row after a gap, not the first one that lies beside the mean line.
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let uneven = |usual: f64| steps.iter().position(|step| !((step - usual).abs() <= UNEVEN * usual));
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    if let Some(step) = uneven(usual) {
        let [time, step_s, usual] = [times[step + 1], steps[step], usual].map(|value| shown(&value.into()));
        let text = format!(
            "time_s = {time}: is {step_s} s after the row before: must be uniform, with steps of {usual} s, or with --resample HZ"
        );
        return table.refuse_at(step + 1, &text);
    }
    let is_off = |index: usize, time: f64| {
        let expected = first + index as f64 * spacing_s;
        !((time - expected).abs() <= UNEVEN * spacing_s)
    };
    if let Some(row) = times.iter().enumerate().position(|(index, &time)| is_off(index, time)) {
        let [time, steps] = [times[row], spacing_s].map(|value| shown(&value.into()));
        let text = format!("time_s = {time}: must be uniform, with steps of {steps} s");
        return table.refuse_at(row, &text);
    }
    Ok(spacing_s)
}
